// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray, or eight, through the top tree and into the objects.
//! Source: [WBS03a] for the two levels; nearer boxes first, boxes beyond the best hit skipped.
//! Space: world until an instance is entered. Proof: `tests/instances.rs`, `tests/brute_force.rs` (`ask`).

use gnurt_simd::{Simd, f32x8, prelude::*};

use super::SceneTree;
use super::instance::Placed;
use super::top::{DEEPEST, TopNode};
use crate::kd::{PacketSlabs, RaySlabs};
use crate::nearest::{Mode, Nearest};
use crate::packet::{NearestPacket, RayPacket};
use crate::{Counters, Ray};

impl SceneTree {
    /// Improves `nearest`; the ray is sound.
    pub(super) fn search<M: Mode>(&self, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters) {
        let Some(root) = self.top.nodes.first() else { return };
        let regular = (Ray::SHORTEST..=Ray::LONGEST).contains(&ray.longest());
        // Boxes are met by the regular ray; what is compared are its parameters.
        let (scaled, scale) = if regular { (*ray, 1.0) } else { ray.within(ray.t_near, nearest.t).regular() };
        // Scales are powers of two: their inverses are exact.
        let over_scale = 1.0 / scale;
        let slabs = RaySlabs::new(&scaled, &root.bounds, self.reach);
        let entry = |node: &TopNode, t_far: f32| {
            slabs.clip(&node.bounds, scaled.t_near, t_far * over_scale).map(|[t_min, _]| t_min)
        };

        if entry(root, nearest.t).is_none() {
            return;
        }
        let mut waiting = [(0u32, 0.0f32); DEEPEST];
        let (mut top, mut at) = (0, 0u32);
        loop {
            let node = &self.top.nodes[at as usize];
            counters.nodes += 1;
            let next = if node.count > 0 {
                for &slot in &self.top.order[node.first as usize..][..node.count as usize] {
                    self.placed[slot as usize].search::<M>(ray, slot, nearest, counters);
                }
                None
            } else {
                let [left, right] = [node.first, node.first + 1];
                // Written out: `map` over an array would be a call for each of the two.
                let [l, r] = [&self.top.nodes[left as usize], &self.top.nodes[right as usize]];
                match (entry(l, nearest.t), entry(r, nearest.t)) {
                    (Some(l), Some(r)) => {
                        let left_first = l <= r;
                        waiting[top] = if left_first { (right, r) } else { (left, l) };
                        top += 1;
                        Some(if left_first { left } else { right })
                    }
                    (Some(_), None) => Some(left),
                    (None, Some(_)) => Some(right),
                    (None, None) => None,
                }
            };
            at = match next {
                Some(child) => child,
                None => loop {
                    if top == 0 {
                        return;
                    }
                    top -= 1;
                    let (node, t_min) = waiting[top];
                    if t_min <= nearest.t * over_scale {
                        break node;
                    }
                },
            };
        }
    }

    /// The same in the active lanes. Lanes of irregular length go one by one.
    #[inline(always)]
    pub(super) fn search_packet<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayPacket<S>,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    ) {
        let Some(root) = self.top.nodes.first() else { return };
        let longest = rays.longest();
        let regular = longest.simd_ge(f32x8::splat(simd, Ray::SHORTEST))
            & longest.simd_le(f32x8::splat(simd, Ray::LONGEST));
        let mut irregular = (rays.active & !regular).to_bitmask();
        while irregular != 0 {
            let i = irregular.trailing_zeros() as usize;
            irregular &= irregular - 1;
            let mut lane = nearest.get(i);
            self.search::<M>(&rays.ray(i), &mut lane, counters);
            nearest.set(i, &lane);
        }
        let rays = rays.with_active(simd, rays.active & regular);
        if !rays.active.any_true() {
            return;
        }

        let slabs = PacketSlabs::new(simd, &rays, &root.bounds, self.reach);
        let mut waiting = [0u32; DEEPEST];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let node = &self.top.nodes[waiting[top] as usize];
            let [t_min, t_max] = slabs.clip(simd, &node.bounds, rays.t_near, nearest.t);
            let alive = rays.active & t_min.simd_le(t_max);
            if !alive.any_true() {
                continue;
            }
            counters.nodes += u64::from(alive.to_bitmask().count_ones());
            if node.count > 0 {
                for &slot in &self.top.order[node.first as usize..][..node.count as usize] {
                    let rays = rays.with_active(simd, alive);
                    self.placed[slot as usize].search_packet::<S, M>(simd, &rays, slot, nearest, counters);
                }
                continue;
            }
            // The child whose centre lies nearer along the first live ray goes first.
            let lane = alive.to_bitmask().trailing_zeros() as usize;
            let towards = |child: u32| {
                let bounds = &self.top.nodes[child as usize].bounds;
                let along = |k: usize| (bounds.min[k] + bounds.max[k]) * gnurt_simd::lane(rays.dir[k], lane);
                along(0) + along(1) + along(2)
            };
            let [left, right] = [node.first, node.first + 1];
            let (near, far) = if towards(left) <= towards(right) { (left, right) } else { (right, left) };
            waiting[top] = far;
            waiting[top + 1] = near;
            top += 2;
        }
    }
}

impl Placed {
    #[inline(always)]
    fn search<M: Mode>(&self, ray: &Ray, slot: u32, nearest: &mut Nearest, counters: &mut Counters) {
        match &self.object_from_world {
            None => self.object.search::<M>(ray, slot, nearest, counters),
            Some(map) => {
                let inside = map.ray(ray);
                if inside.is_sound() {
                    self.object.search::<M>(&inside, slot, nearest, counters);
                }
            }
        }
    }

    #[inline(always)]
    fn search_packet<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayPacket<S>,
        slot: u32,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    ) {
        let inside = match &self.object_from_world {
            None => *rays,
            Some(map) => map.packet(simd, rays),
        };
        if inside.active.any_true() {
            self.object.search_packet::<S, M>(simd, &inside, slot, nearest, counters);
        }
    }
}
