// SPDX-License-Identifier: GPL-3.0-or-later
//! The closest hit and any hit among triangles in double precision, each one kernel for each level.
//! What lanes leave open is decided at once, in doubles or exactly. Lines of a batch are often side by side: the triangle that
//! the last one met is tested first where that has paid.
//! Invariant: of triangles that a line meets at one place the lowest number counts; no answer depends on lines before.
//! Tests: `tests/doubles.rs` of `gnurt-accel`.

use gnurt_accel_core::INVALID_ID;
use gnurt_accel_core::exact::{Along, Corners, Line};
use gnurt_simd::{Level, Simd, dispatch};

use super::block::DoubleBlock;
use super::index::DoubleIndex;
use super::line::{DoubleLine, Given, Lanes, Prepared};
use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::walk::{walk, walk_any};

/// The triangle that the last line met. Of one tree: others may have no such place.
#[derive(Clone, Copy, Debug, Default)]
pub struct Last {
    /// `WIDTH` times its block, and its lane.
    place: u32,
    /// How often the next line met it, too, of late.
    trust: u8,
}

impl Last {
    const MOST: u8 = 3;

    /// After a line that met the triangle at `place`.
    #[inline(always)]
    fn met(&mut self, place: u32) {
        if self.place == place {
            self.trust = (self.trust + 1).min(Self::MOST);
        } else {
            *self = Self { place, trust: self.trust.saturating_sub(1) };
        }
    }

    /// After a line that met none.
    #[inline(always)]
    fn missed(&mut self) {
        self.trust = self.trust.saturating_sub(1);
    }
}

/// The nearest triangle so far.
#[derive(Clone, Copy)]
pub(super) struct Best {
    t: f64,
    number: u32,
    corners: [[f64; 3]; 3],
}

impl Best {
    /// None before the end of a line.
    #[inline(always)]
    pub(super) fn none(line: &Line) -> Self {
        Self { t: line.far, number: INVALID_ID, corners: [[0.0; 3]; 3] }
    }

    /// Whether there is one.
    #[inline(always)]
    pub(super) fn is_met(&self) -> bool {
        self.number != INVALID_ID
    }

    /// Its corners.
    #[inline(always)]
    pub(super) fn corners(&self) -> &[[f64; 3]; 3] {
        &self.corners
    }

    /// The weights of its second and third corner.
    #[inline(always)]
    pub(super) fn weights(&self, line: &Line) -> [f64; 2] {
        line.weights(&Corners::plain(&self.corners))
    }

    /// Its number, the parameter, and its weights.
    #[inline(always)]
    pub(super) fn weighed(&self, weights: impl FnOnce() -> [f64; 2]) -> Option<(u32, [f64; 3])> {
        self.is_met().then(|| {
            let [u, v] = weights();
            (self.number, [self.t, u, v])
        })
    }

    /// Whether the line meets a triangle before the best one, in whose place it then is. `is_certain`: the line passes inside.
    #[inline(always)]
    fn is_improved(
        &mut self,
        line: &Line,
        number: u32,
        corners: &[[f64; 3]; 3],
        is_certain: bool,
        along: Option<Along>,
    ) -> bool {
        if number == self.number {
            return false;
        }
        let plain = Corners::plain(corners);
        let met = match along {
            Some(along) => (is_certain || line.touches(&plain))
                .then(|| line.meets_along(&plain, &along, self.reach()))
                .flatten(),
            None => line.meets_before(&plain, self.reach(), is_certain),
        };
        let Some(t) = met else {
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
    pub(super) fn reach(&self) -> f64 {
        DoubleIndex::reach(self.t)
    }

    /// The end of the line, or [`reach`](Self::reach) where it met one.
    #[inline(always)]
    pub(super) fn far(&self) -> f64 {
        if self.number == INVALID_ID { self.t } else { self.reach() }
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
        let best = self.best(level, line);
        best.weighed(|| best.weights(line))
    }

    /// The triangle that the line meets first.
    pub(super) fn best(&self, level: Level, line: &Line) -> Best {
        let mut best = Best::none(line);
        if self.over.tree.nodes.is_empty() {
            self.search(level, &exact(line), line.far, &mut |(number, corners, is_certain)| {
                best.is_improved(line, number, corners, is_certain, None);
                best.reach()
            });
        } else {
            dispatch!(level, simd => self.closest_with(simd, line, &mut best));
        }
        best
    }

    /// Whether the line meets any triangle. `last`: of a line before in this tree, or none.
    #[must_use]
    pub fn is_met(&self, level: Level, line: &Line, last: &mut Last) -> bool {
        if !self.over.tree.nodes.is_empty() {
            if last.trust > 0 && line.is_blocked(&Corners::plain(&self.corners_at(last.place)), false) {
                return true;
            }
            return dispatch!(level, simd => self.is_met_with(simd, line, last));
        }
        let mut is_met = false;
        self.search(level, &exact(line), line.far, &mut |(_, corners, is_certain)| {
            is_met = is_met || line.is_blocked(&Corners::plain(corners), is_certain);
            if is_met { f64::NEG_INFINITY } else { line.far }
        });
        is_met
    }

    #[inline(always)]
    fn corners_at(&self, place: u32) -> [[f64; 3]; 3] {
        let place = place as usize;
        self.over.blocks[place / WIDTH].corners(place % WIDTH)
    }

    #[inline(always)]
    fn closest_with<S: Simd>(&self, simd: S, line: &Line, best: &mut Best) {
        let over = &self.over;
        let Some(prepared) = Prepared::new(&exact(line), &over.grid, over.greatest) else { return };
        let (lanes, given) = (Lanes::new(simd, &prepared), Given::new(simd, line.org, line.dir));
        let for_nodes = NodeRay::new(simd, &prepared.for_nodes, prepared.greatest);
        let (mut reach, mut depth) = (prepared.reach(line.far), prepared.depth(line.far));
        walk(
            &crate::walk::Ahead { tree: &over.tree, blocks: &over.blocks, two_first: false },
            simd,
            Child::node(0),
            &for_nodes,
            reach,
            #[inline(always)]
            |range| {
                for block in &over.blocks[range] {
                    if block.improves(simd, line, &lanes, &given, depth, best) {
                        let far = best.reach();
                        (reach, depth) = (prepared.reach(far), prepared.depth(far));
                    }
                }
                reach
            },
        );
    }

    #[inline(always)]
    fn is_met_with<S: Simd>(&self, simd: S, line: &Line, last: &mut Last) -> bool {
        let over = &self.over;
        let Some(prepared) = Prepared::new(&exact(line), &over.grid, over.greatest) else { return false };
        let (lanes, given) = (Lanes::new(simd, &prepared), Given::new(simd, line.org, line.dir));
        let for_nodes = NodeRay::new(simd, &prepared.for_nodes, prepared.greatest);
        let (reach, depth) = (prepared.reach(line.far), prepared.depth(line.far));
        let mut met = None;
        walk_any(
            &crate::walk::Ahead { tree: &over.tree, blocks: &over.blocks, two_first: false },
            simd,
            Child::node(0),
            &for_nodes,
            reach,
            #[inline(always)]
            |range| {
                for (i, block) in range.clone().zip(&over.blocks[range]) {
                    let candidates = block.candidates(simd, &lanes, depth);
                    if candidates.is_empty() {
                        continue;
                    }
                    let alongs = block.alongs(simd, &given);
                    for (lane, is_certain) in candidates.of(alongs.within(line.near, line.far)) {
                        let corners = &block.corners(lane);
                        let plain = Corners::plain(corners);
                        if (is_certain || line.touches(&plain))
                            && line.is_blocked_along(&plain, &alongs.at(lane))
                        {
                            met = Some((WIDTH * i + lane) as u32);
                            return false;
                        }
                    }
                }
                true
            },
        );
        match met {
            Some(place) => last.met(place),
            None => last.missed(),
        }
        met.is_some()
    }
}

impl DoubleBlock {
    /// Whether the line meets one of the triangles before the best one, in whose place it then is; `depth` is not before its end.
    #[inline(always)]
    pub(super) fn improves<S: Simd>(
        &self,
        simd: S,
        line: &Line,
        lanes: &Lanes<S>,
        given: &Given<S>,
        depth: f64,
        best: &mut Best,
    ) -> bool {
        let candidates = self.candidates(simd, lanes, depth);
        if candidates.is_empty() {
            return false;
        }
        let alongs = self.alongs(simd, given);
        let mut improves = false;
        for (lane, is_certain) in candidates.of(alongs.within(line.near, best.far())) {
            let (number, along) = (self.numbers[lane], Some(alongs.at(lane)));
            improves |= best.is_improved(line, number, &self.corners(lane), is_certain, along);
        }
        improves
    }
}

/// In the space of the query.
#[inline(always)]
pub(super) fn exact(line: &Line) -> DoubleLine {
    DoubleLine { org: line.org, dir: line.dir, near: line.near, off_org: 0.0, off_dir: 0.0 }
}
