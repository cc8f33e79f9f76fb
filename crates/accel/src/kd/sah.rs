// SPDX-License-Identifier: GPL-3.0-or-later
//! The surface area heuristic: which plane makes a node cheapest for a random ray.
//! Source: [MB90] for the cost, [WH06] for the sweep, its order of events and the side of flat triangles.
//! Differs: planes at the node's own faces are no candidates.
//! Cost: one pass over the sorted events per axis. Proof: `tests::the_sweep_finds_the_naive_minimum`.

use super::event::{Event, Kind};
use crate::Aabb;

/// The costs that a builder weighs; a step through a node costs 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Costs {
    /// Of testing a triangle.
    pub(crate) triangle: f64,
    /// Factor for planes that cut off empty space.
    pub(crate) empty_factor: f64,
}

/// A plane and what it would cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    pub(crate) axis: usize,
    pub(crate) at: f32,
    /// Where triangles go that lie in the plane.
    pub(crate) flat_side: Side,
    pub(crate) cost: f64,
}

/// Towards smaller or greater coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
}

/// Triangles left of a plane, in it and right of it; those across count on both sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    pub(crate) left: usize,
    pub(crate) flat: usize,
    pub(crate) right: usize,
}

impl Costs {
    /// What a leaf of `n` triangles costs.
    pub(crate) fn leaf(&self, n: usize) -> f64 {
        self.triangle * n as f64
    }

    /// No plane can be cheaper.
    pub(crate) fn cheapest_split(&self) -> f64 {
        self.empty_factor.min(1.0)
    }

    /// The cost with flat triangles on the better side; `share` are the sides' shares of the node's area.
    #[inline(always)]
    pub(crate) fn split(&self, share: [f64; 2], counts: Counts) -> (f64, Side) {
        let Counts { left, flat, right } = counts;
        let with = |left: usize, right: usize| {
            let cost = 1.0 + self.triangle * (share[0] * left as f64 + share[1] * right as f64);
            if left == 0 || right == 0 { cost * self.empty_factor } else { cost }
        };
        let (to_left, to_right) = (with(left + flat, right), with(left, flat + right));
        if to_left <= to_right { (to_left, Side::Left) } else { (to_right, Side::Right) }
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

    #[inline(always)]
    pub(crate) fn of(&self, at: f32) -> [f64; 2] {
        let left = f64::from(at) - self.low;
        [left, self.length - left].map(|length| (self.cap + self.girth * length) * self.over_area)
    }
}

/// The cheapest plane inside `bounds`, of `n` triangles whose sorted events are given per axis.
/// Of equally cheap planes it is the first, x before y before z.
pub(crate) fn best_plane(bounds: &Aabb, events: &[Vec<Event>; 3], n: usize, costs: &Costs) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    for (axis, events) in events.iter().enumerate() {
        let shares = Shares::new(bounds, axis);
        let mut counts = Counts { left: 0, flat: 0, right: n };
        let mut next = 0;
        while next < events.len() {
            let (first, mut ended, mut started) = (events[next], 0, 0);
            counts.flat = 0;
            while next < events.len() && events[next].place() == first.place() {
                match events[next].kind() {
                    Kind::End => ended += 1,
                    Kind::Flat => counts.flat += 1,
                    Kind::Start => started += 1,
                }
                next += 1;
            }
            counts.right -= ended + counts.flat;
            let at = first.at();
            if at > bounds.min[axis] && at < bounds.max[axis] {
                let (cost, flat_side) = costs.split(shares.of(at), counts);
                if best.is_none_or(|best| cost < best.cost) {
                    best = Some(Plane { axis, at, flat_side, cost });
                }
            }
            counts.left += started + counts.flat;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::event::push_events;
    use super::*;

    /// Counts by looking at every box for every plane.
    fn naive_minimum(bounds: &Aabb, boxes: &[Aabb], costs: &Costs) -> f64 {
        let mut least = f64::INFINITY;
        for axis in 0..3 {
            for at in boxes.iter().flat_map(|b| [b.min[axis], b.max[axis]]) {
                if at <= bounds.min[axis] || at >= bounds.max[axis] {
                    continue;
                }
                let flat = boxes.iter().filter(|b| b.min[axis] == at && b.max[axis] == at).count();
                let left = boxes.iter().filter(|b| b.min[axis] < at).count();
                let right = boxes.iter().filter(|b| b.max[axis] > at).count();
                let parts = bounds.split(axis, at).map(|part| part.half_area() / bounds.half_area());
                for (l, r) in [(left + flat, right), (left, right + flat)] {
                    let mut cost = 1.0 + costs.triangle * (parts[0] * l as f64 + parts[1] * r as f64);
                    if l == 0 || r == 0 {
                        cost *= costs.empty_factor;
                    }
                    least = least.min(cost);
                }
            }
        }
        least
    }

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
            let found = best_plane(&bounds, &events, n, &costs).map_or(f64::INFINITY, |plane| plane.cost);
            let least = naive_minimum(&bounds, &boxes, &costs);
            let same = found == least || (found - least).abs() < 1e-12 * least;
            assert!(same, "{n} boxes: the sweep says {found}, looking at everything {least}");
        }
    }
}
