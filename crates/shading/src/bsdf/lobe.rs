// SPDX-License-Identifier: GPL-3.0-or-later
//! One lobe of a BSDF as numbers: what kind it is, what it counts, around which normal, and its parameters.
//! Source: see the file of each kind. Space: world. Colours are in [0, 1] but for the indices of metals.
//! What is no function of directions is computed when a lobe is made, so that it can be kept. Proof: `tests`.

use glam::Vec3;

use super::{conductor, fresnel, rough_dielectric};

/// What a lobe does to light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Nothing.
    #[default]
    None,
    /// Scatters to all sides; rough surfaces send more back to where light came from.
    Diffuse,
    /// GGX facets under Schlick's reflectances.
    Facets,
    /// GGX facets of a metal by its complex index.
    Metal,
    /// GGX facets that mirror and refract.
    Glass,
    /// The same of a pane so thin that light goes through unbent.
    Pane,
    /// Fibres that stand up.
    Sheen,
    /// Mirrors in one direction.
    Mirror,
    /// Mirrors and refracts, in one direction each.
    SmoothGlass,
    /// The same of a pane.
    SmoothPane,
}

impl Kind {
    /// In the order of their numbers.
    pub(super) const ALL: [Self; 10] = [
        Self::None,
        Self::Diffuse,
        Self::Facets,
        Self::Metal,
        Self::Glass,
        Self::Pane,
        Self::Sheen,
        Self::Mirror,
        Self::SmoothGlass,
        Self::SmoothPane,
    ];

    /// Its place in a set of kinds.
    #[inline(always)]
    #[must_use]
    pub const fn bit(self) -> u32 {
        1 << self as u32
    }

    /// Whether it has no values, only branches.
    #[must_use]
    pub fn is_delta(self) -> bool {
        matches!(self, Self::Mirror | Self::SmoothGlass | Self::SmoothPane)
    }

    /// Whether some of its light goes through the surface.
    #[must_use]
    pub fn goes_through(self) -> bool {
        matches!(self, Self::Glass | Self::Pane | Self::SmoothGlass | Self::SmoothPane)
    }
}

/// One lobe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobe {
    /// What it does to light.
    pub kind: Kind,
    /// Multiplied to it.
    pub weight: Vec3,
    /// Unit normal that it lies around, on the side that the first ray came from; zero = that of its point.
    pub normal: Vec3,
    /// By kind: the albedo; reflectance at normal incidence; index of a metal; tint of what is mirrored.
    pub a: Vec3,
    /// By kind: reflectance at grazing incidence; extinction of a metal; tint of what goes through.
    pub b: Vec3,
    /// Follows from the other parameters: a metal's mean reflectance; what rough glass loses on this side and beyond, and
    /// which share of that ends beyond.
    pub c: Vec3,
    /// Width of facets' slopes, the square of glTF's roughness; the roughness of diffuse and sheen lobes.
    pub alpha: f32,
    /// Index of refraction on the side that rays come from over the index beyond, > 0.
    pub eta: f32,
    /// How much of what it sends back is missing below it.
    pub(super) cover: f32,
    /// Bits of the lobes of its point that lie above it.
    pub(super) under: u32,
}

impl Lobe {
    #[inline]
    fn of(kind: Kind) -> Self {
        Self { kind, weight: Vec3::ONE, eta: 1.0, ..Self::default() }
    }

    /// Lambert's reflector: `albedo` is the share of light that is scattered.
    #[inline]
    #[must_use]
    pub fn lambert(albedo: Vec3) -> Self {
        Self::oren_nayar(albedo, 0.0)
    }

    /// A rough diffuse surface; `albedo` is what white would be all of, `roughness` is in [0, 1], 0 is Lambert's reflector.
    #[inline]
    #[must_use]
    pub fn oren_nayar(albedo: Vec3, roughness: f32) -> Self {
        Self { a: albedo, alpha: roughness, ..Self::of(Kind::Diffuse) }
    }

    /// Facets of width `alpha`, in (0, 1], that mirror `f0` head on and `f90` at grazing incidence.
    #[must_use]
    pub fn facets(alpha: f32, f0: Vec3, f90: Vec3) -> Self {
        Self { a: f0, b: f90, alpha, ..Self::of(Kind::Facets) }
    }

    /// A metal of width `alpha` by its index of refraction (> 0) and its extinction coefficient (>= 0) per channel.
    #[must_use]
    pub fn metal(alpha: f32, eta: Vec3, k: Vec3) -> Self {
        Self { a: eta, b: k, c: conductor::average(eta, k), alpha, ..Self::of(Kind::Metal) }
    }

    /// A perfect mirror.
    #[must_use]
    pub fn mirror(reflectance: Vec3) -> Self {
        Self { a: reflectance, ..Self::of(Kind::Mirror) }
    }

    /// Smooth glass, a pane if `thin`; `eta` is the index on the side that rays come from over the index beyond.
    #[must_use]
    pub fn glass(eta: f32, reflectance: Vec3, transmittance: Vec3, thin: bool) -> Self {
        let (kind, eta) =
            if thin { (Kind::SmoothPane, eta.min(1.0 / eta)) } else { (Kind::SmoothGlass, eta) };
        Self { a: reflectance, b: transmittance, eta, ..Self::of(kind) }
    }

    /// The same with facets of width `alpha`, in (0, 1].
    #[must_use]
    pub fn rough_glass(alpha: f32, eta: f32, reflectance: Vec3, transmittance: Vec3, thin: bool) -> Self {
        let (eta, c) = rough_dielectric::losses(alpha, eta, thin);
        let kind = if thin { Kind::Pane } else { Kind::Glass };
        Self { a: reflectance, b: transmittance, c, alpha, eta, ..Self::of(kind) }
    }

    /// Fibres of a colour that stand up; `roughness` is glTF's, in [0, 1].
    #[must_use]
    pub fn sheen(color: Vec3, roughness: f32) -> Self {
        Self { weight: color, alpha: roughness, ..Self::of(Kind::Sheen) }
    }

    /// A clear coat: facets of an index of 1.5.
    #[must_use]
    pub fn coat(alpha: f32) -> Self {
        Self::facets(alpha, Vec3::splat(fresnel::normal_reflectance(1.5)), Vec3::ONE)
    }

    /// Whether facets narrower than `alpha`, or none, send its light.
    #[must_use]
    pub fn is_narrow(&self, alpha: f32) -> bool {
        match self.kind {
            Kind::Facets | Kind::Metal | Kind::Glass | Kind::Pane => self.alpha < alpha,
            kind => kind.is_delta(),
        }
    }

    /// Whether it scatters nothing.
    #[must_use]
    pub fn is_black(&self) -> bool {
        self.kind == Kind::None || self.weight == Vec3::ZERO
    }

    /// Index of refraction for light that goes through; 1 where it is not bent.
    pub(super) fn bending(&self) -> f32 {
        if matches!(self.kind, Kind::Glass | Kind::SmoothGlass) { self.eta } else { 1.0 }
    }
}
