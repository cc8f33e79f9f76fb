// SPDX-License-Identifier: GPL-3.0-or-later
//! A direction that a BSDF chose. Source: [PJH23] section 9.1.2. Space: world outside, the shading frame inside of lobes.

use glam::Vec3;

use crate::batch::RayKind;

/// A direction that a BSDF chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The next direction of the path, unit, world.
    pub wi: Vec3,
    /// BSDF times |cos| over the density of `wi`.
    pub weight: Vec3,
    /// Density per solid angle with which [`Bsdf::sample`](super::Bsdf::sample) chooses `wi`, all lobes counted; infinite if `delta`.
    pub pdf: f32,
    /// Whether no other direction could have been chosen by that lobe: mirrors, smooth glass. No light sample meets it.
    pub delta: bool,
    /// Whether it goes through the surface.
    pub transmitted: bool,
    /// Whether a diffuse lobe chose it: neither microfacets nor mirrors nor glass.
    pub wide: bool,
}

impl BsdfSample {
    /// The kind of the ray along the direction.
    #[must_use]
    pub fn ray_kind(&self) -> RayKind {
        RayKind::of(self.delta, self.transmitted, self.wide)
    }
}
