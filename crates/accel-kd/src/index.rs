// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's triangles under a kd-tree.
//! Space: object. Tests: `tests/brute_force.rs`.

mod corners;
mod region;
mod store;

use gnurt_accel_core::blocks::{BlockRay, WIDTH};
use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::heading::Heading;
use gnurt_accel_core::point::{NearestPoint, Probe, on_triangle};
use gnurt_accel_core::screened::Screened;
use gnurt_accel_core::triangle::ShearedRay;
use gnurt_accel_core::trip::{RayTrip, TileTrip};
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
        screened: &Screened,
        options: &BuildOptions,
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let mut tree = KdTree::build(screened, options, threads, watch)?;
        let measured = tree.measure(options);
        watch.take(match options.triangle_test {
            TriangleTest::Watertight => Leaves::memory_for(&tree),
            TriangleTest::Projected => screened.count() * ProjectedTriangles::BYTES,
        });
        watch.result()?;
        let (triangles, bytes) = match options.triangle_test {
            TriangleTest::Watertight => {
                let leaves = Leaves::take(&mut tree, screened, threads);
                let bytes = leaves.memory_bytes();
                (Prepared::Watertight(leaves), bytes)
            }
            TriangleTest::Projected => {
                let projected = ProjectedTriangles::new(numbered(screened));
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

    /// Offers what the ray meets; it is sound and regular.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, trip: &mut RayTrip) {
        let RayTrip { ray, slot, .. } = *trip;
        let slabs = RaySlabs::new(ray, &self.tree.bounds, self.greatest);
        let t_near = ray.t_near;
        let mut tested = 0;
        let visited = match &self.triangles {
            Prepared::Watertight(leaves) => {
                let (lanes, alone) = (BlockRay::new(simd, ray), ShearedRay::new(ray));
                self.tree.walk(
                    &slabs,
                    t_near,
                    trip.reach(),
                    #[inline(always)]
                    |leaf| {
                        for block in &leaves.blocks[leaves.of(leaf)] {
                            tested += WIDTH as u64;
                            if const { S::LANES == 1 } {
                                block.meet_in_turn(&alone, t_near, slot, trip);
                            } else {
                                block.meet(simd, &lanes, slot, trip);
                            }
                        }
                        trip.reach()
                    },
                )
            }
            Prepared::Projected(triangles) => self.tree.walk(
                &slabs,
                t_near,
                trip.reach(),
                #[inline(always)]
                |leaf| {
                    for &number in self.tree.leaf_items(leaf) {
                        tested += 1;
                        if let Some(meeting) = triangles.meet(number, ray, t_near, trip.reach()) {
                            trip.offer(meeting, number, slot);
                            if trip.is_done() {
                                break;
                            }
                        }
                    }
                    trip.reach()
                },
            ),
        };
        trip.counters.nodes += u64::from(visited);
        trip.counters.triangles += tested;
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

    /// The same for a tile's first rays, all of them active and of one heading.
    #[inline(always)]
    pub(crate) fn search_tile<S: Simd>(&self, simd: S, heading: Heading, trip: &mut TileTrip) {
        let Self { tree, greatest, .. } = self;
        match &self.triangles {
            Prepared::Watertight(leaves) => {
                if !(Blocked { tree, leaves }.walk_tile(simd, *greatest, heading, trip)) {
                    trip.one_by_one_outlined(
                        simd,
                        #[inline(always)]
                        |trip| self.search(simd, trip),
                    );
                }
            }
            Prepared::Projected(triangles) => {
                let TileTrip { rays, active, kind, slot, .. } = *trip;
                let search = Search { tree, greatest: *greatest, kind, triangles, slot };
                let count = active.count_ones() as usize;
                for first in (0..count).step_by(packet_rays::WIDTH) {
                    let mut best = NearestPacket::load(simd, trip.nearest, first);
                    let here = mask32x8::from_bitmask(simd, active >> first & 0xff);
                    let packet = RayPacket::from_tile(simd, rays, first, here);
                    search.packet(simd, &packet, heading, &mut best, trip.counters);
                    best.store(trip.nearest, first);
                }
            }
        }
    }
}

/// The corners of all triangles. Dropped ones keep their number; what stands in for them is never looked at.
fn numbered(screened: &Screened) -> impl Iterator<Item = [[f32; 3]; 3]> {
    let mut good = screened.good.iter().copied().peekable();
    (0..screened.count() as u32).map(move |number| match good.next_if_eq(&number) {
        Some(number) => screened.corners(number),
        None => [[0.0; 3]; 3],
    })
}
