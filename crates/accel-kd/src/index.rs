// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's triangles under a kd-tree.
//! Space: object. Tests: `tests/brute_force.rs`.

mod corners;
mod region;
mod store;

use gnurt_accel_core::blocks::{BlockRay, WIDTH};
use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::point::{NearestPoint, Probe, on_triangle};
use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};
use gnurt_accel_core::triangle::ShearedRay;
use gnurt_accel_core::valid_triangles::ValidTriangles;
use gnurt_accel_core::{Aabb, BuildError, BuildOptions, Threads, TreeStats, TriangleTest};
use gnurt_simd::{Simd, mask32x8, prelude::*};

use crate::leaves::Leaves;
use crate::node::KdTree;
use crate::packet::Search;
use crate::packet_rays::{self, NearestPacket, RayPacket};
use crate::projected::ProjectedTriangles;
use crate::slab::RaySlabs;
use crate::tiles::Blocked;

/// Tree and triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct KdIndex {
    tree: KdTree,
    triangles: Prepared,
    /// The greatest coordinate.
    greatest: f32,
    stats: TreeStats,
}

/// Triangles for the test that was chosen.
#[derive(Clone, Debug, PartialEq)]
enum Prepared {
    /// In the leaves, in blocks.
    Watertight(Leaves),
    /// By number.
    Projected(ProjectedTriangles),
}

impl KdIndex {
    /// Builds over the good triangles.
    ///
    /// # Errors
    /// That `watch` stopped it.
    pub fn build(
        valid_triangles: &ValidTriangles,
        options: &BuildOptions,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let mut tree = KdTree::build(valid_triangles, options, threads, watch)?;
        let measured = tree.measure(options);
        watch.take(match options.triangle_test {
            TriangleTest::Watertight => Leaves::memory_for(&tree),
            TriangleTest::Projected => valid_triangles.count() * ProjectedTriangles::BYTES,
        });
        watch.result()?;
        let (triangles, bytes) = match options.triangle_test {
            TriangleTest::Watertight => {
                let leaves = Leaves::take(&mut tree, valid_triangles, threads);
                let bytes = leaves.memory_bytes();
                (Prepared::Watertight(leaves), bytes)
            }
            TriangleTest::Projected => {
                let projected = ProjectedTriangles::new(numbered(valid_triangles));
                let bytes = projected.memory_bytes();
                (Prepared::Projected(projected), bytes)
            }
        };
        let tree_bytes = tree.memory_bytes() as u64;
        let stats = TreeStats { tree_bytes, primitive_bytes: bytes as u64, ..measured };
        let greatest = tree.bounds.greatest();
        Ok(Self { tree, triangles, greatest, stats })
    }

    /// Box around all triangles.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.stats
    }

    /// Offers the ray's hits; it is valid and regular.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        let RayTraversal { ray, slot, .. } = *traversal;
        let slabs = RaySlabs::new(ray, &self.tree.bounds, self.greatest);
        let t_near = ray.t_near;
        let mut tested = 0;
        let visited = match &self.triangles {
            Prepared::Watertight(leaves) => {
                let (lanes, single) = (BlockRay::new(simd, ray), ShearedRay::new(ray));
                self.tree.walk(
                    &slabs,
                    t_near,
                    traversal.reach(),
                    #[inline(always)]
                    |leaf| {
                        for block in &leaves.blocks[leaves.of(leaf)] {
                            tested += WIDTH as u64;
                            if const { S::LANES == 1 } {
                                block.meet_in_turn(&single, t_near, slot, traversal);
                            } else {
                                block.meet(simd, &lanes, slot, traversal);
                            }
                        }
                        traversal.reach()
                    },
                )
            }
            Prepared::Projected(triangles) => self.tree.walk(
                &slabs,
                t_near,
                traversal.reach(),
                #[inline(always)]
                |leaf| {
                    for &number in self.tree.leaf_items(leaf) {
                        tested += 1;
                        if let Some(hit) = triangles.meet(number, ray, t_near, traversal.reach()) {
                            traversal.offer(hit, number, slot);
                            if traversal.is_done() {
                                break;
                            }
                        }
                    }
                    traversal.reach()
                },
            ),
        };
        traversal.counters.nodes += u64::from(visited);
        traversal.counters.triangles += tested;
    }

    /// Improves `nearest` by the triangles.
    pub fn nearest(&self, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        self.tree.near(&probe.point, probe.radius_for(nearest.distance()), |leaf| {
            match &self.triangles {
                Prepared::Watertight(leaves) => {
                    leaves.blocks[leaves.of(leaf)]
                        .iter()
                        .for_each(|block| block.nearest(probe, slot, nearest));
                }
                Prepared::Projected(triangles) => {
                    for &number in self.tree.leaf_items(leaf) {
                        let corners = triangles.corners(number).map(|corner| probe.offset(corner));
                        let (offset, uv) = on_triangle(corners);
                        nearest.offer(offset, uv, number, slot);
                    }
                }
            }
            probe.radius_for(nearest.distance())
        });
    }

    /// The same for a tile's first rays, all of them active and of one direction class.
    #[inline(always)]
    pub(crate) fn search_tile<S: Simd>(
        &self,
        simd: S,
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
    ) {
        let Self { tree, greatest, .. } = self;
        match &self.triangles {
            Prepared::Watertight(leaves) => {
                if !(Blocked { tree, leaves }.walk_tile(simd, *greatest, direction_class, traversal)) {
                    traversal.one_by_one_outlined(
                        simd,
                        #[inline(always)]
                        |traversal| self.search(simd, traversal),
                    );
                }
            }
            Prepared::Projected(triangles) => {
                let TileTraversal { rays, active, kind, slot, .. } = *traversal;
                let search = Search { tree, greatest: *greatest, kind, triangles, slot };
                let count = active.count_ones() as usize;
                for first in (0..count).step_by(packet_rays::WIDTH) {
                    let mut best = NearestPacket::load(simd, traversal.nearest, first);
                    let here = mask32x8::from_bitmask(simd, active >> first & 0xff);
                    let packet = RayPacket::from_tile(simd, rays, first, here);
                    search.packet(simd, &packet, direction_class, &mut best, traversal.counters);
                    best.store(traversal.nearest, first);
                }
            }
        }
    }
}

/// The corners of all triangles. Dropped ones keep their number; their placeholder is never read.
fn numbered(valid_triangles: &ValidTriangles) -> impl Iterator<Item = [[f32; 3]; 3]> {
    let mut good = valid_triangles.good.iter().copied().peekable();
    (0..valid_triangles.count() as u32).map(move |number| match good.next_if_eq(&number) {
        Some(number) => valid_triangles.corners(number),
        None => [[0.0; 3]; 3],
    })
}
