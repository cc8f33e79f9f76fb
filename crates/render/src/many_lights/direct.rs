// SPDX-License-Identifier: GPL-3.0-or-later
//! Direct light: light samples where walks stop, for one point or for many at a time, and lights that only
//! have `illuminate`.
//! Source: [VG95] (weighed against the rays that leave the point). Space: world.
//! Invariant: the light samples of a point are the same for any number of points at a time.
//! Tests: crates/render/tests/{determinism,many_lights,agreement}.rs.

use glam::Vec3;
use gnurt_shading::bsdf::{CachedLobes, left_after};
use gnurt_shading::lanes::{LANES, LanesOf};
use gnurt_shading::lights::{LightSamples, LightSet};
use gnurt_shading::real::{Real, Vector};
use gnurt_shading::{SampleKey, Vec3s};
use gnurt_simd::dispatch_wide;

use super::offers::Offers;
use super::pass::PassLights;
use super::walk::{Stop, purpose};
use crate::tracer::BatchTracer;
use crate::transport::mis::balance_heuristic;
use crate::transport::width::{One, Sixteen, Width};
use crate::transport::{LightQuery, Offer, query_plugin_lights, sampling_normal, shadow_ray};

/// Light samples of a point from which on they are taken side by side.
const MANY: u32 = 4;

/// Direct light.
pub(super) fn light_samples(
    tracer: &mut BatchTracer,
    pass: &PassLights,
    stops: &[Stop],
    radiance: &mut Vec3s,
) {
    let seed = tracer.options.seed;
    let lights = tracer.world.light_set();
    let there: Vec<&Stop> = stops.iter().filter(|stop| stop.eye.bsdf.is_smooth()).collect();
    let most = there.iter().map(|stop| pass.light_samples(stop.walk.is_directly_visible)).max().unwrap_or(0);
    // Sample by sample, so that neighbouring rays are neighbours.
    let mut rounds: Vec<Offers> = (0..most).map(|_| Offers::default()).collect();
    let mut one_each: Vec<&Stop> = Vec::new();
    for &stop in &there {
        let count = pass.light_samples(stop.walk.is_directly_visible);
        if count == 1 && !stop.eye.bsdf.is_translucent() {
            one_each.push(stop);
        } else if count < MANY {
            sample(One, lights, seed, (stop, count), &mut rounds);
        } else {
            dispatch_wide!(
                tracer.options.level,
                simd => sample(Sixteen(simd), lights, seed, (stop, count), &mut rounds),
                else sample(One, lights, seed, (stop, count), &mut rounds)
            );
        }
    }
    let mut rounds = rounds.into_iter();
    let mut offers = rounds.next().unwrap_or_default();
    for stops in one_each.chunks(LANES) {
        dispatch_wide!(
            tracer.options.level,
            simd => sample_each(Sixteen(simd), lights, seed, stops, &mut offers),
            else for &stop in stops {
                sample(One, lights, seed, (stop, 1), std::slice::from_mut(&mut offers));
            }
        );
    }
    rounds.for_each(|round| offers.append(&round));
    let queries: Vec<LightQuery> = there
        .iter()
        .map(|stop| LightQuery {
            point: &stop.eye.point,
            bsdf: &stop.eye.bsdf,
            key: stop.walk.key,
            edges: stop.walk.edges,
        })
        .collect();
    query_plugin_lights(tracer.world, seed, &queries, |i, Offer { dir, dist, arriving }| {
        let Stop { walk, eye, light_gain, .. } = there[i];
        let absorption = eye.bsdf.absorption(dir);
        let left = left_after(dist, [absorption, Vec3::ZERO]);
        let scattered = eye.throughput * eye.bsdf.eval(eye.wo, dir) * arriving * left;
        if let Some(ray) = shadow_ray(&eye.point, &eye.bsdf, dir, dist) {
            let offer = scattered * (light_gain * there[i].rest(dir));
            offers.push_of_light(ray, walk, offer, absorption == Vec3::ZERO);
        }
    });
    offers.settle(tracer, radiance);
}

/// The light samples of one round: the nth offer of a point is added to the nth of the rounds.
#[inline(always)]
fn sample<W: Width>(
    width: W,
    lights: &LightSet,
    seed: u64,
    (stop, count): (&Stop, u32),
    rounds: &mut [Offers],
) {
    let Stop { walk, eye, .. } = stop;
    let zero = width.zero();
    let side = sampling_normal(&eye.point, &eye.bsdf);
    let is_two_sided = side == Vec3::ZERO;
    let (p, ns) = (Vector::all(zero, eye.point.p), Vector::all(zero, eye.point.ns));
    let mut visible = None;
    let first_of = walk.key.sample.wrapping_mul(count);
    for first in (0..count).step_by(W::R::LANES) {
        let key = |n: usize| SampleKey { sample: first_of.wrapping_add(first + n as u32), ..walk.key };
        let keys: [SampleKey; LANES] = std::array::from_fn(key);
        let draws = width.draws(seed, &keys, &[walk.edges; LANES]);
        let [u, v, emitter_choice] = W::triple(draws, purpose::POSITION);
        let requested = (count - first).min(W::R::LANES as u32);
        let requests_light = zero.points((1 << requested) - 1);
        let all_sides = zero.points(if is_two_sided { u64::from(u32::MAX) } else { 0 });
        let light =
            width.lights((lights, None), [requests_light, all_sides], [p, ns], [emitter_choice, u, v]);
        if !W::R::any(light.found & requests_light) {
            continue;
        }
        let visible = visible.get_or_insert_with(|| eye.bsdf.prepared(eye.wo));
        let (scattered, pdf) = visible.eval_pdf_all(light.dir);
        let lit = light.found & requests_light & !scattered.is_zero();
        for i in LanesOf(W::R::bits(lit)) {
            offer(stop, count, (&light, i), (scattered.get(i), pdf.lane(i)), &mut rounds[first as usize + i]);
        }
    }
}

/// A light sample of each of sixteen points or fewer that no light goes through.
#[inline(always)]
fn sample_each<W: Width>(width: W, lights: &LightSet, seed: u64, stops: &[&Stop], offers: &mut Offers) {
    let zero = width.zero();
    let (mut keys, mut edges) = ([SampleKey::default(); LANES], [0; LANES]);
    let (mut p, mut ns, mut all_sides) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3], 0);
    for (i, Stop { walk, eye, .. }) in stops.iter().enumerate() {
        (keys[i], edges[i]) = (walk.key, walk.edges);
        for k in 0..3 {
            (p[k][i], ns[k][i]) = (eye.point.p[k], eye.point.ns[k]);
        }
        all_sides |= u64::from(sampling_normal(&eye.point, &eye.bsdf) == Vec3::ZERO) << i;
    }
    let draws = width.draws(seed, &keys, &edges);
    let [u, v, emitter_choice] = W::triple(draws, purpose::POSITION);
    let requests_light = zero.points((1 << stops.len()) - 1);
    let [p, ns] = [&p, &ns].map(|[x, y, z]| Vector::load(zero, [x, y, z], 0));
    let light = width.lights(
        (lights, None),
        [requests_light, zero.points(all_sides)],
        [p, ns],
        [emitter_choice, u, v],
    );
    if !W::R::any(light.found & requests_light) {
        return;
    }
    let persistent = CachedLobes::new(stops.iter().map(|stop| (&stop.eye.bsdf, stop.eye.wo)));
    let (scattered, pdf) = persistent.eval_pdf(0, light.dir);
    let lit = light.found & requests_light & !scattered.is_zero();
    for i in LanesOf(W::R::bits(lit)) {
        offer(stops[i], 1, (&light, i), (scattered.get(i), pdf.lane(i)), offers);
    }
}

/// The offer of one of `count` light samples of a point.
#[inline(always)]
fn offer<R: Real>(
    stop: &Stop,
    count: u32,
    (light, i): (&LightSamples<R>, usize),
    (scattered, pdf): (Vec3, f32),
    offers: &mut Offers,
) {
    let Stop { walk, eye, light_gain, .. } = stop;
    let (dir, dist, chosen) = (light.dir.get(i), light.dist.lane(i), light.pdf.lane(i));
    let count = count as f32;
    let is_delta = R::bits(light.delta) >> i & 1 != 0;
    let share = if is_delta { 1.0 } else { balance_heuristic(count * chosen, stop.mean_rays() * pdf) };
    let offer = eye.throughput * scattered * light.radiance.get(i) * (share / (count * chosen));
    let absorption = eye.bsdf.absorption(dir);
    let left = left_after(dist, [absorption, Vec3::ZERO]);
    let offer = offer * left * (light_gain * stop.rest(dir));
    if let Some(ray) = shadow_ray(&eye.point, &eye.bsdf, dir, dist) {
        offers.push_of_light(ray, walk, offer, is_delta && absorption == Vec3::ZERO);
    }
}
