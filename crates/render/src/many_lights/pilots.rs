// SPDX-License-Identifier: GPL-3.0-or-later
//! A few points that the camera sees, fresh for each pass: how much a virtual light matters is what it brings to them.
//! Source: [SIMP06] (virtual lights judged by what they bring to the camera). Differs: the same points also choose where
//! reverse virtual lights lie, so that the density of that choice is a plain sum, and no density has to be estimated.
//! Space: world. Invariant: a function of the set's number; the estimate stays unbiased whatever the points are.
//! Proof: crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, RayBatch};
use gnurt_image::srgb::luminance;
use gnurt_shading::bsdf::Bsdf;
use gnurt_shading::sampling::{hash_combine, sample_pair};
use gnurt_shading::{RayRequest, SampleKey, SurfacePoint, Tracer, Vec3s};

use super::bound::Bound;
use super::eye::EyePoint;
use super::lanes::END;
use super::vpl::{self, Vpl};
use crate::tile::Job;
use crate::tracer::BatchTracer;

/// How many; one bit each in a mask of who sees whom.
pub(super) const PILOTS: usize = 64;
/// Says that a number is for pilots.
const PURPOSE: u32 = 0x9107_0000;
/// Mirrors that a pilot's path may meet.
const MOST_MIRRORS: u32 = 8;
/// Share of a virtual light's importance that does not ask whether any pilot sees it.
const DEFENSIVE: f32 = 0.005;

/// Points that the camera sees.
pub(super) struct Pilots {
    pub(super) points: Vec<EyePoint>,
    pub(super) bound: Bound,
    pub(super) max_depth: u32,
    /// About what a unit of strength brings to a point somewhere in the scene.
    anywhere: f32,
}

impl Pilots {
    /// The pilots of a set; fewer than `PILOTS` where the camera sees nothing.
    pub(super) fn new(job: &Job, tracer: &mut BatchTracer, set: u32, bound: Bound) -> Self {
        let options = job.options;
        let pixel = hash_combine(PURPOSE, set);
        let [x0, y0, x1, y1] =
            options.region().unwrap_or([0, 0, options.width, options.height]).map(|x| x as f32);
        let keys: Vec<SampleKey> =
            (0..PILOTS as u32).map(|sample| SampleKey { pixel, sample, branch: PURPOSE }).collect();
        let place = |key: &SampleKey| {
            let [u, v] = sample_pair(options.seed, *key, 0, PURPOSE);
            [(x0 + (x1 - x0) * u) / options.width as f32, 1.0 - (y0 + (y1 - y0) * v) / options.height as f32]
        };
        let places: Vec<[f32; 2]> = keys.iter().map(place).collect();
        let mut rays = RayBatch::default();
        job.camera.rays(&places, options.width as f32 / options.height as f32, &mut rays);
        let mut lanes: Vec<(SampleKey, Vec3)> = keys.into_iter().map(|key| (key, Vec3::ONE)).collect();
        lanes.truncate(rays.len());
        let mut points = Vec::new();
        for edges in 1..=MOST_MIRRORS {
            let keys: Vec<SampleKey> = lanes.iter().map(|lane| lane.0).collect();
            let found = tracer.follow(&rays, &keys, edges, Coherence::Incoherent);
            let (mut next_rays, mut next) = (RayBatch::default(), Vec::new());
            for ((key, throughput), vertex) in lanes.into_iter().zip(found) {
                let Some(vertex) = vertex.filter(|v| !v.is_final) else {
                    continue;
                };
                let eye = EyePoint::new(&vertex, throughput, edges, 0);
                if eye.bsdf.is_smooth() {
                    if eye.bsdf.lambertian() != Some(Vec3::ZERO) {
                        points.push(eye);
                    }
                    continue;
                }
                let [u, v] = sample_pair(options.seed, key, edges, PURPOSE + 1);
                let [lobe, _] = sample_pair(options.seed, key, edges, PURPOSE + 2);
                if let Some(sample) = eye.bsdf.sample(eye.wo, [lobe, u, v])
                    && let Some(ray) = eye.point.scatter_ray(sample.wi, sample.transmitted, f32::INFINITY)
                {
                    next_rays.push(ray);
                    next.push((key, throughput * sample.weight));
                }
            }
            (rays, lanes) = (next_rays, next);
            if lanes.is_empty() {
                break;
            }
        }
        let across =
            job.world.bounds().map_or(1.0, |(low, high)| (Vec3::from(high) - Vec3::from(low)).length());
        let anywhere = DEFENSIVE * 2.0 / (std::f32::consts::PI * across * across).max(f32::MIN_POSITIVE);
        Self { points, bound, max_depth: options.max_depth, anywhere }
    }

    /// Which pilots each point sees, one bit per pilot; those behind surfaces that send nothing there do not count.
    pub(super) fn seen_from(&self, tracer: &mut BatchTracer, points: &[(SurfacePoint, Bsdf)]) -> Vec<u64> {
        let mut seen = vec![0_u64; points.len()];
        let mut request = RayRequest::default();
        let mut lanes = Vec::new();
        for (n, (point, bsdf)) in points.iter().enumerate() {
            let one_sided = bsdf.lambertian().is_some();
            for (k, eye) in self.points.iter().enumerate() {
                let way = point.p - eye.point.p;
                if one_sided && point.ng.dot(way) >= 0.0 {
                    continue;
                }
                if let Some(start) = vpl::start(&eye.point, way) {
                    let way = vpl::end(point, -way) - start;
                    request.rays.push(gnurt_accel::Ray::new(start.into(), way.into()).within(0.0, END));
                    lanes.push((n, k));
                }
            }
        }
        request.key.resize(request.rays.len(), SampleKey::default());
        let mut through = Vec3s::default();
        tracer.occluded(&request, &mut through);
        for (i, (n, k)) in lanes.into_iter().enumerate() {
            if through.get(i) != Vec3::ZERO {
                seen[n] |= 1 << k;
            }
        }
        seen
    }

    /// Density per area with which a ray from a pilot, chosen by its BSDF, meets the front of a point that these pilots
    /// see.
    pub(super) fn pdf(&self, point: &SurfacePoint, seen: u64) -> f32 {
        let mut sum = 0.0;
        for eye in self.seeing(seen) {
            let way = point.p - eye.point.p;
            let distance2 = way.length_squared();
            let to = way / distance2.sqrt();
            let pdf = eye.bsdf.pdf(eye.wo, to) * -point.ng.dot(to).min(0.0) / distance2;
            sum += if pdf.is_finite() { pdf } else { 0.0 };
        }
        sum / self.points.len() as f32
    }

    /// How much a virtual light matters: the mean light that it brings to pilots, and a little for those not there.
    pub(super) fn importance(&self, vpl: &Vpl, seen: u64) -> f32 {
        let mut sum = 0.0;
        for eye in self.seeing(seen) {
            let brought = vpl.brings(eye, &self.bound, self.max_depth).unwrap_or(Vec3::ZERO);
            sum += if brought.is_finite() { luminance(brought.into()) } else { 0.0 };
        }
        let mean = sum / self.points.len().max(1) as f32;
        let importance = mean + self.anywhere * vpl.strength();
        if importance.is_finite() { importance } else { 0.0 }
    }

    fn seeing(&self, seen: u64) -> impl Iterator<Item = &EyePoint> {
        self.points.iter().enumerate().filter(move |(k, _)| seen >> k & 1 == 1).map(|(_, eye)| eye)
    }
}
