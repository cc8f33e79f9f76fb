// SPDX-License-Identifier: GPL-3.0-or-later
//! More camera rays for the first samples of a pixel, without paths. Most of them are where camera rays of a pixel differ, above all
//! at edges of lamps: albedo, normal and directly visible light have little noise there then, which no filter can
//! take out of a few samples.
//! Space: world. Invariant: colours and other layers do not change. Tests: crates/render/tests/seen.rs.

use std::ops::Range;

use gnurt_accel::Coherence;
use gnurt_scene::RayMask;

use crate::camera_batch::CameraBatch;
use crate::film::TileFilm;
use crate::job::Job;
use crate::tracer::BatchTracer;

use super::view::Differs;
use super::{TileSeen, follows};

/// Samples that come with more rays.
const FIRST: u32 = 8;
/// The number of rays for each: everywhere, where surfaces differ, and where directly visible light does.
const MORE: [u32; 3] = [1, 2, 8];
/// The first rays of each kind, as samples of their pixels: no path has these numbers. Each block of eight is stratified.
const BEYOND: [u32; 3] = [1 << 24, 2 << 24, 3 << 24];

/// Adds those of `sample`, which was the last one, to the layers of mirrors and glass, if a tile has them.
pub(crate) fn take(job: &Job, tile: &mut TileFilm, tracer: &mut BatchTracer, sample: u32) {
    if !job.options.seen || job.options.pixel_centres || sample >= FIRST || !follows(tracer) {
        return;
    }
    let shown: Vec<[u32; 2]> = tile.pixels().collect();
    let Some(seen) = tile.aovs.as_mut().and_then(|aovs| aovs.seen.as_mut()) else { return };
    let all: Vec<usize> = (0..shown.len()).collect();
    look(job, seen, tracer, (&shown, &all), rays(0, sample));
    let near = near_light(tile.rect, &shown, &seen.differs);
    let surfaces = |i: &usize| seen.differs[*i] == Differs::Surface && !near[*i];
    let kinds =
        [all.iter().copied().filter(surfaces).collect(), all.into_iter().filter(|&i| near[i]).collect()];
    for (kind, some) in (1..).zip::<[Vec<usize>; 2]>(kinds) {
        look(job, seen, tracer, (&shown, &some), rays(kind, sample));
    }
}

fn rays(kind: usize, sample: u32) -> Range<u32> {
    let first = BEYOND[kind] + sample * MORE[kind];
    first..first + MORE[kind]
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
    // Camera rays are those of samples.
    tracer.stats.secondary_rays += keys.len() as u64;
    for k in 0..count {
        let first = k * some.len();
        let lanes = first..first + some.len();
        seen.add_views(tracer, batch.met(), lanes, false, &|lane| some[lane - first]);
    }
}

/// Whether directly visible light differs in the pixels of a tile, or in one beside: a sliver may be in a pixel that no ray has met.
fn near_light([x0, y0, x1, y1]: [u32; 4], shown: &[[u32; 2]], differs: &[Differs]) -> Vec<bool> {
    let width = (x1 - x0) as usize;
    let mut near = vec![false; width * (y1 - y0) as usize];
    for (&[x, y], _) in shown.iter().zip(differs).filter(|(_, differs)| **differs == Differs::Light) {
        for y in y.saturating_sub(1).max(y0)..(y + 2).min(y1) {
            for x in x.saturating_sub(1).max(x0)..(x + 2).min(x1) {
                near[(y - y0) as usize * width + (x - x0) as usize] = true;
            }
        }
    }
    shown.iter().map(|[x, y]| near[(y - y0) as usize * width + (x - x0) as usize]).collect()
}
