// SPDX-License-Identifier: GPL-3.0-or-later
//! More camera rays for the first samples of a pixel, without paths, most of them where camera rays of a pixel differ or those of
//! a pixel beside it: albedo, normal and directly visible light at edges have little noise then, which
//! no filter can take out of a few samples. They cost little beside paths.
//! Space: world. Invariant: colours and other layers do not change. Tests: crates/render/tests/seen.rs.

use std::ops::Range;

use gnurt_accel::Coherence;
use gnurt_scene::RayMask;

use crate::camera_batch::CameraBatch;
use crate::film::TileFilm;
use crate::job::Job;
use crate::seen::{TileSeen, follows};
use crate::tracer::BatchTracer;

/// Samples that come with more rays, and the number of rays for each: everywhere, and at edges.
const FIRST: u32 = 8;
const EVERYWHERE: u32 = 1;
const AT_EDGES: u32 = 8;
/// The first rays of both kinds, as samples of their pixels: no path has these numbers. Each block of eight is stratified.
const BEYOND: [u32; 2] = [1 << 24, 1 << 25];

/// Adds those of `sample`, which was the last one, to the layers of mirrors and glass, if a tile has them.
pub(crate) fn take(job: &Job, tile: &mut TileFilm, tracer: &mut BatchTracer, sample: u32) {
    if job.options.pixel_centres || sample >= FIRST || !follows(tracer) {
        return;
    }
    let shown: Vec<[u32; 2]> = tile.pixels().collect();
    let Some(seen) = tile.aovs.as_mut().and_then(|aovs| aovs.seen.as_mut()) else { return };
    let all: Vec<usize> = (0..shown.len()).collect();
    look(job, seen, tracer, (&shown, &all), rays(0, sample, EVERYWHERE));
    let edges = edges(tile.rect, &shown, &seen.differs);
    look(job, seen, tracer, (&shown, &edges), rays(1, sample, AT_EDGES));
}

fn rays(kind: usize, sample: u32, count: u32) -> Range<u32> {
    let first = BEYOND[kind] + sample * count;
    first..first + count
}

/// Takes rays through some of the pixels `shown`.
fn look(
    job: &Job,
    seen: &mut TileSeen,
    tracer: &mut BatchTracer,
    (shown, some): (&[[u32; 2]], &[usize]),
    rays: Range<u32>,
) {
    if some.is_empty() {
        return;
    }
    let mut batch = CameraBatch::default();
    let count = rays.len();
    job.camera_rays(some.iter().map(|&i| shown[i]), rays, &mut batch);
    let CameraBatch { rays, keys, hits, .. } = &mut batch;
    tracer.intersect_into(RayMask::CAMERA, rays, keys, Coherence::Coherent, hits);
    tracer.stats.camera_rays += keys.len() as u64;
    for k in 0..count {
        let first = k * some.len();
        let lanes = first..first + some.len();
        seen.add_views(tracer, batch.met(), lanes, false, &|lane| some[lane - first]);
    }
}

/// The pixels of a tile where camera rays differ, and those beside them: a sliver may be in a pixel that no ray has met.
fn edges([x0, y0, x1, y1]: [u32; 4], shown: &[[u32; 2]], differs: &[bool]) -> Vec<usize> {
    let width = (x1 - x0) as usize;
    let mut near = vec![false; width * (y1 - y0) as usize];
    for (&[x, y], _) in shown.iter().zip(differs).filter(|(_, differs)| **differs) {
        for y in y.saturating_sub(1).max(y0)..(y + 2).min(y1) {
            for x in x.saturating_sub(1).max(x0)..(x + 2).min(x1) {
                near[(y - y0) as usize * width + (x - x0) as usize] = true;
            }
        }
    }
    let is_near = |&i: &usize| near[(shown[i][1] - y0) as usize * width + (shown[i][0] - x0) as usize];
    (0..shown.len()).filter(is_near).collect()
}
