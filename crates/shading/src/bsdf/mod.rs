// SPDX-License-Identifier: GPL-3.0-or-later
//! Scattering of surfaces as plain values: weighted lobes for each point. They can be evaluated, sampled and
//! queried for densities, one point at a time ([`Bsdf`]) or sixteen ([`ClosureBatch`]), by the same code.
//! Source: \[PJH23\] chapter 9 (interface), \[Vea97\] section 5.3 (shading normals and light-carrying paths);
//! one lobe, one file; docs/reference/materials.md describes the models.
//! Space: world outside, the shading frame inside (z = the shading normal on the side that the first ray came from).
//! `wo` points back along the path, `wi` forward; both are unit vectors away from the surface. Invariants:
//! values are BSDF times |cos| to the shading normal. Reflection is reciprocal except for that cosine.
//! Refraction does not scale radiance by the square of the index, because light that enters glass leaves it
//! again; so with `wo` and `wi` exchanged it changes by that square. [`Carrying`] handles this for paths that
//! carry light; it also handles lobes with their own normals, and fibres, whose values are not reciprocal.
//! Rule for shading normals: a path always sees the front of a surface, so a `wo` below the shading normal
//! counts as grazing. A `wi` counts by its side of the shading normal;
//! [`SurfacePoint::scatter_ray`](crate::SurfacePoint::scatter_ray) decides whether it may leave, with the
//! same horizon as for light samples.
//! Tests: `tests`.

mod anisotropy;
mod batch;
mod beckmann;
#[cfg(test)]
mod between_facets_tests;
mod cached_lobes;
mod carrying;
#[cfg(test)]
mod carrying_tests;
mod conductor;
mod dielectric;
mod diffuse_once;
mod dispersed;
mod energy;
mod exchange;
mod fibres;
mod film;
pub(crate) mod fresnel;
mod ggx;
mod hair;
#[cfg(test)]
mod layers_tests;
mod lists;
mod lobe;
mod lobes;
mod lobes_at;
mod medium;
mod oren_nayar;
mod phong;
mod prepared;
mod prepared_glass;
mod prepared_lobe;
mod prepared_scalar;
mod prepared_sum;
mod prepared_values;
mod principled;
mod rough_dielectric;
mod rough_fibre;
#[cfg(test)]
mod rough_fibre_tests;
mod sample;
mod scalar_lobes;
mod sheen;
#[cfg(test)]
mod smooth_tests;
mod strand;
mod subsurface;
#[cfg(test)]
mod tests;
mod toon;
mod ward;

use glam::Vec3;

pub use batch::ClosureBatch;
pub use cached_lobes::CachedLobes;
pub use carrying::Carrying;
pub use film::Film;
pub use lists::{Ends, Lists};
pub use lobe::{BetweenFacets, Kind, Lobe};
pub use lobes::{Lobes, MOST};
pub use medium::{Medium, left_after};
pub use prepared::{Prepared, Sampled};
pub use prepared_values::GRAZING;
pub use principled::Principled;
pub use sample::BsdfSample;
pub use subsurface::Entry;

/// The BSDF of one point. Plain data: it outlives the batch that it was made from.
#[derive(Clone, Debug)]
pub struct Bsdf {
    normal: Vec3,
    lobes: Lobes,
    medium: Medium,
}

impl Bsdf {
    /// A BSDF around the unit shading normal `ns`, which is on the side that the first ray came from.
    #[must_use]
    pub fn new(ns: Vec3, lobes: impl Into<Lobes>) -> Self {
        Self { normal: ns, lobes: lobes.into(), medium: Medium::default() }
    }

    /// The same with something on one of its sides.
    #[must_use]
    pub fn neighbours(self, medium: Medium) -> Self {
        Self { medium, ..self }
    }

    /// The media beside it.
    #[inline]
    #[must_use]
    pub fn medium(&self) -> Medium {
        self.medium
    }

    /// Absorption along rays that leave to `dir` or come from there, 1 over world units: by the medium on
    /// that side, for [`left_after`].
    #[inline]
    #[must_use]
    pub fn absorption(&self, dir: Vec3) -> Vec3 {
        if self.medium.absorption == Vec3::ZERO {
            return Vec3::ZERO;
        }
        self.medium.on(!self.is_transmitted(dir))
    }

    /// Scatters nothing.
    #[must_use]
    pub fn black(ns: Vec3) -> Self {
        Self::new(ns, Lobes::default())
    }

    /// The shading normal that it is made around.
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// The lobes.
    #[must_use]
    pub fn lobes(&self) -> &Lobes {
        &self.lobes
    }

    /// It as it is seen from `wo`: for many questions about one direction.
    #[must_use]
    pub fn prepared(&self, wo: Vec3) -> Prepared<f32> {
        self.prepared_for(wo, Vec3::ONE)
    }

    /// The same where the light that it scatters will count `light` by colour: glass that bends colours into different directions then
    /// chooses them by that. Values stay the same, densities are others.
    #[must_use]
    pub fn prepared_for(&self, wo: Vec3, light: Vec3) -> Prepared<f32> {
        Prepared::of_point(self.lobes.as_slice(), self.normal, wo, light)
    }

    /// Whether some of its glass bends colours into different directions.
    #[must_use]
    pub fn is_dispersed(&self) -> bool {
        self.any(Lobe::is_dispersed)
    }

    /// BSDF times |cos| of `wi` to the shading normal, and the density per solid angle with which [`sample`](Self::sample)
    /// chooses it; delta lobes count nothing.
    #[must_use]
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let (value, pdf) = self.prepared(wo).eval_pdf(wi.into());
        (value.into(), pdf)
    }

    /// The value only.
    #[must_use]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.eval_pdf(wo, wi).0
    }

    /// The density only.
    #[must_use]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_pdf(wo, wi).1
    }

    /// The share of lobes that send light to all sides in [`eval`](Self::eval), by colour, in [0, 1].
    #[must_use]
    pub fn wide_share(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.prepared(wo).wide_share(wi)
    }

    /// Chooses the next direction of a path; `u` holds three numbers in [0, 1), the first chooses between
    /// lobes. `None` = it ends here.
    #[must_use]
    pub fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        self.sample_by(wo, Vec3::ONE, u)
    }

    /// The same where the light that it scatters will count `light` by colour; see [`prepared_for`](Self::prepared_for).
    #[must_use]
    pub fn sample_by(&self, wo: Vec3, light: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        self.prepared_for(wo, light).sample(u).of_point()
    }

    /// Directions of delta lobes, reflected and transmitted, each with its share of the light.
    #[must_use]
    pub fn delta_branches(&self, wo: Vec3) -> [Option<BsdfSample>; 2] {
        let [mirrored, through] = self.prepared(wo).delta_branches();
        let branch = |branch: Option<(Vec3, Vec3)>, transmitted| {
            let (wi, weight) = branch?;
            Some(BsdfSample { wi, weight, pdf: f32::INFINITY, delta: true, transmitted, wide: false })
        };
        [branch(mirrored, false), branch(through, true)]
    }

    /// Where all light goes that comes straight through smooth glass towards `wo`, unit, and its share; `None` where nothing does, or
    /// where it comes from several directions: by colour, or by lobes that bend it differently.
    #[must_use]
    pub fn straight(&self, wo: Vec3) -> Option<(Vec3, Vec3)> {
        let mut glass = self.lobes.as_slice().iter().filter(|lobe| lobe.is_clear());
        let refracts_once = glass.next().is_some_and(|lobe| !lobe.is_dispersed()) && glass.next().is_none();
        let [_, through] = refracts_once.then(|| self.delta_branches(wo))?;
        through.map(|sample| (sample.wi, sample.weight))
    }

    /// Share of light from `wo` that is scattered to all sides, in [0, 1] per channel; about, where no closed form is known.
    #[must_use]
    pub fn albedo(&self, wo: Vec3) -> Vec3 {
        self.prepared(wo).albedo().into()
    }

    /// The same in four parts: diffuse reflection, other reflection, diffuse transmission, other transmission.
    #[must_use]
    pub fn albedo_parts(&self, wo: Vec3) -> [Vec3; 4] {
        let of = |lobes: Lobes| Self { lobes, normal: self.normal, medium: self.medium }.albedo(wo);
        let reflected = of(self.lobes.clone().reflecting());
        let diffuse =
            of(self.lobes.clone().filtered(|lobe| lobe.kind.is_wide() && !lobe.kind.goes_through()));
        let beyond = of(self.lobes.clone().filtered(|lobe| lobe.kind == Kind::Translucent));
        let part = |whole: Vec3, less: Vec3| (whole - less).max(Vec3::ZERO);
        [diffuse, part(reflected, diffuse), beyond, part(self.albedo(wo), reflected + beyond)]
    }

    /// The albedo of a point that scatters alike to all sides, and does nothing else.
    #[must_use]
    pub fn lambertian(&self) -> Option<Vec3> {
        self.lobes.lambertian()
    }

    fn any(&self, what: impl Fn(&Lobe) -> bool) -> bool {
        self.lobes.as_slice().iter().any(|lobe| !lobe.is_black() && what(lobe))
    }

    /// Whether light samples can bring anything: some lobe is not a delta.
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        self.any(|lobe| !lobe.kind.is_delta())
    }

    /// Whether some of its light leaves by mirrors or smooth glass.
    #[must_use]
    pub fn has_deltas(&self) -> bool {
        self.any(|lobe| lobe.kind.is_delta())
    }

    /// Whether it scatters nothing at all.
    #[must_use]
    pub fn is_black(&self) -> bool {
        !self.any(|_| true)
    }

    /// The narrow lobes, with microfacets whose slopes are narrower than `alpha`, and the wide ones: together
    /// they are the BSDF. For integrators that trace near-mirror reflections and sample lights for the rest.
    #[must_use]
    pub fn split_at(&self, alpha: f32) -> [Self; 2] {
        [true, false].map(|narrow| Self {
            lobes: self.lobes.clone().filtered(|lobe| lobe.is_narrow(alpha) == narrow),
            normal: self.normal,
            medium: self.medium,
        })
    }

    /// Whether light samples from behind the surface can bring anything.
    #[must_use]
    pub fn is_translucent(&self) -> bool {
        self.any(|lobe| lobe.kind.goes_through() && !lobe.kind.is_delta())
    }

    /// Whether `wi` lies beyond the surface, on the side that the first ray did not come from.
    #[inline]
    #[must_use]
    pub fn is_transmitted(&self, wi: Vec3) -> bool {
        self.normal.dot(wi) < 0.0
    }

    /// Indices of refraction on the side of the first ray over those beyond, for red, green and blue; 1 where nothing is refracted.
    #[must_use]
    pub fn etas(&self) -> Vec3 {
        self.lobes.as_slice().iter().map(Lobe::bending).find(|&etas| etas != Vec3::ONE).unwrap_or(Vec3::ONE)
    }
}

/// The complete scattering and emission of a point.
#[derive(Clone, Debug)]
pub struct Scattering {
    /// Its scattering.
    pub bsdf: Bsdf,
    /// Radiance that it sends against the ray, whatever share of light it stops.
    pub emission: Vec3,
    /// Share of paths that the surface stops, in [0, 1]; the rest goes straight on as if nothing were there.
    pub coverage: f32,
    /// The factor of light that goes straight on.
    pub passing: Vec3,
}
