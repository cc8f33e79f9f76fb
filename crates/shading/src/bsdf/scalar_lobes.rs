// SPDX-License-Identifier: GPL-3.0-or-later
//! Rare lobes, one point at a time: by Phong, by Ward, Beckmann's microfacets, glass under Schlick's
//! reflectances, layers of fibres, hair, cones of toon shading. Sixteen points evaluate them point by point, so that other lobes' code
//! stays small.
//! Source: see the file of each. Space: a frame with z = the shading normal and x along the slopes.
//! Invariant: the same code for one point and for each of sixteen, so the same bits. Tests: `tests` of `bsdf`.

use glam::Vec3;

use super::anisotropy::{AnisotropyFrame, Slopes};
use super::beckmann::Beckmann;
use super::ggx::Ggx;
use super::hair::Hair;
use super::lobe::Kind;
use super::rough_dielectric::{Glass, Microfacets, Mirrored, PreparedGlass};
use super::rough_fibre::RoughFibre;
use super::strand::Strand;
use super::toon::{self, Toon};
use super::{fibres, fresnel, phong, ward};
use crate::real::Vector;

/// Their bits.
pub(super) const KINDS: u32 = Kind::Phong.bit()
    | Kind::Ward.bit()
    | Kind::Beckmann.bit()
    | Kind::SchlickGlass.bit()
    | Kind::Fibres.bit()
    | Kind::Hair.bit()
    | Kind::Toon.bit()
    | Kind::GlossyToon.bit()
    | Kind::Strand.bit()
    | Kind::RoughFibre.bit();

/// A lobe at a point, with the numbers of [`Lobe`](super::Lobe).
#[derive(Clone, Copy, Debug)]
pub(super) struct ScalarLobe {
    pub(super) kind: Kind,
    pub(super) wo: Vec3,
    pub(super) a: Vec3,
    pub(super) b: Vec3,
    pub(super) c: Vec3,
    /// Widths of the slopes along x and y.
    pub(super) widths: [f32; 2],
    pub(super) eta: f32,
    pub(super) spread: f32,
    /// Share, index and thickness.
    pub(super) film: [f32; 3],
}

/// Values that depend on the view.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct View {
    /// Share of light that is scattered, about.
    pub(super) albedo: Vec3,
    /// See [`PreparedGlass`]; for Ward's lobe the albedo of the published form.
    pub(super) hidden: f32,
    pub(super) lost: f32,
}

/// The reflectance of a microfacet of such lobes.
#[derive(Clone, Copy)]
enum Rise {
    All,
    Fresnel,
    Schlick { f0: Vec3, f90: Vec3, power: f32 },
}

impl Mirrored<f32> for Rise {
    const IS_GREY: bool = false;

    fn share(&self, cos: f32, eta: f32, _: bool) -> Vector<f32> {
        match *self {
            Self::All => Vector::grey(1.0),
            Self::Fresnel => Vector::grey(fresnel::dielectric(cos, eta)),
            Self::Schlick { f0, f90, power } => {
                // By the angle on the rarer side, so that both sides agree.
                let cos2_beyond = 1.0 - eta * eta * (1.0 - cos * cos);
                let cos = if eta > 1.0 { cos2_beyond.max(0.0).sqrt() } else { cos };
                let all = eta > 1.0 && cos2_beyond <= 0.0;
                let rise = (1.0 - cos).clamp(0.0, 1.0).powf(power);
                (if all { Vec3::ONE } else { f0 + (f90 - f0) * rise }).into()
            }
        }
    }
}

/// Calls `$then` with the glass that a lobe is, else gives `$other`.
macro_rules! as_glass {
    ($lobe:expr, $glass:ident => $then:expr, $other:expr) => {
        match $lobe.kind {
            Kind::Beckmann => {
                let $glass = $lobe.beckmann();
                $then
            }
            Kind::SchlickGlass => {
                let $glass = $lobe.schlick();
                $then
            }
            _ => $other,
        }
    };
}

impl ScalarLobe {
    fn hair(&self) -> Hair {
        let [variance, scale] = self.widths;
        let (term, index) = (self.c.x as usize, 1.0 / self.eta);
        Hair { term, absorption: self.a, variance, scale, index, tilt: self.c.y }
    }

    fn strand(&self) -> Strand {
        Strand { through: self.c.x > 0.0, widths: self.widths, offset: self.c.y }
    }

    fn rough_fibre(&self) -> RoughFibre {
        RoughFibre {
            term: self.c.x as usize,
            absorption: self.a,
            alpha: self.widths[0],
            index: 1.0 / self.eta,
            tilt: self.c.y,
            aspect: self.b.z,
            major: self.b.truncate(),
            random: self.c.z,
        }
    }

    /// A cone, and its axis.
    fn toon(&self) -> (Toon, Vec3) {
        (Toon::new(self.c.x, self.c.y), toon::axis(self.kind == Kind::GlossyToon, self.wo))
    }

    fn beckmann(&self) -> Glass<f32, Beckmann, Rise> {
        Glass {
            slopes: Beckmann::new(self.widths),
            eta: self.eta,
            film: None,
            rise: if self.eta > 0.0 { Rise::Fresnel } else { Rise::All },
            tints: [self.a.into(), self.b.into()],
            losses: Vector::grey(0.0),
            thin: false,
        }
    }

    fn schlick(&self) -> Glass<f32, Slopes<f32>, Rise> {
        let [along, across] = self.widths;
        let anisotropy =
            AnisotropyFrame { tangent: Vec3::X.into(), bitangent: Vec3::Y.into(), across, is: true };
        let tint = |is: bool| Vector::grey(if is { 1.0 } else { 0.0 });
        Glass {
            slopes: Slopes {
                ggx: Ggx::from_alpha(along),
                anisotropy: (along != across).then_some(anisotropy),
            },
            eta: self.eta,
            film: (self.film[0] > 0.0).then_some(self.film),
            rise: Rise::Schlick { f0: self.a, f90: self.b, power: self.spread.abs() },
            tints: [tint(self.spread > 0.0), tint(self.spread < 0.0)],
            losses: self.c.into(),
            thin: false,
        }
    }

    /// Computes the values that depend on the view.
    #[inline(never)]
    pub(super) fn prepare(&self) -> View {
        let wo = self.wo;
        let of_glass =
            |prepared: PreparedGlass<f32>, mirrored: Vector<f32>, tints: [Vector<f32>; 2], lost: f32| {
                let mirrored = Vec3::from(mirrored);
                let albedo = mirrored * (1.0 - lost) * Vec3::from(tints[0]);
                let albedo = albedo + (1.0 - mirrored) * Vec3::from(tints[1]);
                View { albedo, hidden: prepared.hidden, lost: prepared.lost }
            };
        let dim = |share: f32| View { albedo: Vec3::splat(share), ..View::default() };
        // Approximate: microfacets reflect as the plane does, blurred.
        let blurred = wo.z + (0.7 - wo.z) * (self.widths[0] * 0.5);
        match self.kind {
            Kind::Phong => dim(phong::albedo(self.eta, wo.z)),
            Kind::Fibres => dim(fibres::albedo(self.widths[0], wo.z)),
            Kind::Hair => View { albedo: self.hair().albedo(wo), ..View::default() },
            Kind::Strand => dim(1.0),
            Kind::RoughFibre => View { albedo: self.rough_fibre().albedo(wo), ..View::default() },
            Kind::Toon | Kind::GlossyToon => {
                let (toon, axis) = self.toon();
                dim(toon.albedo(axis.z))
            }
            Kind::Ward => {
                let sent = ward::sent_back(self.widths, wo);
                View { hidden: sent, ..dim(sent.min(1.0)) }
            }
            Kind::Beckmann => {
                let glass = self.beckmann();
                // Of the visible microfacets, some reflect light to others: their number is about that of
                // microfacets that hide each other.
                let hidden = glass.slopes.lambda(wo.into(), wo.z);
                of_glass(
                    glass.prepared(wo.into(), wo.z),
                    glass.mirrored(blurred),
                    glass.tints,
                    hidden / (1.0 + 2.0 * hidden),
                )
            }
            Kind::SchlickGlass => {
                let glass = self.schlick();
                of_glass(glass.prepared(wo.into(), wo.z), glass.mirrored(blurred), glass.tints, 0.0)
            }
            _ => View::default(),
        }
    }

    /// Approximate share of light that is not transmitted, without multiple scattering.
    #[inline(never)]
    pub(super) fn sent_back(&self) -> Vec3 {
        match self.kind {
            Kind::Beckmann => Self { b: Vec3::ZERO, ..*self }.prepare().albedo,
            Kind::SchlickGlass if self.spread < 0.0 => Vec3::ZERO,
            Kind::Strand if self.c.x > 0.0 => Vec3::ZERO,
            _ => self.prepare().albedo,
        }
    }

    /// Value times the cosine and density of the unit `wi`.
    #[inline(never)]
    pub(super) fn eval_pdf(&self, hidden: f32, lost: f32, wi: Vec3) -> (Vec3, f32) {
        let dim = |(value, pdf): (f32, f32)| (Vec3::splat(value), pdf);
        let directions = [self.wo.into(), wi.into()];
        let of = |(value, pdf): (Vector<f32>, f32)| (value.into(), pdf);
        as_glass!(
            self,
            glass => of(glass.eval_pdf(PreparedGlass { hidden, lost }, Vec3::Z.into(), directions, [self.wo.z, wi.z])),
            match self.kind {
                Kind::Phong => dim(phong::eval_pdf(self.eta, self.wo, wi)),
                Kind::Fibres => dim(fibres::eval_pdf(self.widths[0], self.wo, wi)),
                Kind::Hair => self.hair().eval_pdf(self.wo, wi),
                Kind::Strand => dim(self.strand().eval_pdf(self.wo, wi)),
                Kind::RoughFibre => self.rough_fibre().eval_pdf(self.wo, wi),
                Kind::Toon | Kind::GlossyToon => {
                    let (toon, axis) = self.toon();
                    dim(toon.eval_pdf(axis, wi))
                }
                Kind::Ward => dim(ward::eval_pdf(self.widths, hidden, self.wo, wi)),
                _ => dim((0.0, 0.0)),
            }
        )
    }

    /// A unit direction; zero where there is none.
    #[inline(never)]
    pub(super) fn sample(&self, hidden: f32, lost: f32, u: [f32; 3], cosine: Vec3) -> Vec3 {
        let above = |wi: Vec3| if wi.z > 0.0 { wi } else { Vec3::ZERO };
        let of = |(wi, some): (Vector<f32>, bool)| if some { Vec3::from(wi) } else { Vec3::ZERO };
        as_glass!(
            self,
            glass => of(glass.sample(PreparedGlass { hidden, lost }, self.wo.into(), u, cosine.into())),
            match self.kind {
                Kind::Phong => above(phong::sample(self.eta, self.wo, [u[1], u[2]])),
                Kind::Fibres => fibres::sample(self.widths[0], self.wo, cosine),
                Kind::Hair => self.hair().sample(self.wo, u),
                Kind::Strand => self.strand().sample(self.wo, [u[1], u[2]]),
                Kind::RoughFibre => self.rough_fibre().sample(self.wo, u),
                Kind::Toon | Kind::GlossyToon => {
                    let (toon, axis) = self.toon();
                    above(toon.sample(axis, [u[1], u[2]]))
                }
                Kind::Ward => above(ward::sample(self.widths, self.wo, [u[1], u[2]])),
                _ => Vec3::ZERO,
            }
        )
    }
}
