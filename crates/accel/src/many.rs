// SPDX-License-Identifier: GPL-3.0-or-later
//! A million rays in one call: rays in slices or other programs' arrays, traced in batches by the threads of a pool.
//! Each thread collects some rays at a time into a batch of its own, which costs a hundredth of tracing them.
//! Invariant: answers are those of single rays, bit for bit, on any threads; also for rays with
//! double-precision origins, which scenes trace one by one. Tests: `tests/surfaces/slices.rs`.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use gnurt_accel_core::threads::{Pieces, for_each};

use crate::slices::{HitSlices, RaySlices, SliceError, fits};
use crate::target::Target;
use crate::{AnyRay, HitBatch, Query, Ray, Ray64, RayBatch, Record, Threads, batch};

/// Rays that a thread traces at a time: whole tiles, enough of them to be sorted.
const SHARE: usize = 4096;

/// Where rays come from.
trait Rays: Sync {
    fn count(&self) -> usize;
    /// A ray, and its origin where that is no float.
    fn ray(&self, i: usize) -> (Ray, Option<[f64; 3]>);
    /// Appends some rays, of which none needs its origin in double precision.
    fn gather(&self, range: Range<usize>, rays: &mut RayBatch) {
        rays.extend(range.map(|i| self.ray(i).0));
    }
    /// Whether origins of some of these rays may be no floats.
    fn may_be_precise(&self, range: Range<usize>) -> bool;
}

impl Rays for RaySlices<'_> {
    fn count(&self) -> usize {
        self.len()
    }

    fn ray(&self, i: usize) -> (Ray, Option<[f64; 3]>) {
        self.get(i)
    }

    fn gather(&self, range: Range<usize>, rays: &mut RayBatch) {
        self.copy(range, rays);
    }

    fn may_be_precise(&self, _: Range<usize>) -> bool {
        self.has_doubles()
    }
}

impl<R: AnyRay + Sync> Rays for [R] {
    fn count(&self) -> usize {
        self.len()
    }

    fn ray(&self, i: usize) -> (Ray, Option<[f64; 3]>) {
        let ray = self[i].rounded();
        let is_float = |org: &[f64; 3]| (0..3).all(|k| f64::from(ray.org[k]) == org[k] || org[k].is_nan());
        (*ray, self[i].origin64().filter(|org| !is_float(org)))
    }

    fn may_be_precise(&self, range: Range<usize>) -> bool {
        self[range].iter().any(|ray| ray.origin64().is_some())
    }
}

/// State that a thread keeps.
#[derive(Default)]
struct Desk {
    rays: RayBatch,
    hits: HitBatch,
    occluded: Vec<bool>,
    record: Record,
    /// Rays of the batch whose origins are no floats.
    precise: Vec<(usize, Ray64)>,
}

impl Desk {
    /// Takes some rays; those that are traced separately leave one that hits nothing.
    fn gather(&mut self, rays: &(impl Rays + ?Sized), range: Range<usize>, are_origins_precise: bool) {
        self.rays.clear();
        self.precise.clear();
        rays.gather(range.clone(), &mut self.rays);
        if !(are_origins_precise && rays.may_be_precise(range.clone())) {
            return;
        }
        for (index, i) in range.enumerate() {
            if let (Ray { t_near, dir, t_far, mask, time, .. }, Some(org)) = rays.ray(i) {
                self.precise.push((index, Ray64 { org, t_near, dir, t_far, mask, time }));
                (self.rays.t_near[index], self.rays.t_far[index]) = (1.0, 0.0);
            }
        }
    }
}

/// Calls `trace` with each part, in the threads that there are.
fn share<P: Send>(threads: Threads, parts: Vec<P>, trace: impl Fn(&mut Desk, P) + Send + Sync) {
    threads.run(|parallel| {
        let desks = Mutex::new(Vec::new());
        let lock = || desks.lock().unwrap_or_else(PoisonError::into_inner);
        let mut parts: Vec<Option<P>> = parts.into_iter().map(Some).collect();
        let parts = Pieces::new(&mut parts, 1);
        for_each(parallel, parts.count(), &|i| {
            let part = parts.lock(i)[0].take().expect("each is taken once");
            let free = lock().pop();
            let mut desk: Desk = free.unwrap_or_default();
            trace(&mut desk, part);
            lock().push(desk);
        });
    });
}

impl Target<'_> {
    /// Closest hits of all.
    fn hits_of(
        self,
        query: &Query,
        rays: &(impl Rays + ?Sized),
        threads: Threads,
        slices: &mut HitSlices,
    ) -> Result<(), SliceError> {
        slices.check(rays.count())?;
        share(threads, slices.parts(SHARE), |desk, (range, mut slices)| {
            desk.gather(rays, range.clone(), self.minds_origins());
            batch::intersect(self, query, &desk.rays, &mut desk.hits, &mut desk.record);
            for (index, ray) in &desk.precise {
                if let Some(hit) = self.closest(query, ray) {
                    desk.hits.set(*index, hit);
                }
            }
            slices.copy(&desk.hits);
            for (index, normal) in slices.normal.iter_mut().flat_map(|normals| normals.iter_mut()).enumerate()
            {
                let found = desk.hits.get(index).and_then(|hit| {
                    let (ray, origin) = rays.ray(range.start + index);
                    let org = origin.unwrap_or_else(|| ray.org.map(f64::from));
                    let at = |k: usize| org[k] + f64::from(hit.t) * f64::from(ray.dir[k]);
                    self.normal(&hit, Some([at(0), at(1), at(2)]), ray.time)
                });
                *normal = found.unwrap_or_default();
            }
        });
        Ok(())
    }

    /// Whether each hits anything.
    fn occlusion_of(
        self,
        query: &Query,
        rays: &(impl Rays + ?Sized),
        threads: Threads,
        occluded: &mut [bool],
    ) {
        let parts: Vec<_> = occluded.chunks_mut(SHARE).enumerate().collect();
        share(threads, parts, |desk, (i, part)| {
            desk.gather(rays, i * SHARE..i * SHARE + part.len(), self.minds_origins());
            batch::occluded(self, query, &desk.rays, &mut desk.occluded, &mut desk.record);
            for (index, ray) in &desk.precise {
                desk.occluded[*index] = self.any(query, ray);
            }
            part.copy_from_slice(&desk.occluded);
        });
    }

    /// A directly queried object rounds origins.
    fn minds_origins(self) -> bool {
        matches!(self, Self::Scene(_))
    }

    /// Closest hits of rays in a slice.
    pub(crate) fn hits_of_slice<R: AnyRay + Sync>(
        self,
        query: &Query,
        rays: &[R],
        threads: Threads,
        hits: &mut HitBatch,
    ) {
        hits.reset(rays.len());
        let HitBatch { t, u, v, prim_id, geom_id, inst_id, leaf_id } = hits;
        let mut slices = HitSlices {
            t: Some(t),
            u: Some(u),
            v: Some(v),
            prim_id: Some(prim_id),
            geom_id: Some(geom_id),
            inst_id: Some(inst_id),
            leaf_id: Some(leaf_id),
            normal: None,
        };
        self.hits_of(query, rays, threads, &mut slices).expect("they were made for these rays");
    }

    /// Whether each of a slice hits anything.
    pub(crate) fn occlusion_of_slice<R: AnyRay + Sync>(
        self,
        query: &Query,
        rays: &[R],
        threads: Threads,
        occluded: &mut Vec<bool>,
    ) {
        occluded.clear();
        occluded.resize(rays.len(), false);
        self.occlusion_of(query, rays, threads, occluded);
    }

    /// Closest hits of borrowed rays.
    pub(crate) fn hits_of_slices(
        self,
        query: &Query,
        rays: &RaySlices,
        threads: Threads,
        hits: &mut HitSlices,
    ) -> Result<(), SliceError> {
        self.hits_of(query, rays, threads, hits)
    }

    /// Whether each borrowed ray hits anything.
    pub(crate) fn occlusion_of_slices(
        self,
        query: &Query,
        rays: &RaySlices,
        threads: Threads,
        occluded: &mut [bool],
    ) -> Result<(), SliceError> {
        fits("occluded", occluded.len(), rays.len())?;
        self.occlusion_of(query, rays, threads, occluded);
        Ok(())
    }
}
