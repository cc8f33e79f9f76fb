// SPDX-License-Identifier: GPL-3.0-or-later
//! The surface area heuristic: which plane makes a node cheapest for a random ray.
//! Source: [MB90] for the cost, [WH06] for the sweep, its order of events and the side of flat triangles.
//! Differs: planes at the node's own faces are no candidates.
//! Cost: one pass over the sorted events per axis. Tests: `tests::the_sweep_finds_the_naive_minimum`.

use gnurt_simd::{Simd, f32x8, prelude::*, u32x8};

use crate::event::{Event, Kind};
use gnurt_accel_core::Aabb;

/// The costs that a builder weighs; a step through a node costs 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Costs {
    /// Of testing a triangle.
    pub(crate) triangle: f64,
    /// Factor for planes that cut off empty space.
    pub(crate) empty_factor: f64,
}

/// A plane and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    pub(crate) axis: usize,
    pub(crate) at: f32,
    /// The side of triangles in the plane.
    pub(crate) flat_side: Side,
    pub(crate) cost: f64,
}

/// Towards smaller or greater coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
}

impl Costs {
    /// The cost of a leaf of `n` triangles.
    pub(crate) fn leaf(&self, n: usize) -> f64 {
        self.triangle * n as f64
    }

    /// The cost where as many triangles go left and right.
    #[inline(always)]
    pub(crate) fn of_counts(&self, share: [f64; 2], Passed { left, right }: Passed) -> f64 {
        let cost = 1.0 + self.triangle * (share[0] * left as f64 + share[1] * right as f64);
        if left == 0 || right == 0 { cost * self.empty_factor } else { cost }
    }

    /// No plane can be cheaper.
    pub(crate) fn cheapest_split(&self) -> f64 {
        self.empty_factor.min(1.0)
    }
}

/// The areas on both sides of a plane, as shares of the whole node's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shares {
    low: f64,
    length: f64,
    cap: f64,
    girth: f64,
    over_area: f64,
}

impl Shares {
    pub(crate) fn new(bounds: &Aabb, axis: usize) -> Self {
        let extent = bounds.extent();
        let [a, b] = [extent[(axis + 1) % 3], extent[(axis + 2) % 3]];
        let low = f64::from(bounds.min[axis]);
        Self { low, length: extent[axis], cap: a * b, girth: a + b, over_area: 1.0 / bounds.half_area() }
    }

    /// Lower end, length, and the coefficients of a side's share: the third, and the fourth times the side's
    /// length.
    #[inline(always)]
    pub(crate) fn in_single(&self) -> (f32, f32, f32, f32) {
        let Self { low, length, cap, girth, over_area } = *self;
        (low as f32, length as f32, (cap * over_area) as f32, (girth * over_area) as f32)
    }

    #[inline(always)]
    pub(crate) fn of(&self, at: f32) -> [f64; 2] {
        let left = f64::from(at) - self.low;
        [left, self.length - left].map(|length| (self.cap + self.girth * length) * self.over_area)
    }
}

/// The cheapest plane across `axis` inside `bounds`, of `n` triangles whose sorted events along it are given.
///
/// Counts are updated after every event, instead of after every group of events in one position. Within a
/// group they are too high on one side or mix flat triangles; both cost at least as much as the best of the
/// group, so they cannot win. This allows eight events to be weighed at a time. They are compared in single
/// precision: any of planes that differ by less is acceptable, the same on every CPU.
#[inline(always)]
pub(crate) fn best_across<S: Simd>(
    simd: S,
    bounds: &Aabb,
    axis: usize,
    events: &[Event],
    n: usize,
    costs: &Costs,
) -> Option<Plane> {
    // Planes at the node's own faces are no candidates, but many boxes end there.
    let (low, high) = (Event::position_of(bounds.min[axis]), Event::position_of(bounds.max[axis]));
    let mut passed = Passed { left: 0, right: n as i32 };
    let mut events = events;
    while let [first, rest @ ..] = events
        && first.position() <= low
    {
        passed.pass(*first);
        events = rest;
    }
    while let [rest @ .., last] = events
        && last.position() >= high
    {
        events = rest;
    }
    let (first, last) = (*events.first()?, *events.last()?);

    let shares = Shares::new(bounds, axis);
    let mut sweep = Sweep::new(simd, &shares);
    let mut best: Option<Plane> = None;
    let mut consider = |event: Event, passed: Passed, flat_side: Side| {
        let cost = costs.of_counts(shares.of(event.at()), passed);
        if cost.is_finite() && best.is_none_or(|best| cost < best.cost) {
            best = Some(Plane { axis, at: event.at(), flat_side, cost });
        }
    };
    // One side can be empty only before the first event and behind the last one.
    consider(first, passed.before(first), Side::Right);
    let (blocks, rest) = events.as_chunks::<BLOCK>();
    for (number, block) in blocks.iter().enumerate() {
        if block.iter().fold(false, |any, event| any | event.is_flat()) {
            one_by_one(block, &mut passed, &mut consider);
        } else {
            sweep.pass(simd, block, number as u32, &mut passed);
        }
    }
    if rest.iter().any(|event| event.is_flat()) {
        one_by_one(rest, &mut passed, &mut consider);
    } else if !rest.is_empty() {
        // Padding after the last event costs NaN, which is never the least.
        let mut block = [Event::new(f32::INFINITY, Kind::Start, 0); BLOCK];
        block[..rest.len()].copy_from_slice(rest);
        sweep.pass(simd, &block, blocks.len() as u32, &mut passed);
        passed.left -= (BLOCK - rest.len()) as i32;
    }
    if let Some((index, passed)) = sweep.best() {
        consider(events[index], passed, if events[index].ends() == 1 { Side::Right } else { Side::Left });
    }
    if passed.right == 0 {
        consider(last, passed, Side::Left);
    }
    best
}

/// Weighs each event by itself.
#[inline(always)]
fn one_by_one(events: &[Event], passed: &mut Passed, consider: &mut impl FnMut(Event, Passed, Side)) {
    for &event in events {
        consider(event, passed.before(event), Side::Right);
        passed.pass(event);
        if event.is_flat() {
            consider(event, *passed, Side::Left);
        }
    }
}

/// Triangles that started, and that have not yet ended, where a sweep is.
#[derive(Clone, Copy)]
pub(crate) struct Passed {
    pub(crate) left: i32,
    pub(crate) right: i32,
}

impl Passed {
    #[inline(always)]
    fn pass(&mut self, event: Event) {
        self.left += i32::from(event.kind() != Kind::End);
        self.right -= i32::from(event.kind() != Kind::Start);
    }

    /// The counts at the plane of an event, after events that end there and before those that start or are
    /// flat.
    #[inline(always)]
    fn before(mut self, event: Event) -> Self {
        self.right -= i32::from(event.kind() == Kind::End);
        self
    }
}

/// Events that are weighed together.
const BLOCK: usize = 8;

/// The least cost so far in each lane of a block, without a factor and the terms common to all planes.
struct Sweep<S: Simd> {
    low: f32x8<S>,
    length: f32x8<S>,
    cap: f32x8<S>,
    girth: f32x8<S>,
    cost: f32x8<S>,
    left: f32x8<S>,
    right: f32x8<S>,
    block: u32x8<S>,
}

impl<S: Simd> Sweep<S> {
    #[inline(always)]
    fn new(simd: S, shares: &Shares) -> Self {
        let at = |value: f32| f32x8::splat(simd, value);
        let (low, length, cap, girth) = shares.in_single();
        Self {
            low: at(low),
            length: at(length),
            cap: at(cap),
            girth: at(girth),
            cost: at(f32::INFINITY),
            left: at(0.0),
            right: at(0.0),
            block: u32x8::splat(simd, 0),
        }
    }

    /// Takes the next eight events, none of them flat.
    #[inline(always)]
    fn pass(&mut self, simd: S, events: &[Event; BLOCK], number: u32, passed: &mut Passed) {
        let (mut positions, mut ended) = ([0.0; BLOCK], [0.0; BLOCK]);
        for i in 0..BLOCK {
            positions[i] = events[i].at();
            ended[i] = events[i].ends() as f32;
        }
        let at = |value: i32| f32x8::splat(simd, value as f32);
        let here = f32x8::from_slice(simd, &ended);
        // Prefix sums of all.
        let mut ended = here + here.shift_elements_right::<1>(0.0);
        ended += ended.shift_elements_right::<2>(0.0);
        ended += ended.shift_elements_right::<4>(0.0);
        let positions_before = f32x8::from_slice(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let left = at(passed.left) + (positions_before - (ended - here));
        let right = at(passed.right) - ended;
        let all = ended.as_array()[BLOCK - 1] as i32;
        passed.left += BLOCK as i32 - all;
        passed.right -= all;

        let x = f32x8::from_slice(simd, &positions) - self.low;
        let cost = (self.cap + self.girth * x) * left + (self.cap + self.girth * (self.length - x)) * right;
        let better = cost.simd_lt(self.cost);
        self.cost = better.select(cost, self.cost);
        self.left = better.select(left, self.left);
        self.right = better.select(right, self.right);
        self.block = better.select(u32x8::splat(simd, number), self.block);
    }

    /// The event with the cheapest plane, and the counts on its sides.
    #[inline(always)]
    fn best(&self) -> Option<(usize, Passed)> {
        let (cost, block) = (self.cost.as_array(), self.block.as_array());
        let key = |i: usize| (cost[i], block[i] as usize * BLOCK + i);
        let mut best = 0;
        for i in 1..BLOCK {
            best = if key(i) < key(best) { i } else { best };
        }
        let (left, right) = (self.left.as_array()[best] as i32, self.right.as_array()[best] as i32);
        (cost[best] < f32::INFINITY).then_some((key(best).1, Passed { left, right }))
    }
}

/// The cheapest plane inside `bounds`; of equally cheap ones x before y before z.
pub(crate) fn cheapest(planes: [Option<Plane>; 3]) -> Option<Plane> {
    planes.into_iter().flatten().fold(None, |best: Option<Plane>, plane| match best {
        Some(best) if best.cost <= plane.cost => Some(best),
        _ => Some(plane),
    })
}

#[cfg(test)]
mod tests {
    use gnurt_simd::{Level, dispatch};

    use super::*;
    use crate::event::push_events;
    use crate::naive::naive_minimum;

    #[test]
    fn the_sweep_finds_the_naive_minimum() {
        let costs = Costs { triangle: 0.7, empty_factor: 0.8 };
        let mut state = 1u32;
        // Few distinct coordinates, so that starts, ends and flat boxes meet in the same planes.
        let mut coordinate = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 29) as f32
        };
        for n in 1..60 {
            let boxes: Vec<Aabb> = (0..n)
                .map(|_| {
                    Aabb::around(&[[0; 3].map(|_: i32| coordinate()), [0; 3].map(|_: i32| coordinate())])
                })
                .collect();
            let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
            if bounds.half_area() == 0.0 {
                continue;
            }
            let mut events = [const { Vec::new() }; 3];
            for (axis, events) in events.iter_mut().enumerate() {
                boxes.iter().enumerate().for_each(|(i, b)| push_events(events, b, axis, i as u32));
                events.sort_unstable();
            }
            let across = |axis: usize| dispatch!(Level::best(), simd => best_across(simd, &bounds, axis, &events[axis], n, &costs));
            let plane = cheapest([across(0), across(1), across(2)]);
            let found = plane.map_or(f64::INFINITY, |plane| plane.cost);
            let least = naive_minimum(&bounds, &boxes, &costs);
            let same = found == least || (found - least).abs() < 1e-6 * least;
            assert!(same, "{n} boxes: the sweep says {found}, looking at everything {least}");
        }
    }
}
