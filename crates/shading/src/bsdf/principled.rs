// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF's layered surface: a coat, over sheen, over plastic, metal or glass or a mix, over a diffuse body.
//! Source: glTF 2.0 appendix B.3, KHR_materials_{ior, specular, clearcoat, sheen, transmission}; facets and further
//! bounces as in `conductor.rs` and `rough_dielectric.rs`; what a layer mirrors is taken from the body in the reciprocal
//! form of [KC17], and from glossy layers by the larger share of the two directions.
//! Space: the shading frame. Differs from glTF's sample code: the body gets what the layers above leave on the whole,
//! in both directions, not Fresnel's share at the half vector, so that white plastic keeps all light.
//! Proof: `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::energy::Energy;
use super::ggx::Ggx;
use super::rough_dielectric::RoughDielectric;
use super::{BsdfSample, Lobes, fresnel, sheen};
use crate::sampling::cosine_hemisphere;

/// Reflectance of a clear coat at normal incidence: an index of 1.5.
const COAT_F0: Vec3 = Vec3::splat(0.04);

/// glTF's layered surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    /// Albedo of the body, reflectance of the metal at normal incidence, in [0, 1].
    pub base: Vec3,
    /// 0 = plastic, 1 = metal.
    pub metallic: f32,
    /// Width of the facets' slopes, in (0, 1]: the square of glTF's roughness.
    pub alpha: f32,
    /// Reflectance of the plastic at normal incidence, in [0, 1].
    pub f0: Vec3,
    /// Reflectance of the plastic at grazing incidence, in [0, 1].
    pub f90: f32,
    /// How much of a coat there is, in [0, 1].
    pub coat: f32,
    /// Width of the slopes of the coat's facets, in (0, 1].
    pub coat_alpha: f32,
    /// Colour of the sheen, in [0, 1]; black = none.
    pub sheen: Vec3,
    /// glTF's roughness of the sheen, in [0, 1].
    pub sheen_roughness: f32,
    /// Share of the body that is glass, tinted by `base`, in [0, 1].
    pub transmission: f32,
    /// Index of refraction of the glass on the side that rays come from over the index beyond, > 0.
    pub eta: f32,
    /// Whether the glass is a pane that does not bend light.
    pub thin: bool,
    pub(super) lobes: Lobes,
}

impl Principled {
    /// Plastic or metal without a coat; `roughness` and `metallic` are glTF's, in [0, 1].
    #[must_use]
    pub fn new(base: Vec3, metallic: f32, roughness: f32, ior: f32) -> Self {
        Self {
            // More than all light would come back without end between the facets.
            base: base.clamp(Vec3::ZERO, Vec3::ONE),
            metallic,
            alpha: roughness * roughness,
            f0: Vec3::splat(fresnel::normal_reflectance(ior)),
            f90: 1.0,
            coat: 0.0,
            coat_alpha: 0.0,
            sheen: Vec3::ZERO,
            sheen_roughness: 0.0,
            transmission: 0.0,
            eta: 1.0 / ior,
            thin: false,
            lobes: Lobes::ALL,
        }
    }
}

impl Principled {
    /// The lobes with facets narrower than `alpha`, and the rest.
    pub(super) fn split_at(self, alpha: f32) -> [Option<Self>; 2] {
        let narrow = |is: bool, lobe: Lobes| if is { lobe } else { Lobes(0) };
        let coat = narrow(self.coat > 0.0 && self.coat_alpha < alpha, Lobes::COAT);
        let gloss = narrow(self.alpha < alpha, Lobes(Lobes::GLOSS.0 | Lobes::GLASS.0));
        let narrow = Lobes((coat.0 | gloss.0) & self.lobes.0);
        let part = |lobes: Lobes| (lobes.0 != 0).then_some(Self { lobes, ..self });
        [part(narrow), part(self.lobes.without(narrow))]
    }
}

/// What the layers send back on the whole of light from one direction.
pub(super) struct Above {
    coat: f32,
    /// The sheen below the coat.
    sheen: f32,
    /// The plastic below both.
    plastic: Vec3,
}

impl Above {
    /// What all of them send back.
    pub(super) fn sum(&self) -> Vec3 {
        Vec3::splat(1.0 - self.left()) + self.left() * self.plastic
    }

    /// What coat and sheen leave.
    fn left(&self) -> f32 {
        (1.0 - self.coat) * (1.0 - self.sheen)
    }
}

/// Probabilities with which directions are drawn from the lobes.
#[derive(Clone, Copy)]
pub(super) struct Shares {
    coat: f32,
    pub(super) gloss: f32,
    glass: f32,
    /// Body, sheen and further bounces, by the cosine.
    pub(super) body: f32,
}

impl Principled {
    pub(super) fn gloss(&self) -> Ggx {
        Ggx::from_alpha(self.alpha)
    }

    fn coat(&self) -> Ggx {
        Ggx::from_alpha(self.coat_alpha)
    }

    fn glass(&self) -> RoughDielectric {
        RoughDielectric::new(self.alpha, self.eta, Vec3::ONE, self.base, self.thin)
    }

    /// Shares of plastic, metal and glass; they sum to 1.
    pub(super) fn parts(&self) -> [f32; 3] {
        let rest = 1.0 - self.metallic;
        [rest * (1.0 - self.transmission), self.metallic, rest * self.transmission]
    }

    /// Reflectances of plastic and metal mixed, at normal and grazing incidence.
    pub(super) fn mixed(&self) -> (Vec3, f32) {
        let [plastic, metal, _] = self.parts();
        (self.f0 * plastic + self.base * metal, self.f90 * plastic + metal)
    }

    /// Colour of all bounces but the first, of plastic and metal mixed.
    pub(super) fn more(&self, energy: Energy) -> Vec3 {
        let [plastic, metal, _] = self.parts();
        energy.more(fresnel::schlick_average(self.f0, self.f90)) * plastic
            + energy.more(fresnel::schlick_average(self.base, 1.0)) * metal
    }

    pub(super) fn above(&self, cos: f32) -> Above {
        let coat =
            if self.coat > 0.0 { self.coat * Energy::of(self.coat()).all(cos, COAT_F0, 1.0).x } else { 0.0 };
        let sheen = if self.sheen == Vec3::ZERO {
            0.0
        } else {
            self.sheen.max_element() * sheen::albedo(self.sheen_roughness, cos)
        };
        Above { coat, sheen, plastic: Energy::of(self.gloss()).all(cos, self.f0, self.f90) }
    }

    /// [`Above::sum`], averaged over a cosine-weighted hemisphere.
    fn above_average(&self) -> Vec3 {
        if self.coat == 0.0 && self.sheen == Vec3::ZERO {
            return Energy::of(self.gloss()).all_average(self.f0, self.f90);
        }
        // Gauss's rule with four points for the measure 2 cos dcos on [0, 1].
        const RULE: [(f32, f32); 4] = [
            (0.139_759_86, 0.062_361_94),
            (0.416_409_57, 0.259_695_1),
            (0.723_157, 0.406_929_14),
            (0.942_895_8, 0.271_013_83),
        ];
        RULE.iter().map(|&(cos, weight)| self.above(cos).sum() * weight).sum()
    }

    /// Albedo of the body without what lies above.
    pub(super) fn body(&self) -> Vec3 {
        self.base * self.parts()[0]
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let (from, to) = (self.above(wo.z), self.above(wi.z.abs()));
        let left = from.left().min(to.left());
        let [.., glass] = self.parts();
        let mut sum = Vec3::ZERO;
        if glass > 0.0 && self.lobes.has(Lobes::GLASS) {
            sum += self.glass().eval(wo, wi) * (left * glass);
        }
        if wi.z <= 0.0 {
            return sum;
        }
        let h = (wo + wi).normalize_or(Vec3::Z);
        let rise = fresnel::schlick_rise(wo.dot(h));
        let schlick = |f0: Vec3, f90: f32| f0 + (Vec3::splat(f90) - f0) * rise;
        if self.coat > 0.0 {
            let (ggx, energy) = (self.coat(), Energy::of(self.coat()));
            if self.lobes.has(Lobes::COAT) {
                sum += schlick(COAT_F0, 1.0) * (self.coat * ggx.lobe_cos(wo, wi, h));
            }
            if self.lobes.has(Lobes::BODY) {
                let more = energy.more(fresnel::schlick_average(COAT_F0, 1.0));
                sum += more * (self.coat * energy.more_cos(wo.z, wi.z));
            }
        }
        if self.lobes.has(Lobes::GLOSS) {
            let (f0, f90) = self.mixed();
            sum += schlick(f0, f90) * (left * self.gloss().lobe_cos(wo, wi, h));
        }
        if self.lobes.has(Lobes::BODY) {
            if self.sheen != Vec3::ZERO {
                let below_coat = (1.0 - from.coat).min(1.0 - to.coat);
                sum += self.sheen * (below_coat * sheen::lobe_cos(self.sheen_roughness, wo, wi));
            }
            let energy = Energy::of(self.gloss());
            sum += self.more(energy) * (left * energy.more_cos(wo.z, wi.z));
            sum += self.body() * self.entering(&from, &to) * (FRAC_1_PI * wi.z);
        }
        sum
    }

    /// Share of light that reaches the body and comes out again, such that a white one sends back all that the layers
    /// above do not.
    fn entering(&self, from: &Above, to: &Above) -> Vec3 {
        (Vec3::ONE - from.sum()) * (Vec3::ONE - to.sum()) / self.left_on_average()
    }

    /// What the layers above leave to the body, averaged over a cosine-weighted hemisphere.
    pub(super) fn left_on_average(&self) -> Vec3 {
        (Vec3::ONE - self.above_average()).max(Vec3::splat(1e-6))
    }

    pub(super) fn shares(&self, wo: Vec3) -> Shares {
        let above = self.above(wo.z);
        let (f0, f90) = self.mixed();
        let energy = Energy::of(self.gloss());
        let more = self.more(energy).max_element() * (1.0 - energy.white(wo.z));
        let body = (self.body() * (Vec3::ONE - above.sum())).max_element();
        let part = |lobe, weight: f32| if self.lobes.has(lobe) { weight.max(0.0) } else { 0.0 };
        // The coat's further bounces are drawn with the body.
        let coats_more = 0.1 * above.coat * self.coat_alpha;
        let shares = Shares {
            coat: part(Lobes::COAT, above.coat),
            gloss: part(Lobes::GLOSS, above.left() * energy.once(wo.z, f0, f90).max_element()),
            glass: part(Lobes::GLASS, above.left() * self.parts()[2]),
            body: part(Lobes::BODY, body + above.sheen + above.left() * more + coats_more),
        };
        let sum = shares.coat + shares.gloss + shares.glass + shares.body;
        if sum <= 0.0 {
            return shares;
        }
        let scaled = |share: f32| share / sum;
        Shares {
            coat: scaled(shares.coat),
            gloss: scaled(shares.gloss),
            glass: scaled(shares.glass),
            body: scaled(shares.body),
        }
    }

    fn pdf_of(&self, shares: Shares, wo: Vec3, wi: Vec3) -> f32 {
        let mut pdf = 0.0;
        if shares.glass > 0.0 {
            pdf += shares.glass * self.glass().pdf(wo, wi);
        }
        if wi.z <= 0.0 {
            return pdf;
        }
        let h = (wo + wi).normalize_or(Vec3::Z);
        pdf += shares.body * FRAC_1_PI * wi.z;
        if shares.coat > 0.0 {
            pdf += shares.coat * self.coat().mirrored_pdf(wo, h);
        }
        if shares.gloss > 0.0 {
            pdf += shares.gloss * self.gloss().mirrored_pdf(wo, h);
        }
        pdf
    }

    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.pdf_of(self.shares(wo), wo, wi)
    }

    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let shares = self.shares(wo);
        let pair = [u[1], u[2]];
        let before_glass = shares.coat + shares.gloss;
        // Mirrored below the horizon is lost: the glass must not take it for its own.
        let above = |wi: Vec3| (wi.z > 0.0).then_some(wi);
        let wi = if u[0] < shares.coat {
            above((-wo).reflect(self.coat().sample_visible(wo, pair)))?
        } else if u[0] < before_glass {
            above((-wo).reflect(self.gloss().sample_visible(wo, pair)))?
        } else if u[0] < before_glass + shares.glass {
            let choice = ((u[0] - before_glass) / shares.glass).min(0.999_999_9);
            self.glass().sample(wo, [choice, u[1], u[2]])?.wi
        } else {
            cosine_hemisphere(pair)
        };
        let pdf = self.pdf_of(shares, wo, wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.eval(wo, wi) / pdf,
            pdf,
            delta: false,
            transmitted: wi.z < 0.0,
        })
    }

    pub(super) fn albedo(&self, wo: Vec3) -> Vec3 {
        let above = self.above(wo.z);
        let (f0, f90) = self.mixed();
        let energy = Energy::of(self.gloss());
        let mirrored = energy.once(wo.z, f0, f90) + self.more(energy) * (1.0 - energy.white(wo.z));
        let glass =
            if self.parts()[2] > 0.0 { self.glass().albedo(wo) * self.parts()[2] } else { Vec3::ZERO };
        let sheen = self.sheen / self.sheen.max_element().max(1e-6) * above.sheen;
        Vec3::splat(above.coat)
            + (1.0 - above.coat) * sheen
            + above.left() * (mirrored + glass)
            + self.body() * (Vec3::ONE - above.sum())
    }
}
