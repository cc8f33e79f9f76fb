// SPDX-License-Identifier: GPL-3.0-or-later
//! From nested boxes to nodes, with clips where a child does not fill its region: the treatment of empty
//! space. [WK06] and [WMS06] lack it; [SIP06], section 6, shows the consequence: a teapot in a stadium.
//!
//! A descending ray has a *region*: the root's box, cut by the planes that it has passed. A BIH cuts one side
//! of one axis at a time, so that a small object in a large room is entered by all rays that pass it on five
//! sides of six. So each node's box is compared with its region: along each axis, by how much would the
//! region shrink if both of its sides were those of the box? By the surface area heuristic [MB90] that gives
//! the share of rays that would miss. A clip, a node with two planes and one child, costs each ray a step,
//! and saves the subtree for those that miss: it is inserted if the savings are greater.
//!
//! ```text
//! (1 - area(clipped region) / area(region)) * cost below  >  one step
//! ```
//!
//! A refit moves clips as it moves all planes; none are added or removed. Tests: `tests/intervals.rs` of
//! `gnurt-accel`.

use gnurt_accel_core::Aabb;

use super::node::{Kind, Layout};
use super::share::{BLOCK, Binary};

/// Nodes, and the triangles of their leaves.
pub(super) struct Laid<N> {
    pub(super) nodes: Vec<N>,
    pub(super) blocks: Vec<Vec<u32>>,
    /// Whether there may be clips.
    pub(super) clips: bool,
}

impl<N: Layout> Laid<N> {
    /// Puts a tree into nodes; rays start with its box.
    pub(super) fn new(tree: Binary, clips: bool) -> Self {
        let mut laid = Self { nodes: Vec::new(), blocks: Vec::new(), clips };
        let region = *tree.bounds();
        laid.put(tree, region);
        laid
    }

    fn put(&mut self, tree: Binary, mut region: Aabb) {
        while self.clips
            && let Some(axis) = worth_a_clip(&tree, &region)
        {
            let mut clip = N::new(Kind::Clip { axis });
            clip.set_clip(axis, tree.bounds());
            self.nodes.push(clip);
            region = clipped(&region, axis, tree.bounds());
        }
        match tree {
            Binary::Leaf { numbers, .. } => {
                self.nodes.push(N::new(Kind::Leaf { block: self.blocks.len() }));
                self.blocks.push(numbers);
            }
            Binary::Split { axis, children, .. } => {
                let at = self.nodes.len();
                let [left, right] = *children;
                let mut node = N::new(Kind::Split { axis, right: 0 });
                node.set_split(axis, left.bounds(), right.bounds());
                let [left_region, right_region] = node.regions(axis, &region);
                let boxes = [*left.bounds(), *right.bounds()];
                self.nodes.push(node);
                self.put(left, left_region);
                let mut node = N::new(Kind::Split { axis, right: self.nodes.len() });
                node.set_split(axis, &boxes[0], &boxes[1]);
                self.nodes[at] = node;
                self.put(right, right_region);
            }
        }
    }
}

/// The axis along which a clip saves most, if one saves more than it costs.
fn worth_a_clip(tree: &Binary, region: &Aabb) -> Option<usize> {
    let area = region.half_area();
    if area <= 0.0 {
        return None;
    }
    // The number of rays that enter the region, relative to those that hit the box, is the ratio of the
    // sizes; these have less work below.
    let below = f64::from(tree.cost().max(BLOCK));
    let saved = |axis: usize| (1.0 - clipped(region, axis, tree.bounds()).half_area() / area) * below;
    let axis = (0..3).max_by(|&a, &b| saved(a).total_cmp(&saved(b)))?;
    (saved(axis) > STEP).then_some(axis)
}

/// The cost of a clip, in steps through splits: it tests as many planes, but few rays miss, and their branch
/// is hard to predict. All values from 0.8 to 1.6 trace equally fast; greater ones insert fewer clips.
const STEP: f64 = 1.6;

fn clipped(region: &Aabb, axis: usize, to: &Aabb) -> Aabb {
    let mut clipped = *region;
    (clipped.min[axis], clipped.max[axis]) = (to.min[axis], to.max[axis]);
    clipped
}
