// SPDX-License-Identifier: GPL-3.0-or-later
//! Rare parts of materials: an interior, brushed microfacets, a thin film, light below the surface or through it.
//! Source: KHR_materials_{anisotropy, diffuse_transmission, dispersion, iridescence, volume}, which define
//! the numbers; \[CKB16\] (subsurface). Units: world units, nanometres, radians. Tests: `tests` here and `tests/gltf.rs`.

use serde::{Deserialize, Serialize};

use crate::medium::single_albedo;
use crate::texture::TextureRef;

/// The interior of solid glass. Glass that is thin has no inside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interior {
    /// Transmittance of white light over the distance below, in `[0, 1]`.
    pub attenuation_color: [f32; 3],
    /// World units, > 0; infinite = nothing is absorbed.
    pub attenuation_distance: f32,
    /// 20 over Abbe's number: the dispersion; 0 = none.
    pub dispersion: f32,
    /// KHR_materials_volume_scatter: the colour of a thick body by light that is scattered many times, in `[0, 1]`;
    /// black = light is only absorbed.
    pub scatter_color: [f32; 3],
    /// The same: mean cosine of scattered light, in (-1, 1).
    pub scatter_anisotropy: f32,
}

impl Default for Interior {
    /// Clear.
    fn default() -> Self {
        Self {
            attenuation_color: [1.0; 3],
            attenuation_distance: f32::INFINITY,
            dispersion: 0.0,
            scatter_color: [0.0; 3],
            scatter_anisotropy: 0.0,
        }
    }
}

impl Interior {
    /// Scattering coefficient, 1 over world units, by colour: a part of what the attenuation takes.
    #[must_use]
    pub fn scattering(&self) -> [f32; 3] {
        let extinction = self.absorption();
        std::array::from_fn(|c| {
            let color = self.scatter_color[c];
            if color > 0.0 { extinction[c] * single_albedo(color, self.anisotropy()) } else { 0.0 }
        })
    }

    /// The mean cosine of scattered light, as a number that a phase function can have.
    #[must_use]
    pub fn anisotropy(&self) -> f32 {
        let g = self.scatter_anisotropy;
        if g.is_finite() { g.clamp(-0.99, 0.99) } else { 0.0 }
    }

    /// Absorption coefficient (extinction, if it scatters), 1 over world units, by colour: Beer's law has the exponential of minus it
    /// times the distance.
    #[must_use]
    pub fn absorption(&self) -> [f32; 3] {
        // A colour of nothing would be infinitely much of it.
        const DARKEST: f32 = 1e-6;
        let distance = self.attenuation_distance;
        self.attenuation_color.map(|left| {
            let most = -left.clamp(DARKEST, 1.0).ln() / distance;
            if distance > 0.0 && most.is_finite() { most.max(0.0) } else { 0.0 }
        })
    }

    /// How much greater the index of glass is for blue-green light (486.1 nm) than for red (656.3 nm), its index for yellow being `ior`.
    #[must_use]
    pub fn spread(&self, ior: f32) -> f32 {
        let dense = ior.max(1.0 / ior);
        let spread = (dense - 1.0) * self.dispersion / 20.0;
        if spread.is_finite() { spread.max(0.0) } else { 0.0 }
    }
}

/// Anisotropic microfacets: rougher along one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Anisotropy {
    /// In `[0, 1]`; the facets' width along the direction goes from that of the roughness to 1 with its square.
    pub strength: f32,
    /// From the direction in which the texture's u grows, counter-clockwise, radians.
    pub rotation: f32,
    /// Red and green: the direction, `2 texel - 1`, before its rotation; blue: multiplied to the strength.
    pub texture: Option<TextureRef>,
}

/// A thin film, whose two sides' reflections interfere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Iridescence {
    /// Share of the surface that it is on, in `[0, 1]`.
    pub factor: f32,
    /// Index of refraction, >= 1.
    pub ior: f32,
    /// Nanometres.
    pub thickness: f32,
    /// Nanometres, where the texture of the thickness is 0.
    pub least_thickness: f32,
}

impl Default for Iridescence {
    /// None.
    fn default() -> Self {
        Self { factor: 0.0, ior: 1.3, thickness: 400.0, least_thickness: 100.0 }
    }
}

/// A body that scatters light through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiffuseTransmission {
    /// Share of the body's light that goes through, in `[0, 1]`.
    pub factor: f32,
    /// Its colour.
    pub color: [f32; 3],
}

impl Default for DiffuseTransmission {
    /// None.
    fn default() -> Self {
        Self { factor: 0.0, color: [1.0; 3] }
    }
}

/// Light that enters an opaque body, is scattered below its surface, and leaves elsewhere: skin, wax, marble, milk.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Subsurface {
    /// Share of the body's light that does so, in `[0, 1]`. Its colour is the base colour.
    pub factor: f32,
    /// Mean free path between scattering events by colour, world units, >= 0; 0 = that colour leaves where it enters.
    pub radius: [f32; 3],
    /// Mean cosine of scattered light, in (-1, 1).
    pub anisotropy: f32,
}

impl Default for Subsurface {
    /// None.
    fn default() -> Self {
        Self { factor: 0.0, radius: [1.0, 0.2, 0.1], anisotropy: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_after_the_distance_is_the_colour() {
        let tea =
            Interior { attenuation_color: [0.8, 0.4, 0.0], attenuation_distance: 2.5, ..Interior::default() };
        let [r, g, b] = tea.absorption().map(|a| (-a * 2.5).exp());
        assert!((r - 0.8).abs() < 1e-6 && (g - 0.4).abs() < 1e-6 && b < 1e-5, "{r} {g} {b}");
        assert_eq!(Interior::default().absorption(), [0.0; 3], "clear");
        for distance in [0.0, -1.0, f32::NAN] {
            let odd = Interior { attenuation_distance: distance, ..tea };
            assert_eq!(odd.absorption(), [0.0; 3], "a distance that cannot be: {distance}");
        }
    }

    #[test]
    fn abbes_number_is_twenty_over_the_dispersion() {
        let diamond = Interior { dispersion: 0.36, ..Interior::default() };
        let spread = diamond.spread(2.42);
        assert!((1.42 / spread - 20.0 / 0.36).abs() < 0.01, "{spread}");
        assert_eq!(Interior::default().spread(1.5), 0.0, "none");
    }
}
