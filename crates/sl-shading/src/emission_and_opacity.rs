// SPDX-License-Identifier: GPL-3.0-or-later
//! Emission, transparency and the matter behind points: how closures that emit light or transmit it straight
//! change the scattering of the others.
//! Tests: `tests/scripts/{closures,lanes}.rs`.

use glam::Vec3;
use gnurt_shading::bsdf::{ClosureBatch, Lists, Medium};
use gnurt_sl::exec::LANES;

use crate::parts::Lights;

/// The least opacity of a scattering surface, so that its scattered light is not sampled too seldom.
const THERE: f32 = 1.0 / 16.0;
/// Straight transmittances below this are none.
const LEAST: f32 = 1e-3;

/// Emission and opacity of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EmissionAndOpacity {
    /// Light that it gives off.
    pub(crate) emission: Vec3,
    /// Share of paths that it stops.
    pub(crate) there: f32,
    /// The factor of light that the others carry on.
    pub(crate) passing: Vec3,
    /// Absorption coefficient behind the surface, 1 over world units.
    pub(crate) absorption: Vec3,
    /// Share of that which it stops that is a hole in the picture.
    pub(crate) held_out: f32,
}

impl Default for EmissionAndOpacity {
    /// Those of a surface that stops all light and emits none.
    fn default() -> Self {
        Self { emission: Vec3::ZERO, there: 1.0, passing: Vec3::ONE, absorption: Vec3::ZERO, held_out: 0.0 }
    }
}

impl EmissionAndOpacity {
    /// Of one of sixteen points; its lobes become those of the share that it stops.
    pub(crate) fn of(lists: &mut Lists, lights: &Lights, lane: usize) -> Self {
        let emission = lights.emission.get(lane);
        let through = lights.through.get(lane).clamp(Vec3::ZERO, Vec3::ONE);
        let held_out = lights.holdout.get(lane).element_sum() / 3.0;
        let mean = through.element_sum() / 3.0;
        // Where nothing else can happen, all paths go on, with less light; elsewhere the same share of them as of light.
        let is_clear = through.max_element() >= LEAST;
        let there = if !is_clear {
            1.0
        } else if lists.lit() >> lane & 1 != 0 {
            (1.0 - mean).max(THERE)
        } else if held_out > 0.0 {
            1.0 - mean
        } else {
            0.0
        };
        let is_even = through == Vec3::splat(1.0 - there);
        let passing = if is_clear && there < 1.0 && !is_even { through / (1.0 - there) } else { Vec3::ONE };
        if there > 0.0 {
            lists.times(1 << lane, &Default::default(), &[[1.0 / there; LANES]; 3]);
        }
        let emission = if emission.is_finite() { emission } else { Vec3::ZERO };
        let absorption = lights.absorption.get(lane);
        let absorption = if absorption.is_finite() { absorption } else { Vec3::ZERO };
        let held_out = if there > 0.0 { (held_out / there).min(1.0) } else { 0.0 };
        Self { emission, there, passing, absorption, held_out }
    }

    /// Writes it for point `i`, seen from its front or from behind.
    pub(crate) fn write(self, i: usize, front: bool, out: &mut ClosureBatch) {
        if self.there < 1.0 {
            out.cover(i, self.there);
        }
        if self.passing != Vec3::ONE {
            out.tint(i, self.passing);
        }
        if self.held_out > 0.0 {
            out.hold_out(i, self.held_out);
        }
        if self.emission != Vec3::ZERO {
            out.emit(i, self.emission);
        }
        if self.absorption != Vec3::ZERO {
            out.fill(i, Medium::behind(self.absorption, front));
        }
    }
}
