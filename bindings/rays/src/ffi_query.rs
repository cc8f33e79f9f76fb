// SPDX-License-Identifier: GPL-3.0-or-later
//! The queries of `gnurt/rays.h`. See include/gnurt/rays.h. Rays are gathered some thousand at a time;
//! results are those of single rays, for any number of threads. Tests: `tests/c/rays.c`.

use std::cell::Cell;
use std::ffi::{c_int, c_uint, c_void};

use gnurt_accel::doubles::DoubleRay;
use gnurt_accel::{Coherence, Hit, HitBatch, PointHit, Query, Ray, Ray64, Threads};
use rayon::prelude::*;

use crate::ffi_catch::{self, Thrown};
use crate::ffi_columns::{Access, Array, HitArrays, Places, Rows, Written};
use crate::ffi_rays::{built, called, with_threads};
use crate::found::{Found, normal};
use crate::ray_scene::{Built, RayScene, query_tree};

/// Rays that are gathered at a time.
const SHARE: usize = 1 << 16;

/// As many rays or fewer are traced where they are: lists of them and of their hits would take longer than they do.
const FEW: usize = 8;

/// `gnurt_rays`.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct RaysIn {
    count: usize,
    origins: Array,
    directions: Array,
    t_near: Array,
    t_far: Array,
    masks: Array,
}

/// `gnurt_candidate`.
#[repr(C)]
pub(crate) struct Candidate {
    ray: usize,
    t: f32,
    u: f32,
    v: f32,
    prim_id: u32,
    geom_id: u32,
    inst_id: u32,
}

type Filter = unsafe extern "C-unwind" fn(*mut c_void, usize, *const Candidate, *mut c_int);

/// `gnurt_query`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct QueryIn {
    threads: c_uint,
    coherent: c_int,
    filter: Option<Filter>,
    user: *mut c_void,
}

/// Rays to be read.
struct Rays {
    count: usize,
    origins: Rows,
    directions: Rows,
    t_near: Option<Rows>,
    t_far: Option<Rows>,
    masks: Option<Rows>,
}

impl Rays {
    /// # Safety
    /// Rays whose arrays are readable, or null.
    unsafe fn new(rays: *const RaysIn) -> Result<Self, String> {
        // SAFETY: passed on.
        let rays = unsafe { rays.as_ref() }.ok_or("rays: a null pointer")?;
        let count = rays.count;
        let read = |array: &Array, width: usize, access: Access, what: &str| -> Result<Rows, String> {
            // SAFETY: passed on.
            let rows = unsafe { Rows::new(array, width, access, what)? };
            if rows.len() != count && rows.len() != 1 {
                return Err(format!("{what}: {} rows for {count} rays", rows.len()));
            }
            Ok(rows)
        };
        let optional = |array: &Array, access: Access, what: &str| {
            (!array.data.is_null()).then(|| read(array, 1, access, what)).transpose()
        };
        Ok(Self {
            count,
            origins: read(&rays.origins, 3, Access::Floats, "origins")?,
            directions: read(&rays.directions, 3, Access::Floats, "directions")?,
            t_near: optional(&rays.t_near, Access::Floats, "t_near")?,
            t_far: optional(&rays.t_far, Access::Floats, "t_far")?,
            masks: optional(&rays.masks, Access::Indices, "masks")?,
        })
    }

    fn get(&self, i: usize) -> Ray64 {
        let number = |rows: &Option<Rows>, none: f32| {
            rows.as_ref().map_or(none, |rows| rows.numbers::<1>(i)[0] as f32)
        };
        Ray64 {
            t_near: number(&self.t_near, 0.0),
            t_far: number(&self.t_far, f32::INFINITY),
            mask: self.masks.as_ref().map_or(u32::MAX, |rows| rows.mask(i)),
            ..Ray64::new(self.origins.numbers(i), self.directions.numbers(i).map(|x| x as f32))
        }
    }

    /// In single precision. Not by way of the other: a value that was just written in parts would be read as a whole.
    #[inline(always)]
    fn single(&self, i: usize) -> Ray {
        let number = |rows: &Option<Rows>, none: f32| {
            rows.as_ref().map_or(none, |rows| rows.numbers::<1>(i)[0] as f32)
        };
        let ([x, y, z], [a, b, c]) = (self.origins.numbers(i), self.directions.numbers(i));
        Ray {
            org: [x as f32, y as f32, z as f32],
            t_near: number(&self.t_near, 0.0),
            dir: [a as f32, b as f32, c as f32],
            time: 0.0,
            t_far: number(&self.t_far, f32::INFINITY),
            mask: self.masks.as_ref().map_or(u32::MAX, |rows| rows.mask(i)),
        }
    }

    /// In double precision.
    fn double(&self, i: usize) -> DoubleRay {
        let number =
            |rows: &Option<Rows>, none: f64| rows.as_ref().map_or(none, |rows| rows.numbers::<1>(i)[0]);
        DoubleRay {
            org: self.origins.numbers(i),
            dir: self.directions.numbers(i),
            t_near: number(&self.t_near, 0.0),
            t_far: number(&self.t_far, f64::INFINITY),
            mask: self.masks.as_ref().map_or(u32::MAX, |rows| rows.mask(i)),
        }
    }

    fn doubles(&self, range: &std::ops::Range<usize>) -> Vec<DoubleRay> {
        range.clone().map(|i| self.double(i)).collect()
    }

    /// Whether they are traced where they are.
    fn are_few(&self, ray_query: &RayQuery) -> bool {
        self.count <= FEW && ray_query.filter.is_none()
    }

    /// In parts of this many rays.
    fn parts(&self, size: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
        let count = self.count;
        (0..count).step_by(size).map(move |first| first..(first + size).min(count))
    }
}

/// The kind of query.
struct RayQuery {
    query: Query,
    threads: usize,
    filter: Option<(Filter, *mut c_void)>,
    /// Whether the filter has thrown an exception: it is not called any more.
    thrown: Cell<bool>,
}

impl RayQuery {
    /// # Safety
    /// A query, or null.
    unsafe fn new(query: *const QueryIn) -> Self {
        // SAFETY: passed on.
        let Some(&QueryIn { threads, coherent, filter, user }) = (unsafe { query.as_ref() }) else {
            return Self { query: Query::default(), threads: 0, filter: None, thrown: Cell::new(false) };
        };
        let coherence = if coherent != 0 { Coherence::Coherent } else { Coherence::default() };
        let query = Query { coherence, ..Query::default() };
        let filter = filter.map(|filter| (filter, user));
        Self { query, threads: threads as usize, filter, thrown: Cell::new(false) }
    }
}

/// Queries a scene. An exception that a function of the program throws meanwhile is an error.
///
/// # Safety
/// A scene, and a query or null.
unsafe fn asking(
    scene: *const RayScene,
    query: *const QueryIn,
    job: impl FnOnce(&Built, &RayQuery) -> Result<(), String>,
) -> c_int {
    called(|| {
        // SAFETY: passed on.
        let (built, ray_query) = unsafe { (built(scene)?, RayQuery::new(query)) };
        let before = built.thrown();
        job(&built, &ray_query)?;
        if ray_query.thrown.get() {
            return Err(format!("filter: {Thrown}"));
        }
        // One of another thread's query of the same geometry counts for both.
        if built.thrown() != before { Err(format!("user: intersect: {Thrown}")) } else { Ok(()) }
    })
}

/// Calls a filter for hits of rays; none passes once it has thrown.
fn accepted(
    built: &Built,
    ray_query: &RayQuery,
    (filter, user): (Filter, *mut c_void),
    hits: &[(usize, Found)],
) -> Vec<bool> {
    if ray_query.thrown.get() {
        return vec![false; hits.len()];
    }
    let candidates: Vec<Candidate> = hits
        .iter()
        .map(|&(ray, Found { t, u, v, prim_id, geom_id, inst_id, leaf_id })| {
            let (geom_id, inst_id) = built.ids(geom_id, inst_id, leaf_id);
            let [t, u, v] = [t, u, v].map(|x| x as f32);
            Candidate { ray, t, u, v, prim_id, geom_id, inst_id }
        })
        .collect();
    let mut accept: Vec<c_int> = vec![1; hits.len()];
    if !hits.is_empty() {
        // SAFETY: the program gave the filter to be called like this; both arrays are of this length.
        let call = || unsafe { filter(user, hits.len(), candidates.as_ptr(), accept.as_mut_ptr()) };
        if ffi_catch::call(call).is_err() {
            ray_query.thrown.set(true);
            return vec![false; hits.len()];
        }
    }
    accept.into_iter().map(|accept| accept != 0).collect()
}

/// All hits of some rays, in order, each with its ray.
fn lists(
    built: &Built,
    rays: &Rays,
    range: std::ops::Range<usize>,
    query: &Query,
    threads: Threads,
) -> Vec<Vec<Found>> {
    let all = |hits: &mut Vec<Hit>, i: usize| {
        if let Some(scene) = &built.doubles {
            let mut hits = Vec::new();
            scene.first_hits(&rays.double(i), usize::MAX, &mut hits);
            return hits.into_iter().map(Found::from).collect();
        }
        query_tree!(built, tree => tree.all_hits(query, &rays.get(i), hits));
        hits.iter().map(|&hit| hit.into()).collect()
    };
    threads.run(|parallel| {
        if parallel {
            range.into_par_iter().with_min_len(32).map_init(Vec::new, all).collect()
        } else {
            let mut hits = Vec::new();
            range.map(|i| all(&mut hits, i)).collect()
        }
    })
}

/// First hits that the filter lets pass: rays that are undecided go round by round.
fn filtered(
    built: &Built,
    rays: &Rays,
    range: std::ops::Range<usize>,
    ray_query: &RayQuery,
    filter: (Filter, *mut c_void),
    threads: Threads,
) -> Vec<Option<Found>> {
    let lists = lists(built, rays, range.clone(), &ray_query.query, threads);
    let mut first = vec![None; range.len()];
    let mut open: Vec<usize> = (0..range.len()).collect();
    for round in 0.. {
        open.retain(|&i| lists[i].len() > round);
        if open.is_empty() {
            break;
        }
        let hits: Vec<(usize, Found)> = open.iter().map(|&i| (range.start + i, lists[i][round])).collect();
        let accept = accepted(built, ray_query, filter, &hits);
        let mut decided = accept.into_iter();
        open.retain(|&i| {
            let accept = decided.next() == Some(true);
            if accept {
                first[i] = Some(lists[i][round]);
            }
            !accept
        });
    }
    first
}

/// The output for a hit.
fn written(built: &Built, hit_arrays: &HitArrays, hit: &Found, at: impl FnOnce() -> [f64; 3]) -> Written {
    let Found { t, u, v, prim_id, .. } = *hit;
    let (geom_id, inst_id) = built.ids(hit.geom_id, hit.inst_id, hit.leaf_id);
    let normal = if hit_arrays.needs_normals() { normal(built, hit, at) } else { [0.0; 3] };
    Written { t, u, v, prim_id, geom_id, inst_id, normal }
}

/// The closest hit of one ray, without lists.
fn closest(built: &Built, rays: &Rays, query: &Query, i: usize) -> Option<Found> {
    if let Some(scene) = &built.doubles {
        return scene.intersect(&rays.double(i)).map(Found::from);
    }
    let hit = match rays.origins.is_double() {
        true => query_tree!(built, tree => tree.intersect_with(query, &rays.get(i))),
        false => query_tree!(built, tree => tree.intersect_with(query, &rays.single(i))),
    };
    hit.map(Found::from)
}

/// Whether one ray hits anything, without lists.
fn any(built: &Built, rays: &Rays, query: &Query, i: usize) -> bool {
    match &built.doubles {
        Some(scene) => scene.occluded(&rays.double(i)),
        None => query_tree!(built, tree => tree.occluded_with(query, &rays.get(i))),
    }
}

/// A hit of a batch, field by field.
#[inline(always)]
fn found_at(hits: &HitBatch, i: usize) -> Option<Found> {
    (hits.prim_id[i] != u32::MAX).then(|| Found {
        t: hits.t[i].into(),
        u: hits.u[i].into(),
        v: hits.v[i].into(),
        prim_id: hits.prim_id[i],
        geom_id: hits.geom_id[i],
        inst_id: hits.inst_id[i],
        leaf_id: hits.leaf_id[i],
    })
}

/// Queries each of a few rays. Apart from [`trace`], where more code makes copies of many rays slower.
#[inline(never)]
fn trace_few(built: &Built, rays: &Rays, query: &Query, take: &mut dyn FnMut(usize, Option<Found>)) {
    (0..rays.count).for_each(|i| take(i, closest(built, rays, query, i)));
}

/// Queries each part of the rays.
fn trace(
    built: &Built,
    rays: &Rays,
    ray_query: &RayQuery,
    threads: Threads,
    mut take: impl FnMut(usize, Option<Found>),
) {
    if rays.are_few(ray_query) {
        return trace_few(built, rays, &ray_query.query, &mut take);
    }
    let mut hits = HitBatch::default();
    for range in rays.parts(if ray_query.filter.is_some() { 4096 } else { SHARE }) {
        if let Some(filter) = ray_query.filter {
            let first = filtered(built, rays, range.clone(), ray_query, filter, threads);
            range.zip(first).for_each(|(i, hit)| take(i, hit));
            continue;
        }
        if let Some(scene) = &built.doubles {
            let hits = scene.intersect_batch(&rays.doubles(&range), threads);
            range.zip(hits).for_each(|(i, hit)| take(i, hit.map(Found::from)));
            continue;
        }
        if rays.origins.is_double() {
            let part: Vec<Ray64> = range.clone().map(|i| rays.get(i)).collect();
            query_tree!(built, tree => tree.intersect_rays(&ray_query.query, &part, threads, &mut hits));
        } else {
            let part: Vec<Ray> = range.clone().map(|i| rays.single(i)).collect();
            query_tree!(built, tree => tree.intersect_rays(&ray_query.query, &part, threads, &mut hits));
        }
        range.clone().for_each(|i| take(i, found_at(&hits, i - range.start)));
    }
}

/// Closest hits.
///
/// # Safety
/// As include/gnurt/rays.h says: a scene, rays, a query or null, places.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_intersect(
    scene: *const RayScene,
    rays: *const RaysIn,
    query: *const QueryIn,
    hits: *const Places<f32>,
) -> c_int {
    // SAFETY: passed on; nothing is written of paths without levels.
    unsafe { gnurt_intersect_paths(scene, rays, query, hits, 0, std::ptr::null_mut()) }
}

/// Closest hits, with all instances that contain each.
///
/// # Safety
/// As [`gnurt_intersect`], with room for `levels` ids for each ray.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_intersect_paths(
    scene: *const RayScene,
    rays: *const RaysIn,
    query: *const QueryIn,
    hits: *const Places<f32>,
    levels: usize,
    paths: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    let hits = unsafe { hits.as_ref() }.map(|places| HitArrays::Single(*places));
    // SAFETY: passed on.
    unsafe { intersect(scene, rays, query, hits, levels, paths) }
}

/// The same in double precision.
///
/// # Safety
/// As [`gnurt_intersect_paths`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_intersect64(
    scene: *const RayScene,
    rays: *const RaysIn,
    query: *const QueryIn,
    hits: *const Places<f64>,
    levels: usize,
    paths: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    let hits = unsafe { hits.as_ref() }.map(|places| HitArrays::Double(*places));
    // SAFETY: passed on.
    unsafe { intersect(scene, rays, query, hits, levels, paths) }
}

/// # Safety
/// As [`gnurt_intersect_paths`].
unsafe fn intersect(
    scene: *const RayScene,
    rays: *const RaysIn,
    query: *const QueryIn,
    hits: Option<HitArrays>,
    levels: usize,
    paths: *mut u32,
) -> c_int {
    let job = |built: &Built, ray_query: &RayQuery| {
        // SAFETY: passed on.
        let rays = unsafe { Rays::new(rays)? };
        let hit_arrays = hits.ok_or("hits: a null pointer")?;
        if levels > 0 && paths.is_null() {
            return Err(format!("paths: a null pointer for {levels} levels"));
        }
        with_threads(ray_query.threads, rays.count, |threads| {
            trace(built, &rays, ray_query, threads, |i, hit| {
                let found = hit.map_or(Written::MISS, |hit| {
                    written(built, &hit_arrays, &hit, || {
                        let ray = rays.get(i);
                        ray.at(hit.t as f32)
                    })
                });
                // SAFETY: there is a place for each ray.
                unsafe { hit_arrays.set(i, &found) };
                if levels > 0 {
                    let mut path = hit.map(|hit| built.path(hit.leaf_id)).unwrap_or_default();
                    path.resize(levels, u32::MAX);
                    // SAFETY: there is room for as many ids for each ray.
                    unsafe { paths.add(i * levels).copy_from_nonoverlapping(path.as_ptr(), levels) };
                }
            });
        });
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { asking(scene, query, job) }
}

/// Whether anything is hit.
///
/// # Safety
/// As [`gnurt_intersect`], with room for a byte for each ray.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_occluded(
    scene: *const RayScene,
    rays: *const RaysIn,
    query: *const QueryIn,
    occluded: *mut u8,
) -> c_int {
    let job = |built: &Built, ray_query: &RayQuery| {
        // SAFETY: passed on.
        let rays = unsafe { Rays::new(rays)? };
        if occluded.is_null() {
            return Err("occluded: a null pointer".into());
        }
        // SAFETY: passed on.
        let set = |i: usize, is_hit: bool| unsafe { occluded.add(i).write(u8::from(is_hit)) };
        with_threads(ray_query.threads, rays.count, |threads| {
            if ray_query.filter.is_some() {
                return trace(built, &rays, ray_query, threads, |i, hit| set(i, hit.is_some()));
            }
            if rays.are_few(ray_query) {
                return (0..rays.count).for_each(|i| set(i, any(built, &rays, &ray_query.query, i)));
            }
            let mut answers = Vec::new();
            for range in rays.parts(SHARE) {
                if let Some(scene) = &built.doubles {
                    let found = scene.occluded_batch(&rays.doubles(&range), threads);
                    range.zip(found).for_each(|(i, is_hit)| set(i, is_hit));
                    continue;
                }
                let part: Vec<Ray64> = range.clone().map(|i| rays.get(i)).collect();
                query_tree!(built, tree => tree.occluded_rays(&ray_query.query, &part, threads, &mut answers));
                range.zip(&answers).for_each(|(i, &is_hit)| set(i, is_hit));
            }
        });
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { asking(scene, query, job) }
}

/// All hits.
///
/// # Safety
/// As [`gnurt_intersect`], with room for an end for each ray, and for `capacity` hits.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_all_hits(
    scene: *const RayScene,
    rays: *const RaysIn,
    query: *const QueryIn,
    most: usize,
    ends: *mut usize,
    capacity: usize,
    hits: *const Places<f32>,
) -> c_int {
    // SAFETY: passed on.
    let hits = unsafe { hits.as_ref() }.map(|places| HitArrays::Single(*places));
    // SAFETY: passed on.
    unsafe { all_hits(scene, rays, query, most, ends, capacity, hits) }
}

/// All hits, in double precision.
///
/// # Safety
/// As [`gnurt_all_hits`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_all_hits64(
    scene: *const RayScene,
    rays: *const RaysIn,
    query: *const QueryIn,
    most: usize,
    ends: *mut usize,
    capacity: usize,
    hits: *const Places<f64>,
) -> c_int {
    // SAFETY: passed on.
    let hits = unsafe { hits.as_ref() }.map(|places| HitArrays::Double(*places));
    // SAFETY: passed on.
    unsafe { all_hits(scene, rays, query, most, ends, capacity, hits) }
}

/// # Safety
/// As [`gnurt_all_hits`].
unsafe fn all_hits(
    scene: *const RayScene,
    rays: *const RaysIn,
    query: *const QueryIn,
    most: usize,
    ends: *mut usize,
    capacity: usize,
    hits: Option<HitArrays>,
) -> c_int {
    let job = |built: &Built, ray_query: &RayQuery| {
        // SAFETY: passed on.
        let rays = unsafe { Rays::new(rays)? };
        if ends.is_null() {
            return Err("ends: a null pointer".into());
        }
        let hit_arrays = hits.as_ref();
        if hit_arrays.is_none() && capacity > 0 {
            return Err(format!("hits: a null pointer for {capacity} hits"));
        }
        let most = if most == 0 { usize::MAX } else { most };
        let mut end = 0;
        with_threads(ray_query.threads, rays.count, |threads| {
            for range in rays.parts(4096) {
                let lists = lists(built, &rays, range.clone(), &ray_query.query, threads);
                let flat: Vec<(usize, Found)> = range
                    .clone()
                    .zip(&lists)
                    .flat_map(|(i, hits)| hits.iter().map(move |&hit| (i, hit)))
                    .collect();
                let accept = match ray_query.filter {
                    Some(filter) => accepted(built, ray_query, filter, &flat),
                    None => vec![true; flat.len()],
                };
                let mut accept = accept.into_iter();
                for (i, list) in range.zip(&lists) {
                    let passed: Vec<&Found> = list.iter().filter(|_| accept.next() == Some(true)).collect();
                    for hit in passed.into_iter().take(most) {
                        if let Some(hit_arrays) = hit_arrays.filter(|_| end < capacity) {
                            let found = written(built, hit_arrays, hit, || rays.get(i).at(hit.t as f32));
                            // SAFETY: there is room for this many.
                            unsafe { hit_arrays.set(end, &found) };
                        }
                        end += 1;
                    }
                    // SAFETY: passed on.
                    unsafe { ends.add(i).write(end) };
                }
            }
        });
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { asking(scene, query, job) }
}

/// Crossings.
///
/// # Safety
/// As [`gnurt_intersect`], with room for a number for each ray.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_crossings(
    scene: *const RayScene,
    rays: *const RaysIn,
    query: *const QueryIn,
    counts: *mut u32,
) -> c_int {
    let job = |built: &Built, ray_query: &RayQuery| {
        // SAFETY: passed on.
        let rays = unsafe { Rays::new(rays)? };
        if counts.is_null() {
            return Err("counts: a null pointer".into());
        }
        with_threads(ray_query.threads, rays.count, |threads| {
            let mut answers = Vec::new();
            for range in rays.parts(SHARE) {
                if let Some(scene) = &built.doubles {
                    answers = scene.crossings_batch(&rays.doubles(&range), threads);
                } else {
                    let part: Vec<Ray64> = range.clone().map(|i| rays.get(i)).collect();
                    query_tree!(built, tree => tree.crossings_batch(&ray_query.query, &part, threads, &mut answers));
                }
                // SAFETY: passed on.
                range.zip(&answers).for_each(|(i, &count)| unsafe { counts.add(i).write(count) });
            }
        });
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { asking(scene, query, job) }
}

/// Points to be read, in parts.
///
/// # Safety
/// An array that is readable.
unsafe fn each_part(points: &Array, mut job: impl FnMut(usize, &[[f64; 3]])) -> Result<(), String> {
    // SAFETY: passed on.
    let rows = unsafe { Rows::new(points, 3, Access::Floats, "points")? };
    for first in (0..rows.len()).step_by(SHARE) {
        let last = (first + SHARE).min(rows.len());
        let part: Vec<[f64; 3]> = (first..last).map(|i| rows.numbers(i)).collect();
        job(first, &part);
    }
    Ok(())
}

/// Whether closed meshes contain points.
///
/// # Safety
/// As include/gnurt/rays.h says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_contains(
    scene: *const RayScene,
    points: Array,
    query: *const QueryIn,
    contained: *mut u8,
) -> c_int {
    let job = |built: &Built, ray_query: &RayQuery| {
        if contained.is_null() {
            return Err("contained: a null pointer".into());
        }
        let mut answers = Vec::new();
        with_threads(ray_query.threads, points.count, |threads| {
            let job = |first: usize, part: &[[f64; 3]]| {
                if let Some(scene) = &built.doubles {
                    answers = scene.contains_batch(part, ray_query.query.mask, threads);
                } else {
                    query_tree!(built, tree => tree.contains_batch(&ray_query.query, part, threads, &mut answers));
                }
                for (i, &is_in) in answers.iter().enumerate() {
                    // SAFETY: passed on.
                    unsafe { contained.add(first + i).write(u8::from(is_in)) }
                }
            };
            // SAFETY: passed on.
            unsafe { each_part(&points, job) }
        })
    };
    // SAFETY: passed on.
    unsafe { asking(scene, query, job) }
}

/// Signed distances.
///
/// # Safety
/// As include/gnurt/rays.h says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_signed_distances(
    scene: *const RayScene,
    points: Array,
    query: *const QueryIn,
    distances: *mut f64,
) -> c_int {
    let job = |built: &Built, ray_query: &RayQuery| {
        if distances.is_null() {
            return Err("distances: a null pointer".into());
        }
        let mut answers = Vec::new();
        with_threads(ray_query.threads, points.count, |threads| {
            let job = |first: usize, part: &[[f64; 3]]| {
                if let Some(scene) = &built.doubles {
                    answers = scene.signed_distance_batch(part, ray_query.query.mask, threads);
                } else {
                    query_tree!(built, tree => tree.signed_distance_batch(&ray_query.query, part, threads, &mut answers));
                }
                for (i, &distance) in answers.iter().enumerate() {
                    // SAFETY: passed on.
                    unsafe { distances.add(first + i).write(distance) }
                }
            };
            // SAFETY: passed on.
            unsafe { each_part(&points, job) }
        })
    };
    // SAFETY: passed on.
    unsafe { asking(scene, query, job) }
}

/// Nearest points.
///
/// # Safety
/// As include/gnurt/rays.h says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_closest_points(
    scene: *const RayScene,
    points: Array,
    radius: f64,
    query: *const QueryIn,
    nearest: *mut [f64; 3],
    hits: *const Places<f32>,
) -> c_int {
    // SAFETY: passed on.
    let hits = unsafe { hits.as_ref() }.map(|places| HitArrays::Single(*places));
    // SAFETY: passed on.
    unsafe { closest_points(scene, points, radius, query, nearest, hits) }
}

/// Nearest points, with distances, weights and normals in double precision.
///
/// # Safety
/// As include/gnurt/rays.h says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_closest_points64(
    scene: *const RayScene,
    points: Array,
    radius: f64,
    query: *const QueryIn,
    nearest: *mut [f64; 3],
    hits: *const Places<f64>,
) -> c_int {
    // SAFETY: passed on.
    let hits = unsafe { hits.as_ref() }.map(|places| HitArrays::Double(*places));
    // SAFETY: passed on.
    unsafe { closest_points(scene, points, radius, query, nearest, hits) }
}

/// # Safety
/// As include/gnurt/rays.h says.
unsafe fn closest_points(
    scene: *const RayScene,
    points: Array,
    radius: f64,
    query: *const QueryIn,
    nearest: *mut [f64; 3],
    hits: Option<HitArrays>,
) -> c_int {
    let job = |built: &Built, ray_query: &RayQuery| {
        with_threads(ray_query.threads, points.count, |threads| {
            let job = |first: usize, part: &[[f64; 3]]| {
                let answers = nearest_points(built, &ray_query.query, part, radius, threads);
                for (i, found) in answers.iter().enumerate() {
                    if !nearest.is_null() {
                        let point = found.map_or([f64::NAN; 3], |(_, point)| point);
                        // SAFETY: passed on.
                        unsafe { nearest.add(first + i).write_unaligned(point) }
                    }
                    let Some(hit_arrays) = &hits else { continue };
                    let shown = found
                        .map_or(Written::MISS, |(hit, point)| written(built, hit_arrays, &hit, || point));
                    // SAFETY: there is a place for each point.
                    unsafe { hit_arrays.set(first + i, &shown) };
                }
            };
            // SAFETY: passed on.
            unsafe { each_part(&points, job) }
        })
    };
    // SAFETY: passed on.
    unsafe { asking(scene, query, job) }
}

/// The nearest point of each, as a hit at its distance.
fn nearest_points(
    built: &Built,
    query: &Query,
    points: &[[f64; 3]],
    radius: f64,
    threads: Threads,
) -> Vec<Option<(Found, [f64; 3])>> {
    if let Some(scene) = &built.doubles {
        let all = scene.closest_points(points, radius, query.mask, threads);
        return all.into_iter().map(|near| near.map(|near| (near.into(), near.point))).collect();
    }
    let mut answers: Vec<Option<PointHit>> = Vec::new();
    query_tree!(built, tree => tree.closest_points(query, points, radius, threads, &mut answers));
    answers.into_iter().map(|near| near.map(|near| (near.into(), near.point))).collect()
}
