// SPDX-License-Identifier: GPL-3.0-or-later
//! From queries to kernels: the only place where this crate dispatches on the CPU.
//! Source: original.
//!
//! The way of a coherent batch: `intersect` -> `dispatch!` -> `packets` (one pass over the batch, eight rays at a time)
//! -> `Traceable::packet` (the scene's top tree) -> `ObjectTree::search_packet` -> `Search::packet` (kd-tree) ->
//! `PreparedTriangles::meet_packet`. Everything from `packets` on is `#[inline(always)]`, or lanes become calls.
//! The way of a single ray: `closest` -> `Traceable::closest` -> `ObjectTree::search` -> `KdTree::walk` -> `meet`.

use gnurt_simd::{Simd, dispatch, prelude::*};

use crate::nearest::{AnyHit, Closest, Mode, Nearest};
use crate::packet::{NearestPacket, RayPacket, WIDTH};
use crate::{Coherence, Counters, Hit, HitBatch, Query, Ray, RayBatch, Record};

/// What rays can be sent into: an object or a scene.
pub(crate) trait Traceable {
    /// Improves `nearest`; the ray is sound.
    fn closest(&self, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters);
    /// Notes any hit in `nearest`; the ray is sound.
    fn any(&self, ray: &Ray, nearest: &mut Nearest, counters: &mut Counters);
    /// The same for the active lanes of a packet, of which there is at least one.
    fn packet<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayPacket<S>,
        nearest: &mut NearestPacket<S>,
        counters: &mut Counters,
    );
    /// Ids of what was hit.
    fn hit(&self, nearest: &Nearest) -> Hit;
}

/// One ray's closest hit.
pub(crate) fn closest<T: Traceable>(target: &T, ray: &Ray, counters: &mut Counters) -> Option<Hit> {
    let mut nearest = Nearest::none(ray.t_far);
    if ray.is_sound() {
        target.closest(ray, &mut nearest, counters);
    }
    nearest.is_hit().then(|| target.hit(&nearest))
}

/// Whether one ray hits anything.
pub(crate) fn any<T: Traceable>(target: &T, ray: &Ray, counters: &mut Counters) -> bool {
    let mut nearest = Nearest::none(ray.t_far);
    if ray.is_sound() {
        target.any(ray, &mut nearest, counters);
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
    if goes_in_packets(query, record) {
        let mut write = |i: usize, nearest: &Nearest| hits.set(i, target.hit(nearest));
        let counters = &mut record.counters;
        dispatch!(query.level, simd => packets::<_, Closest, _>(simd, target, rays, &mut write, counters));
    } else {
        one_by_one(rays, record, |i, ray, counters| {
            if let Some(hit) = closest(target, ray, counters) {
                hits.set(i, hit);
            }
        });
    }
    record.counters.rays += rays.len() as u64;
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
    if goes_in_packets(query, record) {
        let mut write = |i: usize, _: &Nearest| occluded[i] = true;
        let counters = &mut record.counters;
        dispatch!(query.level, simd => packets::<_, AnyHit, _>(simd, target, rays, &mut write, counters));
    } else {
        one_by_one(rays, record, |i, ray, counters| occluded[i] = any(target, ray, counters));
    }
    record.counters.rays += rays.len() as u64;
}

fn goes_in_packets(query: &Query, record: &Record) -> bool {
    query.coherence == Coherence::Coherent && record.costs.is_none()
}

/// Traces rays singly, and notes what each costs where the record asks for it.
fn one_by_one(rays: &RayBatch, record: &mut Record, mut trace: impl FnMut(usize, &Ray, &mut Counters)) {
    let spent = |counters: &Counters| counters.nodes + counters.triangles;
    if let Some(costs) = &mut record.costs {
        costs.clear();
        costs.reserve(rays.len());
    }
    for i in 0..rays.len() {
        let before = spent(&record.counters);
        trace(i, &rays.get(i), &mut record.counters);
        if let Some(costs) = &mut record.costs {
            costs.push((spent(&record.counters) - before).min(u64::from(u32::MAX)) as u32);
        }
    }
}

/// Traces rays in packets of eight neighbours; `write` gets those that hit.
#[inline(always)]
fn packets<S: Simd, M: Mode, T: Traceable>(
    simd: S,
    target: &T,
    rays: &RayBatch,
    write: &mut impl FnMut(usize, &Nearest),
    counters: &mut Counters,
) {
    let mut first = 0;
    while first < rays.len() {
        let (packet, t_far) = RayPacket::load(simd, rays, first);
        if packet.active.any_true() {
            let mut nearest = NearestPacket::none(simd, t_far);
            target.packet::<S, M>(simd, &packet, &mut nearest, counters);
            let mut active = packet.active.to_bitmask();
            while active != 0 {
                let i = active.trailing_zeros() as usize;
                active &= active - 1;
                let nearest = nearest.get(i);
                if nearest.is_hit() {
                    write(first + i, &nearest);
                }
            }
        }
        first += WIDTH;
    }
}
