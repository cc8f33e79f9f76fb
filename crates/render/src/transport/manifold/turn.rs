// SPDX-License-Identifier: GPL-3.0-or-later
//! Scattered rays at delta lobes: whether searches turn there, too. Space: world. Tests: crates/render/tests/caustics.rs.

use glam::Vec3;

use super::chain::Chain;
use super::smooth::SmoothPoint;

/// The largest square of the difference of directions that are one.
const SAME: f32 = 1e-6;

/// The chain of a path that came from `org` along `dir` and leaves this point by a delta lobe to `wi`, through the surface or not.
pub(crate) fn turned(
    at: Option<&SmoothPoint>,
    (org, dir): (Vec3, Vec3),
    (wi, transmitted): (Vec3, bool),
    before: Chain,
) -> Chain {
    let is_branch = |at: &&SmoothPoint| {
        at.branches[usize::from(transmitted)]
            .is_some_and(|(expected, _)| expected.distance_squared(wi) < SAME)
    };
    at.filter(is_branch).map_or(before.lost(), |at| before.turned(at, (org, dir), transmitted))
}
