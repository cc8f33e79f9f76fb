// SPDX-License-Identifier: GPL-3.0-or-later
//! The fast builder: planes from samples of the cost along each axis instead of a sweep over all events.
//! Source: [HMS06]: eight even samples, then eight where the counts change most, and between them counts that grow
//! linearly, so that the cost is a parabola. Differs: the second eight are taken along the best axis only,
//! samples lie within the existing boxes, and nodes of a few triangles try every plane, eight at a time.
//! Triangles are treated as boxes cut at planes; the exact builder's perfect splits are omitted. Cost: two
//! passes over a node's boxes, and one that partitions them; nothing is sorted.
//! Invariant: counts are exact below 2^24 triangles, and sums do not depend on the threads, so the tree
//! depends neither on the threads nor on the CPU. Tests: `tests::{few_are_weighed_exactly,
//! samples_come_close_to_the_minimum}`, `tests/kd_build.rs`.

use gnurt_simd::{Simd, dispatch_two, f32x4, f32x8, mask32x8, prelude::*, u32x8};

use crate::builder::{Builder, Cell, Subtree, WORTH_A_THREAD};
use crate::sah::{Costs, Plane, Shares, Side};
use gnurt_accel_core::Aabb;
use gnurt_accel_core::float::{least, most};

/// Nodes of at most this many triangles try every plane.
const FEW: usize = 16;
/// Samples of one pass.
const SAMPLES: usize = 8;
/// Of more boxes than twice this, about this many are counted, evenly spaced, for all.
const ENOUGH: usize = 2048;

/// A triangle's box in a node, cut at the planes above: x, y, z of the lower corner, the triangle's number (the bits of
/// a float), x, y, z of the upper corner, nothing.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct BoxRef([f32; 8]);

impl BoxRef {
    pub(crate) fn new(bounds: &Aabb, number: u32) -> Self {
        let Aabb { min: [a, b, c], max: [d, e, f] } = *bounds;
        Self([a, b, c, f32::from_bits(number), d, e, f, 0.0])
    }

    pub(crate) fn number(&self) -> u32 {
        self.0[3].to_bits()
    }

    #[inline(always)]
    fn low(&self, axis: usize) -> f32 {
        self.0[axis & 3]
    }

    #[inline(always)]
    fn high(&self, axis: usize) -> f32 {
        self.0[4 + (axis & 3)]
    }
}

impl Builder<'_> {
    /// Builds over `refs` into `slot` of `tree`, by several threads as long as there are many.
    pub(super) fn grow_sampled(&self, mut refs: Vec<BoxRef>, cell: Cell, tree: &mut Subtree, slot: usize) {
        let mut aside = Vec::new();
        if !self.parallel || refs.len() < WORTH_A_THREAD {
            let before = size_of::<BoxRef>() * refs.capacity();
            tree.counted = before;
            self.grow_sampled_single(&mut refs, 0, cell, &mut aside, tree, slot);
            self.watch.recount(&mut tree.counted, before);
            return;
        }
        let Some((plane, counts, cells)) = self.sampled_step(&refs, cell) else {
            return tree.set_leaf(slot, refs.iter().map(BoxRef::number));
        };
        part(&mut refs, 0, &plane, counts, &mut aside);
        aside.truncate(counts[0]);
        let first = tree.set_inner(slot, &plane);
        let bytes = size_of::<BoxRef>() * aside.capacity();
        self.watch.take(bytes);
        let split_off = |refs: Vec<BoxRef>, child: Cell| {
            let mut split_off = Subtree::new();
            self.grow_sampled(refs, child, &mut split_off, 0);
            self.grown(&cell, &child, &split_off);
            split_off
        };
        let on_left = || {
            let grown = split_off(aside, cells[0]);
            self.watch.give(bytes);
            grown
        };
        let (left, right) = rayon::join(on_left, || split_off(refs, cells[1]));
        tree.attach(first, left);
        tree.attach(first + 1, right);
    }

    /// Builds over the elements behind `start` in `refs`, and removes them.
    fn grow_sampled_single(
        &self,
        refs: &mut Vec<BoxRef>,
        start: usize,
        cell: Cell,
        aside: &mut Vec<BoxRef>,
        tree: &mut Subtree,
        slot: usize,
    ) {
        match self.sampled_step(&refs[start..], cell) {
            None => tree.set_leaf(slot, refs[start..].iter().map(BoxRef::number)),
            Some((plane, counts, [left, right])) => {
                let first = tree.set_inner(slot, &plane);
                part(refs, start, &plane, counts, aside);
                let behind = refs.len();
                refs.extend_from_slice(&aside[..counts[0]]);
                if !cell.small {
                    let boxes = refs.capacity() + aside.capacity();
                    let now = size_of::<BoxRef>() * boxes + tree.memory_bytes();
                    self.watch.recount(&mut tree.counted, now);
                }
                self.grow_sampled_single(refs, behind, left, aside, tree, first);
                self.advance(&cell, &left);
                self.grow_sampled_single(refs, start, right, aside, tree, first + 1);
                self.advance(&cell, &right);
            }
        }
        refs.truncate(start);
    }

    /// Where to divide, how many boxes each side gets, and the children; `None` for a leaf.
    fn sampled_step(&self, refs: &[BoxRef], cell: Cell) -> Option<(Plane, [usize; 2], [Cell; 2])> {
        let as_leaf = self.costs.leaf(refs.len());
        if cell.depth >= self.max_depth || as_leaf <= self.costs.cheapest_split() {
            return None;
        }
        if !cell.small && !self.watch.go_on() {
            return None;
        }
        let plane = dispatch_two!(self.level, simd => cheapest(simd, refs, &cell.bounds, &self.costs));
        let plane = plane.filter(|plane| plane.cost < as_leaf)?;
        let counts = refs.iter().fold([0, 0], |[left, right], one| {
            let [to_left, to_right] = sides(one, &plane);
            [left + usize::from(to_left), right + usize::from(to_right)]
        });
        // A plane that leaves everything on both sides gains nothing.
        if counts == [refs.len(); 2] {
            return None;
        }
        Some((plane, counts, cell.children(&plane, counts)?))
    }
}

/// Whether a box goes left and right.
#[inline(always)]
fn sides(one: &BoxRef, plane: &Plane) -> [bool; 2] {
    let (low, high) = (one.low(plane.axis), one.high(plane.axis));
    let (left, right) = (low < plane.at, high > plane.at);
    let flat = !left & !right;
    [left | (flat & (plane.flat_side == Side::Left)), right | (flat & (plane.flat_side == Side::Right))]
}

/// Leaves the right side's boxes behind `start` and puts the left side's to the front of `lefts`. Each box is written
/// to both, and counts where it belongs.
fn part(refs: &mut Vec<BoxRef>, start: usize, plane: &Plane, counts: [usize; 2], lefts: &mut Vec<BoxRef>) {
    if lefts.len() < counts[0] + 1 {
        lefts.resize(counts[0] + 1, BoxRef([0.0; 8]));
    }
    let here = &mut refs[start..];
    let (mut left, mut right) = (0, 0);
    for i in 0..here.len() {
        let one = here[i];
        let [to_left, to_right] = sides(&one, plane);
        lefts[left] = one;
        lefts[left].0[4 + (plane.axis & 3)] = least(one.high(plane.axis), plane.at);
        left += usize::from(to_left);
        here[right] = one;
        here[right].0[plane.axis & 3] = most(one.low(plane.axis), plane.at);
        right += usize::from(to_right);
    }
    debug_assert_eq!([left, right], counts, "counted before");
    refs.truncate(start + right);
}

/// The plane that seems cheapest.
#[inline(always)]
fn cheapest<S: Simd>(simd: S, refs: &[BoxRef], cell: &Aabb, costs: &Costs) -> Option<Plane> {
    if refs.len() <= FEW {
        cheapest_of_few(simd, refs, cell, costs)
    } else {
        sampled(simd, refs, cell, costs)
    }
}

/// Counts at a plane, in floats.
#[derive(Clone, Copy, Debug)]
struct Sample {
    at: f32,
    left: f32,
    right: f32,
}

/// The least of the parabolas between samples of the cost.
#[inline(always)]
fn sampled<S: Simd>(simd: S, refs: &[BoxRef], cell: &Aabb, costs: &Costs) -> Option<Plane> {
    let tight = tight_box(simd, refs);
    let every = (refs.len() / ENOUGH).max(1);
    let n = refs.len().div_ceil(every) as f32;
    let mut at = [[0.0f32; SAMPLES]; 3];
    for (axis, at) in at.iter_mut().enumerate() {
        let (low, high) = (tight.min[axis], tight.max[axis]);
        for (i, at) in at.iter_mut().enumerate() {
            *at = low + (high - low) * ((i + 1) as f32 / (SAMPLES + 1) as f32);
        }
    }
    let counts = count_along_all(simd, refs, every, &at);
    let mut best: Option<(Plane, usize)> = None;
    for axis in 0..3 {
        let row = with_ends(&tight, axis, n, &at[axis], &counts[axis]);
        let plane = least_of_parabolas(&row, cell, axis, costs, every);
        if let Some(plane) = plane.filter(|plane| best.is_none_or(|(best, _)| plane.cost < best.cost)) {
            best = Some((plane, axis));
        }
    }
    let (first, axis) = best?;

    // Again along that axis, where the counts change.
    let row = with_ends(&tight, axis, n, &at[axis], &counts[axis]);
    let more_at = evenly_changing(&row, n);
    let more = count_along(simd, refs, every, axis, &more_at);
    let mut rows = [Sample { at: 0.0, left: 0.0, right: 0.0 }; 2 * SAMPLES + 2];
    rows[..SAMPLES + 2].copy_from_slice(&row);
    for i in 0..SAMPLES {
        rows[SAMPLES + 2 + i] = Sample { at: more_at[i], left: more[0][i], right: more[1][i] };
    }
    rows.sort_unstable_by(|a, b| a.at.total_cmp(&b.at));
    let refined = least_of_parabolas(&rows, cell, axis, costs, every);
    Some(refined.unwrap_or(first))
}

/// Box around all.
#[inline(always)]
fn tight_box<S: Simd>(simd: S, refs: &[BoxRef]) -> Aabb {
    let (mut low, mut high) = (f32x4::splat(simd, f32::INFINITY), f32x4::splat(simd, f32::NEG_INFINITY));
    for one in refs {
        low = low.min(f32x4::from_slice(simd, &one.0[..4]));
        high = high.max(f32x4::from_slice(simd, &one.0[4..]));
    }
    let ([a, b, c, _], [d, e, f, _]) = (low.to_array(), high.to_array());
    Aabb { min: [a, b, c], max: [d, e, f] }
}

/// How many boxes begin left and end right of each plane, along each axis.
#[inline(always)]
fn count_along_all<S: Simd>(
    simd: S,
    refs: &[BoxRef],
    every: usize,
    at: &[[f32; SAMPLES]; 3],
) -> [[[f32; SAMPLES]; 2]; 3] {
    let load = |axis: usize| f32x8::from_slice(simd, &at[axis]);
    let (x, y, z) = (load(0), load(1), load(2));
    let zero = f32x8::splat(simd, 0.0);
    let (mut lx, mut ly, mut lz, mut rx, mut ry, mut rz) = (zero, zero, zero, zero, zero, zero);
    for one in refs.iter().step_by(every) {
        lx = one_more(simd, lx, f32x8::splat(simd, one.0[0]).simd_lt(x));
        ly = one_more(simd, ly, f32x8::splat(simd, one.0[1]).simd_lt(y));
        lz = one_more(simd, lz, f32x8::splat(simd, one.0[2]).simd_lt(z));
        rx = one_more(simd, rx, f32x8::splat(simd, one.0[4]).simd_gt(x));
        ry = one_more(simd, ry, f32x8::splat(simd, one.0[5]).simd_gt(y));
        rz = one_more(simd, rz, f32x8::splat(simd, one.0[6]).simd_gt(z));
    }
    [[lx.to_array(), rx.to_array()], [ly.to_array(), ry.to_array()], [lz.to_array(), rz.to_array()]]
}

/// The same along one axis.
#[inline(always)]
fn count_along<S: Simd>(
    simd: S,
    refs: &[BoxRef],
    every: usize,
    axis: usize,
    at: &[f32; SAMPLES],
) -> [[f32; SAMPLES]; 2] {
    let at = f32x8::from_slice(simd, at);
    let (mut left, mut right) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 0.0));
    for one in refs.iter().step_by(every) {
        left = one_more(simd, left, f32x8::splat(simd, one.low(axis)).simd_lt(at));
        right = one_more(simd, right, f32x8::splat(simd, one.high(axis)).simd_gt(at));
    }
    [left.to_array(), right.to_array()]
}

#[inline(always)]
fn one_more<S: Simd>(simd: S, count: f32x8<S>, here: mask32x8<S>) -> f32x8<S> {
    count + here.select(f32x8::splat(simd, 1.0), f32x8::splat(simd, 0.0))
}

/// Samples between the ends of the boxes, where all is on one side.
#[inline(always)]
fn with_ends(
    tight: &Aabb,
    axis: usize,
    n: f32,
    at: &[f32; SAMPLES],
    counts: &[[f32; SAMPLES]; 2],
) -> [Sample; SAMPLES + 2] {
    let mut row = [Sample { at: tight.min[axis], left: 0.0, right: n }; SAMPLES + 2];
    for i in 0..SAMPLES {
        row[i + 1] = Sample { at: at[i], left: counts[0][i], right: counts[1][i] };
    }
    row[SAMPLES + 1] = Sample { at: tight.max[axis], left: n, right: 0.0 };
    row
}

/// The positions at which the number of starts plus ends, 0 to 2n, takes evenly spaced values.
#[inline(always)]
fn evenly_changing(row: &[Sample; SAMPLES + 2], n: f32) -> [f32; SAMPLES] {
    let changed = |sample: &Sample| sample.left + (n - sample.right);
    let mut at = [row[0].at; SAMPLES];
    let mut next = 1;
    for (i, at) in at.iter_mut().enumerate() {
        let expected = 2.0 * n * ((i + 1) as f32 / (SAMPLES + 1) as f32);
        while next < SAMPLES + 1 && changed(&row[next]) < expected {
            next += 1;
        }
        let (from, to) = (&row[next - 1], &row[next]);
        let share = (expected - changed(from)) / (changed(to) - changed(from));
        let share = if (0.0..=1.0).contains(&share) { share } else { 0.5 };
        *at = from.at + share * (to.at - from.at);
    }
    at
}

/// The least cost of planes inside the cell, along one axis, where counts grow linearly from sample to sample.
#[inline(always)]
fn least_of_parabolas(
    row: &[Sample],
    cell: &Aabb,
    axis: usize,
    costs: &Costs,
    every: usize,
) -> Option<Plane> {
    let shares = Shares::new(cell, axis);
    let (low, length, cap, girth) = shares.in_single();
    let (mut best_at, mut least) = (f32::NAN, f32::INFINITY);
    let triangle = (costs.triangle * every as f64) as f32;
    let mut consider = |at: f32, weighed: f32, empty: bool| {
        let cost = 1.0 + triangle * weighed;
        let cost = if empty { cost * costs.empty_factor as f32 } else { cost };
        if cost < least && at > cell.min[axis] && at < cell.max[axis] {
            (best_at, least) = (at, cost);
        }
    };
    let first = &row[0];
    consider(first.at, (cap + girth * (length - (first.at - low))) * first.right, true);
    for pair in row.windows(2) {
        let (from, to) = (&pair[0], &pair[1]);
        let to_left = cap + girth * (from.at - low);
        let to_right = cap + girth * (length - (from.at - low));
        let step = girth * (to.at - from.at);
        let (begin, end) = (to.left - from.left, from.right - to.right);
        // cost(u) = (to_left + step u) (left + begin u) + (to_right - step u) (right - end u)
        let square = step * (begin + end);
        let linear = to_left * begin + step * from.left - to_right * end - step * from.right;
        let constant = to_left * from.left + to_right * from.right;
        consider(from.at, constant, every == 1 && (from.left == 0.0 || from.right == 0.0));
        let u = -0.5 * linear / square;
        if u > 0.0 && u < 1.0 {
            consider(from.at + u * (to.at - from.at), constant + u * (linear + u * square), false);
        }
    }
    if let Some(last) = row.last() {
        let to_left = cap + girth * (last.at - low);
        consider(last.at, to_left * last.left, true);
    }
    let flat_side = if best_at == row[0].at { Side::Right } else { Side::Left };
    (least < f32::INFINITY).then_some(Plane { axis, at: best_at, flat_side, cost: f64::from(least) })
}

/// Tries the faces of all boxes, with flat ones on both sides.
#[inline(always)]
fn cheapest_of_few<S: Simd>(simd: S, refs: &[BoxRef], cell: &Aabb, costs: &Costs) -> Option<Plane> {
    let splat = |value: f32| f32x8::splat(simd, value);
    let (zero, infinite) = (splat(0.0), splat(f32::INFINITY));
    let (triangle, factor) = (splat(costs.triangle as f32), splat(costs.empty_factor as f32));
    let n = splat(refs.len() as f32);
    // The best plane of each lane; codes are twice the axis, and one more where flat ones go left.
    let (mut best, mut best_at, mut best_code) = (infinite, zero, u32x8::splat(simd, 0));
    for axis in 0..3u32 {
        let (code, axis) = (2 * axis, axis as usize);
        let (low, length, cap, girth) = Shares::new(cell, axis).in_single();
        // Planes that do not exist lie on the cell's face, where no plane counts.
        let mut faces = [cell.min[axis]; 2 * FEW];
        for (i, one) in refs.iter().enumerate() {
            (faces[2 * i], faces[2 * i + 1]) = (one.low(axis), one.high(axis));
        }
        for faces in faces.chunks(SAMPLES).take((2 * refs.len()).div_ceil(SAMPLES)) {
            let at = f32x8::from_slice(simd, faces);
            let (mut left, mut right, mut across) = (zero, zero, zero);
            for one in refs {
                let begun = splat(one.low(axis)).simd_lt(at);
                let not_ended = splat(one.high(axis)).simd_gt(at);
                left = one_more(simd, left, begun);
                right = one_more(simd, right, not_ended);
                across = one_more(simd, across, begun & not_ended);
            }
            let flat = n - (left + right - across);
            let x = at - splat(low);
            let (to_left, to_right) =
                (splat(cap) + splat(girth) * x, splat(cap) + splat(girth) * (splat(length) - x));
            let cost = |left: f32x8<S>, right: f32x8<S>| {
                let cost = splat(1.0) + triangle * (to_left * left + to_right * right);
                (left.simd_eq(zero) | right.simd_eq(zero)).select(cost * factor, cost)
            };
            let (flat_left, flat_right) = (cost(left + flat, right), cost(left, right + flat));
            let inside = at.simd_gt(splat(cell.min[axis])) & at.simd_lt(splat(cell.max[axis]));
            let cost = inside.select(flat_left.min(flat_right), infinite);
            let on_left = flat_left.simd_le(flat_right);
            let code = on_left.select(u32x8::splat(simd, code | 1), u32x8::splat(simd, code));
            let better = cost.simd_lt(best);
            best = better.select(cost, best);
            best_at = better.select(at, best_at);
            best_code = better.select(code, best_code);
        }
    }
    let (costs, positions, codes) = (best.as_array(), best_at.as_array(), best_code.as_array());
    let key = |i: usize| (costs[i], codes[i], positions[i]);
    let mut lane = 0;
    for i in 1..SAMPLES {
        lane = if key(i) < key(lane) { i } else { lane };
    }
    let (cost, code, at) = key(lane);
    let flat_side = if code & 1 == 1 { Side::Left } else { Side::Right };
    (cost < f32::INFINITY).then_some(Plane {
        axis: (code >> 1) as usize,
        at,
        flat_side,
        cost: f64::from(cost),
    })
}

#[cfg(test)]
mod tests {
    use gnurt_simd::{Level, dispatch};

    use super::*;
    use crate::naive::naive_minimum;

    fn boxes(random: &mut gnurt_testkit::Random, n: usize, size: f32) -> Vec<Aabb> {
        let some = |_| {
            let (a, b) = (random.point(), random.point());
            Aabb::around(&[a, [0, 1, 2].map(|k| a[k] + size * b[k])])
        };
        (0..n).map(some).collect()
    }

    fn found(boxes: &[Aabb], costs: &Costs) -> (Aabb, f64) {
        let refs: Vec<BoxRef> = boxes.iter().enumerate().map(|(i, b)| BoxRef::new(b, i as u32)).collect();
        let cell = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
        let planes = Level::available()
            .into_iter()
            .map(|level| dispatch!(level, simd => cheapest(simd, &refs, &cell, costs)));
        let planes: Vec<Option<Plane>> = planes.collect();
        assert!(planes.iter().all(|plane| *plane == planes[0]), "one plane at every level: {planes:?}");
        (cell, planes[0].map_or(f64::INFINITY, |plane| plane.cost))
    }

    #[test]
    fn few_are_weighed_exactly() {
        let costs = Costs { triangle: 0.7, empty_factor: 0.8 };
        let mut random = gnurt_testkit::Random::new(5);
        for round in 0..400 {
            let mut boxes = boxes(&mut random, 1 + round % FEW, 1.0);
            if round % 2 == 0 {
                // Few distinct coordinates, so that starts, ends and flat boxes meet in the same planes.
                for x in boxes.iter_mut().flat_map(|b| b.min.iter_mut().chain(&mut b.max)) {
                    *x = (2.0 * *x).round();
                }
            }
            let (cell, cost) = found(&boxes, &costs);
            if cell.half_area() == 0.0 {
                continue;
            }
            let least = naive_minimum(&cell, &boxes, &costs);
            let same = cost == least || (cost - least).abs() < 1e-5 * least;
            assert!(same, "{} boxes: {cost} in lanes, looking at everything {least}", boxes.len());
        }
    }

    #[test]
    fn samples_come_close_to_the_minimum() {
        let costs = Costs { triangle: 0.3, empty_factor: 0.8 };
        let mut random = gnurt_testkit::Random::new(6);
        for (n, size) in [(20, 0.2), (100, 0.1), (400, 0.05), (400, 0.5), (6000, 0.01)] {
            let boxes = boxes(&mut random, n, size);
            let (cell, cost) = found(&boxes, &costs);
            let least = naive_minimum(&cell, &boxes, &costs);
            let error = cost / least - 1.0;
            assert!(
                error.abs() < 0.05,
                "{n} boxes of {size}: {cost} by samples, looking at everything {least}"
            );
        }
    }
}
