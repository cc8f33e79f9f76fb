// SPDX-License-Identifier: GPL-3.0-or-later
//! What surfaces do to light, as plain values: a BSDF per point that can be evaluated, sampled and asked for densities.
//! Source: \[PJH23\] chapter 9 (interface), \[Vea97\] section 5.3 (shading normals and light-carrying paths); one lobe, one
//! file; docs/materials.md tells the models.
//! Space: world outside, the shading frame inside (z = the shading normal on the side that the first ray came from).
//! `wo` points to where the path came from, `wi` to where it goes; both unit and away from the surface.
//! Invariants: values are BSDF times |cos| to the shading normal. Reflection is the same with `wo` and `wi` exchanged but
//! for that cosine. Refraction does not scale radiance by the square of the index, for what enters glass leaves it again;
//! so with `wo` and `wi` exchanged it changes by that square: [`Bsdf::adjoint_correction`].
//! Rule for shading normals: a path that sees the surface sees its front, so a `wo` below the shading normal counts as
//! grazing; a `wi` counts by the side of the shading normal that it is on, and whether it may leave at all is said by
//! [`SurfacePoint::scatter_ray`](crate::SurfacePoint::scatter_ray), with the same horizon as for light samples.
//! Proof: `tests`.

mod conductor;
mod dielectric;
mod energy;
mod facets;
pub(crate) mod fresnel;
mod ggx;
mod lambert;
mod lobes;
mod mirror;
mod oren_nayar;
mod principled;
mod rough_dielectric;
mod sample;
mod sheen;
#[cfg(test)]
mod tests;

use glam::Vec3;

use crate::batch::SurfaceBatch;
use crate::sampling::{Basis, cosine_hemisphere_by_series};

pub use conductor::{Conductor, Reflectance};
pub use dielectric::Dielectric;
pub use energy::SentBack;
pub use facets::{FacetLanes, Facets};
use lobes::Lobes;
pub use principled::Principled;
pub use rough_dielectric::RoughDielectric;
pub use sample::BsdfSample;

/// The BSDF of one point. Plain data: it outlives the batch that it was made from.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    basis: Basis,
    model: Model,
}

/// How a point scatters.
#[derive(Clone, Copy, Debug)]
pub enum Model {
    /// Not at all.
    Black,
    /// Alike to all sides, on the side that light comes from.
    Lambert {
        /// Share of light that is scattered.
        albedo: Vec3,
    },
    /// One of the simple models.
    Lobe(Lobe),
    /// Two simple models side by side.
    Mix {
        /// The first.
        a: Lobe,
        /// The second.
        b: Lobe,
        /// Share of the second, in [0, 1].
        share_b: f32,
    },
    /// glTF's layered surface.
    Principled(Principled),
}

/// Models without parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobe {
    /// Scatters nothing.
    Black,
    /// Alike to all sides.
    Lambert {
        /// Share of light that is scattered.
        albedo: Vec3,
    },
    /// Rough and diffuse: more light goes back to where it came from.
    OrenNayar {
        /// What white would be all of, in [0, 1].
        albedo: Vec3,
        /// In [0, 1]; 0 is Lambert's reflector.
        roughness: f32,
    },
    /// A perfect mirror.
    Mirror {
        /// Share of light that is mirrored.
        reflectance: Vec3,
    },
    /// Smooth glass.
    Dielectric(Dielectric),
    /// A rough metal.
    Conductor(Conductor),
    /// Rough glass.
    RoughDielectric(RoughDielectric),
}

/// Cosine: a `wo` nearer to the shading normal's horizon than this, or below it, counts as that near.
pub const GRAZING: f32 = 1e-3;

impl Bsdf {
    /// A BSDF around the unit shading normal `ns`, which is on the side that the first ray came from.
    #[must_use]
    pub fn new(ns: Vec3, model: Model) -> Self {
        Self { basis: Basis::around(ns), model }
    }

    /// Scatters nothing.
    #[must_use]
    pub fn black(ns: Vec3) -> Self {
        Self::new(ns, Model::Black)
    }

    /// The shading normal that it is made around.
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        self.basis.normal
    }

    /// The model and its parameters.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// `wo` in the frame, raised to where it can see the front.
    fn local_wo(&self, wo: Vec3) -> Vec3 {
        let wo = self.basis.to_local(wo);
        if wo.z >= GRAZING { wo } else { Vec3::new(wo.x, wo.y, GRAZING).normalize() }
    }

    /// BSDF times |cos| of `wi` to the shading normal; delta lobes count nothing.
    #[must_use]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if let Model::Lambert { albedo } = self.model {
            return lambert::eval(albedo, self.basis.normal.dot(wi));
        }
        let (wo, wi) = (self.local_wo(wo), self.basis.to_local(wi));
        match &self.model {
            Model::Black => Vec3::ZERO,
            Model::Lambert { albedo } => lambert::eval(*albedo, wi.z),
            Model::Lobe(lobe) => lobe.eval(wo, wi),
            Model::Mix { a, b, share_b } => a.eval(wo, wi).lerp(b.eval(wo, wi), *share_b),
            Model::Principled(principled) => principled.eval(wo, wi),
        }
    }

    /// Density per solid angle with which [`sample`](Self::sample) chooses `wi`; delta lobes count nothing.
    #[must_use]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if let Model::Lambert { .. } = self.model {
            return lambert::pdf(self.basis.normal.dot(wi));
        }
        let (wo, wi) = (self.local_wo(wo), self.basis.to_local(wi));
        match &self.model {
            Model::Black => 0.0,
            Model::Lambert { .. } => lambert::pdf(wi.z),
            Model::Lobe(lobe) => lobe.pdf(wo, wi),
            Model::Mix { a, b, share_b } => {
                let q = chance_of_b(a, b, *share_b, wo);
                (1.0 - q) * a.pdf(wo, wi) + q * b.pdf(wo, wi)
            }
            Model::Principled(principled) => principled.pdf(wo, wi),
        }
    }

    /// Chooses where a path goes on; `u` holds three numbers in [0, 1), the first chooses between lobes. `None` = it
    /// ends here.
    #[must_use]
    pub fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let wo = self.local_wo(wo);
        let local = match &self.model {
            Model::Black => None,
            Model::Lambert { albedo } => lambert::sample(*albedo, [u[1], u[2]]),
            Model::Lobe(lobe) => lobe.sample(wo, u),
            Model::Mix { a, b, share_b } => sample_mix(a, b, *share_b, wo, u),
            Model::Principled(principled) => principled.sample(wo, u),
        }?;
        self.in_world(local)
    }

    /// [`sample`](Self::sample), with directions from Lambert's reflector as lanes choose them: see
    /// [`cosine_hemisphere_by_series`].
    #[must_use]
    pub fn sample_by_series(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        match self.model {
            Model::Lambert { albedo } => {
                let wi = cosine_hemisphere_by_series([u[1], u[2]]);
                self.in_world(lambert::sample_of(albedo, wi)?)
            }
            _ => self.sample(wo, u),
        }
    }

    /// What leaves by delta lobes, mirrored and through the surface, each with its share of the light.
    #[must_use]
    pub fn delta_branches(&self, wo: Vec3) -> [Option<BsdfSample>; 2] {
        let wo = self.local_wo(wo);
        let branches = match &self.model {
            Model::Lobe(lobe) => lobe.delta_branches(wo),
            Model::Mix { a, b, share_b } => {
                let ([a0, a1], [b0, b1]) = (a.delta_branches(wo), b.delta_branches(wo));
                [mix_branch(a0, b0, *share_b), mix_branch(a1, b1, *share_b)]
            }
            _ => [None; 2],
        };
        branches.map(|branch| self.in_world(branch?))
    }

    fn in_world(&self, local: BsdfSample) -> Option<BsdfSample> {
        let wi = self.basis.to_world(local.wi).normalize();
        (wi.is_finite() && local.weight.is_finite()).then_some(BsdfSample { wi, ..local })
    }

    /// Share of light from `wo` that is scattered to all sides, in [0, 1] per channel; about, where no closed form is known.
    #[must_use]
    pub fn albedo(&self, wo: Vec3) -> Vec3 {
        let wo = self.local_wo(wo);
        match &self.model {
            Model::Black => Vec3::ZERO,
            Model::Lambert { albedo } => *albedo,
            Model::Lobe(lobe) => lobe.albedo(wo),
            Model::Mix { a, b, share_b } => a.albedo(wo).lerp(b.albedo(wo), *share_b),
            Model::Principled(principled) => principled.albedo(wo),
        }
    }

    /// The albedo of a point that scatters alike to all sides, and does nothing else.
    #[must_use]
    pub fn lambertian(&self) -> Option<Vec3> {
        match self.model {
            Model::Lambert { albedo } => Some(albedo),
            Model::Lobe(_) | Model::Mix { .. } | Model::Principled(_) => None,
            Model::Black => Some(Vec3::ZERO),
        }
    }

    /// Whether light samples can bring anything: some lobe is not a delta.
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        match &self.model {
            Model::Black => false,
            Model::Lambert { .. } | Model::Principled(_) => true,
            Model::Lobe(lobe) => lobe.is_smooth(),
            Model::Mix { a, b, .. } => a.is_smooth() || b.is_smooth(),
        }
    }

    /// Whether it scatters nothing at all.
    #[must_use]
    pub fn is_black(&self) -> bool {
        matches!(self.model, Model::Black | Model::Lobe(Lobe::Black))
    }

    /// The narrow lobes, with facets whose slopes are narrower than `alpha`, and the wide ones: together they are the
    /// BSDF. For integrators that trace what is nearly a mirror image and sample lights for the rest.
    #[must_use]
    pub fn split_at(&self, alpha: f32) -> [Self; 2] {
        let with = |model| Self { basis: self.basis, model };
        let black = with(Model::Black);
        match self.model {
            Model::Black => [black; 2],
            Model::Lambert { .. } => [black, *self],
            Model::Lobe(lobe) => {
                if lobe.is_narrow(alpha) {
                    [*self, black]
                } else {
                    [black, *self]
                }
            }
            Model::Mix { a, b, share_b } => {
                let part = |narrow: bool| {
                    let keep = |lobe: Lobe| if lobe.is_narrow(alpha) == narrow { lobe } else { Lobe::Black };
                    match (keep(a), keep(b)) {
                        (Lobe::Black, Lobe::Black) => black,
                        (a, b) => with(Model::Mix { a, b, share_b }),
                    }
                };
                [part(true), part(false)]
            }
            Model::Principled(principled) => principled
                .split_at(alpha)
                .map(|part| part.map_or(black, |principled| with(Model::Principled(principled)))),
        }
    }

    /// What a path that carries light multiplies to [`eval`](Self::eval) and to weights of samples, where `wo` points
    /// to where the light came from and `wi` to where it goes: shading normals treat light and its measurement
    /// differently \[Vea97\], and so does refraction. `ng` is the unit geometric normal, on either side. Zero where light
    /// comes from below the shading normal: there light samples bring nothing, either.
    #[must_use]
    pub fn adjoint_correction(&self, wo: Vec3, wi: Vec3, ng: Vec3) -> f32 {
        let ns = self.basis.normal;
        let (so, si) = (ns.dot(wo), ns.dot(wi));
        let (go, gi) = (ng.dot(wo), ng.dot(wi));
        if so <= 0.0 || si == 0.0 || go == 0.0 {
            return 0.0;
        }
        let eta = if si < 0.0 { self.eta() } else { 1.0 };
        (so * gi / (go * si)).abs() * eta * eta
    }

    /// Whether light samples from behind the surface can bring anything.
    #[must_use]
    pub fn is_translucent(&self) -> bool {
        let rough = |lobe: &Lobe| matches!(lobe, Lobe::RoughDielectric(_));
        match &self.model {
            Model::Lobe(lobe) => rough(lobe),
            Model::Mix { a, b, .. } => rough(a) || rough(b),
            Model::Principled(p) => p.transmission > 0.0 && p.metallic < 1.0,
            Model::Black | Model::Lambert { .. } => false,
        }
    }

    /// Whether `wi` lies beyond the surface, on the side that the first ray did not come from.
    #[inline]
    #[must_use]
    pub fn is_transmitted(&self, wi: Vec3) -> bool {
        self.basis.normal.dot(wi) < 0.0
    }

    /// Index of refraction on the side of the first ray over the index beyond; 1 where nothing is refracted.
    #[must_use]
    pub fn eta(&self) -> f32 {
        match &self.model {
            Model::Lobe(lobe) => lobe.eta(),
            Model::Mix { a, b, .. } => {
                if a.eta() == 1.0 {
                    b.eta()
                } else {
                    a.eta()
                }
            }
            Model::Principled(p) if p.transmission > 0.0 && !p.thin => p.eta,
            _ => 1.0,
        }
    }
}

impl Lobe {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        match self {
            Self::Black | Self::Mirror { .. } | Self::Dielectric(_) => Vec3::ZERO,
            Self::Lambert { albedo } => lambert::eval(*albedo, wi.z),
            Self::OrenNayar { albedo, roughness } => oren_nayar::eval(*albedo, *roughness, wo, wi),
            Self::Conductor(conductor) => conductor.eval(wo, wi),
            Self::RoughDielectric(glass) => glass.eval(wo, wi),
        }
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self {
            Self::Black | Self::Mirror { .. } | Self::Dielectric(_) => 0.0,
            Self::Lambert { .. } | Self::OrenNayar { .. } => lambert::pdf(wi.z),
            Self::Conductor(conductor) => conductor.pdf(wo, wi),
            Self::RoughDielectric(glass) => glass.pdf(wo, wi),
        }
    }

    fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        match self {
            Self::Black => None,
            Self::Lambert { albedo } => lambert::sample(*albedo, [u[1], u[2]]),
            Self::Mirror { reflectance } => mirror::sample(*reflectance, wo),
            Self::Dielectric(dielectric) => dielectric.sample(wo, u[0]),
            Self::OrenNayar { albedo, roughness } => {
                let sample = lambert::sample(Vec3::ONE, [u[1], u[2]])?;
                let value = oren_nayar::eval(*albedo, *roughness, wo, sample.wi);
                Some(BsdfSample { weight: value / sample.pdf, ..sample })
            }
            Self::Conductor(conductor) => conductor.sample(wo, u),
            Self::RoughDielectric(glass) => glass.sample(wo, u),
        }
    }

    fn delta_branches(&self, wo: Vec3) -> [Option<BsdfSample>; 2] {
        match self {
            Self::Mirror { reflectance } => [mirror::sample(*reflectance, wo), None],
            Self::Dielectric(dielectric) => dielectric.branches(wo),
            _ => [None; 2],
        }
    }

    fn albedo(&self, wo: Vec3) -> Vec3 {
        match self {
            Self::Black => Vec3::ZERO,
            Self::Lambert { albedo } => *albedo,
            Self::Mirror { reflectance } => *reflectance,
            Self::Dielectric(dielectric) => dielectric.albedo(wo),
            Self::OrenNayar { albedo, roughness } => oren_nayar::albedo(*albedo, *roughness, wo),
            Self::Conductor(conductor) => conductor.albedo(wo),
            Self::RoughDielectric(glass) => glass.albedo(wo),
        }
    }

    fn is_smooth(&self) -> bool {
        !matches!(self, Self::Black | Self::Mirror { .. } | Self::Dielectric(_))
    }

    fn is_narrow(&self, alpha: f32) -> bool {
        match self {
            Self::Black | Self::Lambert { .. } | Self::OrenNayar { .. } => false,
            Self::Mirror { .. } | Self::Dielectric(_) => true,
            Self::Conductor(conductor) => conductor.alpha() < alpha,
            Self::RoughDielectric(glass) => glass.alpha() < alpha,
        }
    }

    fn eta(&self) -> f32 {
        match self {
            Self::Dielectric(dielectric) if !dielectric.thin => dielectric.eta,
            Self::RoughDielectric(glass) => glass.eta(),
            _ => 1.0,
        }
    }
}

/// Probability with which a mix draws from its second model: by the light that each scatters.
fn chance_of_b(a: &Lobe, b: &Lobe, share_b: f32, wo: Vec3) -> f32 {
    let part = |lobe: &Lobe, share: f32| share * lobe.albedo(wo).max_element();
    let (a, b) = (part(a, 1.0 - share_b), part(b, share_b));
    if a + b > 0.0 { b / (a + b) } else { share_b }
}

fn sample_mix(a: &Lobe, b: &Lobe, share_b: f32, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
    let q = chance_of_b(a, b, share_b, wo);
    let (lobe, share, chance, first) = if u[0] < q {
        (b, share_b, q, u[0] / q)
    } else {
        (a, 1.0 - share_b, 1.0 - q, (u[0] - q) / (1.0 - q))
    };
    let sample = lobe.sample(wo, [first.min(0.999_999_9), u[1], u[2]])?;
    if sample.delta {
        return Some(BsdfSample { weight: sample.weight * (share / chance), ..sample });
    }
    let pdf = (1.0 - q) * a.pdf(wo, sample.wi) + q * b.pdf(wo, sample.wi);
    let value = a.eval(wo, sample.wi).lerp(b.eval(wo, sample.wi), share_b);
    (pdf > 0.0).then(|| BsdfSample { weight: value / pdf, pdf, ..sample })
}

fn mix_branch(a: Option<BsdfSample>, b: Option<BsdfSample>, share_b: f32) -> Option<BsdfSample> {
    let scaled = |s: BsdfSample, share: f32| BsdfSample { weight: s.weight * share, ..s };
    match (a, b) {
        // Two refractions of one mix differ in direction if their indices do: the heavier one stands for both.
        (Some(a), Some(b)) => {
            let (a, b) = (scaled(a, 1.0 - share_b), scaled(b, share_b));
            let wi = if a.weight.element_sum() >= b.weight.element_sum() { a.wi } else { b.wi };
            Some(BsdfSample { wi, weight: a.weight + b.weight, ..a })
        }
        (a, b) => a.map(|a| scaled(a, 1.0 - share_b)).or(b.map(|b| scaled(b, share_b))),
    }
}

/// All that light transport needs to know of a point.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    /// What it does to light.
    pub bsdf: Bsdf,
    /// Radiance that it sends against the ray.
    pub emission: Vec3,
    /// Share of light that the surface stops, in [0, 1]; the rest goes straight on as if nothing were there.
    pub coverage: f32,
}

impl Scattering {
    /// A point of lane `i` that only scatters, around its mesh's shading normal.
    #[must_use]
    pub fn new(hits: &SurfaceBatch, i: usize, model: Model) -> Self {
        Self::around(hits.facing_ns(i), model)
    }

    /// A point that only scatters, around the unit shading normal `ns`.
    #[must_use]
    pub fn around(ns: Vec3, model: Model) -> Self {
        Self { bsdf: Bsdf::new(ns, model), emission: Vec3::ZERO, coverage: 1.0 }
    }
}

/// [`Bsdf::eval`] of many points, with the densities: `out[i]` = value and density of `bsdfs[i]` from `wo[i]` to `wi[i]`.
/// All slices are of one length; what is beyond the shortest is left as it is.
pub fn eval_all(bsdfs: &[Bsdf], wo: &[Vec3], wi: &[Vec3], out: &mut [(Vec3, f32)]) {
    for (((bsdf, &wo), &wi), out) in bsdfs.iter().zip(wo).zip(wi).zip(out) {
        *out = (bsdf.eval(wo, wi), bsdf.pdf(wo, wi));
    }
}

/// [`Bsdf::sample`] of many points; the slices as in [`eval_all`].
pub fn sample_all(bsdfs: &[Bsdf], wo: &[Vec3], u: &[[f32; 3]], out: &mut [Option<BsdfSample>]) {
    for (((bsdf, &wo), &u), out) in bsdfs.iter().zip(wo).zip(u).zip(out) {
        *out = bsdf.sample(wo, u);
    }
}
