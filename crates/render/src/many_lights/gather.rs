// SPDX-License-Identifier: GPL-3.0-or-later
//! All virtual lights on all points that a tile of camera rays sees.
//! Source: [Kel97]; rays with a common virtual light and neighbouring ends are traced together, as in
//! [WKB*02] and [SIP06], section 7. Space: world. Flow: neighbouring points become blocks of arrays. For each
//! block and each virtual light chosen for it (`chosen.rs`), in spatial order: one pass over the block in
//! lanes (`lanes.rs`), its shadow rays as one pencil from the light, sums in lanes. Cases without lanes
//! (other BSDFs, transparent surfaces, costs) go ray by ray.
//! Invariant: the light of a point depends on the other points of its tile only through the choice of lights,
//! which does not change the mean.
//! Tests: crates/render/tests/many_lights.rs.

use std::time::Instant;

use glam::Vec3;
use gnurt_shading::sampling::{hash_combine, sample_pair};
use gnurt_shading::{RayRequest, SampleKey, Tracer, Vec3s};
use gnurt_simd::dispatch;

use super::bound::Bound;
use super::chosen::{Learned, Rows};
use super::contribution::each_contribution;
use super::cut::{MOST, cut_of};
use super::eye::EyePoint;
use super::lanes::{BLOCK, Block, Color, END, Light, Source};
use super::mixing::mix;
use super::neighbours;
use super::vpl::{self, Vpl};
use crate::tracer::BatchTracer;

/// Purpose of the number that chooses virtual lights for a block.
const CUT: u32 = 0x6000;

/// Virtual lights ready to be gathered, such that neighbours in the list are neighbours.
pub(super) fn sources(vpls: &[Vpl], bound: &Bound) -> Vec<Source> {
    let positions: Vec<Vec3> = vpls.iter().map(|vpl| vpl.point.p).collect();
    neighbours::in_order(&positions, 1).into_iter().map(|i| Source::new(&vpls[i as usize], bound)).collect()
}

/// Gathers; adds to `radiance` by lane.
pub(super) fn gather(
    tracer: &mut BatchTracer,
    points: &[&EyePoint],
    keys: &[SampleKey],
    sources: &[Source],
    bound: &Bound,
    radiance: &mut Vec3s,
) {
    if points.is_empty() || sources.is_empty() {
        return;
    }
    let (begin, rays_before) = (Instant::now(), tracer.stats.shadow_rays);
    gather_all(tracer, points, keys, sources, bound, radiance);
    tracer.stats.gather_rays += tracer.stats.shadow_rays - rays_before;
    tracer.stats.gather_seconds += begin.elapsed().as_secs_f64();
}

fn gather_all(
    tracer: &mut BatchTracer,
    points: &[&EyePoint],
    keys: &[SampleKey],
    sources: &[Source],
    bound: &Bound,
    radiance: &mut Vec3s,
) {
    let mut scratch = Scratch::default();
    let most = lights_of(sources.len());
    let SampleKey { pixel, sample, .. } = keys[points[0].lane as usize];
    let mixed = (sources.len() > most).then(|| hash_combine(pixel, sample));
    let mut parts: Vec<Part> = blocks(points, mixed).map(|eyes| Part::new(tracer, eyes, keys)).collect();
    if sources.len() <= most {
        // Neighbouring lights serve one block in succession, so that the geometry between stays in caches.
        for near in sources.chunks(NEAR) {
            for part in &mut parts {
                for source in near {
                    part.gather(tracer, (source, 1.0), bound, &mut scratch);
                }
            }
        }
    } else {
        let mut learned = Learned::new(sources.len());
        for part in &mut parts {
            for (i, weight) in part.choice(tracer, (sources, &learned), most, bound, &mut scratch) {
                let [requests, came] = part.gather(tracer, (&sources[i], weight), bound, &mut scratch);
                learned.note(i, requests, came);
            }
        }
    }
    for mut part in parts {
        part.single.settle(tracer, &mut part.sums);
        for (i, eye) in part.eyes.iter().enumerate() {
            radiance.add(eye.lane as usize, part.sums.get(i));
        }
    }
}

/// Number of virtual lights that serve one block, then the next.
const NEAR: usize = 8;

/// The limit of virtual lights for a block, of this number of lights: a part, because each takes a ray from
/// each of its points, and their contributions take none.
fn lights_of(lights: usize) -> usize {
    (lights / 4).clamp(256, MOST)
}

/// Memory for one virtual light on one block, and for the contributions of all lights to it.
#[derive(Default)]
struct Scratch {
    light: Box<Light>,
    rows: Rows,
}

/// The points of one block, and their light.
struct Part<'a> {
    eyes: Vec<&'a EyePoint>,
    keys: Vec<SampleKey>,
    block: Block,
    sums: Color,
    single: Single,
    /// Whether its rays may go by pencils, which support neither transparency nor costs.
    by_pencils: bool,
}

impl<'a> Part<'a> {
    fn new(tracer: &BatchTracer, eyes: Vec<&'a EyePoint>, keys: &[SampleKey]) -> Self {
        Self {
            block: Block::new(&eyes, tracer.options.max_depth),
            keys: eyes.iter().map(|eye| keys[eye.lane as usize]).collect(),
            sums: Color::default(),
            single: Single::default(),
            by_pencils: tracer.world.materials().all_solid() && tracer.costs.is_none(),
            eyes,
        }
    }

    /// The lights for the block: positions in the list, and weights.
    fn choice(
        &self,
        tracer: &BatchTracer,
        (sources, learned): (&[Source], &Learned),
        most: usize,
        bound: &Bound,
        scratch: &mut Scratch,
    ) -> Vec<(usize, f32)> {
        let [u, _] = sample_pair(tracer.options.seed, self.keys[0], 0, CUT);
        if self.block.other.len() == self.eyes.len() {
            // These points are not in lanes; each uses as many lights as the limit allows.
            return match sources.len() {
                few if few <= MOST => (0..few).map(|i| (i, 1.0)).collect(),
                _ => cut_of(&self.eyes, sources, MOST, u),
            };
        }
        let Scratch { light, rows } = scratch;
        let (level, max_edges) = (tracer.options.level, tracer.options.max_depth);
        rows.clear();
        let requests = (&self.block, &self.eyes[..]);
        each_contribution(level, requests, sources, (bound, max_edges), light, |i, contribution, _| {
            rows.push(i, contribution)
        });
        rows.chosen(learned, most, u)
    }

    /// Adds the light of one virtual light, times a weight; returns the number of shadow rays in lanes, and
    /// how many of them were unoccluded.
    fn gather(
        &mut self,
        tracer: &mut BatchTracer,
        (source, weight): (&Source, f32),
        bound: &Bound,
        scratch: &mut Scratch,
    ) -> [u32; 2] {
        let Self { eyes, keys, block, sums, single, by_pencils } = self;
        let Scratch { light, .. } = scratch;
        let (level, max_edges) = (tracer.options.level, tracer.options.max_depth);
        let lanes = if block.other.len() == eyes.len() {
            None
        } else if block.may_get(source) {
            block.light(level, source, light)
        } else {
            Some(0)
        };
        let mut found = [0; 2];
        match lanes {
            Some(0) | None => {}
            Some(count) if *by_pencils => {
                tracer.stats.shadow_rays += u64::from(count);
                let hit = tracer.occluded_pencil(&mut light.rays);
                dispatch!(level, _simd => sums.add(&light.color, hit, weight));
                found = [count, count.saturating_sub(hit.count_ones())];
            }
            Some(_) => {
                let lit = |i: &usize| light.rays.t_far()[*i] > 0.0;
                for i in (0..eyes.len()).filter(lit) {
                    let offset = Vec3::from(light.rays.org) - block.end(i);
                    single.push((block.end(i), offset), keys[i], i, light.color.get(i) * weight);
                }
            }
        }
        let mut query = |i: usize| single.query((&source.vpl, weight), i, eyes, keys, bound, max_edges);
        if lanes.is_some() {
            block.other.iter().for_each(|&i| query(i));
        } else {
            (0..eyes.len()).for_each(query);
        }
        if single.lanes.len() >= ENOUGH {
            single.settle(tracer, sums);
        }
        found
    }
}

/// The points of a tile such that those of a block lie near each other and do alike to light; where there is a seed blocks mix.
fn blocks<'a>(points: &[&'a EyePoint], seed: Option<u32>) -> impl Iterator<Item = Vec<&'a EyePoint>> {
    let kinds = [0, 1, 2].map(|kind| points.iter().copied().filter(|eye| kind_of(eye) == kind).collect());
    let in_order = |kind: Vec<&'a EyePoint>| {
        let positions: Vec<Vec3> = kind.iter().map(|eye| eye.point.p).collect();
        let order = neighbours::in_order(&positions, BLOCK);
        let mut positions_in_order: Vec<usize> = (0..order.len()).collect();
        if let Some(seed) = seed {
            for near in positions_in_order.chunks_mut(MIXED * BLOCK) {
                mix(near, hash_combine(seed, near[0] as u32));
                // Lanes side by side stay near each other.
                near.chunks_mut(BLOCK).for_each(<[_]>::sort_unstable);
            }
        }
        positions_in_order.into_iter().map(move |i| kind[order[i] as usize])
    };
    let all: Vec<&EyePoint> = kinds.into_iter().flat_map(in_order).collect();
    (0..all.len()).step_by(BLOCK).map(move |first| all[first..all.len().min(first + BLOCK)].to_vec())
}

/// Number of successive blocks that exchange points at random where each uses its own lights, so that errors
/// do not show as blocks.
const MIXED: usize = 4;

/// Lambertian, another, or a transmitting one, which lanes do not support.
fn kind_of(eye: &EyePoint) -> usize {
    if eye.bsdf.lambertian().is_some() {
        0
    } else if eye.bsdf.is_translucent() {
        2
    } else {
        1
    }
}

/// Rays that go together.
const ENOUGH: usize = 1024;

/// Rays that do not go by pencils.
#[derive(Default)]
struct Single {
    request: RayRequest,
    /// The lane of each in the block, and its unoccluded light.
    lanes: Vec<(usize, Vec3)>,
    through: Vec3s,
}

impl Single {
    fn push(&mut self, (start, offset): (Vec3, Vec3), key: SampleKey, lane: usize, color: Vec3) {
        let ray = gnurt_accel::Ray::new(start.into(), offset.into()).within(0.0, END);
        self.request.rays.push(ray);
        self.request.key.push(key);
        self.lanes.push((lane, color));
    }

    /// Light of a virtual light at lane `i`, with any BSDF, times a weight.
    fn query(
        &mut self,
        (vpl, weight): (&Vpl, f32),
        i: usize,
        eyes: &[&EyePoint],
        keys: &[SampleKey],
        bound: &Bound,
        max_edges: u32,
    ) {
        let eye = eyes[i];
        let Some(color) = vpl.brings(eye, bound, max_edges).filter(|color| color.is_finite()) else { return };
        let offset = vpl.point.p - eye.point.p;
        let start = vpl::start(eye, offset).unwrap_or(eye.point.p);
        self.push((start, vpl::end(&vpl.point, -offset) - start), keys[i], i, color * weight);
    }

    /// Adds the unoccluded light.
    fn settle(&mut self, tracer: &mut BatchTracer, sums: &mut Color) {
        if self.lanes.is_empty() {
            return;
        }
        tracer.occluded(&self.request, &mut self.through);
        for (n, (lane, color)) in self.lanes.drain(..).enumerate() {
            sums.set(lane, sums.get(lane) + color * self.through.get(n));
        }
        self.request.rays.clear();
        self.request.key.clear();
    }
}
