// SPDX-License-Identifier: GPL-3.0-or-later
//! From queries to kernels: the only place where this crate dispatches on the CPU.
//! Source: original.
//!
//! The way of a coherent batch: `intersect` -> `dispatch!` -> `tiles` (one pass over the batch, 64 rays at a time) ->
//! `Traceable::tile` (the scene's top tree) -> `ObjectTree::search_tile` (parts rays of different headings) -> `sweep` of
//! the kd-tree or the BVH. Where rays are apart (an incoherent batch): -> `ObjectTree::search_apart` -> that of the BVH.
//! The way of a single ray: `closest` -> `dispatch!` -> `Traceable::single` -> `ObjectTree::search` -> `search` of the
//! index; what it gathers on its way is a `Collect`. Everything from `tiles` and `single` on is `#[inline(always)]` or
//! entered by `vectorize`, or lanes become calls.

use gnurt_simd::{Simd, dispatch, dispatch_wide, f32x16, prelude::*, u32x16};

use crate::candidates::Candidates;
use crate::nearest::{AnyHit, Best, Closest, Collect, Mode, Nearest};
use crate::point::{NearestPoint, PointHit, Probe};
use crate::tile::{Headings, LANES, NearestTile, RayTile, TILE, all, chunk, each};
use crate::{Coherence, Counters, Hit, HitBatch, INVALID_ID, Pencil, Query, Ray, RayBatch, Record};

/// What rays can be sent into: an object or a scene.
pub(crate) trait Traceable {
    /// Offers what the ray meets; it is sound. `origin` is its own in double precision, where that is known.
    fn single<S: Simd, C: Collect>(
        &self,
        simd: S,
        ray: &Ray,
        origin: Option<&[f64; 3]>,
        collect: &mut C,
        counters: &mut Counters,
    );
    /// Improves the best hits of those rays of a tile that are in `active`. Where they are `apart`, they need not have
    /// anything in common.
    fn tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        apart: bool,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    );
    /// Ids of what was hit.
    fn hit(&self, nearest: &Nearest) -> Hit;
    /// Writes what those rays of a tile that are in `bits` have hit, the tile's first ray to lane `first`.
    fn write(&self, nearest: &NearestTile, bits: u64, first: usize, hits: &mut HitBatch) {
        each(bits, |i| hits.set(first + i, self.hit(&nearest.get(i))));
    }
    /// The instance, where all hits have the same one and their numbers are `prim_id`s of its only mesh.
    fn only_mesh(&self) -> Option<u32>;
    /// Improves the nearest point.
    fn point<S: Simd>(&self, simd: S, probe: &Probe, nearest: &mut NearestPoint);
}

/// The nearest point of a surface.
pub(crate) fn closest_point<T: Traceable>(
    target: &T,
    query: &Query,
    point: [f64; 3],
    radius: f64,
) -> Option<PointHit> {
    if !point.iter().all(|x| x.is_finite()) || radius.is_nan() {
        return None;
    }
    let (probe, mut nearest) = (Probe::new(point, query.mask), NearestPoint::within(radius));
    dispatch!(query.level, simd => target.point(simd, &probe, &mut nearest));
    nearest.hit(point, |nearest| target.hit(nearest))
}

/// A single ray as it is asked for.
#[derive(Clone, Copy)]
pub(crate) struct One<'a> {
    pub(crate) query: &'a Query,
    pub(crate) ray: &'a Ray,
    /// The ray's origin in double precision, where that is known.
    pub(crate) origin: Option<&'a [f64; 3]>,
}

impl One<'_> {
    #[inline(always)]
    fn trace<T: Traceable, C: Collect>(self, target: &T, collect: &mut C) {
        // Copied only where it must be: what has just been stored in parts cannot be loaded in lanes for a while.
        let (masked, mask) = (&mut None, self.ray.mask & self.query.mask);
        let ray = match mask == self.ray.mask {
            true => self.ray,
            false => masked.insert(Ray { mask, ..*self.ray }),
        };
        if ray.is_sound() {
            let (origin, counters) = (self.origin, &mut Counters::default());
            dispatch!(self.query.level, simd => target.single::<_, C>(simd, ray, origin, collect, counters));
        }
    }

    /// The closest hit.
    #[inline(always)]
    pub(crate) fn closest<T: Traceable>(self, target: &T) -> Option<Hit> {
        let mut best = Best::<Closest>::new(Nearest::none(self.ray.t_far));
        self.trace(target, &mut best);
        best.0.is_hit().then(|| target.hit(&best.0))
    }

    /// Whether there is a hit.
    #[inline(always)]
    pub(crate) fn any<T: Traceable>(self, target: &T) -> bool {
        let mut best = Best::<AnyHit>::new(Nearest::none(self.ray.t_far));
        self.trace(target, &mut best);
        best.0.is_hit()
    }

    /// Shows all hits to `judge`, in any order; it answers with how far the ray is still of interest.
    pub(crate) fn candidates<T: Traceable>(self, target: &T, judge: &mut dyn FnMut(Hit) -> f32) {
        let resolve = |nearest: &Nearest| target.hit(nearest);
        self.trace(target, &mut Candidates::new(self.ray.t_far, &resolve, judge));
    }
}

/// A batch's closest hits.
pub(crate) fn intersect<T: Traceable>(
    target: &T,
    query: &Query,
    rays: &RayBatch,
    hits: &mut HitBatch,
    record: &mut Record,
) {
    hits.reset(rays.len());
    trace::<Closest, T>(target, query, rays, &mut Found { target, hits }, record);
}

/// Which rays of a batch hit anything.
pub(crate) fn occluded<T: Traceable>(
    target: &T,
    query: &Query,
    rays: &RayBatch,
    occluded: &mut Vec<bool>,
    record: &mut Record,
) {
    occluded.clear();
    occluded.resize(rays.len(), false);
    trace::<AnyHit, T>(target, query, rays, &mut Flags(occluded), record);
}

/// Which rays of a pencil hit anything.
pub(crate) fn occluded_pencil<T: Traceable>(
    target: &T,
    query: &Query,
    pencil: &mut Pencil,
    record: &mut Record,
) -> u64 {
    dispatch_wide!(
        query.level,
        simd => trace_pencil(simd, target, query.mask, pencil, &mut record.counters),
        else trace_as_batch(target, query, pencil, record)
    )
}

/// The same where lanes are too narrow for a kernel of its own to be worth its code.
fn trace_as_batch<T: Traceable>(target: &T, query: &Query, pencil: &Pencil, record: &mut Record) -> u64 {
    let [x, y, z] = &pencil.rays.dir;
    let lanes: Vec<usize> = (0..TILE).filter(|&i| pencil.t_far[i] >= 0.0).collect();
    let ray = |&i: &usize| Ray::new(pencil.org, [x[i], y[i], z[i]]).within(0.0, pencil.t_far[i]);
    let query = Query { coherence: Coherence::Coherent, ..*query };
    let mut blocked = Vec::new();
    occluded(target, &query, &lanes.iter().map(ray).collect(), &mut blocked, record);
    lanes.iter().zip(blocked).fold(0, |bits, (i, blocked)| bits | u64::from(blocked) << i)
}

#[inline(always)]
fn trace_pencil<S: Simd, T: Traceable>(
    simd: S,
    target: &T,
    mask: u32,
    pencil: &mut Pencil,
    counters: &mut Counters,
) -> u64 {
    let mut nearest = NearestTile::EMPTY;
    let Pencil { org, rays, t_far } = pencil;
    let active = rays.fill(simd, *org, t_far, mask, &mut nearest);
    counters.rays += u64::from(active.count_ones());
    if active == 0 {
        return 0;
    }
    target.tile::<S, AnyHit>(simd, rays, active, false, &mut nearest, counters);
    active & nearest.hit(simd)
}

/// Where answers go.
trait Answers {
    /// Ray `i` has hit.
    fn one(&mut self, i: usize, nearest: &Nearest);
    /// Rays from `first` on, those in `active`, have been traced.
    fn tile<S: Simd>(&mut self, simd: S, first: usize, active: u64, nearest: &NearestTile);
}

/// Closest hits of a target.
struct Found<'a, T> {
    target: &'a T,
    hits: &'a mut HitBatch,
}

/// One flag for each ray.
struct Flags<'a>(&'a mut [bool]);

impl<T: Traceable> Answers for Found<'_, T> {
    #[inline(always)]
    fn one(&mut self, i: usize, nearest: &Nearest) {
        self.hits.set(i, self.target.hit(nearest));
    }

    #[inline(always)]
    fn tile<S: Simd>(&mut self, simd: S, first: usize, active: u64, nearest: &NearestTile) {
        match self.target.only_mesh() {
            Some(inst_id) if active == u64::MAX => store(simd, self.hits, first, nearest, inst_id),
            _ => self.target.write(nearest, active & nearest.hit(simd), first, self.hits),
        }
    }
}

impl Answers for Flags<'_> {
    #[inline(always)]
    fn one(&mut self, i: usize, _: &Nearest) {
        self.0[i] = true;
    }

    #[inline(always)]
    fn tile<S: Simd>(&mut self, simd: S, first: usize, active: u64, nearest: &NearestTile) {
        each(active & nearest.hit(simd), |i| self.0[first + i] = true);
    }
}

/// Writes a whole tile whose numbers are `prim_id`s.
#[inline(always)]
fn store<S: Simd>(simd: S, hits: &mut HitBatch, first: usize, nearest: &NearestTile, inst_id: u32) {
    let (none, zero) = (u32x16::splat(simd, INVALID_ID), f32x16::splat(simd, 0.0));
    for lane in (0..TILE).step_by(LANES) {
        let at = first + lane..first + lane + LANES;
        let number = u32x16::from_slice(simd, &nearest.number[lane..lane + LANES]);
        let missed = number.simd_eq(none);
        let t = missed.select(f32x16::splat(simd, f32::INFINITY), chunk(simd, &nearest.t, lane));
        let u = missed.select(zero, chunk(simd, &nearest.u, lane));
        let v = missed.select(zero, chunk(simd, &nearest.v, lane));
        t.store_slice(&mut hits.t[at.clone()]);
        u.store_slice(&mut hits.u[at.clone()]);
        v.store_slice(&mut hits.v[at.clone()]);
        number.store_slice(&mut hits.prim_id[at.clone()]);
        missed.select(none, u32x16::splat(simd, 0)).store_slice(&mut hits.geom_id[at.clone()]);
        missed.select(none, u32x16::splat(simd, 0)).store_slice(&mut hits.leaf_id[at.clone()]);
        missed.select(none, u32x16::splat(simd, inst_id)).store_slice(&mut hits.inst_id[at]);
    }
}

fn trace<M: Mode, T: Traceable>(
    target: &T,
    query: &Query,
    rays: &RayBatch,
    answers: &mut impl Answers,
    record: &mut Record,
) {
    assert!(
        rays.mask.is_empty() || rays.mask.len() == rays.len(),
        "{} masks for {} rays",
        rays.mask.len(),
        rays.len()
    );
    let Record { counters, costs } = record;
    let masks = &Masks { own: &rays.mask, common: query.mask };
    match (costs, query.coherence) {
        (Some(costs), _) => {
            dispatch!(query.level, simd => singles::<_, M, T>(simd, target, rays, masks, answers, counters, costs));
        }
        (None, Coherence::Fanned) => {
            dispatch!(query.level, simd => fans::<_, M, T>(simd, target, rays, masks, answers, counters));
        }
        (None, coherence) => {
            let apart = coherence == Coherence::Incoherent;
            dispatch!(query.level, simd => tiles::<_, M, T>(simd, target, rays, apart, masks, answers, counters));
        }
    }
    counters.rays += rays.len() as u64;
}

/// What the rays of a batch see.
struct Masks<'a> {
    /// One for each ray, or none.
    own: &'a [u32],
    /// For all of them.
    common: u32,
}

impl Masks<'_> {
    #[inline(always)]
    fn of(&self, i: usize) -> u32 {
        if self.own.is_empty() { self.common } else { self.own[i] & self.common }
    }

    /// Traces a tile whose ray `i` is `place(i)` of the batch; rays that see the same go together.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "what a tile takes, and its masks")]
    fn tile<S: Simd, M: Mode, T: Traceable>(
        &self,
        simd: S,
        target: &T,
        tile: &mut RayTile,
        active: u64,
        apart: bool,
        place: impl Fn(usize) -> usize,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        let mut left = active;
        loop {
            let mut same = left;
            tile.mask = self.common;
            if !self.own.is_empty() && left != 0 {
                tile.mask = self.of(place(left.trailing_zeros() as usize));
                each(left, |i| {
                    if self.of(place(i)) != tile.mask {
                        same &= !(1 << i);
                    }
                });
            }
            target.tile::<S, M>(simd, tile, same, apart, nearest, counters);
            left &= !same;
            if left == 0 {
                return;
            }
        }
    }
}

/// Traces rays one by one and notes what each costs.
#[inline(always)]
fn singles<S: Simd, M: Mode, T: Traceable>(
    simd: S,
    target: &T,
    rays: &RayBatch,
    masks: &Masks,
    answers: &mut impl Answers,
    counters: &mut Counters,
    costs: &mut Vec<u32>,
) {
    costs.clear();
    costs.reserve(rays.len());
    let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
    for first in (0..rays.len()).step_by(TILE) {
        let sound = tile.load(simd, rays, first, &mut nearest);
        for i in 0..TILE.min(rays.len() - first) {
            let before = counters.nodes + counters.triangles;
            if sound >> i & 1 == 1 {
                let mut best = Best::<M>::new(Nearest::none(nearest.t[i]));
                let ray = Ray { mask: masks.of(first + i), ..tile.ray(i, best.reach()) };
                target.single::<S, _>(simd, &ray, None, &mut best, counters);
                if best.0.is_hit() {
                    answers.one(first + i, &best.0);
                }
            }
            let spent = counters.nodes + counters.triangles - before;
            costs.push(spent.min(u64::from(u32::MAX)) as u32);
        }
    }
}

/// Traces rays in tiles of 64 neighbours, which may be `apart`.
#[inline(always)]
fn tiles<S: Simd, M: Mode, T: Traceable>(
    simd: S,
    target: &T,
    rays: &RayBatch,
    apart: bool,
    masks: &Masks,
    answers: &mut impl Answers,
    counters: &mut Counters,
) {
    let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
    for first in (0..rays.len()).step_by(TILE) {
        let active = tile.load(simd, rays, first, &mut nearest);
        let place = |i: usize| first + i;
        masks.tile::<S, M, T>(simd, target, &mut tile, active, apart, place, &mut nearest, counters);
        answers.tile(simd, first, active, &nearest);
    }
}

/// Rays that are sorted at a time.
const FAN: usize = 4096;

/// Headings that they are sorted by, and those that cannot be traced: a power of two above their number.
const PLACES: usize = 32;
const _: () = assert!(Headings::CODES < PLACES, "each heading has its place");

/// Sorts rays by where they are heading, then traces them in tiles.
#[inline(always)]
fn fans<S: Simd, M: Mode, T: Traceable>(
    simd: S,
    target: &T,
    rays: &RayBatch,
    masks: &Masks,
    answers: &mut impl Answers,
    counters: &mut Counters,
) {
    let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
    let (mut codes, mut order) = ([0u8; FAN], [0u32; FAN]);
    for window in (0..rays.len()).step_by(FAN) {
        let count = FAN.min(rays.len() - window);
        let mut ends = [0u32; PLACES];
        for first in (0..count).step_by(TILE) {
            let sound = tile.load(simd, rays, window + first, &mut nearest);
            let of_tile = tile.headings(simd).codes(simd, sound);
            for (code, &of_ray) in codes[first..count].iter_mut().zip(&of_tile) {
                *code = of_ray as u8;
                ends[of_ray as usize % PLACES] += 1;
            }
        }
        let mut sum = 0;
        for end in &mut ends {
            sum += *end;
            *end = sum - *end;
        }
        for (i, &code) in codes[..count].iter().enumerate() {
            let place = &mut ends[code as usize % PLACES];
            order[*place as usize % FAN] = (window + i) as u32;
            *place += 1;
        }
        // The unsound ones come last and are left out.
        let sound = ends[Headings::CODES - 1] as usize;
        let mut from = 0;
        for &end in &ends[..Headings::CODES] {
            let end = end as usize;
            while from < end {
                let some = &order[from..end.min(from + TILE)];
                tile.pick(rays, some, &mut nearest);
                let active = all(some.len());
                let place = |i: usize| some[i] as usize;
                masks.tile::<S, M, T>(simd, target, &mut tile, active, false, place, &mut nearest, counters);
                each(active & nearest.hit(simd), |i| answers.one(some[i] as usize, &nearest.get(i)));
                from += some.len();
            }
        }
        debug_assert_eq!(from, sound, "every sound ray was traced");
    }
}
