// SPDX-License-Identifier: GPL-3.0-or-later
//! Makes a binary tree cheaper: knots are taken out and put in again where they add the least surface.
//! Source: [MB18], with the searches of [BHH13]. Differs: all searches of a round see the tree as it was at its start; then
//! moves are made one after the other, the most promising first, and each only if the tree as it is by then gets
//! cheaper. Large knots are searched for only, fewer in each round: they bring almost all that there is to gain.
//!
//! ```text
//!        g              g             a               a
//!       / \            / \           / \             / \
//!      p   .    =>    s   .         t   .    =>     p   .      x moves to t, and takes its parent p along
//!     / \                                          / \
//!    x   s                                        x   t
//!
//!    saved: area(p), and what boxes from g on upwards lose      added: area(t and x), and what boxes from a on upwards win
//! ```
//!
//! Space: areas are scaled as in `bins`. Invariants: leaves stay as they are and boxes hold what is below; the sum of areas never rises;
//! no path gets longer than the longest was, or than [`DEEPEST`]; threads do not matter. Proof: `tests`, `super::tests`.

mod cost;
#[cfg(test)]
mod tests;

use gnurt_simd::{Simd, dispatch, f32x4, f32x8, prelude::*};
use rayon::prelude::*;

use super::binary::Knot;
use super::collapse::DEEPEST;
use super::crew::Crew;
use super::reference::Lanes;

/// Shares of all knots, the largest ones, that are searched for in each round: for the default trees,
pub(super) const QUICK: &[f32] = &[0.05];

/// and for those of high quality behind it.
pub(super) const THOROUGH: &[f32] = &[0.5, 0.25, 0.12];

/// In place of a knot that there is not.
const NONE: u32 = u32::MAX;

/// Searches that are done by one thread. Tests have small scenes.
const PIECE: usize = if cfg!(test) { 1 << 4 } else { 1 << 10 };

/// Steps of progress for each knot that is searched for, one for the search and one for its move; every two knots take
/// another step for what is done once. A step is what building over one primitive takes; measured with conference and dragon.
const STEPS: usize = 2;

/// One of so many areas is looked at to learn how large the largest are.
const SAMPLE: usize = 16;

/// What there is to know of a knot while it may move: a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Spot {
    bounds: Lanes,
    /// None of a leaf.
    children: [u32; 2],
    /// None of the root.
    parent: u32,
    /// Knots on the longest way down; 0 of a leaf.
    height: u32,
}

/// Where a knot would be better off.
#[derive(Clone, Copy, Debug)]
struct Move {
    gain: f32,
    knot: u32,
    target: u32,
}

/// A tree whose knots may move. Knots keep their numbers, the root as well.
struct Garden<'a> {
    spots: Vec<Spot>,
    root: u32,
    /// No path may be longer.
    longest: u32,
    crew: Crew<'a>,
}

/// Improves the tree whose root is the last of `knots`; returns what the wide tree made of it will cost. Nothing is done once
/// the build was stopped.
pub(super) fn reinsert(knots: &mut [Knot], rounds: &[f32], crew: Crew) -> f32 {
    let bytes = knots.len() * size_of::<Spot>();
    if knots.is_empty() || !crew.watch.take(bytes) {
        return f32::INFINITY;
    }
    let mut garden = Garden::new(knots, crew);
    crew.watch.advance(knots.len() / 2);
    for &share in rounds {
        let some = garden.largest(share);
        let moves = garden.search(&some);
        garden.make(moves, some.len());
    }
    let cost = garden.write(knots);
    crew.watch.give(bytes);
    cost
}

/// Steps of progress that it takes for `knots`, about.
pub(super) fn steps(knots: usize, rounds: &[f32]) -> usize {
    knots / 2 + (rounds.iter().sum::<f32>() * (STEPS * knots) as f32) as usize
}

/// Half the surface of a box.
#[inline(always)]
fn area<S: Simd>(simd: S, bounds: f32x8<S>, scale: f32) -> f32 {
    let (low, high) = simd.split_f32x8(bounds);
    let sides = (high + low) * f32x4::splat(simd, scale);
    let [x, y, z, _] = *sides.as_array();
    x * y + y * z + z * x
}

impl<'a> Garden<'a> {
    fn new(knots: &[Knot], crew: Crew<'a>) -> Self {
        let spot = |at: usize| {
            let knot = &knots[at];
            let mut bounds = knot.bounds;
            // Nobody looks at these lanes, but small numbers would slow down arithmetic.
            (bounds.0[3], bounds.0[7]) = (0.0, 0.0);
            let children =
                if knot.is_leaf() { [NONE; 2] } else { knot.children(at).map(|child| child as u32) };
            Spot { bounds, children, parent: NONE, height: 0 }
        };
        let mut spots = Vec::new();
        crew.extend(&mut spots, knots.len(), spot);
        for at in 0..spots.len() {
            let children = spots[at].children.into_iter().filter(|&child| child != NONE);
            children.for_each(|child| spots[child as usize].parent = at as u32);
        }
        // From each leaf upwards, as long as that is the longest way.
        for leaf in 0..spots.len() {
            let (mut at, mut height) = (spots[leaf].parent, 1);
            while spots[leaf].is_leaf() && at != NONE && spots[at as usize].height < height {
                let above = &mut spots[at as usize];
                above.height = height;
                (at, height) = (above.parent, height + 1);
            }
        }
        let root = spots.len() - 1;
        let longest = spots[root].height.max(DEEPEST as u32);
        Self { spots, root: root as u32, longest, crew }
    }

    fn spot(&self, at: u32) -> &Spot {
        &self.spots[at as usize]
    }

    /// Knots that may move: the root and its children stay.
    fn may_move(&self, at: u32) -> bool {
        at != self.root && self.spot(at).parent != self.root
    }

    /// About `share` of all knots, the largest, in order.
    fn largest(&self, share: f32) -> Vec<u32> {
        let area = |at: u32| self.spot(at).bounds.half_area(self.crew.scale);
        let count = self.spots.len() as u32;
        let mut areas: Vec<f32> = (0..count).step_by(SAMPLE).map(area).collect();
        let place = ((1.0 - share) * areas.len() as f32) as usize;
        let place = place.min(areas.len() - 1);
        let least = *areas.select_nth_unstable_by(place, f32::total_cmp).1;
        let wanted = |&at: &u32| area(at) >= least && self.may_move(at);
        if self.crew.parallel {
            (0..count).into_par_iter().with_min_len(PIECE).filter(wanted).collect()
        } else {
            (0..count).filter(wanted).collect()
        }
    }

    /// The best move of each knot that has a good one, in order.
    fn search(&self, knots: &[u32]) -> Vec<Move> {
        let piece = |knots: &[u32]| {
            let mut moves = Vec::new();
            if self.crew.watch.go_on() {
                dispatch!(self.crew.level, simd => self.search_piece(simd, knots, &mut moves));
                self.crew.watch.advance(knots.len());
            }
            moves
        };
        if self.crew.parallel {
            knots.par_chunks(PIECE).flat_map_iter(piece).collect()
        } else {
            knots.chunks(PIECE).flat_map(piece).collect()
        }
    }

    #[inline(always)]
    fn search_piece<S: Simd>(&self, simd: S, knots: &[u32], moves: &mut Vec<Move>) {
        let mut waiting = Vec::new();
        for &knot in knots {
            let best = self.best_move(simd, knot, &mut waiting);
            if best.gain > 0.0 {
                moves.push(best);
            }
        }
    }

    /// The best place for a knot. From its parent upwards, what hangs on the other side is searched as long as it may be better
    /// than what was found; `waiting` is empty before and after.
    #[inline(always)]
    fn best_move<S: Simd>(&self, simd: S, knot: u32, waiting: &mut Vec<(f32, u32)>) -> Move {
        let scale = self.crew.scale;
        let bounds_of = |at: u32| self.spot(at).bounds.load(simd);
        let moved = bounds_of(knot);
        let moved_area = area(simd, moved, scale);
        let mut best = Move { gain: 0.0, knot, target: NONE };
        let parent = self.spot(knot).parent;
        let sibling = self.spot(parent).other_than(knot);
        // What is saved by boxes up to `above`, and the box of all below it without the knot.
        let (mut above, mut other) = (parent, sibling);
        let mut saved = area(simd, bounds_of(parent), scale);
        let mut without = bounds_of(sibling);
        loop {
            // What is added to boxes above a knot, and that knot.
            waiting.push((0.0, other));
            while let Some((added, at)) = waiting.pop() {
                // It costs at least its own area, wherever it is.
                if saved - added - moved_area <= best.gain {
                    continue;
                }
                let here = self.spot(at);
                let bounds = here.bounds.load(simd);
                let both = area(simd, bounds.max(moved), scale);
                let gain = saved - added - both;
                if gain > best.gain && at != sibling {
                    best = Move { gain, knot, target: at };
                }
                if !here.is_leaf() {
                    let added = added + both - area(simd, bounds, scale);
                    if saved - added - moved_area > best.gain {
                        waiting.extend(here.children.map(|child| (added, child)));
                    }
                }
            }
            let below = above;
            above = self.spot(above).parent;
            if above == NONE {
                return best;
            }
            other = self.spot(above).other_than(below);
            without = without.max(bounds_of(other));
            saved += area(simd, bounds_of(above), scale) - area(simd, without, scale);
        }
    }

    /// Makes those moves that are still good ones; `searched` knots were searched for.
    fn make(&mut self, mut moves: Vec<Move>, searched: usize) {
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.knot.cmp(&b.knot)));
        for piece in moves.chunks(PIECE) {
            if !self.crew.watch.go_on() {
                return;
            }
            piece.iter().for_each(|&Move { knot, target, .. }| self.try_move(knot, target));
            self.crew.watch.advance(piece.len());
        }
        // Those that had no good place.
        self.crew.watch.advance(searched - moves.len());
    }

    /// Moves `knot` to `target`, where that is possible and makes the tree cheaper.
    fn try_move(&mut self, knot: u32, target: u32) {
        let parent = self.spot(knot).parent;
        let sibling = self.spot(parent).other_than(knot);
        if parent == self.root || [self.root, parent, sibling].contains(&target) {
            return;
        }
        let mut above = 0;
        let mut at = target;
        while at != self.root {
            if at == knot {
                return;
            }
            at = self.spot(at).parent;
            above += 1;
        }
        let height = 1 + self.spot(knot).height.max(self.spot(target).height);
        if above + height > self.longest {
            return;
        }
        let saved = self.exact_area(&self.spot(parent).bounds) - self.take_out(parent, sibling);
        let added = self.put_in(parent, knot, target);
        if added >= saved {
            self.take_out(parent, target);
            self.put_in(parent, knot, sibling);
        }
    }

    /// `child` takes the place of its parent. Returns how much larger areas above are for it.
    fn take_out(&mut self, parent: u32, child: u32) -> f64 {
        let above = self.spot(parent).parent;
        self.replace(above, parent, child);
        self.fit(above)
    }

    /// `parent` takes the place of `target`, which hangs below it from now on, as `knot` does. Returns how much larger areas
    /// are for it, that of `parent` included.
    fn put_in(&mut self, parent: u32, knot: u32, target: u32) -> f64 {
        let above = self.spot(target).parent;
        self.replace(above, target, parent);
        self.spots[target as usize].parent = parent;
        self.spots[parent as usize].children = [target, knot];
        let (bounds, height) = self.around([target, knot]);
        let spot = &mut self.spots[parent as usize];
        (spot.bounds, spot.height) = (bounds, height);
        self.exact_area(&bounds) + self.fit(above)
    }

    fn replace(&mut self, above: u32, old: u32, new: u32) {
        let children = &mut self.spots[above as usize].children;
        children[usize::from(children[0] != old)] = new;
        self.spots[new as usize].parent = above;
    }

    /// Box and height of a knot with these children.
    fn around(&self, children: [u32; 2]) -> (Lanes, u32) {
        let [a, b] = children.map(|child| self.spot(child));
        (a.bounds.union(&b.bounds), 1 + a.height.max(b.height))
    }

    /// Boxes and heights from `at` upwards, as far as they change. Returns how much larger areas are.
    fn fit(&mut self, mut at: u32) -> f64 {
        let mut larger = 0.0;
        while at != NONE {
            let now = self.around(self.spot(at).children);
            let spot = self.spot(at);
            if now == (spot.bounds, spot.height) {
                break;
            }
            larger += self.exact_area(&now.0) - self.exact_area(&spot.bounds);
            let spot = &mut self.spots[at as usize];
            (spot.bounds, spot.height) = now;
            at = spot.parent;
        }
        larger
    }

    /// Half the surface in double precision: differences of large ones are small.
    fn exact_area(&self, bounds: &Lanes) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(bounds.side(axis)) * f64::from(self.crew.scale));
        x * y + y * z + z * x
    }
}

impl Spot {
    fn is_leaf(&self) -> bool {
        self.children[0] == NONE
    }

    /// The other child.
    #[inline(always)]
    fn other_than(&self, child: u32) -> u32 {
        let [a, b] = self.children;
        if a == child { b } else { a }
    }
}
