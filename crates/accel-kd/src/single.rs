// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray through the kd-tree, leaf by leaf, nearest first.
//! Source: the paper's Figure 3; the planes' intervals make its three cases conservative (`slab.rs`):
//!
//! ```text
//! a) the plane's interval overlap_mask [t_min, t_max]: near child, then far child, both up to the interval's other end
//! b) the plane lies before t_min: far child only
//! c) the plane lies after t_max: near child only
//! ```
//!
//! Invariant: `packet.rs` visits the same leaves in the same order for each of its lanes.

use gnurt_accel_core::float::{least, most};

use crate::node::{DEEPEST, KdTree, Node};
use crate::slab::RaySlabs;

/// A far child that is still to be visited.
#[derive(Clone, Copy, Default)]
struct FarChild {
    node: u32,
    t_min: f32,
    t_max: f32,
}

impl KdTree {
    /// Calls `visit` with each leaf that is not empty and that the ray may meet before `t_max`. It returns how far the
    /// ray still has to be followed: less after a hit, negative infinity to stop. Returns the nodes visited.
    #[inline(always)]
    pub(crate) fn walk(
        &self,
        ray: &RaySlabs,
        t_near: f32,
        t_far: f32,
        mut visit: impl FnMut(Node) -> f32,
    ) -> u32 {
        let Some([mut t_min, mut t_max]) = ray.clip(&self.bounds, t_near, t_far) else { return 0 };
        let mut waiting = [FarChild::default(); DEEPEST];
        let (mut top, mut at, mut visited, mut t_far) = (0, 0, 0, t_far);
        loop {
            let mut node = self.nodes[at as usize];
            visited += 1;
            while !node.is_leaf() {
                let axis = node.axis();
                let d = (node.plane() - ray.org[axis]) * ray.inv[axis];
                let (first, last) = (d - ray.slack[axis], d + ray.slack[axis]);
                let near = node.left() + ray.back[axis];
                let far = node.left() + 1 - ray.back[axis];
                at = if last < t_min {
                    far
                } else {
                    if first <= t_max {
                        waiting[top] = FarChild { node: far, t_min: most(t_min, first), t_max };
                        top += 1;
                        t_max = least(t_max, last);
                    }
                    near
                };
                node = self.nodes[at as usize];
                visited += 1;
            }
            if node.item() != 0 {
                t_far = visit(node);
            }
            (at, t_min, t_max) = loop {
                if top == 0 {
                    return visited;
                }
                top -= 1;
                let next = waiting[top];
                if next.t_min <= t_far {
                    break (next.node, next.t_min, least(next.t_max, t_far));
                }
            };
        }
    }
}
