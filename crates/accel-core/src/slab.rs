// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays against the boxes of a wide BVH: values prepared for planes, for one ray or for lanes of them.
//! Source: slabs, [KK86]; the error bound is that of the kd-tree's `slab.rs`.
//!
//! A plane `b` is hit at `t = b * inv - org * inv`, one fused operation where the CPU has it. Rounding here,
//! in the boxes and in the triangle tests moves points by less than `SLACK * (2 * greatest + away)`, where
//! `greatest` is the greatest coordinate of the tree and `away` that of the origin. In units of 2^-24: 17 for
//! the tests, 5 for boxes (the kd-tree's `slab.rs`), 3 for the difference of products, and 5 more for compact
//! nodes. The slack is part of the term that is subtracted: it costs nothing.
//! Invariant: a primitive that the triangle test hits is in no skipped box. Tests: `tests/watertight.rs` of
//! `gnurt-accel`.

use crate::float::{FLATTEST, Number};

/// 33 units of 2^-24: see the head.
pub const SLACK: f32 = 2e-6;

/// `1 / dir`, where no component of `dir` counts for less than [`FLATTEST`] of the longest; `at` makes numbers of floats.
#[inline(always)]
pub fn inverse<V: Number>(dir: [V; 3], at: impl Fn(f32) -> V) -> [V; 3] {
    let [x, y, z] = dir;
    let flattest = x.size().or_more(y.size()).or_more(z.size()) * at(FLATTEST);
    let one = at(1.0);
    let over = |x: V| one / x.size().or_more(flattest).signed_as(x);
    [over(x), over(y), over(z)]
}

/// A ray's inverse direction, and `org * inv` plus and minus the slack: for nearer and for farther planes.
#[derive(Clone, Copy)]
pub struct Slabs<V> {
    pub inv: [V; 3],
    pub near: [V; 3],
    pub far: [V; 3],
}

impl<V: Number> Slabs<V> {
    /// For a tree, not empty, whose greatest coordinate is `greatest`; rays are valid and regular.
    #[inline(always)]
    pub fn new(org: [V; 3], dir: [V; 3], greatest: f32, at: impl Fn(f32) -> V) -> Self {
        let inv = inverse(dir, &at);
        // No face is farther away than the origin's coordinates and the greatest one together.
        let away = org[0].size().or_more(org[1].size()).or_more(org[2].size());
        let slack = at(SLACK) * (at(2.0 * greatest) + away);
        let met = [org[0] * inv[0], org[1] * inv[1], org[2] * inv[2]];
        let pad = [slack * inv[0].size(), slack * inv[1].size(), slack * inv[2].size()];
        Self {
            inv,
            near: [met[0] + pad[0], met[1] + pad[1], met[2] + pad[2]],
            far: [met[0] - pad[0], met[1] - pad[1], met[2] - pad[2]],
        }
    }
}
