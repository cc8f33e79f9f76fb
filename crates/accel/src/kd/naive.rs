// SPDX-License-Identifier: GPL-3.0-or-later
//! An oracle for whole trees: the same greedy rules as `build.rs`, without events, merging or numbering.
//! Source: [MB90, WH06]; every plane of every box is tried, and every box is looked at for each: O(n^2) per node.
//! Proof: `tests::the_built_tree_costs_what_the_naive_one_does` is the comparison itself.

use super::clip::split_boxes;
use super::sah::{Costs, Counts, Plane, Shares, Side};
use crate::Aabb;
use crate::geometry::Screened;

/// What a node sees of a triangle.
#[derive(Clone, Copy)]
struct Seen {
    number: u32,
    bounds: Aabb,
}

/// The expected cost of the naive tree, weighted by area, not yet divided by the root's.
fn cost_below(screened: &Screened, seen: &[Seen], cell: &Aabb, depth: usize, costs: &Costs) -> f64 {
    let as_leaf = costs.leaf(seen.len());
    let plane = best_plane(seen, cell, costs).filter(|plane| plane.cost < as_leaf);
    let Some(plane) = plane.filter(|_| depth > 0 && as_leaf > costs.cheapest_split()) else {
        return as_leaf * cell.half_area();
    };
    let cells = cell.split(plane.axis, plane.at);
    let [mut left, mut right] = [Vec::new(), Vec::new()];
    for &one in seen {
        let (low, high) = (one.bounds.min[plane.axis], one.bounds.max[plane.axis]);
        let in_plane = low == plane.at && high == plane.at;
        if in_plane {
            if plane.flat_side == Side::Left { left.push(one) } else { right.push(one) }
        } else if high <= plane.at {
            left.push(one);
        } else if low >= plane.at {
            right.push(one);
        } else {
            let corners = screened.corners(one.number);
            let parts = split_boxes(&corners, cell, plane.axis, plane.at);
            left.extend(parts[0].map(|bounds| Seen { bounds, ..one }));
            right.extend(parts[1].map(|bounds| Seen { bounds, ..one }));
        }
    }
    cell.half_area()
        + cost_below(screened, &left, &cells[0], depth - 1, costs)
        + cost_below(screened, &right, &cells[1], depth - 1, costs)
}

/// The first of the cheapest planes: x before y before z, smaller coordinates first.
fn best_plane(seen: &[Seen], cell: &Aabb, costs: &Costs) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    for axis in 0..3 {
        let ends = |one: &Seen| [one.bounds.min[axis], one.bounds.max[axis]];
        let mut places: Vec<f32> = seen.iter().flat_map(ends).collect();
        places.retain(|&at| at > cell.min[axis] && at < cell.max[axis]);
        places.sort_by(f32::total_cmp);
        for at in places {
            let count =
                |side: fn([f32; 2], f32) -> bool| seen.iter().filter(|one| side(ends(one), at)).count();
            let counts = Counts {
                left: count(|[low, _], at| low < at),
                flat: count(|[low, high], at| low == at && high == at),
                right: count(|[_, high], at| high > at),
            };
            let (cost, flat_side) = costs.split(Shares::new(cell, axis).of(at), counts);
            if best.is_none_or(|best| cost < best.cost) {
                best = Some(Plane { axis, at, flat_side, cost });
            }
        }
    }
    best
}

mod tests {
    use super::super::KdTree;
    use super::*;
    use crate::{BuildOptions, Threads, Triangles};
    use gnurt_testkit::{Soup, closed};

    #[test]
    fn the_built_tree_costs_what_the_naive_one_does() {
        // Without a limit on references, which the naive builder does not know.
        let options = BuildOptions { reference_budget: 1e6, max_depth: 20, ..BuildOptions::default() };
        let costs = Costs { triangle: 0.5, empty_factor: 0.8 };
        let soups = [
            ("random", Soup::random(1, 150, 0.3)),
            ("large", Soup::random(2, 60, 1.0)),
            ("grid", Soup::grid(3, 150)),
            ("slivers", Soup::slivers(4, 60)),
            ("sphere", closed::sphere(10)),
            ("cube", closed::cube(4)),
        ];
        for (name, soup) in soups {
            let meshes = [Triangles { positions: &soup.positions, indices: &soup.indices }];
            let screened = Screened::new(&meshes);
            let built = KdTree::build(&screened, &options, Threads::Single).measure(&options).sah_cost;
            let seen: Vec<Seen> = screened
                .good
                .iter()
                .map(|&number| Seen { number, bounds: Aabb::around(&screened.corners(number)) })
                .collect();
            let whole = screened.bounds;
            let naive = cost_below(&screened, &seen, &whole, 20, &costs) / whole.half_area();
            // Stored planes are rounded by two units in the last place, so costs differ a little.
            let error = (built - naive).abs() / naive;
            assert!(error < 1e-4, "{name}: the built tree costs {built}, the naive one {naive}");
        }
    }
}
