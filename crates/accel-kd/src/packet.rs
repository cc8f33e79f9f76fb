// SPDX-License-Identifier: GPL-3.0-or-later
//! Eight rays through the kd-tree together.
//! Source: the paper's section 5.1 and Figure 4 (masked traversal of packets); [WSBW01].
//! In: a packet whose active lanes have one [`DirectionClass`], so that all agree on which child is
//! nearer. A lane is alive in a node while its interval is not empty, which is exactly where a single ray would go:
//! each lane gets the same tests in the same order as in `single.rs`. Tests: `tests/brute_force.rs` (`ask`).

use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::nearest::Kind;
use gnurt_accel_core::slab::inverse;
use gnurt_accel_core::{Aabb, Counters};
use gnurt_simd::{Simd, f32x8, mask32x8, prelude::*};

use crate::node::{DEEPEST, KdTree};
use crate::packet_rays::{NearestPacket, RayPacket};
use crate::projected::ProjectedTriangles;
use crate::slab::pads;

/// `RaySlabs` in lanes.
#[derive(Clone, Copy)]
pub(crate) struct PacketSlabs<S: Simd> {
    org: [f32x8<S>; 4],
    inv: [f32x8<S>; 4],
    slack: [f32x8<S>; 4],
}

impl<S: Simd> PacketSlabs<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, rays: &RayPacket<S>, bounds: &Aabb, greatest: f32) -> Self {
        let at = |value: f32| f32x8::splat(simd, value);
        let inv = inverse(rays.dir, at);
        let ([ox, oy, oz], [ix, iy, iz]) = (rays.org, inv);
        let [px, py, pz] = pads(rays.org, inv, bounds, greatest, at);
        Self { org: [ox, oy, oz, at(0.0)], inv: [ix, iy, iz, at(1.0)], slack: [px, py, pz, at(0.0)] }
    }

    /// The parts of `[t_min, t_max]` inside a box; empty intervals have swapped ends.
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
struct FarChild<S: Simd> {
    node: u32,
    t_min: f32x8<S>,
    t_max: f32x8<S>,
}

/// A search through one object's tree.
pub(crate) struct Search<'a> {
    pub(crate) tree: &'a KdTree,
    pub(crate) greatest: f32,
    pub(crate) kind: Kind,
    pub(crate) triangles: &'a ProjectedTriangles,
    /// The object's index in its scene.
    pub(crate) slot: u32,
}

impl Search<'_> {
    /// Improves `nearest` in the active lanes. Counts as single rays do.
    #[inline(always)]
    pub(crate) fn packet<S: Simd>(
        &self,
        simd: S,
        rays: &RayPacket<S>,
        direction_class: DirectionClass,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    ) {
        let slabs = PacketSlabs::new(simd, rays, &self.tree.bounds, self.greatest);
        let beyond = f32x8::splat(simd, f32::NEG_INFINITY);
        let reach = rays.active.select(nearest.t, beyond);
        let [mut t_min, mut t_max] = slabs.clip(simd, &self.tree.bounds, rays.t_near, reach);
        let mut alive = rays.active & t_min.simd_le(t_max);
        if !alive.any_true() {
            return;
        }
        // From here on a lane is dead where its interval is empty.
        t_max = alive.select(t_max, beyond);

        let start = FarChild { node: 0, t_min, t_max };
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
                let back = u32::from(direction_class.backwards[axis % 3]);
                let (near, far) = (node.left() + back, node.left() + 1 - back);
                if !near_alive.any_true() {
                    (at, t_min, alive) = (far, far_min, far_alive);
                } else {
                    if far_alive.any_true() {
                        waiting[top] = FarChild { node: far, t_min: far_min, t_max };
                        top += 1;
                    }
                    (at, t_max, alive) = (near, near_max, near_alive);
                }
                node = self.tree.nodes[at as usize];
                counters.nodes += lanes(alive);
            }
            for &number in self.tree.leaf_items(node) {
                counters.triangles += lanes(alive);
                let hits = self.triangles.meet_packet(simd, number, rays, alive, rays.t_near, nearest.t);
                if hits.hit.any_true() {
                    nearest.offer(simd, self.kind, &hits, number, self.slot);
                    if self.kind == Kind::Any {
                        alive &= !hits.hit;
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
