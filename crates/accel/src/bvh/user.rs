// SPDX-License-Identifier: GPL-3.0-or-later
//! User geometry under a wide BVH: leaf blocks of eight, tested one by one by the caller's code.
//! Source: original. Space: object. Proof: `tests/mixed.rs`.

use std::sync::Arc;

use gnurt_simd::Simd;

use super::slab::NodeRay;
use super::{Child, Tree, WIDTH, build};
use crate::geometry::{GeometryKind, Numbering};
use crate::nearest::Collect;
use crate::triangle::Meeting;
use crate::{
    Aabb, BadPrimitives, Counters, Geometry, INVALID_ID, Memory, Quality, Ray, Threads, TreeStats,
    UserGeometry,
};

/// Tree, and who knows what is in it.
#[derive(Debug)]
pub(crate) struct UserIndex {
    pub(super) tree: Tree,
    /// Numbers in the object, eight to each block.
    pub(super) blocks: Vec<[u32; WIDTH]>,
    /// Geometries and their first numbers, ascending.
    geometries: Vec<(u32, Arc<dyn UserGeometry>)>,
    reach: f32,
    stats: TreeStats,
}

impl UserIndex {
    /// Over the user geometries that are `wanted`; primitives with unsound boxes are counted.
    pub(crate) fn build(
        geometries: &[Geometry],
        numbering: &Numbering,
        wanted: impl Fn(&Geometry) -> bool,
        bad: &mut BadPrimitives,
        quality: Quality,
        memory: Memory,
        threads: Threads,
    ) -> Self {
        let (mut boxes, mut of_boxes) = (Vec::new(), Vec::new());
        let mut users = Vec::new();
        for (i, geometry) in geometries.iter().enumerate().filter(|(_, geometry)| wanted(geometry)) {
            let GeometryKind::User(user) = &geometry.kind else { continue };
            let numbers = numbering.range(i);
            users.push((numbers.start, Arc::clone(user)));
            for number in numbers.clone() {
                let bounds = user.bounds(number - numbers.start);
                if bounds.is_empty() {
                    bad.zero_area += 1;
                } else if let Some(fault) = bad.fault(bounds.min.into_iter().chain(bounds.max)) {
                    *fault += 1;
                } else {
                    boxes.push(bounds);
                    of_boxes.push(number);
                }
            }
        }
        let mut tree = build(&&boxes[..], quality, threads);
        tree.settle(memory);
        let stats = tree.measure();
        let number = |i: u32| of_boxes.get(i as usize).copied().unwrap_or(INVALID_ID);
        let blocks = std::mem::take(&mut tree.blocks).iter().map(|places| places.map(number)).collect();
        let reach = tree.reach();
        Self { tree, blocks, geometries: users, reach, stats }
    }

    /// Box around everything.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    pub(crate) fn stats(&self) -> TreeStats {
        TreeStats {
            primitives: self.stats.references,
            tree_bytes: self.tree.node_bytes() as u64,
            primitive_bytes: size_of_val(&self.blocks[..]) as u64,
            ..self.stats
        }
    }

    /// Whether two trees are the same over the same geometries.
    pub(crate) fn same_tree(&self, other: &Self) -> bool {
        self.tree == other.tree && self.blocks == other.blocks
    }

    /// The geometry of a number, and the primitive in it.
    pub(super) fn primitive(&self, number: u32) -> (&dyn UserGeometry, u32) {
        let at = self.geometries.partition_point(|(start, _)| *start <= number) - 1;
        let (start, user) = &self.geometries[at];
        (&**user, number - start)
    }

    /// Offers what `ray` meets; it is sound and regular, the tree not empty.
    #[inline(always)]
    pub(crate) fn search<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let for_nodes = NodeRay::new(simd, ray, self.reach);
        let mut tested = 0;
        let visited = self.tree.walk(
            simd,
            Child::node(0),
            &for_nodes,
            collect.reach(),
            #[inline(always)]
            |blocks| {
                for &number in self.blocks[blocks].iter().flatten().filter(|&&number| number != INVALID_ID) {
                    if collect.is_done() {
                        break;
                    }
                    tested += 1;
                    let (user, prim_id) = self.primitive(number);
                    let seen = Ray { t_far: collect.reach(), ..*ray };
                    user.intersect(prim_id, &seen, &mut |hit| {
                        if hit.t >= ray.t_near && hit.t <= collect.reach() {
                            let meeting = Meeting { t: hit.t + 0.0, u: hit.u, v: hit.v };
                            collect.offer(meeting, number, slot);
                        }
                    });
                }
                collect.reach()
            },
        );
        counters.nodes += u64::from(visited);
        counters.triangles += tested;
    }
}
