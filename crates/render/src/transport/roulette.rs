// SPDX-License-Identifier: GPL-3.0-or-later
//! Russian roulette: random termination of paths. Source: [AK90]; the start of termination was measured,
//! docs/explanation/tried.md.
//! Invariant: if a path ends with probability `1 - survival`, the survivors' light is divided by `survival`.
//! Tests: crates/render/tests/{path,agreement,many_lights}.rs.

use gnurt_shading::real::Real;

/// Paths of fewer edges are never ended by chance; of a part of a path, the edges that others are sure to add count.
const FROM: u32 = 4;
/// No path continues with more than this probability, once roulette decides.
const MOST: f32 = 0.95;
/// The same of paths that a medium scatters, hundreds of times in thick bodies: a loss of one in twenty each time would leave a few
/// survivors with thousands of times the light.
const MOST_IN_MEDIUM: f32 = 0.995;
/// A path from the eye may end if less than one over this is left of its throughput. Survivors carry this
/// much on average. With termination at any loss, the few survivors would be fireflies where they hit a
/// light.
const SPARED: f32 = 4.0;

/// Whether roulette decides on a path with this number of edges.
#[inline(always)]
pub(crate) fn decides(edges: u32) -> bool {
    edges >= FROM
}

/// The probability that a path from the eye continues with this throughput, in its brightest channel.
#[inline(always)]
pub(crate) fn survival_from_eye<R: Real>(left: R) -> R {
    survival(left * SPARED)
}

/// The same of a path that a medium scatters.
#[inline(always)]
pub(crate) fn survival_in_medium<R: Real>(left: R) -> R {
    (left * SPARED).or_less(left.all(MOST_IN_MEDIUM))
}

/// The probability that another path continues with this throughput, in its brightest channel.
#[inline(always)]
pub(crate) fn survival<R: Real>(left: R) -> R {
    left.or_less(left.all(MOST))
}
