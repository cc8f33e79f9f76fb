// SPDX-License-Identifier: GPL-3.0-or-later
//! One object's triangles, ready to be asked for rays: built once, never changed, shared through `Arc`.
//! Source: original. Space: object; `inst_id` is 0 in all hits.
//! Proof: `tests/brute_force.rs`.

use gnurt_simd::Simd;

use crate::batch::Traceable;
use crate::geometry::{Screened, mesh_of};
use crate::kd::{KdTree, RaySlabs, Search};
use crate::nearest::{AnyHit, Closest, Mode, Nearest};
use crate::packet::{Heading, NearestPacket, RayPacket, WIDTH};
use crate::triangle::{PreparedTriangles, ProjectedTriangles, WatertightTriangles};
use crate::{
    Aabb, BadPrimitives, BuildOptions, Counters, Hit, HitBatch, Query, Ray, RayBatch, Record, Threads,
    TreeStats, TriangleTest, Triangles,
};

/// A tree over the triangles of an object's meshes.
#[derive(Debug)]
pub struct ObjectTree {
    tree: KdTree,
    triangles: Prepared,
    /// First number of each mesh's triangles.
    starts: Vec<u32>,
    reach: f32,
    bad: BadPrimitives,
    stats: TreeStats,
}

/// Triangles for the test that was chosen.
#[derive(Debug)]
enum Prepared {
    Watertight(WatertightTriangles),
    Projected(ProjectedTriangles),
}

impl ObjectTree {
    /// Builds over `meshes`. Triangles that cannot be traced are left out and counted; no triangle at all is fine.
    #[must_use]
    pub fn build(meshes: &[Triangles], options: &BuildOptions, threads: Threads) -> Self {
        let screened = Screened::new(meshes);
        let tree = KdTree::build(&screened, options, threads);
        let triangles = Prepared::new(&screened, options.triangle_test);
        let stats = TreeStats {
            primitives: screened.good.len() as u64,
            primitive_bytes: triangles.memory_bytes() as u64,
            ..tree.measure(options)
        };
        let reach = tree.bounds.reach();
        Self { tree, triangles, starts: screened.starts, reach, bad: screened.bad, stats }
    }

    /// Box around all triangles, object space; [`Aabb::EMPTY`] without any.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds
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
        self.tree == other.tree
    }

    /// The closest hit.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        crate::batch::closest(self, ray, &mut Counters::default())
    }

    /// Whether anything is hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        crate::batch::any(self, ray, &mut Counters::default())
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
    pub(crate) fn search<M: Mode>(
        &self,
        ray: &Ray,
        slot: u32,
        nearest: &mut Nearest,
        counters: &mut Counters,
    ) {
        if self.stats.primitives == 0 {
            return;
        }
        if !(Ray::SHORTEST..=Ray::LONGEST).contains(&ray.longest()) {
            return self.search_scaled::<M>(ray, slot, nearest, counters);
        }
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
        let visited = self.tree.walk(&slabs, ray.t_near, nearest.t, |numbers| {
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
        });
        counters.nodes += u64::from(visited);
        counters.triangles += tested;
    }

    /// For directions so long or short that their inverse is of no use.
    #[cold]
    fn search_scaled<M: Mode>(&self, ray: &Ray, slot: u32, nearest: &mut Nearest, counters: &mut Counters) {
        let (scaled, scale) = ray.within(ray.t_near, nearest.t).regular();
        if !(Ray::SHORTEST..=Ray::LONGEST).contains(&scaled.longest()) {
            return;
        }
        let mut found = Nearest { t: scaled.t_far, ..*nearest };
        self.search::<M>(&scaled, slot, &mut found, counters);
        if found.slot != nearest.slot || found.number != nearest.number {
            *nearest = Nearest { t: if M::ANY { found.t } else { found.t * scale }, ..found };
        }
    }

    /// [`search`](Self::search) in lanes. Lanes that do not go the same way go one by one.
    ///
    /// A function of its own for the compiler, entered with the features of `S`: it is instantiated once per level
    /// and mode, not once per caller.
    #[inline(always)]
    pub(crate) fn search_packet<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayPacket<S>,
        slot: u32,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    ) {
        simd.vectorize(
            #[inline(always)]
            || match rays.heading(simd) {
                None => self.search_lanes::<S, M>(rays, slot, nearest, counters),
                Some(heading) => self.search_together::<S, M>(simd, rays, heading, slot, nearest, counters),
            },
        );
    }

    #[inline(always)]
    fn search_together<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayPacket<S>,
        heading: Heading,
        slot: u32,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    ) {
        let (tree, reach) = (&self.tree, self.reach);
        if self.stats.primitives == 0 {
            return;
        }
        match &self.triangles {
            Prepared::Watertight(triangles) => {
                Search { tree, reach, triangles, slot }.packet::<S, M>(simd, rays, heading, nearest, counters)
            }
            Prepared::Projected(triangles) => {
                Search { tree, reach, triangles, slot }.packet::<S, M>(simd, rays, heading, nearest, counters)
            }
        }
    }

    #[inline(always)]
    fn search_lanes<S: Simd, M: Mode>(
        &self,
        rays: &RayPacket<S>,
        slot: u32,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    ) {
        let active = gnurt_simd::prelude::SimdMask::to_bitmask(rays.active);
        for i in (0..WIDTH).filter(|i| active >> i & 1 == 1) {
            let mut lane = nearest.get(i);
            self.search::<M>(&rays.ray(i), slot, &mut lane, counters);
            nearest.set(i, &lane);
        }
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
    fn closest(&self, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters) {
        self.search::<Closest>(ray, 0, nearest, counters);
    }

    fn any(&self, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters) {
        self.search::<AnyHit>(ray, 0, nearest, counters);
    }

    #[inline(always)]
    fn packet<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayPacket<S>,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    ) {
        self.search_packet::<S, M>(simd, rays, 0, nearest, counters);
    }

    fn hit(&self, nearest: &Nearest) -> Hit {
        self.resolve(nearest, 0)
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

    fn memory_bytes(&self) -> usize {
        match self {
            Self::Watertight(triangles) => triangles.memory_bytes(),
            Self::Projected(triangles) => triangles.memory_bytes(),
        }
    }
}
