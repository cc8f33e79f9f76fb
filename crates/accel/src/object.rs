// SPDX-License-Identifier: GPL-3.0-or-later
//! One object's triangles, ready to be asked for rays: built once, never changed, shared through `Arc`.
//! Source: original. Space: object; `inst_id` is 0 in all hits.
//! Proof: `tests/brute_force.rs`.

use gnurt_simd::{Level, Simd};

use crate::batch::Traceable;
use crate::bvh::BvhIndex;
use crate::geometry::{Screened, mesh_of};
use crate::kd::KdIndex;
use crate::nearest::{Mode, Nearest};
use crate::tile::{NearestTile, RayTile};
use crate::{
    Aabb, BadPrimitives, BuildOptions, Counters, Hit, HitBatch, Query, Ray, RayBatch, Record, Structure,
    Threads, TreeStats, Triangles,
};

/// A tree over the triangles of an object's meshes.
#[derive(Debug)]
pub struct ObjectTree {
    index: Index,
    /// First number of each mesh's triangles.
    starts: Vec<u32>,
    bad: BadPrimitives,
    stats: TreeStats,
}

/// What was built. To add a structure is to add a line here and in the three matches below.
#[derive(Debug)]
enum Index {
    Kd(KdIndex),
    Bvh(BvhIndex),
}

/// Fewer rays of one heading go one by one.
const WORTH_A_TILE: u32 = 4;

impl ObjectTree {
    /// Builds over `meshes`. Triangles that cannot be traced are left out and counted; no triangle at all is fine.
    #[must_use]
    pub fn build(meshes: &[Triangles], options: &BuildOptions, threads: Threads) -> Self {
        let screened = Screened::new(meshes);
        let (index, measured) = match options.structure {
            Structure::Kd => {
                let index = KdIndex::build(&screened, options, threads);
                let stats = index.stats();
                (Index::Kd(index), stats)
            }
            Structure::Bvh => {
                let index = BvhIndex::build(&screened, options.quality, threads);
                let stats = index.stats();
                (Index::Bvh(index), stats)
            }
        };
        let stats = TreeStats { primitives: screened.good.len() as u64, ..measured };
        Self { index, starts: screened.starts, bad: screened.bad, stats }
    }

    /// Box around all triangles, object space; [`Aabb::EMPTY`] without any.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        match &self.index {
            Index::Kd(index) => index.bounds(),
            Index::Bvh(index) => index.bounds(),
        }
    }

    /// What was left out at build.
    #[must_use]
    pub fn bad_primitives(&self) -> BadPrimitives {
        self.bad
    }

    /// Size and shape of the tree.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.stats
    }

    /// Whether two trees are the same, node for node.
    #[must_use]
    pub fn same_tree(&self, other: &Self) -> bool {
        match (&self.index, &other.index) {
            (Index::Kd(a), Index::Kd(b)) => a == b,
            (Index::Bvh(a), Index::Bvh(b)) => a == b,
            _ => false,
        }
    }

    /// The closest hit.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        crate::batch::closest(self, Level::best(), ray)
    }

    /// Whether anything is hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        crate::batch::any(self, Level::best(), ray)
    }

    /// Closest hits of a batch; `hits` is resized to it.
    pub fn intersect_batch(&self, query: &Query, rays: &RayBatch, hits: &mut HitBatch, record: &mut Record) {
        crate::batch::intersect(self, query, rays, hits, record);
    }

    /// Whether anything is hit, ray by ray; `occluded` is resized to the batch.
    pub fn occluded_batch(
        &self,
        query: &Query,
        rays: &RayBatch,
        occluded: &mut Vec<bool>,
        record: &mut Record,
    ) {
        crate::batch::occluded(self, query, rays, occluded, record);
    }

    /// Improves `nearest`; the ray is sound, `slot` is noted with the hit.
    ///
    /// A function of its own for the compiler, entered with the features of `S`: kernels are compiled once per level
    /// and mode, not once per caller.
    #[inline(never)]
    pub(crate) fn search<S: Simd, M: Mode>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                if self.stats.primitives == 0 {
                    return;
                }
                if !(Ray::SHORTEST..=Ray::LONGEST).contains(&ray.longest()) {
                    return self.search_scaled::<S, M>(simd, ray, slot, nearest, counters);
                }
                self.search_regular::<S, M>(simd, ray, slot, nearest, counters);
            },
        );
    }

    #[inline(always)]
    fn search_regular<S: Simd, M: Mode>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        match &self.index {
            Index::Kd(index) => index.search::<S, M>(simd, ray, slot, nearest, counters),
            Index::Bvh(index) => index.search::<S, M>(simd, ray, slot, nearest, counters),
        }
    }

    /// For directions so long or short that their inverse is of no use.
    #[cold]
    #[inline(never)]
    fn search_scaled<S: Simd, M: Mode>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        let (scaled, scale) = ray.within(ray.t_near, nearest.t).regular();
        if !(Ray::SHORTEST..=Ray::LONGEST).contains(&scaled.longest()) {
            return;
        }
        let mut found = Nearest { t: scaled.t_far, ..*nearest };
        self.search::<S, M>(simd, &scaled, slot, &mut found, counters);
        if found.slot != nearest.slot || found.number != nearest.number {
            *nearest = Nearest { t: if M::ANY { found.t } else { found.t * scale }, ..found };
        }
    }

    /// [`search`](Self::search) for the rays of a tile that are in `active`, all of them sound. Rays that go different
    /// ways are parted first.
    #[inline(never)]
    pub(crate) fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        slot: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                if self.stats.primitives == 0 || active == 0 {
                    return;
                }
                let ways = rays.headings(simd);
                let regular = active & ways.regular;
                if regular == u64::MAX {
                    let (heading, bits) = ways.like(0, regular);
                    if bits == u64::MAX {
                        return self.sweep::<S, M>(simd, rays, 64, heading, slot, nearest, counters);
                    }
                }
                let mut alone = active & !ways.regular;
                let mut left = regular;
                while left != 0 {
                    let (heading, bits) = ways.like(left.trailing_zeros() as usize, left);
                    left &= !bits;
                    if bits.count_ones() < WORTH_A_TILE {
                        alone |= bits;
                        continue;
                    }
                    let (mut some, mut best) = (RayTile::EMPTY, NearestTile::EMPTY);
                    let count = rays.gather(nearest, bits, &mut some, &mut best);
                    self.sweep::<S, M>(simd, &some, count, heading, slot, &mut best, counters);
                    nearest.scatter(bits, &best);
                }
                while alone != 0 {
                    let i = alone.trailing_zeros() as usize;
                    alone &= alone - 1;
                    let mut lane = nearest.get(i);
                    self.search::<S, M>(simd, &rays.ray(i, lane.t), slot, &mut lane, counters);
                    nearest.set(i, &lane);
                }
            },
        );
    }

    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "they are what a tile's way through a tree takes")]
    fn sweep<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        count: usize,
        heading: crate::packet::Heading,
        slot: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        simd.vectorize(
            #[inline(always)]
            || match &self.index {
                Index::Kd(index) => index.sweep::<S, M>(simd, rays, count, heading, slot, nearest, counters),
                Index::Bvh(index) => index.sweep::<S, M>(simd, rays, count, heading, slot, nearest, counters),
            },
        );
    }

    /// Whether triangles' numbers are their `prim_id`s.
    pub(crate) fn has_one_mesh(&self) -> bool {
        self.starts.len() == 2
    }

    /// Ids of a hit in this object.
    pub(crate) fn resolve(&self, nearest: &Nearest, inst_id: u32) -> Hit {
        let mesh = mesh_of(&self.starts, nearest.number);
        Hit {
            t: nearest.t,
            u: nearest.u,
            v: nearest.v,
            prim_id: nearest.number - self.starts[mesh],
            geom_id: mesh as u32,
            inst_id,
        }
    }
}

impl Traceable for ObjectTree {
    #[inline(always)]
    fn single<S: Simd, M: Mode>(&self, simd: S, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters) {
        self.search::<S, M>(simd, ray, 0, nearest, counters);
    }

    #[inline(always)]
    fn tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        self.search_tile::<S, M>(simd, rays, active, 0, nearest, counters);
    }

    fn hit(&self, nearest: &Nearest) -> Hit {
        self.resolve(nearest, 0)
    }

    fn only_mesh(&self) -> Option<u32> {
        self.has_one_mesh().then_some(0)
    }
}
