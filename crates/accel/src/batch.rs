// SPDX-License-Identifier: GPL-3.0-or-later
//! From queries to kernels: the only place where this crate dispatches on the CPU.
//! Source: original.
//!
//! The way of a coherent batch: `intersect` -> `dispatch!` -> `tiles` (one pass over the batch, 64 rays at a time) ->
//! `Traceable::tile` (the scene's top tree) -> `ObjectTree::search_tile` (parts rays of different headings) -> `sweep` of
//! the kd-tree or the BVH. The way of a single ray: `closest` -> `dispatch!` -> `Traceable::single` ->
//! `ObjectTree::search` -> `search` of the index. Everything from `tiles` and `single` on is `#[inline(always)]` or
//! entered by `vectorize`, or lanes become calls.

use gnurt_simd::{Level, Simd, dispatch};

use crate::nearest::{AnyHit, Closest, Mode, Nearest};
use crate::tile::{NearestTile, RayTile, TILE};
use crate::{Coherence, Counters, Hit, HitBatch, Query, Ray, RayBatch, Record};

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
    let write = |i: usize, nearest: &Nearest| hits.set(i, target.hit(nearest));
    trace::<Closest, T>(target, query, rays, write, record);
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
    trace::<AnyHit, T>(target, query, rays, |i, _| occluded[i] = true, record);
}

/// `write` gets those that hit.
fn trace<M: Mode, T: Traceable>(
    target: &T,
    query: &Query,
    rays: &RayBatch,
    mut write: impl FnMut(usize, &Nearest),
    record: &mut Record,
) {
    let Record { counters, costs } = record;
    let write = &mut write;
    if query.coherence == Coherence::Coherent && costs.is_none() {
        dispatch!(query.level, simd => tiles::<_, M, T>(simd, target, rays, write, counters));
    } else {
        dispatch!(query.level, simd => singles::<_, M, T>(simd, target, rays, write, counters, costs));
    }
    counters.rays += rays.len() as u64;
}

/// Traces rays singly, and notes what each costs where the record asks for it.
#[inline(always)]
fn singles<S: Simd, M: Mode, T: Traceable>(
    simd: S,
    target: &T,
    rays: &RayBatch,
    write: &mut impl FnMut(usize, &Nearest),
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
                    write(first + i, &found);
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
    write: &mut impl FnMut(usize, &Nearest),
    counters: &mut Counters,
) {
    let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
    for first in (0..rays.len()).step_by(TILE) {
        let mut active = tile.load(simd, rays, first, &mut nearest);
        target.tile::<S, M>(simd, &tile, active, &mut nearest, counters);
        while active != 0 {
            let i = active.trailing_zeros() as usize;
            active &= active - 1;
            let nearest = nearest.get(i);
            if nearest.is_hit() {
                write(first + i, &nearest);
            }
        }
    }
}
