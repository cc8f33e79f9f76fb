// SPDX-License-Identifier: GPL-3.0-or-later
//! From queries to kernels: the only place where this crate dispatches on the CPU.
//! Source: original.
//!
//! The way of a coherent batch: `intersect` -> `dispatch!` -> `tiles` (one pass over the batch, 64 rays at a time) ->
//! `Traceable::tile` (the scene's top tree) -> `ObjectTree::search_tile` (parts rays of different headings) -> `sweep` of
//! the kd-tree or the BVH. The way of a single ray: `closest` -> `dispatch!` -> `Traceable::single` ->
//! `ObjectTree::search` -> `search` of the index. Everything from `tiles` and `single` on is `#[inline(always)]` or
//! entered by `vectorize`, or lanes become calls.

use gnurt_simd::{Level, Simd, dispatch, f32x16, prelude::*, u32x16};

use crate::nearest::{AnyHit, Closest, Mode, Nearest};
use crate::tile::{Headings, LANES, NearestTile, RayTile, TILE, all, chunk};
use crate::{Coherence, Counters, Hit, HitBatch, INVALID_ID, Query, Ray, RayBatch, Record};

/// What rays can be sent into: an object or a scene.
pub(crate) trait Traceable {
    /// Improves `nearest`; the ray is sound.
    fn single<S: Simd, M: Mode>(&self, simd: S, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters);
    /// The same for those rays of a tile that are in `active`.
    fn tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    );
    /// Ids of what was hit.
    fn hit(&self, nearest: &Nearest) -> Hit;
    /// The instance, where all hits have the same one and their numbers are `prim_id`s of its only mesh.
    fn only_mesh(&self) -> Option<u32>;
}

/// One ray's closest hit.
#[inline]
pub(crate) fn closest<T: Traceable>(target: &T, level: Level, ray: &Ray) -> Option<Hit> {
    let (mut nearest, mut counters) = (Nearest::none(ray.t_far), Counters::default());
    if ray.is_sound() {
        dispatch!(level, simd => target.single::<_, Closest>(simd, ray, &mut nearest, &mut counters));
    }
    nearest.is_hit().then(|| target.hit(&nearest))
}

/// Whether one ray hits anything.
#[inline]
pub(crate) fn any<T: Traceable>(target: &T, level: Level, ray: &Ray) -> bool {
    let (mut nearest, mut counters) = (Nearest::none(ray.t_far), Counters::default());
    if ray.is_sound() {
        dispatch!(level, simd => target.single::<_, AnyHit>(simd, ray, &mut nearest, &mut counters));
    }
    nearest.is_hit()
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
            _ => each(active & nearest.hit(simd), |i| self.one(first + i, &nearest.get(i))),
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

/// Calls `f` with the place of every bit.
#[inline(always)]
fn each(mut bits: u64, mut f: impl FnMut(usize)) {
    while bits != 0 {
        f(bits.trailing_zeros() as usize);
        bits &= bits - 1;
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
    let Record { counters, costs } = record;
    match query.coherence {
        Coherence::Coherent if costs.is_none() => {
            dispatch!(query.level, simd => tiles::<_, M, T>(simd, target, rays, answers, counters));
        }
        Coherence::Fanned if costs.is_none() => {
            dispatch!(query.level, simd => fans::<_, M, T>(simd, target, rays, answers, counters));
        }
        _ => {
            dispatch!(query.level, simd => singles::<_, M, T>(simd, target, rays, answers, counters, costs));
        }
    }
    counters.rays += rays.len() as u64;
}

/// Traces rays singly, and notes what each costs where the record asks for it.
#[inline(always)]
fn singles<S: Simd, M: Mode, T: Traceable>(
    simd: S,
    target: &T,
    rays: &RayBatch,
    answers: &mut impl Answers,
    counters: &mut Counters,
    costs: &mut Option<Vec<u32>>,
) {
    if let Some(costs) = costs {
        costs.clear();
        costs.reserve(rays.len());
    }
    let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
    for first in (0..rays.len()).step_by(TILE) {
        let sound = tile.load(simd, rays, first, &mut nearest);
        for i in 0..TILE.min(rays.len() - first) {
            let before = counters.nodes + counters.triangles;
            if sound >> i & 1 == 1 {
                let mut found = Nearest::none(nearest.t[i]);
                target.single::<S, M>(simd, &tile.ray(i, found.t), &mut found, counters);
                if found.is_hit() {
                    answers.one(first + i, &found);
                }
            }
            if let Some(costs) = costs {
                let spent = counters.nodes + counters.triangles - before;
                costs.push(spent.min(u64::from(u32::MAX)) as u32);
            }
        }
    }
}

/// Traces rays in tiles of 64 neighbours.
#[inline(always)]
fn tiles<S: Simd, M: Mode, T: Traceable>(
    simd: S,
    target: &T,
    rays: &RayBatch,
    answers: &mut impl Answers,
    counters: &mut Counters,
) {
    let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
    for first in (0..rays.len()).step_by(TILE) {
        let active = tile.load(simd, rays, first, &mut nearest);
        target.tile::<S, M>(simd, &tile, active, &mut nearest, counters);
        answers.tile(simd, first, active, &nearest);
    }
}

/// Rays that are sorted at a time.
const FAN: usize = 2048;

/// Sorts rays by where they are heading, then traces them in tiles.
#[inline(always)]
fn fans<S: Simd, M: Mode, T: Traceable>(
    simd: S,
    target: &T,
    rays: &RayBatch,
    answers: &mut impl Answers,
    counters: &mut Counters,
) {
    let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
    let (mut codes, mut order) = ([0u8; FAN], [0u32; FAN]);
    for window in (0..rays.len()).step_by(FAN) {
        let count = FAN.min(rays.len() - window);
        let mut ends = [0u32; Headings::CODES + 1];
        for first in (0..count).step_by(TILE) {
            let sound = tile.load(simd, rays, window + first, &mut nearest);
            let ways = tile.headings(simd);
            for i in 0..TILE.min(count - first) {
                let code = if sound >> i & 1 == 1 { ways.code(i) } else { Headings::CODES };
                codes[first + i] = code as u8;
                ends[code] += 1;
            }
        }
        let mut sum = 0;
        for end in &mut ends {
            sum += *end;
            *end = sum - *end;
        }
        for i in 0..count {
            let place = &mut ends[codes[i] as usize % (Headings::CODES + 1)];
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
                target.tile::<S, M>(simd, &tile, active, &mut nearest, counters);
                each(active & nearest.hit(simd), |i| answers.one(some[i] as usize, &nearest.get(i)));
                from += some.len();
            }
        }
        debug_assert_eq!(from, sound, "every sound ray was traced");
    }
}
