// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays through an interval hierarchy, one or all of a tile: the same traversal, because both hit planes in
//! an interval of their own width.
//! Source: [WK06] section 4; intervals as in the kd-tree's `slab.rs` and in [RSH05] for tiles.
//!
//! A ray is in a node during the interval `[t_min, t_max]`. A split cuts that for each child separately:
//! children may overlap, so that a hit in the nearer one does not end the traversal, but later nodes are
//! skipped. A clip cuts it for its only child.
//! Invariant: no triangle that the test can hit is in a skipped node. Tests: `tests/brute_force.rs`,
//! `tests/intervals.rs` of `gnurt-accel`.

use gnurt_accel_core::beam::PlaneBeam;
use gnurt_accel_core::float::{least, most};
use gnurt_accel_core::slab::Slabs;
use gnurt_accel_core::{Aabb, Ray};
use gnurt_simd::StackBuffer;

use super::node::{Kind, Layout, OverlapTest};

/// No node has this many splits above it.
pub(super) const DEEPEST: usize = 88;

/// A child that is still to be visited.
#[derive(Clone, Copy)]
struct Waiting {
    node: u32,
    t_min: f32,
    t_max: f32,
}

/// One ray: [`Slabs`], which meet a plane by a product and a difference. Arrays have four entries so that two bits of an axis
/// need no check.
pub(super) struct PlaneRay {
    inv: [f32; 4],
    near: [f32; 4],
    far: [f32; 4],
    /// 1 where it goes towards smaller coordinates.
    back: [u32; 4],
}

impl PlaneRay {
    /// For a tree, not empty, whose greatest coordinate is `greatest`; the ray is valid and regular.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, greatest: f32) -> Self {
        let Slabs { inv, near, far } = Slabs::new(ray.org, ray.dir, greatest, |x| x);
        let four = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let back = |k: usize| u32::from(ray.dir[k].is_sign_negative());
        let back = [back(0), back(1), back(2), 0];
        Self { inv: four(inv), near: four(near), far: four(far), back }
    }

    /// When it may be in a box, from `t_min` to `t_max`; in that order where it is.
    #[inline(always)]
    pub(super) fn clip(&self, bounds: &Aabb, [mut t_min, mut t_max]: [f32; 2]) -> [f32; 2] {
        for k in 0..3 {
            let ends = [bounds.min[k], bounds.max[k]];
            let back = self.back(k) & 1;
            t_min = most(t_min, self.first(k, ends[back]));
            t_max = least(t_max, self.last(k, ends[1 - back]));
        }
        [t_min, t_max]
    }
}

impl OverlapTest for PlaneRay {
    #[inline(always)]
    fn first(&self, axis: usize, plane: f32) -> f32 {
        plane * self.inv[axis & 3] - self.near[axis & 3]
    }

    #[inline(always)]
    fn last(&self, axis: usize, plane: f32) -> f32 {
        plane * self.inv[axis & 3] - self.far[axis & 3]
    }

    #[inline(always)]
    fn back(&self, axis: usize) -> usize {
        self.back[axis & 3] as usize
    }
}

impl OverlapTest for PlaneBeam {
    #[inline(always)]
    fn first(&self, axis: usize, plane: f32) -> f32 {
        PlaneBeam::meet(self, axis & 3, plane)[0]
    }

    #[inline(always)]
    fn last(&self, axis: usize, plane: f32) -> f32 {
        PlaneBeam::meet(self, axis & 3, plane)[1]
    }

    #[inline(always)]
    fn back(&self, axis: usize) -> usize {
        self.back[axis & 3] as usize
    }
}

/// From the root on, where rays are from `t_min` to `t_max`: calls `leaf` with the block of each leaf that they may meet before they
/// reach `t_max`; it answers with the new reach. Returns the nodes visited.
#[inline(always)]
pub(super) fn walk<N: Layout, M: OverlapTest>(
    nodes: &[N],
    rays: &M,
    [mut t_min, mut t_max]: [f32; 2],
    mut leaf: impl FnMut(usize) -> f32,
) -> u64 {
    if t_min > t_max {
        return 0;
    }
    let mut buffer = StackBuffer::<Waiting, DEEPEST>::new();
    let mut waiting = buffer.stack();
    let (mut at, mut visited, mut reach) = (0, 0, t_max);
    loop {
        let node = &nodes[at];
        visited += 1;
        match node.kind() {
            Kind::Leaf { block } => reach = leaf(block),
            Kind::Clip { axis } => {
                let ends = node.ends();
                let back = rays.back(axis) & 1;
                t_min = most(t_min, rays.first(axis, ends[back]));
                t_max = least(t_max, rays.last(axis, ends[1 - back]));
                if t_min <= t_max {
                    at += 1;
                    continue;
                }
            }
            Kind::Split { axis, right } => {
                let [near, far] = node.children(rays, axis);
                let near = [most(t_min, near[0]), least(t_max, near[1])];
                let far = [most(t_min, far[0]), least(t_max, far[1])];
                let (first, second) = if rays.back(axis) == 0 { (at + 1, right) } else { (right, at + 1) };
                if near[0] <= near[1] {
                    if far[0] <= far[1] {
                        waiting.push(Waiting { node: second as u32, t_min: far[0], t_max: far[1] });
                    }
                    (at, [t_min, t_max]) = (first, near);
                    continue;
                }
                if far[0] <= far[1] {
                    (at, [t_min, t_max]) = (second, far);
                    continue;
                }
            }
        }
        loop {
            let Some(next) = waiting.pop() else { return visited };
            if next.t_min <= reach {
                (at, t_min, t_max) = (next.node as usize, next.t_min, least(next.t_max, reach));
                break;
            }
        }
    }
}
