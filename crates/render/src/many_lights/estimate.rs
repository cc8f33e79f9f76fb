// SPDX-License-Identifier: GPL-3.0-or-later
//! Radiance against camera rays, given the virtual lights of a pass: what all integrators of many lights share.
//! Source: [Kel97]; the energy that the bound takes from virtual lights comes back by rays [KK06]; light from lamps by
//! light samples and scattered rays, weighted [VG95]. Space: world.
//! A path ends at a lamp. Its last edge but one, seen from the eye, is the first whose ends both scatter smoothly:
//! virtual lights bring its share of that edge, a ray that the eye's BSDF chooses brings the rest, and from there on the
//! same again, with few virtual lights chosen by chance. Mirrors and smooth glass are followed: no virtual light is there.
//! Proof: crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, RayBatch};
use gnurt_shading::sampling::sample_pair;
use gnurt_shading::{RayRequest, SampleKey, SurfacePoint, Tracer, Vec3s};

use gnurt_image::srgb::luminance;

use super::cut::resample;
use super::eye::EyePoint;
use super::gather::{END, gather};
use super::pass::PassLights;
use super::vpl::{self, pdf_of_other_end};
use crate::tracer::BatchTracer;
use crate::transport::Vertex;
use crate::world::HitLanes;

/// Purposes of random numbers; those of light samples follow the last one.
mod purpose {
    pub(super) const DIRECTION: u32 = 0x5000;
    pub(super) const LOBE: u32 = 0x5001;
    pub(super) const LAMP: u32 = 0x5002;
    pub(super) const PLACE: u32 = 0x5003;
    pub(super) const CHOICE: u32 = 0x5004;
}

/// Virtual lights of which those few are chosen that promise most.
const ASKED: u32 = 128;

/// The last smooth scattering of a path from the eye.
#[derive(Clone, Copy)]
struct Last {
    point: SurfacePoint,
    /// Density per solid angle of the ray that left it.
    pdf: f32,
    /// The side that light samples were taken for.
    side: Vec3,
    /// How many light samples were taken there.
    light_samples: f32,
}

/// A path from the eye that is under way.
#[derive(Clone, Copy)]
struct Walk {
    lane: u32,
    key: SampleKey,
    throughput: Vec3,
    /// Edges, that under way included.
    edges: u32,
    /// `None` if the edge under way comes from the eye, a mirror or smooth glass.
    last: Option<Last>,
    /// Whether all edges so far do.
    is_seen: bool,
}

/// Where a walk arrived and goes on from.
struct Stop {
    walk: Walk,
    eye: EyePoint,
}

impl Stop {
    /// Share of light from `to` that is left for rays that come this way; 1 where virtual lights bring none of it.
    fn rest(&self, pass: &PassLights, to: Vec3) -> f32 {
        let Some(last) = &self.walk.last else { return 1.0 };
        let point = &self.eye.point;
        let distance2 = (point.p - last.point.p).length_squared();
        let pdf_eye = last.pdf * point.ng.dot(self.eye.wo).abs() / distance2;
        let pdf_vpl = pdf_of_other_end(point, &self.eye.bsdf, to, self.eye.wo)
            * last.point.ng.dot(self.eye.wo).abs()
            / distance2;
        1.0 - pass.bound.share(pdf_eye, pdf_vpl)
    }

    /// Whether virtual lights bring all that it could.
    fn is_spent(&self, pass: &PassLights) -> bool {
        // Lambertian ends choose alike whatever the light's direction: one answer for all.
        self.eye.bsdf.lambertian().is_some() && self.rest(pass, self.eye.wo) <= 0.0
    }
}

/// Writes the radiance against each camera ray.
pub(crate) fn radiance(tracer: &mut BatchTracer, pass: &PassLights, camera: HitLanes, radiance: &mut Vec3s) {
    radiance.reset(camera.rays.len(), Vec3::ZERO);
    if tracer.options.max_depth == 0 {
        return;
    }
    let mut walks: Vec<Walk> = camera
        .keys
        .iter()
        .enumerate()
        .map(|(lane, &key)| Walk {
            lane: lane as u32,
            key,
            throughput: Vec3::ONE,
            edges: 1,
            last: None,
            is_seen: true,
        })
        .collect();
    let mut vertices = tracer.vertices(camera);
    tracer.pass_on(&mut vertices, 0);
    let mut rays = camera.rays.clone();
    for depth in 1.. {
        let stops = arrive(tracer, pass, &walks, &vertices, &rays, radiance);
        light_samples(tracer, pass, &stops, radiance);
        let seen: Vec<EyePoint> =
            stops.iter().filter(|stop| stop.walk.is_seen).map(|stop| stop.eye).collect();
        gather(tracer, &seen, camera.keys, &pass.vpls, &pass.bound, radiance);
        few_virtual_lights(tracer, pass, &stops, radiance);
        (rays, walks) = scatter(tracer, pass, &stops);
        if walks.is_empty() {
            return;
        }
        let keys: Vec<SampleKey> = walks.iter().map(|walk| walk.key).collect();
        vertices = tracer.follow(&rays, &keys, depth, Coherence::Incoherent);
    }
}

/// Adds what is met at the end of each ray, and says which walks may go on.
fn arrive(
    tracer: &BatchTracer,
    pass: &PassLights,
    walks: &[Walk],
    vertices: &[Option<Vertex>],
    rays: &RayBatch,
    radiance: &mut Vec3s,
) -> Vec<Stop> {
    let lights = tracer.world.light_set();
    let mut stops = Vec::new();
    for (i, (walk, vertex)) in walks.iter().zip(vertices).enumerate() {
        let lane = walk.lane as usize;
        let share = |pdf_light: f32| {
            walk.last.map_or(1.0, |last| last.pdf / (last.pdf + last.light_samples * pdf_light))
        };
        let Some(vertex) = vertex else {
            let dir = Vec3::from(rays.get(i).dir);
            let seen = lights.environment(dir);
            if seen != Vec3::ZERO {
                let pdf = walk.last.map_or(0.0, |last| lights.pdf_environment(last.point.p, last.side, dir));
                radiance.add(lane, walk.throughput * seen * share(pdf));
            }
            continue;
        };
        let emission = vertex.scattering.emission;
        if emission != Vec3::ZERO {
            let [instance, mesh, triangle] = vertex.ids;
            let pdf = walk.last.map_or(0.0, |last| {
                let light = lights.triangle(instance, mesh, triangle).filter(|_| !vertex.is_final);
                let dist = (vertex.point.p - last.point.p).length();
                light.map_or(0.0, |light| {
                    lights.pdf_triangle(last.point.p, last.side, light, -vertex.wo, dist)
                })
            });
            radiance.add(lane, walk.throughput * emission * share(pdf));
        }
        if vertex.is_final || walk.edges >= tracer.options.max_depth {
            continue;
        }
        let stop = Stop { walk: *walk, eye: EyePoint::new(vertex, walk.throughput, walk.edges, walk.lane) };
        if !stop.is_spent(pass) {
            stops.push(stop);
        }
    }
    stops
}

/// Rays towards light and what they bring if nothing is in between.
#[derive(Default)]
struct Offers {
    request: RayRequest,
    offers: Vec<(u32, Vec3)>,
}

impl Offers {
    fn push(&mut self, ray: gnurt_accel::Ray, walk: &Walk, offer: Vec3) {
        if offer.is_finite() && offer != Vec3::ZERO {
            self.request.rays.push(ray);
            self.request.key.push(walk.key);
            self.offers.push((walk.lane, offer));
        }
    }

    /// Adds what arrives.
    fn settle(self, tracer: &mut BatchTracer, radiance: &mut Vec3s) {
        let mut through = Vec3s::default();
        tracer.occluded(&self.request, &mut through);
        for (i, (lane, offer)) in self.offers.into_iter().enumerate() {
            radiance.add(lane as usize, offer * through.get(i));
        }
    }
}

/// Light that comes straight from lamps.
fn light_samples(tracer: &mut BatchTracer, pass: &PassLights, stops: &[Stop], radiance: &mut Vec3s) {
    let seed = tracer.options.seed;
    let lights = tracer.world.light_set();
    let mut offers = Offers::default();
    let most = stops.iter().map(|stop| pass.light_samples(stop.walk.is_seen)).max().unwrap_or(0);
    // Sample by sample, so that neighbouring rays are neighbours.
    for n in 0..most {
        for Stop { walk, eye } in stops {
            let stop = Stop { walk: *walk, eye: *eye };
            let count = pass.light_samples(walk.is_seen);
            if n >= count || !eye.bsdf.is_smooth() {
                continue;
            }
            let key = SampleKey { sample: walk.key.sample.wrapping_mul(count).wrapping_add(n), ..walk.key };
            let [lamp, _] = sample_pair(seed, key, walk.edges, purpose::LAMP);
            let [u, v] = sample_pair(seed, key, walk.edges, purpose::PLACE);
            let side = lamp_side(eye);
            let Some(sample) = lights.sample(eye.point.p, side, [lamp, u, v]) else { continue };
            let scattered = eye.bsdf.eval(eye.wo, sample.dir);
            if scattered == Vec3::ZERO {
                continue;
            }
            let count = count as f32;
            let share = if sample.delta {
                1.0
            } else {
                count * sample.pdf / (count * sample.pdf + eye.bsdf.pdf(eye.wo, sample.dir))
            };
            let offer = eye.throughput * scattered * sample.radiance * (share / (count * sample.pdf));
            let offer = offer * stop.rest(pass, sample.dir);
            let ray = if eye.point.ns.dot(sample.dir) > 0.0 {
                eye.point.shadow_ray(sample.dir, sample.dist)
            } else {
                eye.point.shadow_ray_through(sample.dir, sample.dist)
            };
            if let Some(ray) = ray {
                offers.push(ray, walk, offer);
            }
        }
    }
    offers.settle(tracer, radiance);
}

/// Light from a few virtual lights on what scattered rays met: chosen from many by what they bring if nothing is in
/// between [TCE05].
fn few_virtual_lights(tracer: &mut BatchTracer, pass: &PassLights, stops: &[Stop], radiance: &mut Vec3s) {
    let Some(choice) = &pass.choice else { return };
    let seed = tracer.options.seed;
    let mut offers = Offers::default();
    let mut found: Vec<(&super::vpl::Vpl, Vec3)> = Vec::new();
    for stop in stops.iter().filter(|stop| !stop.walk.is_seen && stop.eye.bsdf.is_smooth()) {
        let [first, second] = sample_pair(seed, stop.walk.key, stop.walk.edges, purpose::CHOICE);
        found.clear();
        let asked = ASKED.max(pass.few);
        for n in 0..asked {
            let at = (n as f32 + first) / asked as f32;
            let chosen = choice.sample(at);
            let vpl = &pass.vpls[chosen.index];
            let Some(brought) = vpl.brings(&stop.eye, &pass.bound, tracer.options.max_depth) else {
                continue;
            };
            let way = vpl.point.p - stop.eye.point.p;
            let rest = stop.rest(pass, way.normalize());
            found.push((vpl, brought * (rest / (asked as f32 * chosen.probability))));
        }
        let promise = found.iter().map(|(_, offer)| f64::from(luminance((*offer).into())));
        for (k, weight) in resample(promise, pass.few as usize, second) {
            let (vpl, offer) = (found[k].0, found[k].1 * weight);
            let way = vpl.point.p - stop.eye.point.p;
            let Some(start) = vpl::start(&stop.eye.point, way) else { continue };
            let way = vpl::end(&vpl.point, -way) - start;
            let ray = gnurt_accel::Ray::new(start.into(), way.into()).within(0.0, END);
            offers.push(ray, &stop.walk, offer);
        }
    }
    offers.settle(tracer, radiance);
}

/// The normal that lamps are chosen for; zero where light may come from both sides.
fn lamp_side(eye: &EyePoint) -> Vec3 {
    if eye.bsdf.lambertian().is_some() { eye.point.ns } else { Vec3::ZERO }
}

/// Where walks go on.
fn scatter(tracer: &BatchTracer, pass: &PassLights, stops: &[Stop]) -> (RayBatch, Vec<Walk>) {
    let seed = tracer.options.seed;
    let (mut rays, mut walks) = (RayBatch::default(), Vec::new());
    for stop in stops {
        let Stop { walk, eye } = stop;
        let [u, v] = sample_pair(seed, walk.key, walk.edges, purpose::DIRECTION);
        let [lobe, end] = sample_pair(seed, walk.key, walk.edges, purpose::LOBE);
        let Some(sample) = eye.bsdf.sample(eye.wo, [lobe, u, v]) else { continue };
        let Some(ray) = eye.point.scatter_ray(sample.wi, sample.transmitted, f32::INFINITY) else { continue };
        let rest = if sample.delta { 1.0 } else { stop.rest(pass, sample.wi) };
        let mut throughput = walk.throughput * sample.weight * rest;
        if walk.edges > 2 && !walk.is_seen {
            let survival = throughput.max_element().clamp(0.05, 1.0);
            if end >= survival {
                continue;
            }
            throughput /= survival;
        }
        if throughput == Vec3::ZERO || !throughput.is_finite() {
            continue;
        }
        let light_samples = pass.light_samples(walk.is_seen) as f32;
        rays.push(ray);
        walks.push(Walk {
            throughput,
            edges: walk.edges + 1,
            last: (!sample.delta).then_some(Last {
                point: eye.point,
                pdf: sample.pdf,
                side: lamp_side(eye),
                light_samples,
            }),
            is_seen: walk.is_seen && sample.delta,
            ..*walk
        });
    }
    (rays, walks)
}
