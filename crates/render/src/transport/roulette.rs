// SPDX-License-Identifier: GPL-3.0-or-later
//! Which paths are ended by chance. Source: [AK90] (Russian roulette); how soon was measured, docs/explanation/tried.md.
//! Invariant: who ends a path with probability `1 - survival` divides what it carries by `survival`.
//! Tests: crates/render/tests/{path,agreement,many_lights}.rs.

use gnurt_shading::real::Real;

/// Paths of fewer edges are never ended by chance; of a part of a path, the edges that others are sure to add count.
const FROM: u32 = 4;
/// No path goes on with more than this probability, once chance decides.
const MOST: f32 = 0.95;
/// A path from the eye is in danger where less than one over this is left of its light. Those that live carry so much on average, and what
/// they meet counts as much: ended as soon as anything is lost, the few that live would be fireflies where they meet a lamp.
const SPARED: f32 = 4.0;

/// Whether chance decides on a path of so many edges.
#[inline(always)]
pub(crate) fn decides(edges: u32) -> bool {
    edges >= FROM
}

/// The probability that a path from the eye goes on of whose light so much is left, in its brightest channel.
#[inline(always)]
pub(crate) fn survival_from_eye<R: Real>(left: R) -> R {
    survival(left * SPARED)
}

/// The probability that another path goes on of whose light so much is left, in its brightest channel.
#[inline(always)]
pub(crate) fn survival<R: Real>(left: R) -> R {
    left.or_less(left.all(MOST))
}
