// SPDX-License-Identifier: GPL-3.0-or-later
//! Refit of an interval hierarchy over moved triangles: the same nodes, with the planes of the current boxes;
//! and its cost.
//! Source: [WMS06] section 4, [WK06]: from the last node to the first, which is bottom-up. Cost: O(n), by all
//! threads over the leaves.
//! Invariant: planes are exactly those of the boxes below, so that hits are those of a new tree. Tests:
//! `tests/refit.rs` of `gnurt-accel`.

use gnurt_accel_core::blocks::TriangleBlock;
use gnurt_accel_core::surfaces::Surfaces;
use gnurt_accel_core::{Aabb, BadPrimitives, RefitError, Threads, TreeStats};
use rayon::prelude::*;

use super::index::{IntervalIndex, Nodes, with_nodes};
use super::node::{Kind, Layout};
use super::share::BLOCK;

impl IntervalIndex {
    /// Fits the tree to triangles that have moved.
    ///
    /// # Errors
    /// That it has to be built again, because not all that is there can be traced or could be. It is of no use then.
    pub fn refit(&mut self, surfaces: &Surfaces, threads: Threads) -> Result<(), RefitError> {
        let count: u64 = surfaces.numbers().map(|numbers| numbers.len() as u64).sum();
        if count != self.stats.primitives {
            return Err(RefitError::OtherPrimitives);
        }
        let gather = |block: &mut TriangleBlock| {
            let numbers = block.numbers;
            if !numbers.iter().all(|&number| surfaces.judge(number, &mut BadPrimitives::default())) {
                return Err(RefitError::OtherPrimitives);
            }
            *block = TriangleBlock::new(|number| surfaces.corners(number), &numbers);
            Ok(())
        };
        threads.run(|parallel| match parallel {
            true => self.blocks.par_iter_mut().with_min_len(64).try_for_each(gather),
            false => self.blocks.iter_mut().try_for_each(gather),
        })?;
        let boxes = self.boxes();
        self.bounds = with_nodes!(&mut self.nodes, nodes => fit(nodes, &boxes));
        self.greatest = self.bounds.greatest();
        self.measure(count);
        Ok(())
    }

    fn boxes(&self) -> Vec<Aabb> {
        let triangles = |block: &TriangleBlock| {
            let [a, b, c] = &block.corners;
            let mut bounds = Aabb::EMPTY;
            for k in 0..3 {
                for &x in [a[k], b[k], c[k]].as_flattened() {
                    (bounds.min[k], bounds.max[k]) = (bounds.min[k].min(x), bounds.max[k].max(x));
                }
            }
            bounds
        };
        self.blocks.iter().map(triangles).collect()
    }

    /// Counts everything. A visit of a node costs 1, and a block's triangles [`BLOCK`].
    pub(super) fn measure(&mut self, primitives: u64) {
        let boxes = self.boxes();
        let mut stats = with_nodes!(&self.nodes, nodes => measure(nodes, &boxes, self.bounds));
        stats.primitives = primitives;
        stats.references = primitives;
        stats.tree_bytes = with_nodes!(&self.nodes, nodes => size_of_val(&nodes[..])) as u64;
        stats.primitive_bytes = size_of_val(&self.blocks[..]) as u64;
        self.stats = stats;
    }
}

/// Sets all planes; the box around all.
fn fit<N: Layout>(nodes: &mut [N], boxes: &[Aabb]) -> Aabb {
    let mut bounds = vec![Aabb::EMPTY; nodes.len()];
    for at in (0..nodes.len()).rev() {
        bounds[at] = match nodes[at].kind() {
            Kind::Leaf { block } => boxes[block],
            Kind::Clip { axis } => {
                nodes[at].set_clip(axis, &bounds[at + 1]);
                bounds[at + 1]
            }
            Kind::Split { axis, right } => {
                nodes[at].set_split(axis, &bounds[at + 1], &bounds[right]);
                bounds[at + 1].union(&bounds[right])
            }
        };
    }
    bounds.first().copied().unwrap_or(Aabb::EMPTY)
}

/// The expected cost of a ray that hits the bounds: the probability of a visit is that of hitting the node's
/// region.
fn measure<N: Layout>(nodes: &[N], boxes: &[Aabb], bounds: Aabb) -> TreeStats {
    let mut stats =
        TreeStats { nodes: nodes.len() as u64, leaves: boxes.len() as u64, ..TreeStats::default() };
    let whole = bounds.half_area();
    let mut waiting = vec![(0, bounds, 1)];
    while let Some((at, region, depth)) = waiting.pop() {
        let node = nodes[at];
        stats.depth = stats.depth.max(depth);
        let area = if region.is_empty() { 0.0 } else { region.half_area() };
        let share = if whole > 0.0 { area / whole } else { 1.0 };
        stats.sah_cost += share;
        match node.kind() {
            Kind::Leaf { .. } => stats.sah_cost += share * f64::from(BLOCK),
            Kind::Clip { axis } => {
                let [low, high] = node.ends();
                let mut clipped = region;
                (clipped.min[axis], clipped.max[axis]) = (low, high);
                waiting.push((at + 1, clipped, depth + 1));
            }
            Kind::Split { axis, right } => {
                let [a, b] = node.regions(axis, &region);
                waiting.extend([(at + 1, a, depth + 1), (right, b, depth + 1)]);
            }
        }
    }
    stats
}
