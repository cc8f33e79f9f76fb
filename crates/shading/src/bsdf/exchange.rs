// SPDX-License-Identifier: GPL-3.0-or-later
//! Correction of one lobe on light paths, if it differs from the correction of the point's normal and glass.
//! Source: \[Vea97\] sections 5.2 (refraction) and 5.3 (shading normals), lobe by lobe. Tests: `carrying_tests`.

use glam::Vec3;

use super::lobe::{Kind, Lobe, rare};

/// The difference, as factors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exchange {
    /// For a lobe around its own normal, the cosine of the light's direction to that, 0 from behind, over the
    /// cosine to the point's normal.
    pub(super) tilt: Option<f32>,
    /// For light that goes through, by colour: the square of the index that the lobe bends it by over that of the point's glass.
    pub(super) through: Vec3,
}

impl Exchange {
    /// None.
    pub(super) const NONE: Self = Self { tilt: None, through: Vec3::ONE };

    /// That of a lobe of a point with this normal and glass, for light from the unit `from` at the cosine `cos` > 0 to the normal.
    pub(super) fn of(lobe: &Lobe, (ns, etas): (Vec3, Vec3), from: Vec3, cos: f32) -> Self {
        let own = lobe.normal != Vec3::ZERO && lobe.normal != ns;
        let tilt = own.then(|| lobe.normal.dot(from).max(0.0) / cos);
        let relative = lobe.bending() / etas;
        let through =
            if lobe.kind.goes_through() && lobe.bending() != etas { relative * relative } else { Vec3::ONE };
        Self { tilt, through }
    }

    /// Whether a lobe differs at all, or is not reciprocal.
    pub(super) fn applies_to(&self, lobe: &Lobe) -> bool {
        let one_way = lobe.kind == Kind::Fibres || lobe.rare() & rare::SCALED != 0;
        !lobe.is_black() && (self.tilt.is_some() || self.through != Vec3::ONE || one_way)
    }
}
