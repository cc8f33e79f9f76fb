// SPDX-License-Identifier: GPL-3.0-or-later
//! Scattered rays at delta lobes: whether searches turn there, too. Space: world. Tests: crates/render/tests/caustics.rs.

use glam::Vec3;
use gnurt_shading::SurfaceBatch;
use gnurt_shading::bsdf::ClosureBatch;

use super::chain::Chain;
use super::known::Caustics;
use super::smooth::SmoothPoint;
use crate::world::World;

/// The largest square of the difference of directions that are one.
const SAME: f32 = 1e-6;

/// The chain of a path that came from `org` to point `k` and leaves by a delta lobe to `wi`, through the surface or not.
pub(crate) fn turned(
    of: (&World, &Caustics),
    surface: (&SurfaceBatch, &ClosureBatch),
    (k, org): (usize, Vec3),
    (wi, transmitted): (Vec3, bool),
    before: Chain,
) -> Chain {
    let Some(at) = SmoothPoint::of(of, surface, k) else { return before.lost() };
    match at.branches[usize::from(transmitted)] {
        Some((expected, _)) if expected.distance_squared(wi) < SAME => {
            before.turned(&at, (org, surface.0.ray_dir.get(k)), transmitted)
        }
        _ => before.lost(),
    }
}
