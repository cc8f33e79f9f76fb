// SPDX-License-Identifier: GPL-3.0-or-later
//! The closest hit and any hit among triangles in double precision, each one kernel for each level.
//! What lanes leave open is decided at once, in doubles or exactly.
//! Invariant: of triangles that a line meets at one place the lowest number counts. Tests: `tests/doubles.rs` of `gnurt-accel`.

use gnurt_accel_core::INVALID_ID;
use gnurt_accel_core::exact::{Corners, Line};
use gnurt_simd::{Level, Simd, dispatch};

use super::index::DoubleIndex;
use super::line::{DoubleLine, Lanes, Prepared};
use crate::node::Child;
use crate::node_ray::NodeRay;
use crate::walk::{walk, walk_any};

/// The nearest triangle so far.
#[derive(Clone, Copy)]
struct Best {
    t: f64,
    number: u32,
    corners: [[f64; 3]; 3],
}

impl Best {
    /// Whether the line meets a triangle before the best one, in whose place it then is. `is_certain`: the line passes inside.
    #[inline(always)]
    fn is_improved(&mut self, line: &Line, number: u32, corners: &[[f64; 3]; 3], is_certain: bool) -> bool {
        let Some(t) = line.meets_before(&Corners::plain(corners), self.reach(), is_certain) else {
            return false;
        };
        if self.number != INVALID_ID {
            let order = line.order((self.t, &Corners::plain(&self.corners)), (t, &Corners::plain(corners)));
            if order.then(self.number.cmp(&number)).is_lt() {
                return false;
            }
        }
        *self = Self { t, number, corners: *corners };
        true
    }

    #[inline(always)]
    fn reach(&self) -> f64 {
        DoubleIndex::reach(self.t)
    }
}

impl DoubleIndex {
    /// From where on hits are certainly behind one at `t`, of which 1e-13 may be wrong.
    #[inline(always)]
    #[must_use]
    pub fn reach(t: f64) -> f64 {
        t + 4e-13 * t
    }

    /// The number of the triangle that the line meets first, the parameter, and the weights of its second and third corner.
    #[must_use]
    pub fn closest(&self, level: Level, line: &Line) -> Option<(u32, [f64; 3])> {
        let mut best = Best { t: line.far, number: INVALID_ID, corners: [[0.0; 3]; 3] };
        if self.over.tree.nodes.is_empty() {
            self.search(level, &exact(line), line.far, &mut |(number, corners, is_certain)| {
                best.is_improved(line, number, corners, is_certain);
                best.reach()
            });
        } else {
            dispatch!(level, simd => self.closest_with(simd, line, &mut best));
        }
        let weights = || line.weights(&Corners::plain(&best.corners));
        (best.number != INVALID_ID).then(|| {
            let [u, v] = weights();
            (best.number, [best.t, u, v])
        })
    }

    /// Whether the line meets any triangle.
    #[must_use]
    pub fn is_met(&self, level: Level, line: &Line) -> bool {
        if !self.over.tree.nodes.is_empty() {
            return dispatch!(level, simd => self.is_met_with(simd, line));
        }
        let mut is_met = false;
        self.search(level, &exact(line), line.far, &mut |(_, corners, is_certain)| {
            is_met = is_met || line.is_blocked(&Corners::plain(corners), is_certain);
            if is_met { f64::NEG_INFINITY } else { line.far }
        });
        is_met
    }

    #[inline(always)]
    fn closest_with<S: Simd>(&self, simd: S, line: &Line, best: &mut Best) {
        let over = &self.over;
        let Some(prepared) = Prepared::new(&exact(line), &over.grid, over.greatest) else { return };
        let lanes = Lanes::new(simd, &prepared);
        let for_nodes = NodeRay::new(simd, &prepared.for_nodes, prepared.greatest);
        let (mut reach, mut depth) = (prepared.reach(line.far), prepared.depth(line.far));
        walk(
            &crate::walk::Ahead { tree: &over.tree, blocks: &over.blocks },
            simd,
            Child::node(0),
            &for_nodes,
            reach,
            #[inline(always)]
            |range| {
                for block in &over.blocks[range] {
                    for (lane, is_certain) in block.candidates(simd, &lanes, depth) {
                        if best.is_improved(line, block.numbers[lane], &block.corners(lane), is_certain) {
                            let far = best.reach();
                            (reach, depth) = (prepared.reach(far), prepared.depth(far));
                        }
                    }
                }
                reach
            },
        );
    }

    #[inline(always)]
    fn is_met_with<S: Simd>(&self, simd: S, line: &Line) -> bool {
        let over = &self.over;
        let Some(prepared) = Prepared::new(&exact(line), &over.grid, over.greatest) else { return false };
        let lanes = Lanes::new(simd, &prepared);
        let for_nodes = NodeRay::new(simd, &prepared.for_nodes, prepared.greatest);
        let (reach, depth) = (prepared.reach(line.far), prepared.depth(line.far));
        let mut is_met = false;
        walk_any(
            &crate::walk::Ahead { tree: &over.tree, blocks: &over.blocks },
            simd,
            Child::node(0),
            &for_nodes,
            reach,
            #[inline(always)]
            |range| {
                for block in &over.blocks[range] {
                    for (lane, is_certain) in block.candidates(simd, &lanes, depth) {
                        if line.is_blocked(&Corners::plain(&block.corners(lane)), is_certain) {
                            is_met = true;
                            return false;
                        }
                    }
                }
                true
            },
        );
        is_met
    }
}

/// In the space of the query.
fn exact(line: &Line) -> DoubleLine {
    DoubleLine { org: line.org, dir: line.dir, near: line.near, off_org: 0.0, off_dir: 0.0 }
}
