// SPDX-License-Identifier: GPL-3.0-or-later
//! Emission, transparency and the matter behind points: how closures that emit light or transmit it straight
//! change the scattering of the others.
//! Tests: `tests/scripts/{closures,lanes}.rs`.

use glam::Vec3;
use gnurt_shading::bsdf::{ClosureBatch, Lists, Lobe, Medium};
use gnurt_sl::exec::LANES;

use crate::parts::Lights;

/// The least opacity of a scattering surface, so that its scattered light is not sampled too seldom.
const THERE: f32 = 1.0 / 16.0;

/// Emission and opacity of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EmissionAndOpacity {
    /// Light that it gives off.
    pub(crate) emission: Vec3,
    /// Share of light that it stops.
    pub(crate) there: f32,
    /// Absorption coefficient behind the surface, 1 over world units.
    pub(crate) absorption: Vec3,
    /// Share of that which it stops that is a hole in the picture.
    pub(crate) held_out: f32,
}

impl Default for EmissionAndOpacity {
    /// Those of a surface that stops all light and emits none.
    fn default() -> Self {
        Self { emission: Vec3::ZERO, there: 1.0, absorption: Vec3::ZERO, held_out: 0.0 }
    }
}

impl EmissionAndOpacity {
    /// Of one of sixteen points; its lobes become those of the share that it stops.
    pub(crate) fn of(lists: &mut Lists, lights: &Lights, lane: usize) -> Self {
        let emission = lights.emission.get(lane);
        let through = lights.through.get(lane).clamp(Vec3::ZERO, Vec3::ONE);
        let shared = through.min_element();
        let is_lit = lists.lit() >> lane & 1 != 0;
        // The transmittance common to all channels is transparency; the coloured rest is transmitted as
        // through a pane.
        let mut transparent = if is_lit { shared.min(1.0 - THERE) } else { shared };
        if transparent < 1e-3 {
            transparent = 0.0;
        }
        let there = 1.0 - transparent;
        let tint = through - Vec3::splat(transparent);
        if tint.max_element() > 1e-3 {
            lists.push(1 << lane, &Lobe::glass(1.0, Vec3::ZERO, tint.max(Vec3::ZERO), true));
        }
        if there > 0.0 {
            lists.times(1 << lane, &Default::default(), &[[1.0 / there; LANES]; 3]);
        }
        let emission = if emission.is_finite() { emission } else { Vec3::ZERO };
        let absorption = lights.absorption.get(lane);
        let absorption = if absorption.is_finite() { absorption } else { Vec3::ZERO };
        let held_out = lights.holdout.get(lane).element_sum() / 3.0;
        let held_out = if there > 0.0 { (held_out / there).min(1.0) } else { 0.0 };
        Self { emission, there, absorption, held_out }
    }

    /// Writes it for point `i`, seen from its front or from behind.
    pub(crate) fn write(self, i: usize, front: bool, out: &mut ClosureBatch) {
        if self.there < 1.0 {
            out.cover(i, self.there);
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
