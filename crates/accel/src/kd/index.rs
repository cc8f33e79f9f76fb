// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's triangles under a kd-tree.
//! Source: original. Space: object. Proof: `tests/brute_force.rs`.

use gnurt_simd::{Simd, mask32x8, prelude::*};

use super::{KdTree, RaySlabs, Search};
use crate::geometry::Screened;
use crate::nearest::{Mode, Nearest};
use crate::packet::{Heading, NearestPacket, RayPacket, WIDTH};
use crate::tile::{NearestTile, RayTile};
use crate::triangle::{PreparedTriangles, ProjectedTriangles, WatertightTriangles};
use crate::{Aabb, BuildOptions, Counters, Ray, Threads, TriangleTest};

/// Tree and triangles.
#[derive(Debug)]
pub(crate) struct KdIndex {
    tree: KdTree,
    triangles: Prepared,
    reach: f32,
}

/// Triangles for the test that was chosen.
#[derive(Debug)]
enum Prepared {
    Watertight(WatertightTriangles),
    Projected(ProjectedTriangles),
}

impl KdIndex {
    /// Builds over the good triangles.
    pub(crate) fn build(screened: &Screened, options: &BuildOptions, threads: Threads) -> Self {
        let tree = KdTree::build(screened, options, threads);
        let triangles = Prepared::new(screened, options.triangle_test);
        let reach = tree.bounds.reach();
        Self { tree, triangles, reach }
    }

    /// Box around all triangles.
    pub(crate) fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    pub(crate) fn tree(&self) -> &KdTree {
        &self.tree
    }

    pub(crate) fn triangle_bytes(&self) -> usize {
        match &self.triangles {
            Prepared::Watertight(triangles) => triangles.memory_bytes(),
            Prepared::Projected(triangles) => triangles.memory_bytes(),
        }
    }

    /// Improves `nearest`; the ray is sound and regular.
    #[inline(always)]
    pub(crate) fn search<S: Simd, M: Mode>(
        &self,
        _simd: S,
        ray: &Ray,
        slot: u32,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        match &self.triangles {
            Prepared::Watertight(triangles) => {
                self.search_with::<M, _>(triangles, ray, slot, nearest, counters)
            }
            Prepared::Projected(triangles) => {
                self.search_with::<M, _>(triangles, ray, slot, nearest, counters)
            }
        }
    }

    #[inline(always)]
    fn search_with<M: Mode, T: PreparedTriangles>(
        &self,
        triangles: &T,
        ray: &Ray,
        slot: u32,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        let prepared = T::prepare(ray);
        let slabs = RaySlabs::new(ray, &self.tree.bounds, self.reach);
        let mut tested = 0;
        let visited = self.tree.walk(
            &slabs,
            ray.t_near,
            nearest.t,
            #[inline(always)]
            |numbers| {
                for &number in numbers {
                    tested += 1;
                    if let Some(meeting) = triangles.meet(number, &prepared, ray.t_near, nearest.t) {
                        nearest.offer::<M>(meeting, number, slot);
                        if M::ANY {
                            break;
                        }
                    }
                }
                nearest.t
            },
        );
        counters.nodes += u64::from(visited);
        counters.triangles += tested;
    }

    /// The same for the first `count` rays of a tile, all of one heading; see `BvhIndex::sweep`.
    #[inline(always)]
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
        for first in (0..count).step_by(WIDTH) {
            let mut best = NearestPacket::load(simd, nearest, first);
            let here = u64::MAX >> (64 - (count - first).min(WIDTH));
            let packet = RayPacket::from_tile(simd, rays, first, mask32x8::from_bitmask(simd, here));
            let (tree, reach) = (&self.tree, self.reach);
            match &self.triangles {
                Prepared::Watertight(triangles) => Search { tree, reach, triangles, slot }
                    .packet::<S, M>(simd, &packet, heading, &mut best, counters),
                Prepared::Projected(triangles) => Search { tree, reach, triangles, slot }
                    .packet::<S, M>(simd, &packet, heading, &mut best, counters),
            }
            best.store(nearest, first);
        }
    }
}

impl Prepared {
    fn new(screened: &Screened, test: TriangleTest) -> Self {
        // Dropped triangles keep their number; what stands in for them is never looked at.
        let mut good = screened.good.iter().copied().peekable();
        let corners = (0..screened.count() as u32).map(move |number| match good.next_if_eq(&number) {
            Some(number) => screened.corners(number),
            None => [[0.0; 3]; 3],
        });
        match test {
            TriangleTest::Watertight => Self::Watertight(WatertightTriangles::new(corners.collect())),
            TriangleTest::Projected => Self::Projected(ProjectedTriangles::new(corners)),
        }
    }
}
