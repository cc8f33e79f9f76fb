// SPDX-License-Identifier: GPL-3.0-or-later
//! An oracle for whole trees: the same greedy rules as `build.rs`, without events, merging or numbering.
//! Source: [MB90, WH06]; every plane of every box is tried, and every box is looked at for each: O(n^2) per node.
//! Tests: `tests::the_built_tree_costs_what_the_naive_one_does` is the comparison itself.

use crate::sah::{Costs, Passed, Plane, Shares, Side};
use gnurt_accel_core::Aabb;
use gnurt_accel_core::clip::split_boxes;
use gnurt_accel_core::valid_triangles::ValidTriangles;

/// A node's part of a triangle.
#[derive(Clone, Copy)]
struct Overlap {
    number: u32,
    bounds: Aabb,
}

/// The expected cost of the naive tree, weighted by area, not yet divided by the root's.
fn cost_below(
    valid_triangles: &ValidTriangles,
    overlap: &[Overlap],
    cell: &Aabb,
    depth: usize,
    costs: &Costs,
) -> f64 {
    let as_leaf = costs.leaf(overlap.len());
    let plane = best_plane(overlap, cell, costs).filter(|plane| plane.cost < as_leaf);
    let Some(plane) = plane.filter(|_| depth > 0 && as_leaf > costs.cheapest_split()) else {
        return as_leaf * cell.half_area();
    };
    let cells = cell.split(plane.axis, plane.at);
    let [mut left, mut right] = [Vec::new(), Vec::new()];
    for &one in overlap {
        let (low, high) = (one.bounds.min[plane.axis], one.bounds.max[plane.axis]);
        let in_plane = low == plane.at && high == plane.at;
        if in_plane {
            if plane.flat_side == Side::Left { left.push(one) } else { right.push(one) }
        } else if high <= plane.at {
            left.push(one);
        } else if low >= plane.at {
            right.push(one);
        } else {
            let corners = valid_triangles.corners(one.number);
            let parts = split_boxes(&corners, cell, plane.axis, plane.at);
            left.extend(parts[0].map(|bounds| Overlap { bounds, ..one }));
            right.extend(parts[1].map(|bounds| Overlap { bounds, ..one }));
        }
    }
    cell.half_area()
        + cost_below(valid_triangles, &left, &cells[0], depth - 1, costs)
        + cost_below(valid_triangles, &right, &cells[1], depth - 1, costs)
}

/// The first of the cheapest planes: x before y before z, smaller coordinates first.
fn best_plane(overlap: &[Overlap], cell: &Aabb, costs: &Costs) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    for axis in 0..3 {
        let ends = |one: &Overlap| [one.bounds.min[axis], one.bounds.max[axis]];
        let mut plane_positions: Vec<f32> = overlap.iter().flat_map(ends).collect();
        plane_positions.retain(|&at| at > cell.min[axis] && at < cell.max[axis]);
        plane_positions.sort_by(f32::total_cmp);
        for at in plane_positions {
            let count = |side: fn([f32; 2], f32) -> bool| {
                overlap.iter().filter(|one| side(ends(one), at)).count() as i32
            };
            let flat = count(|[low, high], at| low == at && high == at);
            let (left, right) = (count(|[low, _], at| low < at), count(|[_, high], at| high > at));
            let share = Shares::new(cell, axis).of(at);
            let to_left = costs.of_counts(share, Passed { left: left + flat, right });
            let to_right = costs.of_counts(share, Passed { left, right: right + flat });
            let flat_side = if to_left <= to_right { Side::Left } else { Side::Right };
            let cost = to_left.min(to_right);
            if best.is_none_or(|best| cost < best.cost) {
                best = Some(Plane { axis, at, flat_side, cost });
            }
        }
    }
    best
}

/// Counts by testing every box for every plane.
pub(super) fn naive_minimum(bounds: &Aabb, boxes: &[Aabb], costs: &Costs) -> f64 {
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

mod tests {
    use super::*;
    use crate::node::KdTree;
    use gnurt_accel_core::{BuildOptions, Threads, Triangles};
    use gnurt_testkit::{Soup, closed};

    #[test]
    fn the_built_tree_costs_what_the_naive_one_does() {
        // Without a limit on references, which the naive builder lacks.
        let options = BuildOptions {
            triangle_cost: 0.5,
            reference_budget: 1e6,
            max_depth: 20,
            ..BuildOptions::default()
        };
        let costs = Costs { triangle: 0.5, empty_factor: 0.8 };
        let soups = [
            ("random", Soup::random(1, 150, 0.3)),
            ("large", Soup::random(2, 60, 1.0)),
            ("grid", Soup::grid(3, 150)),
            ("slivers", Soup::slivers(4, 60)),
            ("sphere", closed::sphere(10)),
            ("cube", closed::cube(4)),
        ];
        let mut errors = 0.0;
        for (name, soup) in &soups {
            let meshes = [Triangles { positions: &soup.positions, indices: &soup.indices }];
            let valid_triangles = ValidTriangles::new(&meshes);
            let built = KdTree::build(
                &valid_triangles,
                &options,
                Threads::Single,
                &gnurt_accel_core::control::Watch::new(&()),
            )
            .expect("nobody stops it")
            .measure(&options)
            .sah_cost;
            let overlap: Vec<Overlap> = valid_triangles
                .good
                .iter()
                .map(|&number| Overlap { number, bounds: Aabb::around(&valid_triangles.corners(number)) })
                .collect();
            let whole = valid_triangles.bounds;
            let naive = cost_below(&valid_triangles, &overlap, &whole, 20, &costs) / whole.half_area();
            // The builder compares costs in single precision. Where planes are equally good for that, it may take another
            // one than the naive builder, and go on to a tree that is a little better or worse.
            let error = (built - naive) / naive;
            assert!(error.abs() < 0.01, "{name}: the built tree costs {built}, the naive one {naive}");
            errors += error / soups.len() as f64;
        }
        assert!(errors < 1e-3, "built trees cost {errors} more than naive ones on average");
    }
}
