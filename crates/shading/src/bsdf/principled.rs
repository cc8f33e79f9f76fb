// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF's layered surface: a coat, over sheen, over plastic, metal or glass or a mix, over a diffuse body
//! that reflects or transmits.
//! Source: glTF 2.0 appendix B.3, KHR_materials_{anisotropy, clearcoat, diffuse_transmission, dispersion,
//! ior, iridescence, sheen, specular, transmission}. Differs from glTF's sample code: the body gets the total
//! light that the layers above leave, in both directions, instead of Fresnel's share at the half vector, so
//! that white plastic keeps all light. A body that transmits has panes for its glass, because the refraction
//! of its light is unknown.
//! Tests: `tests` of `bsdf`.

use glam::Vec3;

use super::film::Film;
use super::fresnel;
use super::ggx::SMALLEST_ALPHA;
use super::lobe::Lobe;
use super::lobes::Lobes;

/// glTF's layered surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    /// Albedo of the body, reflectance of the metal at normal incidence, in [0, 1].
    pub base: Vec3,
    /// 0 = plastic, 1 = metal.
    pub metallic: f32,
    /// Width of the microfacets' slopes, in (0, 1]: the square of glTF's roughness.
    pub alpha: f32,
    /// Reflectance of the plastic at normal incidence, in [0, 1].
    pub f0: Vec3,
    /// Reflectance of the plastic at grazing incidence, in [0, 1].
    pub f90: f32,
    /// How much of a coat there is, in [0, 1].
    pub coat: f32,
    /// Width of the slopes of the coat's microfacets, in (0, 1].
    pub coat_alpha: f32,
    /// Unit normal of the coat; zero = that of its point.
    pub coat_normal: Vec3,
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
    /// Unit, about along the surface: where the microfacets' slopes have the width `alpha`, if they have
    /// another across that.
    pub tangent: Vec3,
    /// Width of the slopes across the tangent; 0 = alike in all directions. The coat's are.
    pub across: f32,
    /// A film on plastic, metal and glass, below sheen and coat.
    pub film: Film,
    /// How much greater the glass's index is for blue-green light than for red: see [`Lobe::dispersed`].
    pub spread: f32,
    /// Share of the body's light that it scatters through, in [0, 1].
    pub translucence: f32,
    /// Albedo of that.
    pub beyond: Vec3,
    /// Share of the body's other light that is scattered below the surface, in [0, 1].
    pub subsurface: f32,
    /// Mean free path of that by colour, world units: see [`Lobe::subsurface`].
    pub radius: Vec3,
    /// Mean cosine of its scattering, in (-1, 1).
    pub scattering: f32,
}

impl Principled {
    /// Plastic or metal without a coat; `roughness` and `metallic` are glTF's, in [0, 1].
    #[must_use]
    pub fn new(base: Vec3, metallic: f32, roughness: f32, ior: f32) -> Self {
        Self {
            // Values above 1 would let light between the microfacets grow without limit.
            base: base.clamp(Vec3::ZERO, Vec3::ONE),
            metallic,
            alpha: roughness * roughness,
            f0: Vec3::splat(fresnel::normal_reflectance(ior)),
            f90: 1.0,
            coat: 0.0,
            coat_alpha: 0.0,
            coat_normal: Vec3::ZERO,
            sheen: Vec3::ZERO,
            sheen_roughness: 0.0,
            transmission: 0.0,
            eta: 1.0 / ior,
            thin: false,
            tangent: Vec3::ZERO,
            across: 0.0,
            film: Film::default(),
            spread: 0.0,
            translucence: 0.0,
            beyond: Vec3::ONE,
            subsurface: 0.0,
            radius: Vec3::ZERO,
            scattering: 0.0,
        }
    }
}

impl From<Principled> for Lobes {
    fn from(p: Principled) -> Self {
        let mut lobes = Self::default();
        p.write(&mut lobes);
        lobes
    }
}

impl Principled {
    /// Whether its glass, if any, is too smooth for microfacets: light takes one path through it, so that
    /// rays and light continue straight.
    #[must_use]
    pub fn has_smooth_glass(&self) -> bool {
        self.alpha.max(self.across) <= SMALLEST_ALPHA
    }

    /// Replaces the lobes by its own: `coat over (sheen over (plastic over body, metal and glass by their
    /// shares))`, without intermediate sums, into existing memory, because this runs for every point.
    pub fn write(&self, lobes: &mut Lobes) {
        let p = self;
        lobes.clear();
        let rest = 1.0 - p.metallic;
        let [plastic, metal, glass] = [rest * (1.0 - p.transmission), p.metallic, rest * p.transmission];
        let mut above = 0;
        if p.coat > 0.0 {
            let (weight, normal) = (Vec3::splat(p.coat), p.coat_normal);
            let coat = Lobe { weight, normal, cover: Vec3::splat(p.coat), ..Lobe::coat(p.coat_alpha) };
            above = lobes.put(coat, 0);
        }
        if p.sheen != Vec3::ZERO {
            let cover = Vec3::splat(p.sheen.max_element());
            above |= lobes.put(Lobe { cover, ..Lobe::sheen(p.sheen, p.sheen_roughness) }, above);
        }
        let microfacets = |lobe: Lobe| {
            let brushed = if p.across > 0.0 { lobe.brushed(p.tangent, p.across) } else { lobe };
            if p.film.is_there() { brushed.filmed(p.film) } else { brushed }
        };
        let translucence = p.translucence;
        if plastic > 0.0 {
            let weight = Vec3::splat(plastic);
            let lobe = microfacets(Lobe::microfacets(p.alpha, p.f0, Vec3::splat(p.f90)));
            let above = above | lobes.put(Lobe { weight, cover: Vec3::ONE, ..lobe }, above);
            let body = plastic * (1.0 - translucence);
            if body > 0.0 && p.subsurface < 1.0 {
                let weight = Vec3::splat(body * (1.0 - p.subsurface));
                lobes.put(Lobe { weight, ..Lobe::lambert(p.base) }, above);
            }
            if body > 0.0 && p.subsurface > 0.0 {
                let weight = Vec3::splat(body * p.subsurface);
                lobes.put(Lobe { weight, ..Lobe::subsurface(p.base, p.radius, p.scattering, 1.0) }, above);
            }
            if translucence > 0.0 {
                let weight = Vec3::splat(plastic * translucence);
                lobes.put(Lobe { weight, ..Lobe::translucent(p.beyond) }, above);
            }
        }
        if metal > 0.0 {
            let weight = Vec3::splat(metal);
            lobes.put(Lobe { weight, ..microfacets(Lobe::microfacets(p.alpha, p.base, Vec3::ONE)) }, above);
        }
        if glass > 0.0 {
            let weight = Vec3::splat(glass);
            let thin = p.thin || translucence > 0.0;
            let glass = if p.has_smooth_glass() {
                Lobe::glass(p.eta, Vec3::ONE, p.base, thin).filmed(p.film)
            } else {
                microfacets(Lobe::rough_glass(p.alpha, p.eta, Vec3::ONE, p.base, thin))
            };
            lobes.put(Lobe { weight, ..glass.dispersed(p.spread) }, above);
        }
    }
}
