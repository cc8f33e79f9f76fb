// SPDX-License-Identifier: GPL-3.0-or-later
//! Eight rays through the kd-tree together.
//! Source: the paper's section 5.1 and Figure 4 (masked traversal of packets); [WSBW01].
//! In: a packet whose active lanes have one [`Heading`](crate::packet::Heading), so that all agree on which child is
//! nearer. A lane is alive in a node while its interval is not empty, which is exactly where a single ray would go:
//! each lane gets the same tests in the same order as in `single.rs`. Proof: `tests/brute_force.rs` (`ask`).

use gnurt_simd::{Simd, f32x8, mask32x8, prelude::*};

use super::slab::{FLATTEST, SLACK};
use super::{DEEPEST, KdTree};
use crate::nearest::Mode;
use crate::packet::{Heading, NearestPacket, RayPacket};
use crate::triangle::ProjectedTriangles;
use crate::{Aabb, Counters};

/// [`RaySlabs`](super::RaySlabs) in lanes.
#[derive(Clone, Copy)]
pub(crate) struct PacketSlabs<S: Simd> {
    org: [f32x8<S>; 4],
    inv: [f32x8<S>; 4],
    slack: [f32x8<S>; 4],
}

impl<S: Simd> PacketSlabs<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, rays: &RayPacket<S>, bounds: &Aabb, reach: f32) -> Self {
        let at = |value: f32| f32x8::splat(simd, value);
        let flattest = rays.longest() * at(FLATTEST);
        let mut slabs = Self { org: [at(0.0); 4], inv: [at(1.0); 4], slack: [at(0.0); 4] };
        let mut distance = at(0.0);
        for k in 0..3 {
            slabs.org[k] = rays.org[k];
            slabs.inv[k] = at(1.0) / rays.dir[k].abs().max(flattest).copysign(rays.dir[k]);
            let to_min = (at(bounds.min[k]) - rays.org[k]).abs();
            let to_max = (at(bounds.max[k]) - rays.org[k]).abs();
            distance = distance.max(to_min).max(to_max);
        }
        let slack = at(SLACK) * (at(reach) + distance);
        for k in 0..3 {
            slabs.slack[k] = slack * slabs.inv[k].abs();
        }
        slabs
    }

    /// The parts of `[t_min, t_max]` inside a box; empty intervals have their ends the wrong way round.
    #[inline(always)]
    pub(crate) fn clip(&self, simd: S, bounds: &Aabb, t_min: f32x8<S>, t_max: f32x8<S>) -> [f32x8<S>; 2] {
        let (mut t_min, mut t_max) = (t_min, t_max);
        for k in 0..3 {
            let a = (f32x8::splat(simd, bounds.min[k]) - self.org[k]) * self.inv[k];
            let b = (f32x8::splat(simd, bounds.max[k]) - self.org[k]) * self.inv[k];
            t_min = t_min.max(a.min(b) - self.slack[k]);
            t_max = t_max.min(a.max(b) + self.slack[k]);
        }
        [t_min, t_max]
    }
}

/// A far child that is still to be visited.
#[derive(Clone, Copy)]
struct Waiting<S: Simd> {
    node: u32,
    t_min: f32x8<S>,
    t_max: f32x8<S>,
}

/// A search through one object's tree.
pub(crate) struct Search<'a> {
    pub(crate) tree: &'a KdTree,
    pub(crate) reach: f32,
    pub(crate) triangles: &'a ProjectedTriangles,
    /// Where the object stands in its scene.
    pub(crate) slot: u32,
}

impl Search<'_> {
    /// Improves `nearest` in the active lanes. Counts what single rays would.
    #[inline(always)]
    pub(crate) fn packet<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayPacket<S>,
        heading: Heading,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    ) {
        let slabs = PacketSlabs::new(simd, rays, &self.tree.bounds, self.reach);
        let beyond = f32x8::splat(simd, f32::NEG_INFINITY);
        let reach = rays.active.select(nearest.t, beyond);
        let [mut t_min, mut t_max] = slabs.clip(simd, &self.tree.bounds, rays.t_near, reach);
        let mut alive = rays.active & t_min.simd_le(t_max);
        if !alive.any_true() {
            return;
        }
        // From here on a lane is dead where its interval is empty.
        t_max = alive.select(t_max, beyond);

        let start = Waiting { node: 0, t_min, t_max };
        let mut waiting = [start; DEEPEST];
        let (mut top, mut at) = (0, 0u32);
        loop {
            let mut node = self.tree.nodes[at as usize];
            counters.nodes += lanes(alive);
            while !node.is_leaf() {
                let axis = node.axis();
                let d = (f32x8::splat(simd, node.plane()) - slabs.org[axis]) * slabs.inv[axis];
                let near_max = t_max.min(d + slabs.slack[axis]);
                let far_min = t_min.max(d - slabs.slack[axis]);
                let (near_alive, far_alive) = (t_min.simd_le(near_max), far_min.simd_le(t_max));
                let back = u32::from(heading.backwards[axis % 3]);
                let (near, far) = (node.left() + back, node.left() + 1 - back);
                if !near_alive.any_true() {
                    (at, t_min, alive) = (far, far_min, far_alive);
                } else {
                    if far_alive.any_true() {
                        waiting[top] = Waiting { node: far, t_min: far_min, t_max };
                        top += 1;
                    }
                    (at, t_max, alive) = (near, near_max, near_alive);
                }
                node = self.tree.nodes[at as usize];
                counters.nodes += lanes(alive);
            }
            for &number in self.tree.leaf_items(node) {
                counters.triangles += lanes(alive);
                let meeting = self.triangles.meet_packet(simd, number, rays, alive, rays.t_near, nearest.t);
                if meeting.hit.any_true() {
                    nearest.offer::<M>(simd, &meeting, number, self.slot);
                    if M::ANY {
                        alive &= !meeting.hit;
                    }
                }
            }
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let next = waiting[top];
                t_min = next.t_min;
                t_max = next.t_max.min(nearest.t);
                alive = t_min.simd_le(t_max);
                if alive.any_true() {
                    at = next.node;
                    break;
                }
            }
        }
    }
}

/// How many lanes are set.
#[inline(always)]
fn lanes<S: Simd>(mask: mask32x8<S>) -> u64 {
    u64::from(mask.to_bitmask().count_ones())
}
