// SPDX-License-Identifier: GPL-3.0-or-later
//! One object's geometry, ready to be asked for rays: built once, never changed, shared through `Arc`.
//! Source: original; a tree for each kind of primitive, searched one after the other up to the best hit so far, is what
//! Embree does. Space: object; `inst_id` is 0 in all hits.
//! Invariant: primitives are numbered through all geometries, so what is best does not depend on the order of trees.
//! Proof: `tests/brute_force.rs`, `tests/mixed.rs`.

mod store;

use gnurt_simd::Simd;

use crate::batch::Traceable;
use crate::bvh::{BvhIndex, SphereIndex, UserIndex};
use crate::control::Watch;
use crate::geometry::Screened;
use crate::geometry::{GeometryKind, Numbering};
use crate::kd::KdIndex;
use crate::nearest::{Collect, Mode, Nearest, Relay};
use crate::point::{NearestPoint, Probe};
use crate::tile::{NearestTile, RayTile, all};
use crate::{
    Aabb, BadPrimitives, BuildControl, BuildError, BuildOptions, Counters, Geometry, Hit, Ray, Structure,
    Threads, TreeStats, Triangles,
};

/// Trees over an object's geometries.
#[derive(Debug)]
pub struct ObjectTree {
    /// None of them empty.
    parts: Vec<Part>,
    numbering: Numbering,
    bad: BadPrimitives,
    bounds: Aabb,
    stats: TreeStats,
}

/// A tree over all primitives of one kind and mask.
#[derive(Debug)]
struct Part {
    mask: u32,
    index: Index,
}

/// What was built. To add a structure is to add a line here and in the matches below.
#[derive(Debug)]
enum Index {
    Kd(KdIndex),
    Bvh(BvhIndex),
    Spheres(SphereIndex),
    User(UserIndex),
}

/// What trees are told apart by.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Surfaces,
    Spheres,
    User,
}

fn kind_of(geometry: &Geometry) -> Kind {
    match geometry.kind {
        GeometryKind::Triangles(_) | GeometryKind::Quads(_) => Kind::Surfaces,
        GeometryKind::Spheres(_) => Kind::Spheres,
        GeometryKind::User(_) => Kind::User,
    }
}

impl ObjectTree {
    /// Builds over triangle meshes. Triangles that cannot be traced are left out and counted; no triangle at all is
    /// fine.
    #[must_use]
    pub fn build(meshes: &[Triangles], options: &BuildOptions, threads: Threads) -> Self {
        let geometries: Vec<Geometry> = meshes.iter().map(|&mesh| mesh.into()).collect();
        Self::build_from(&geometries, options, threads)
    }

    /// The same under control: may be cancelled, tells how far it is and what memory it takes, and stays within a budget.
    /// The tree does not depend on who listens.
    ///
    /// # Errors
    /// That `control` stopped it: see [`BuildError`]. Bad triangles are no errors, but counted.
    pub fn try_build(
        meshes: &[Triangles],
        options: &BuildOptions,
        threads: Threads,
        control: &dyn BuildControl,
    ) -> Result<Self, BuildError> {
        let geometries: Vec<Geometry> = meshes.iter().map(|&mesh| mesh.into()).collect();
        Self::try_build_from(&geometries, options, threads, control)
    }

    /// Builds over geometries of any kinds. What cannot be traced is left out and counted; nothing at all is fine.
    ///
    /// Spheres and user geometry always get a BVH; `options.structure` is for triangles and quads.
    #[must_use]
    pub fn build_from(geometries: &[Geometry], options: &BuildOptions, threads: Threads) -> Self {
        Self::try_build_from(geometries, options, threads, &()).expect("nobody stops it")
    }

    /// The same under control, as [`try_build`](Self::try_build). Trees of spheres and of user geometry are built in one
    /// go, and their memory is not counted.
    ///
    /// # Errors
    /// That `control` stopped it: see [`BuildError`].
    pub fn try_build_from(
        geometries: &[Geometry],
        options: &BuildOptions,
        threads: Threads,
        control: &dyn BuildControl,
    ) -> Result<Self, BuildError> {
        let watch = Watch::new(control);
        let numbering = Numbering::new(geometries);
        let mut bad = BadPrimitives { too_many: numbering.too_many, ..BadPrimitives::default() };
        let mut groups: Vec<(Kind, u32)> = Vec::new();
        for group in geometries.iter().map(|geometry| (kind_of(geometry), geometry.mask)) {
            if !groups.contains(&group) {
                groups.push(group);
            }
        }
        let mut parts = Vec::new();
        let mut stats = TreeStats::default();
        for (kind, mask) in groups {
            let wanted = |geometry: &Geometry| (kind_of(geometry), geometry.mask) == (kind, mask);
            let (quality, memory) = (options.quality, options.memory);
            let mut triangles = None;
            watch.result()?;
            let index = match kind {
                Kind::Surfaces => {
                    let wanted_numbers = (0..geometries.len()).filter(|&i| wanted(&geometries[i]));
                    let numbers: usize = wanted_numbers.map(|i| numbering.range(i).len()).sum();
                    let bytes = size_of::<u32>() * numbers;
                    watch.take(bytes);
                    watch.result()?;
                    let screened = Screened::over(geometries, &numbering, wanted, threads);
                    bad += screened.bad;
                    triangles = Some(screened.good.len() as u64);
                    if screened.good.is_empty() {
                        continue;
                    }
                    let index = match options.structure {
                        Structure::Kd => Index::Kd(KdIndex::build(&screened, options, threads, &watch)?),
                        Structure::Bvh => {
                            Index::Bvh(BvhIndex::build(&screened, quality, memory, threads, &watch)?)
                        }
                    };
                    watch.give(bytes);
                    index
                }
                Kind::Spheres => Index::Spheres(SphereIndex::build(
                    geometries, &numbering, wanted, &mut bad, quality, memory, threads,
                )),
                Kind::User => Index::User(UserIndex::build(
                    geometries, &numbering, wanted, &mut bad, quality, memory, threads,
                )),
            };
            if !index.bounds().is_empty() {
                let measured = index.stats();
                let primitives = triangles.unwrap_or(measured.primitives);
                stats = both(stats, TreeStats { primitives, ..measured });
                parts.push(Part { mask, index });
            }
        }
        let bounds = parts.iter().fold(Aabb::EMPTY, |all, part| all.union(&part.index.bounds()));
        watch.result()?;
        watch.finish();
        Ok(Self { parts, numbering, bad, bounds, stats })
    }

    /// Box around everything, object space; [`Aabb::EMPTY`] without anything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// What was left out at build.
    #[must_use]
    pub fn bad_primitives(&self) -> BadPrimitives {
        self.bad
    }

    /// Size and shape of the trees, added up.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.stats
    }

    /// Whether two objects have the same trees, node for node.
    #[must_use]
    pub fn same_tree(&self, other: &Self) -> bool {
        let same = |(a, b): (&Part, &Part)| {
            a.mask == b.mask
                && match (&a.index, &b.index) {
                    (Index::Kd(a), Index::Kd(b)) => a == b,
                    (Index::Bvh(a), Index::Bvh(b)) => a == b,
                    (Index::Spheres(a), Index::Spheres(b)) => a == b,
                    (Index::User(a), Index::User(b)) => a.same_tree(b),
                    _ => false,
                }
        };
        self.parts.len() == other.parts.len() && self.parts.iter().zip(&other.parts).all(same)
    }

    /// Offers what the ray meets; it is sound, `slot` is noted with each hit.
    ///
    /// A function of its own for the compiler, entered with the features of `S`: kernels are compiled once per level
    /// and mode, not once per caller.
    #[inline(never)]
    pub(crate) fn search<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                if !(Ray::SHORTEST..=Ray::LONGEST).contains(&ray.longest()) {
                    return self.search_scaled::<S, C>(simd, ray, slot, collect, counters);
                }
                for part in &self.parts {
                    if part.mask & ray.mask != 0 && !collect.is_done() {
                        part.index.search::<S, C>(simd, ray, slot, collect, counters);
                    }
                }
            },
        );
    }

    /// For directions so long or short that their inverse is of no use.
    #[cold]
    #[inline(never)]
    fn search_scaled<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let (scaled, scale) = ray.within(ray.t_near, collect.reach()).regular();
        if (Ray::SHORTEST..=Ray::LONGEST).contains(&scaled.longest()) {
            collect.scaled(scale, |collect| self.search::<S, C>(simd, &scaled, slot, collect, counters));
        }
    }

    /// [`search`](Self::search) for the rays of a tile that are in `active`, all of them sound. Rays that go different
    /// ways are parted first, unless all of them are `apart`.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "they are what a tile's way through a tree takes")]
    pub(crate) fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        apart: bool,
        slot: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                if self.parts.is_empty() || active == 0 {
                    return;
                }
                if apart {
                    return self.search_apart::<S, M>(simd, rays, active, slot, nearest, counters);
                }
                let alone = rays.part(
                    simd,
                    active,
                    nearest,
                    #[inline(always)]
                    |rays, count, heading, best| {
                        self.sweep::<S, M>(simd, rays, count, heading, slot, best, counters);
                    },
                );
                if alone != 0 {
                    self.search_apart::<S, M>(simd, rays, alone, slot, nearest, counters);
                }
            },
        );
    }

    /// For rays that have nothing in common.
    #[inline(never)]
    fn search_apart<S: Simd, M: Mode>(
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
                let mut alone = active;
                if let [Part { index: Index::Bvh(index), mask }] = &self.parts[..] {
                    let ways = rays.headings(simd);
                    let regular = active & ways.regular;
                    alone &= !regular;
                    if mask & rays.mask != 0 && regular != 0 {
                        index.search_apart::<S, M>(simd, rays, ways, regular, slot, nearest, counters);
                    }
                }
                nearest.one_by_one::<M>(
                    rays,
                    alone,
                    #[inline(always)]
                    |ray, best| self.search::<S, _>(simd, ray, slot, best, counters),
                );
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
            || {
                for part in self.parts.iter().filter(|part| part.mask & rays.mask != 0) {
                    match &part.index {
                        Index::Kd(index) => {
                            index.sweep::<S, M>(simd, rays, count, heading, slot, nearest, counters);
                        }
                        Index::Bvh(index) => {
                            index.sweep::<S, M>(simd, rays, count, heading, slot, nearest, counters);
                        }
                        other => other.one_by_one::<S, M>(simd, rays, count, slot, nearest, counters),
                    }
                }
            },
        );
    }

    /// Improves `nearest`.
    #[inline(never)]
    pub(crate) fn nearest<S: Simd>(&self, simd: S, probe: &Probe, slot: u32, nearest: &mut NearestPoint) {
        simd.vectorize(
            #[inline(always)]
            || {
                for part in self.parts.iter().filter(|part| part.mask & probe.mask != 0) {
                    part.index.nearest(simd, probe, slot, nearest);
                }
            },
        );
    }

    /// Whether triangles' numbers are their `prim_id`s.
    pub(crate) fn has_one_mesh(&self) -> bool {
        self.numbering.quads == [false]
    }

    /// Ids of a hit in this object.
    #[inline]
    pub(crate) fn resolve(&self, nearest: &Nearest, inst_id: u32, leaf_id: u32) -> Hit {
        let Nearest { t, u, v, number, .. } = *nearest;
        let place = self.numbering.place(number);
        // The second half of a quad has its vertices 2, 3 and 1.
        let (u, v) = if place.second_half { (1.0 - u, 1.0 - v) } else { (u, v) };
        Hit { t, u, v, prim_id: place.prim_id, geom_id: place.geom_id, inst_id, leaf_id }
    }
}

impl Index {
    fn bounds(&self) -> Aabb {
        match self {
            Self::Kd(index) => index.bounds(),
            Self::Bvh(index) => index.bounds(),
            Self::Spheres(index) => index.bounds(),
            Self::User(index) => index.bounds(),
        }
    }

    fn stats(&self) -> TreeStats {
        match self {
            Self::Kd(index) => index.stats(),
            Self::Bvh(index) => index.stats(),
            Self::Spheres(index) => index.stats(),
            Self::User(index) => index.stats(),
        }
    }

    #[inline(always)]
    fn search<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        match self {
            Self::Kd(index) => index.search::<S, C>(simd, ray, slot, collect, counters),
            Self::Bvh(index) => index.search::<S, C>(simd, ray, slot, collect, counters),
            other => Relay::run(collect, |relay| other.search_others(simd, ray, slot, relay, counters)),
        }
    }

    /// For indices that have no kernel for each collector, out of the way of those for triangles.
    #[inline(never)]
    fn search_others<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        slot: u32,
        relay: &mut Relay,
        counters: &mut Counters,
    ) {
        simd.vectorize(
            #[inline(always)]
            || match self {
                Self::Spheres(index) => index.search::<S, Relay>(simd, ray, slot, relay, counters),
                Self::User(index) => index.search::<S, Relay>(simd, ray, slot, relay, counters),
                Self::Kd(_) | Self::Bvh(_) => unreachable!("triangles have kernels of their own"),
            },
        );
    }

    /// For indices that know no tiles: the first `count` rays of one, in turn.
    fn one_by_one<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        count: usize,
        slot: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        nearest.one_by_one::<M>(rays, all(count), |ray, best| {
            Relay::run(best, |relay| self.search_others(simd, ray, slot, relay, counters));
        });
    }

    /// Improves `nearest`.
    #[inline(always)]
    fn nearest<S: Simd>(&self, simd: S, probe: &Probe, slot: u32, nearest: &mut NearestPoint) {
        match self {
            Self::Kd(index) => index.nearest(probe, slot, nearest),
            Self::Bvh(index) => index.nearest(simd, probe, slot, nearest),
            Self::Spheres(index) => index.nearest(simd, probe, slot, nearest),
            Self::User(index) => index.nearest(simd, probe, slot, nearest),
        }
    }
}

/// The sizes of two trees together.
fn both(a: TreeStats, b: TreeStats) -> TreeStats {
    TreeStats {
        primitives: a.primitives + b.primitives,
        nodes: a.nodes + b.nodes,
        leaves: a.leaves + b.leaves,
        empty_leaves: a.empty_leaves + b.empty_leaves,
        references: a.references + b.references,
        depth: a.depth.max(b.depth),
        sah_cost: a.sah_cost + b.sah_cost,
        tree_bytes: a.tree_bytes + b.tree_bytes,
        primitive_bytes: a.primitive_bytes + b.primitive_bytes,
    }
}

impl Traceable for ObjectTree {
    #[inline(always)]
    fn single<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        _: Option<&[f64; 3]>,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        self.search::<S, C>(simd, ray, 0, collect, counters);
    }

    #[inline(always)]
    fn tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        apart: bool,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        self.search_tile::<S, M>(simd, rays, active, apart, 0, nearest, counters);
    }

    fn hit(&self, nearest: &Nearest) -> Hit {
        self.resolve(nearest, 0, 0)
    }

    #[inline(always)]
    fn point<S: Simd>(&self, simd: S, probe: &Probe, nearest: &mut NearestPoint) {
        self.nearest(simd, probe, 0, nearest);
    }

    fn only_mesh(&self) -> Option<u32> {
        self.has_one_mesh().then_some(0)
    }
}
