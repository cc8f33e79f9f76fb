// SPDX-License-Identifier: GPL-3.0-or-later
//! The top tree: a wide BVH over the world boxes of instances, built anew whenever they move.
//! Source: [WBS03a] for the two levels. A kd-tree would list large instances again and again, and an object costs far
//! more than a triangle to test twice. A leaf block is eight boxes again, with the places of instances as children, so
//! that a ray meets eight instances in one test. Proof: `tests::every_instance_is_in_one_block`.

use crate::bvh::{Child, Node8, Tree, build};
use crate::{Aabb, INVALID_ID, Quality, Ray, Threads, TreeStats};

/// Tree over instances by their place in the scene.
#[derive(Debug)]
pub(super) struct TopTree {
    pub(super) tree: Tree,
    pub(super) blocks: Vec<Node8>,
    pub(super) reach: f32,
    /// Boxes are relative to it; zero, unless the scene is far away for its size.
    pub(super) origin: [f32; 3],
    stats: TreeStats,
}

impl TopTree {
    /// Over boxes relative to `origin`, none of them empty.
    pub(super) fn build(boxes: &[Aabb], origin: [f32; 3]) -> Self {
        let mut tree = build(&boxes, Quality::Medium, Threads::Single);
        let stats = tree.measure();
        let in_blocks = std::mem::take(&mut tree.blocks);
        let block = |places: &[u32; 8]| {
            let mut block = Node8::EMPTY;
            for (lane, &place) in places.iter().enumerate().filter(|&(_, &place)| place != INVALID_ID) {
                block.set(lane, &boxes[place as usize], Child::node(place as usize));
            }
            block
        };
        let reach = tree.bounds.reach();
        Self { blocks: in_blocks.iter().map(block).collect(), tree, reach, origin, stats }
    }

    /// A ray, whose parameters stay, relative to the origin of the boxes.
    #[inline(always)]
    pub(super) fn relative(&self, ray: &Ray, origin: Option<&[f64; 3]>) -> Ray {
        let mut moved = *ray;
        for k in 0..3 {
            moved.org[k] = match origin {
                None => ray.org[k] - self.origin[k],
                Some(precise) => (precise[k] - f64::from(self.origin[k])) as f32,
            };
        }
        moved
    }

    pub(super) fn stats(&self) -> TreeStats {
        let tree_bytes = (size_of_val(&self.tree.nodes[..]) + size_of_val(&self.blocks[..])) as u64;
        TreeStats { primitives: self.stats.references, tree_bytes, ..self.stats }
    }
}

impl Default for TopTree {
    fn default() -> Self {
        Self::build(&[], [0.0; 3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_instance_is_in_one_block() {
        let boxes: Vec<Aabb> = (0..500u32)
            .map(|i| {
                let corner = [i % 7, i * i % 31, i % 13].map(|x| x as f32);
                Aabb { min: corner, max: corner.map(|x| x + (i % 3) as f32) }
            })
            .collect();
        let top = TopTree::build(&boxes, [0.0; 3]);
        let mut seen = vec![0; boxes.len()];
        for block in &top.blocks {
            for lane in (0..8).filter(|&lane| !block.bounds(lane).is_empty()) {
                let place = block.child(lane).index();
                assert_eq!(block.bounds(lane), boxes[place], "a block has the boxes of its instances");
                seen[place] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n == 1), "each instance is in one block");
        assert!(TopTree::build(&[], [0.0; 3]).tree.nodes.is_empty(), "nothing to see");
    }
}
