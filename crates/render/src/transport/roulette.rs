// SPDX-License-Identifier: GPL-3.0-or-later
//! Which paths are ended by chance. Source: [AK90] (Russian roulette).
//! Invariant: who ends a path with probability `1 - survival` divides what it carries by `survival`.
//! Proof: crates/render/tests/{path,agreement,many_lights}.rs.

use gnurt_shading::real::Real;

/// Paths of fewer edges are never ended by chance; of a part of a path, the edges that others are sure to add count.
const FROM: u32 = 4;
/// No path goes on with more than this probability, once chance decides.
const MOST: f32 = 0.95;

/// Whether chance decides on a path of so many edges.
#[inline(always)]
pub(crate) fn decides(edges: u32) -> bool {
    edges >= FROM
}

/// The probability that a path goes on of whose light so much is left, in its brightest channel.
#[inline(always)]
pub(crate) fn survival<R: Real>(left: R) -> R {
    left.or_less(left.all(MOST))
}
