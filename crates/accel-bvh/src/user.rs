// SPDX-License-Identifier: GPL-3.0-or-later
//! User geometry under a wide BVH: leaf blocks of eight, tested one by one by the caller's code.
//! Space: object. Tests: `tests/mixed.rs`.

use std::sync::Arc;

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::geometry::{GeometryKind, Numbering};
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{
    Aabb, BadPrimitives, BuildError, Geometry, INVALID_ID, Memory, Quality, Ray, Threads, TreeStats,
    UserGeometry,
};
use gnurt_simd::Simd;

use crate::blocked::Blocked;
use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::walk::walk;

/// The tree, and the caller's geometry in it.
#[derive(Clone, Debug)]
pub struct UserIndex {
    /// Blocks are numbers in the object.
    pub(crate) over: Blocked<[u32; WIDTH]>,
    /// Geometries and their first numbers, ascending.
    pub(crate) geometries: Vec<(u32, Arc<dyn UserGeometry>)>,
}

impl UserIndex {
    /// Over the user geometries that are `accept`; primitives with unsound boxes are counted.
    ///
    /// # Errors
    /// That there are too many.
    pub fn build(
        geometries: &[Geometry],
        numbering: &Numbering,
        accept: impl Fn(&Geometry) -> bool,
        bad: &mut BadPrimitives,
        quality: Quality,
        memory: Memory,
        threads: Threads,
    ) -> Result<Self, BuildError> {
        let (mut boxes, mut of_boxes) = (Vec::new(), Vec::new());
        let mut users = Vec::new();
        for (i, geometry) in geometries.iter().enumerate().filter(|(_, geometry)| accept(geometry)) {
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
        let number = |i: u32| of_boxes.get(i as usize).copied().unwrap_or(INVALID_ID);
        let block = |indices: &[u32; WIDTH]| indices.map(number);
        let over = Blocked::build(&&boxes[..], quality, memory, threads, block)?;
        Ok(Self { over, geometries: users })
    }

    /// Box around everything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.over.bounds()
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.over.stats()
    }

    /// Whether two trees are the same over the same geometries.
    #[must_use]
    pub fn same_tree(&self, other: &Self) -> bool {
        self.over.tree == other.over.tree && self.over.blocks == other.over.blocks
    }

    /// The geometry of a number, and the primitive in it.
    pub(crate) fn primitive(&self, number: u32) -> (&dyn UserGeometry, u32) {
        let at = self.geometries.partition_point(|(start, _)| *start <= number) - 1;
        let (start, user) = &self.geometries[at];
        (&**user, number - start)
    }

    /// Offers the ray's hits; it is valid and regular, the tree not empty.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        let RayTraversal { ray, slot, .. } = *traversal;
        let Blocked { tree, blocks, greatest, .. } = &self.over;
        let for_nodes = NodeRay::new(simd, ray, *greatest);
        let mut tested = 0;
        let visited = walk(
            tree,
            simd,
            Child::node(0),
            &for_nodes,
            traversal.reach(),
            #[inline(always)]
            |range| {
                for &number in blocks[range].iter().flatten().filter(|&&number| number != INVALID_ID) {
                    if traversal.is_done() {
                        break;
                    }
                    tested += 1;
                    let (user, prim_id) = self.primitive(number);
                    let visits = Ray { t_far: traversal.reach(), ..*ray };
                    user.intersect(prim_id, &visits, &mut |hit| {
                        if hit.t >= ray.t_near && hit.t <= traversal.reach() {
                            let triangle_hit = TriangleHit { t: hit.t + 0.0, u: hit.u, v: hit.v };
                            traversal.offer(triangle_hit, number, slot);
                        }
                    });
                }
                traversal.reach()
            },
        );
        traversal.counters.nodes += u64::from(visited);
        traversal.counters.triangles += tested;
    }
}
