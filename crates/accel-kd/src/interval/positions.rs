// SPDX-License-Identifier: GPL-3.0-or-later
//! Primitives near a point, or in a region, under an interval hierarchy; and the contents of leaf blocks.
//! Regions of nodes are maintained in the descent, cut by the passed planes. Source: [Ben75] for the search.
//! Space: object.
//! Tests: `tests/closest_point.rs`, `tests/surfaces/{crossings,overlaps,normals}.rs` of `gnurt-accel`.

use gnurt_accel_core::Aabb;
use gnurt_accel_core::blocks::WIDTH;
use gnurt_accel_core::filter_region::NOTHING;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::{RegionFilter, Rows};

use super::index::{IntervalIndex, Nodes, with_nodes};
use super::node::{Kind, Layout};

/// Calls `leaf` with blocks of those leaves whose region, and whose parents', is `expected`; of two children
/// first the one with the lesser `rank`.
fn descend<N: Layout>(
    nodes: &[N],
    bounds: Aabb,
    expected: &mut dyn FnMut(&Aabb) -> bool,
    rank: &dyn Fn(&Aabb) -> f64,
    leaf: &mut dyn FnMut(usize),
) {
    let mut waiting = vec![(0, bounds)];
    while let Some((at, region)) = waiting.pop() {
        if !expected(&region) {
            continue;
        }
        let node = nodes[at];
        match node.kind() {
            Kind::Leaf { block } => leaf(block),
            Kind::Clip { axis } => {
                let [low, high] = node.ends();
                let mut clipped = region;
                (clipped.min[axis], clipped.max[axis]) = (low, high);
                waiting.push((at + 1, clipped));
            }
            Kind::Split { axis, right } => {
                let [a, b] = node.regions(axis, &region);
                let mut children = [(at + 1, a), (right, b)];
                if rank(&a) < rank(&b) {
                    children.reverse();
                }
                waiting.extend(children);
            }
        }
    }
}

impl IntervalIndex {
    /// Improves `nearest` by the triangles.
    pub fn nearest(&self, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        let reach = std::cell::Cell::new(probe.radius_for(nearest.distance()));
        let far = |region: &Aabb| region.distance(&probe.point);
        let mut leaf = |block: usize| {
            self.blocks[block].nearest(probe, slot, nearest);
            reach.set(probe.radius_for(nearest.distance()));
        };
        with_nodes!(&self.nodes, nodes => {
            descend(nodes, self.bounds, &mut |region| far(region) <= reach.get(), &far, &mut leaf);
        });
    }

    /// Shows the triangles that may meet a region.
    pub fn filter_region(&self, region_filter: &RegionFilter, visit: &mut dyn FnMut(u32, Primitive)) {
        let mut expected = |region: &Aabb| {
            let mut rows: Rows = NOTHING;
            for k in 0..3 {
                (rows[2 * k][0], rows[2 * k + 1][0]) = (region.min[k], region.max[k]);
            }
            region_filter.overlap_mask(&rows) & 1 != 0
        };
        let mut leaf = |block: usize| self.blocks[block].filter_region(region_filter, visit);
        with_nodes!(&self.nodes, nodes => {
            descend(nodes, self.bounds, &mut expected, &|_| 0.0, &mut leaf);
        });
    }

    /// Numbers of all leaf blocks, and how many there are.
    pub fn numbers(&self, visit: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
        self.blocks.iter().enumerate().for_each(|(i, block)| visit(i, &block.numbers));
        self.blocks.len()
    }

    /// The corners of one triangle.
    #[must_use]
    pub fn corners_at(&self, block: usize, lane: usize) -> [[f32; 3]; 3] {
        self.blocks[block].triangle(lane)
    }
}
