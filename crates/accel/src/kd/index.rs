// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's triangles under a kd-tree.
//! Source: original. Space: object. Proof: `tests/brute_force.rs`.

mod store;

use gnurt_simd::{Simd, mask32x8, prelude::*};

use super::leaves::Leaves;
use super::sweep::Blocked;
use super::{KdTree, RaySlabs, Search};
use crate::bvh::{BlockRay, Sweep};
use crate::control::Watch;
use crate::geometry::Screened;
use crate::nearest::{Collect, Mode};
use crate::packet::{Heading, NearestPacket, RayPacket, WIDTH};
use crate::point::{NearestPoint, Probe, on_triangle};
use crate::tile::{NearestTile, RayTile, all};
use crate::triangle::{ProjectedTriangles, ShearedRay};
use crate::{Aabb, BuildError, BuildOptions, Counters, Ray, Threads, TreeStats, TriangleTest};

/// Tree and triangles.
#[derive(Debug, PartialEq)]
pub(crate) struct KdIndex {
    tree: KdTree,
    triangles: Prepared,
    reach: f32,
    stats: TreeStats,
}

/// Triangles for the test that was chosen.
#[derive(Debug, PartialEq)]
enum Prepared {
    /// In the leaves, in blocks.
    Watertight(Leaves),
    /// By number.
    Projected(ProjectedTriangles),
}

impl KdIndex {
    /// Builds over the good triangles.
    pub(crate) fn build(
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
        let reach = tree.bounds.reach();
        Ok(Self { tree, triangles, reach, stats })
    }

    /// Box around all triangles.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    pub(crate) fn stats(&self) -> TreeStats {
        self.stats
    }

    /// Offers what `ray` meets; it is sound and regular.
    #[inline(always)]
    pub(crate) fn search<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let slabs = RaySlabs::new(ray, &self.tree.bounds, self.reach);
        let t_near = ray.t_near;
        let mut tested = 0;
        let visited = match &self.triangles {
            Prepared::Watertight(leaves) => {
                let (lanes, alone) = (BlockRay::new(simd, ray), ShearedRay::new(ray));
                self.tree.walk(
                    &slabs,
                    t_near,
                    collect.reach(),
                    #[inline(always)]
                    |leaf| {
                        for block in &leaves.blocks[leaves.of(leaf)] {
                            tested += WIDTH as u64;
                            if simd.level().is_fallback() {
                                block.meet_in_turn(&alone, t_near, slot, collect);
                            } else {
                                block.meet(simd, &lanes, slot, collect);
                            }
                        }
                        collect.reach()
                    },
                )
            }
            Prepared::Projected(triangles) => self.tree.walk(
                &slabs,
                t_near,
                collect.reach(),
                #[inline(always)]
                |leaf| {
                    for &number in self.tree.leaf_items(leaf) {
                        tested += 1;
                        if let Some(meeting) = triangles.meet(number, ray, t_near, collect.reach()) {
                            collect.offer(meeting, number, slot);
                            if collect.is_done() {
                                break;
                            }
                        }
                    }
                    collect.reach()
                },
            ),
        };
        counters.nodes += u64::from(visited);
        counters.triangles += tested;
    }

    /// Improves `nearest` by the triangles.
    pub(crate) fn nearest(&self, probe: &Probe, slot: u32, nearest: &mut NearestPoint) {
        self.tree.near(&probe.point, probe.reach(nearest.distance), |leaf| {
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
            probe.reach(nearest.distance)
        });
    }

    /// The same for the first `count` rays of a tile, all of one heading; see `BvhIndex::sweep`.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "they are what a tile's way through a tree takes")]
    pub(crate) fn sweep<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        count: usize,
        heading: Heading,
        slot: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        let (tree, reach) = (&self.tree, self.reach);
        match &self.triangles {
            Prepared::Watertight(leaves) => {
                let tree = &Blocked { tree, leaves };
                let sweep = Sweep { simd, tree, reach, slot, rays, count, heading };
                if !sweep.run::<M>(nearest, counters) {
                    nearest.one_by_one::<M>(
                        rays,
                        all(count),
                        #[inline(always)]
                        |ray, best| self.search::<S, _>(simd, ray, slot, best, counters),
                    );
                }
            }
            Prepared::Projected(triangles) => {
                for first in (0..count).step_by(WIDTH) {
                    let mut best = NearestPacket::load(simd, nearest, first);
                    let here = u64::MAX >> (64 - (count - first).min(WIDTH));
                    let packet = RayPacket::from_tile(simd, rays, first, mask32x8::from_bitmask(simd, here));
                    Search { tree, reach, triangles, slot }
                        .packet::<S, M>(simd, &packet, heading, &mut best, counters);
                    best.store(nearest, first);
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
