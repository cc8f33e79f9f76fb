// SPDX-License-Identifier: GPL-3.0-or-later
//! Radiance of a pixel's samples: surfaces one behind the other by their opacity, and volumes between them. The background stays
//! dark here and is counted as opacity, so that any background can be put there.
//! The integrator sees the first surface of each ray without holes; further ones are asked for here.
//! Invariant: `light` is associated with `opacity`, both means over the samples. Tests: tests/{materials,volumes}.rs.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::Vec3;
use gnurt::accel::Ray;
use gnurt::shading::sampling::hash_combine;
use gnurt::shading::{PixelSamples, PixelShader, RayRequest, SampleKey, Tracer, Vec3s};

use crate::table::Table;

/// Surfaces with holes that a ray goes through, at most.
const LAYERS: u32 = 64;
/// Below this share, further layers do not show.
const FAINT: f32 = 1e-3;

/// Sums of opacities, pixel by pixel.
pub(crate) struct Opacities(Vec<AtomicU32>);

impl Opacities {
    /// Zero for so many pixels.
    pub(crate) fn new(pixels: usize) -> Self {
        Self((0..pixels).map(|_| AtomicU32::new(0)).collect())
    }

    /// Adds to a pixel. Samples of a pixel are taken by one thread, in order.
    fn add(&self, pixel: u32, opacity: f32) {
        if let Some(sum) = self.0.get(pixel as usize) {
            let now = f32::from_bits(sum.load(Ordering::Relaxed)) + opacity;
            sum.store(now.to_bits(), Ordering::Relaxed);
        }
    }

    /// The sum of a pixel.
    pub(crate) fn sum(&self, pixel: usize) -> f32 {
        f32::from_bits(self.0[pixel].load(Ordering::Relaxed))
    }
}

/// The pixel shader of surfaces and volumes in layers.
pub(crate) struct Layers {
    pub(crate) table: Arc<Table>,
    pub(crate) opacities: Arc<Opacities>,
}

/// A ray on its way through surfaces and volumes.
#[derive(Clone, Copy)]
struct Walk {
    light: Vec3,
    left: f32,
    /// Where it is, in multiples of its direction.
    t: f32,
}

/// Light of the volumes between two places of a ray, nearest first.
pub(crate) fn through_volumes(table: &Table, ray: &Ray, [from, to]: [f32; 2], random: f32) -> (Vec3, f32) {
    if table.volumes.is_empty() {
        return (Vec3::ZERO, 1.0);
    }
    let (org, dir) = (Vec3::from(ray.org), Vec3::from(ray.dir));
    let spans = table.volumes.iter().filter_map(|volume| Some((volume, volume.span(org, dir, to)?)));
    let within = |(volume, [enter, leave]): (_, [f32; 2])| {
        let span = [enter.max(from), leave.min(to)];
        (span[0] < span[1]).then_some((volume, span))
    };
    let mut spans: Vec<(&crate::volume::Volume, [f32; 2])> = spans.filter_map(within).collect();
    spans.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let (mut light, mut left) = (Vec3::ZERO, 1.0);
    for (volume, span) in spans {
        let (own, stopped) = volume.march(org, dir, span, random);
        light += own * left;
        left *= 1.0 - stopped;
    }
    (light, left)
}

/// A number in [0, 1) for a sample.
fn random(key: SampleKey) -> f32 {
    let bits = hash_combine(hash_combine(key.pixel, key.sample.wrapping_add(1)), 0x9e37);
    (bits >> 8) as f32 / (1 << 24) as f32
}

impl Layers {
    /// Takes the samples of `lanes` on by a surface: `radiance` and `t` by place in `lanes`. Those that go on stay in `lanes`.
    fn step(
        &self,
        samples: &PixelSamples,
        walks: &mut [Walk],
        lanes: &mut Vec<usize>,
        radiance: &Vec3s,
        distances: &[f32],
        coverage: &[f32],
    ) {
        let mut kept = Vec::new();
        for (k, &lane) in lanes.iter().enumerate() {
            let (walk, ray) = (&mut walks[lane], samples.rays.get(lane));
            let (own, left) =
                through_volumes(&self.table, &ray, [walk.t, distances[k]], random(samples.keys[lane]));
            walk.light += own * walk.left;
            walk.left *= left;
            let is_miss = !distances[k].is_finite();
            let stopped = if is_miss { f32::from(u8::from(self.table.shows_sky)) } else { coverage[k] };
            let here = radiance.get(k);
            if stopped > 0.0 && here.is_finite() {
                walk.light += here * (walk.left * stopped);
            }
            walk.left *= 1.0 - stopped;
            walk.t = distances[k];
            if !is_miss && walk.left > FAINT {
                kept.push(lane);
            }
        }
        *lanes = kept;
    }

    /// The share of light that the surfaces stop which these rays meet first.
    fn coverage(&self, tracer: &mut dyn Tracer, request: &RayRequest, distances: &[f32]) -> Vec<f32> {
        if !self.table.has_holes {
            return vec![1.0; distances.len()];
        }
        let mut met = Vec::new();
        tracer.meet(request, &mut met);
        let of = |hit: &Option<gnurt::shading::SurfaceHit>| {
            let hit = (*hit)?;
            let at = self.table.at_position(hit.ids[0], hit.ids[3], hit.p, hit.ns)?;
            Some(at.surface.material.coverage(&at))
        };
        met.iter().map(|hit| of(hit).unwrap_or(1.0)).collect()
    }
}

impl PixelShader for Layers {
    fn show(&self, tracer: &mut dyn Tracer, samples: &PixelSamples, out: &mut Vec3s) {
        let count = samples.rays.len();
        let mut walks = vec![Walk { light: Vec3::ZERO, left: 1.0, t: 0.0 }; count];
        let mut lanes: Vec<usize> =
            (0..count).filter(|&lane| samples.rays.get(lane).dir != [0.0; 3]).collect();
        let request = |lanes: &[usize], walks: &[Walk]| {
            let mut request = RayRequest::default();
            for &lane in lanes {
                let ray = samples.rays.get(lane);
                // Away from the surface by more than its rounding.
                let t = walks[lane].t;
                let near = if t > 0.0 { t * (1.0 + 1e-5) + 1e-6 } else { ray.t_near };
                request.push(ray.within(near, ray.t_far), lane, samples.keys[lane]);
            }
            request
        };
        let first = request(&lanes, &walks);
        let mut radiance = Vec3s::with_capacity(lanes.len());
        lanes.iter().for_each(|&lane| radiance.push(samples.radiance.get(lane)));
        let distances: Vec<f32> = lanes.iter().map(|&lane| samples.distances[lane]).collect();
        let coverage = self.coverage(tracer, &first, &distances);
        self.step(samples, &mut walks, &mut lanes, &radiance, &distances, &coverage);
        for layer in 1..LAYERS {
            if lanes.is_empty() {
                break;
            }
            let mut next = request(&lanes, &walks);
            next.key.iter_mut().for_each(|key| *key = key.fork(layer));
            let mut radiance = Vec3s::default();
            radiance.reset(lanes.len(), Vec3::ZERO);
            tracer.trace(0, &next, &mut radiance);
            let mut distances = Vec::new();
            tracer.distances(&next, &mut distances);
            let coverage = self.coverage(tracer, &next, &distances);
            self.step(samples, &mut walks, &mut lanes, &radiance, &distances, &coverage);
        }
        for (lane, walk) in walks.iter().enumerate() {
            out.set(lane, walk.light);
            self.opacities.add(samples.keys[lane].pixel, 1.0 - walk.left);
        }
    }
}
