// SPDX-License-Identifier: GPL-3.0-or-later
//! A few visible points, fresh for each pass: the importance of a virtual light is its contribution to them.
//! Source: [SIMP06] (importance of virtual lights from their contribution to the camera). Differs: the same
//! points also choose the positions of reverse virtual lights, so that the density of that choice is a plain
//! sum and needs no estimate. Where rays bring much of a point's light, as on gloss, the ends of some of
//! these rays are pilot points, too.
//! Space: world. Invariant: a function of the set's number; the estimate stays unbiased for any points.
//! Tests: crates/render/tests/many_lights.rs.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use gnurt_accel::RayBatch;
use gnurt_image::srgb::luminance;
use gnurt_shading::bsdf::Bsdf;
use gnurt_shading::sampling::{hash_combine, sample_pair};
use gnurt_shading::{CameraSamples, RayRequest, SampleKey, SurfacePoint, Tracer, Vec3s};
use gnurt_simd::{Level, dispatch_wide, f32x16, prelude::*};

use super::bound::Bound;
use super::eye::EyePoint;
use super::lanes::{BLOCK, Block, Densities, END, Light, Source};
use super::neighbours;
use super::vpl::{self, Vpl};
use crate::cone::{Cone, Cones};
use crate::job::Job;
use crate::tracer::BatchTracer;
use crate::transport::opacity;
use crate::transport::walks::Walks;

/// Points that the eye sees, at most.
const SEEN: u32 = 64;
/// Blocks of lanes for all pilot points: rays may end at as many points again. One bit each in a mask of
/// mutual visibility.
const BLOCKS: usize = 2;
/// Share of light that rays must bring from there.
const LEAST_REST: f32 = 0.05;
/// Marks numbers for pilot points.
const PURPOSE: u32 = 0x9107_0000;
/// Mirrors that a pilot's path may meet.
const MOST_MIRRORS: u32 = 8;
/// Fraction of a virtual light's importance that is independent of its visibility to pilot points.
const DEFENSIVE: f32 = 0.005;

/// Which pilots see a point.
pub(super) type VisibleMask = [u64; BLOCKS];

/// Points that the camera sees.
pub(super) struct Pilots {
    pub(super) points: Vec<EyePoint>,
    pub(super) max_depth: u32,
    bound: Bound,
    /// All of them, by blocks.
    groups: Vec<Group>,
    /// Approximate contribution of unit power to a point somewhere in the scene.
    anywhere: f32,
    level: Level,
}

/// Some pilots as lanes.
struct Group {
    block: Block,
    /// Points without lanes.
    other: u64,
}

/// Memory for results of lanes.
#[derive(Default)]
pub(super) struct Scratch {
    light: Box<Light>,
    densities: Box<Densities>,
}

impl Pilots {
    /// The pilots of a set: at most `SEEN`, and as many where their rays end; fewer where the camera sees nothing.
    pub(super) fn new(job: &Job, tracer: &mut BatchTracer, set: u32, bound: Bound) -> Self {
        let options = job.options;
        let pixel = hash_combine(PURPOSE, set);
        let [x0, y0, x1, y1] =
            options.region().unwrap_or([0, 0, options.width, options.height]).map(|x| x as f32);
        let keys: Vec<SampleKey> =
            (0..SEEN).map(|sample| SampleKey { pixel, sample, branch: PURPOSE }).collect();
        let position = |key: &SampleKey| {
            let [u, v] = sample_pair(options.seed_of_lights(), *key, 0, PURPOSE);
            [(x0 + (x1 - x0) * u) / options.width as f32, 1.0 - (y0 + (y1 - y0) * v) / options.height as f32]
        };
        let positions: Vec<[f32; 2]> = keys.iter().map(position).collect();
        let mut rays = RayBatch::default();
        let lens: Vec<[f32; 2]> =
            keys.iter().map(|&key| sample_pair(options.seed_of_lights(), key, 0, PURPOSE + 5)).collect();
        let times: Vec<f32> = match job.world.is_open() {
            true => keys.iter().map(|&key| job.world.time(key)).collect(),
            false => Vec::new(),
        };
        let samples = CameraSamples { positions: &positions, lens: &lens, times: &times };
        job.camera.rays(&samples, options.width as f32 / options.height as f32, &mut rays);
        // The factor of light at its end.
        let carried = vec![Vec3::ONE; rays.len()];
        let keys = keys[..rays.len()].to_vec();
        let mut walks = Walks { keys, rays, cones: Some(Cones::default()), carried, ..Walks::default() };
        let mut points = Vec::new();
        for edges in 1..=MOST_MIRRORS {
            walks.chances = chances(options.seed_of_lights(), &walks.keys, edges);
            let found = walks.meet(tracer, edges);
            let mut next = Walks::default();
            let passed: Vec<Vec3> = (0..walks.carried.len()).map(|i| found.passed(i)).collect();
            let carried = walks.keys.iter().zip(&walks.carried).zip(passed);
            for (((&key, &throughput), passed), vertex) in carried.zip(found.vertices) {
                let throughput = throughput * passed;
                let Some(vertex) = vertex.filter(|v| !v.is_final) else { continue };
                let eye = EyePoint::new(vertex, throughput, edges, 0);
                if eye.bsdf.is_smooth() {
                    if eye.bsdf.lambertian() != Some(Vec3::ZERO) {
                        points.push(eye);
                    }
                    continue;
                }
                let [u, v] = sample_pair(options.seed_of_lights(), key, edges, PURPOSE + 1);
                let [lobe, _] = sample_pair(options.seed_of_lights(), key, edges, PURPOSE + 2);
                if let Some((ray, sample)) = eye.scatter([lobe, u, v]) {
                    next.push((ray, Cone::default()), key, throughput * sample.weight);
                }
            }
            walks = next;
        }
        points.extend(ends_of_rays(job, tracer, pixel, &points, &bound));
        // Adjacent lanes face the same way.
        let positions: Vec<Vec3> = points.iter().map(|eye| eye.point.p).collect();
        let points: Vec<EyePoint> =
            neighbours::in_order(&positions, BLOCK).into_iter().map(|i| points[i as usize].clone()).collect();
        let across =
            job.world.bounds().map_or(1.0, |(low, high)| (Vec3::from(high) - Vec3::from(low)).length());
        let anywhere = DEFENSIVE * 2.0 / (std::f32::consts::PI * across * across).max(f32::MIN_POSITIVE);
        let max_depth = options.max_depth;
        let group = |some: &[EyePoint]| {
            let block = Block::new(&some.iter().collect::<Vec<_>>(), max_depth);
            let other = block.other.iter().fold(0, |mask, &i| mask | 1 << i);
            Group { block, other }
        };
        let groups = points.chunks(BLOCK).map(group).collect();
        Self { points, max_depth, bound, groups, anywhere, level: options.level }
    }

    /// Which pilots see the front of each point; those behind surfaces that send nothing there do not count.
    pub(super) fn visible_from(
        &self,
        tracer: &mut BatchTracer,
        points: &[(SurfacePoint, &Bsdf)],
        scratch: &mut Scratch,
    ) -> Vec<VisibleMask> {
        let mut masks = vec![VisibleMask::default(); points.len()];
        let mut request = RayRequest::default();
        let mut lanes = Vec::new();
        let by_pencils = tracer.world.materials().all_solid();
        for (n, (point, bsdf)) in points.iter().enumerate() {
            let is_one_sided = !bsdf.is_translucent();
            for (b, group) in self.groups.iter().enumerate() {
                let mut one_by_one = u64::MAX;
                if is_one_sided && by_pencils {
                    one_by_one = group.other;
                    let rays = &mut scratch.light.rays;
                    dispatch_wide!(
                        self.level,
                        simd => group.block.directions_from(f32x16::splat(simd, 0.0), point, rays),
                        else group.block.directions_from(0.0_f32, point, rays)
                    );
                    let queried =
                        (0..BLOCK).filter(|&i| rays.t_far()[i] > 0.0).fold(0, |mask, i| mask | 1_u64 << i);
                    if queried != 0 {
                        tracer.stats.shadow_rays += u64::from(queried.count_ones());
                        masks[n][b] = queried & !tracer.occluded_pencil(rays) & !group.other;
                    }
                }
                for (i, eye) in self.of_block(b, one_by_one) {
                    let offset = point.p - eye.point.p;
                    if is_one_sided && point.ng.dot(offset) >= 0.0 {
                        continue;
                    }
                    if let Some(start) = vpl::start(eye, offset) {
                        let offset = vpl::end(point, -offset) - start;
                        request
                            .rays
                            .push(gnurt_accel::Ray::new(start.into(), offset.into()).within(0.0, END));
                        lanes.push((n, b, i));
                    }
                }
            }
        }
        request.key.resize(request.rays.len(), SampleKey::default());
        let mut through = Vec3s::default();
        tracer.occluded(&request, &mut through);
        for (i, (n, b, k)) in lanes.into_iter().enumerate() {
            if through.get(i) != Vec3::ZERO {
                masks[n][b] |= 1 << k;
            }
        }
        masks
    }

    /// Density per area with which a ray from a pilot, chosen by its BSDF, meets the front of a point that these pilots
    /// see.
    pub(super) fn pdf(&self, point: &SurfacePoint, masks: &VisibleMask, scratch: &mut Scratch) -> f32 {
        let mut sum = 0.0;
        for (b, group) in self.groups.iter().enumerate().filter(|&(b, _)| masks[b] != 0) {
            let densities = &mut scratch.densities.0;
            dispatch_wide!(
                self.level,
                simd => group.block.densities(f32x16::splat(simd, 0.0), point, densities),
                else group.block.densities(0.0_f32, point, densities)
            );
            sum += bits(masks[b] & !group.other).map(|i| densities[i]).sum::<f32>();
            for (_, eye) in self.of_block(b, masks[b] & group.other) {
                let offset = point.p - eye.point.p;
                let distance2 = offset.length_squared();
                let to = offset / distance2.sqrt();
                let pdf = eye.bsdf.pdf(eye.wo, to) * -point.ng.dot(to).min(0.0) / distance2;
                sum += if pdf.is_finite() { pdf } else { 0.0 };
            }
        }
        sum / self.points.len() as f32
    }

    /// How much a virtual light matters: the mean light that it brings to pilots, and a little for those not there.
    pub(super) fn importance(&self, vpl: &Vpl, masks: &VisibleMask, scratch: &mut Scratch) -> f32 {
        let mut sum = 0.0;
        let source = Source::new(vpl, &self.bound);
        let light_of = |color: [f32; 3]| {
            let light = luminance(color);
            if light < f32::INFINITY { light } else { 0.0 }
        };
        for (b, group) in self.groups.iter().enumerate().filter(|&(b, _)| masks[b] != 0) {
            let light = &mut *scratch.light;
            let mut one_by_one = masks[b];
            let lit = group.block.light(self.level, &source, light);
            match lit {
                None => {}
                Some(0) => one_by_one &= group.other,
                Some(_) => {
                    one_by_one &= group.other;
                    let by_lanes = bits(masks[b] & !group.other);
                    sum += by_lanes.map(|i| light_of(light.color.get(i).into())).sum::<f32>();
                }
            }
            for (_, eye) in self.of_block(b, one_by_one) {
                let brought = vpl.brings(eye, &self.bound, self.max_depth).unwrap_or(Vec3::ZERO);
                sum += light_of(brought.into());
            }
        }
        let mean = sum / self.points.len().max(1) as f32;
        let importance = mean + self.anywhere * vpl.strength();
        if importance.is_finite() { importance } else { 0.0 }
    }

    /// Pilots of a block, by a mask.
    fn of_block(&self, block: usize, mask: u64) -> impl Iterator<Item = (usize, &EyePoint)> {
        let points = &self.points[block * BLOCK..];
        bits(mask).take_while(move |&i| i < points.len()).map(move |i| (i, &points[i]))
    }
}

/// Numbers that decide which surfaces walks meet that are there in part: by the seed of virtual lights, as all about pilots.
fn chances(seed: u64, keys: &[SampleKey], edges: u32) -> Vec<f32> {
    keys.iter().map(|&key| opacity::probability(seed, key, edges)).collect()
}

/// The end of a ray from each point that finds the remainder of virtual lights, if that is large: on gloss it
/// is most.
fn ends_of_rays(
    job: &Job,
    tracer: &mut BatchTracer,
    pixel: u32,
    points: &[EyePoint],
    bound: &Bound,
) -> Vec<EyePoint> {
    let mut walks = Walks::default();
    for (sample, eye) in (0..).zip(points) {
        let key = SampleKey { pixel, sample, branch: PURPOSE + 1 };
        let [u, v] = sample_pair(job.options.seed_of_lights(), key, 0, PURPOSE + 3);
        let [lobe, _] = sample_pair(job.options.seed_of_lights(), key, 0, PURPOSE + 4);
        if let Some((ray, sample)) = eye.scatter([lobe, u, v]) {
            walks.push((ray, Cone::from_point(sample.pdf)), key, (eye, sample));
        }
    }
    walks.chances = chances(job.options.seed_of_lights(), &walks.keys, MOST_MIRRORS + 1);
    let found = walks.meet(tracer, MOST_MIRRORS + 1);
    let mut out = Vec::new();
    let passed: Vec<Vec3> = (0..walks.carried.len()).map(|i| found.passed(i)).collect();
    for (((eye, sample), passed), vertex) in walks.carried.into_iter().zip(passed).zip(found.vertices) {
        let Some(vertex) = vertex.filter(|v| !v.is_final && v.scattering.bsdf.is_smooth()) else { continue };
        let distance2 = (vertex.point.p - eye.point.p).length_squared();
        let (cos, back) = (vertex.point.ng.dot(vertex.wo).abs(), eye.point.ng.dot(vertex.wo).abs());
        let share = bound.share(sample.pdf * cos / distance2, cos * FRAC_1_PI * back / distance2);
        let throughput = eye.throughput * sample.weight * passed * (1.0 - share);
        if throughput.max_element() >= LEAST_REST {
            out.push(EyePoint::new(vertex, throughput, eye.edges + 1, 0));
        }
    }
    out
}

/// Positions of the set bits.
fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let position = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (position < 64).then_some(position)
    })
}
