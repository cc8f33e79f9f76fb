// SPDX-License-Identifier: GPL-3.0-or-later
//! Light that comes straight from lamps: light samples where walks stop, those of one point side by side, and lights that only know
//! `illuminate`.
//! Source: [VG95] (weighed against the rays that leave the point). Space: world.
//! Invariant: the light samples of a point are the same however many are looked at at once.
//! Proof: crates/render/tests/{determinism,many_lights,agreement}.rs.

use glam::Vec3;
use gnurt_shading::bsdf::left_after;
use gnurt_shading::lanes::{LANES, LanesOf};
use gnurt_shading::lights::LightSet;
use gnurt_shading::real::{Real, Vector};
use gnurt_shading::{SampleKey, Vec3s};
use gnurt_simd::dispatch_wide;

use super::offers::Offers;
use super::pass::PassLights;
use super::walk::{Stop, purpose};
use crate::tracer::BatchTracer;
use crate::transport::mis::balance_heuristic;
use crate::transport::width::{One, Sixteen, Width};
use crate::transport::{Asking, Offer, ask_plugin_lights, sampling_normal, shadow_ray};

/// Light samples of a point from which on they are taken side by side.
const MANY: u32 = 4;

/// Light that comes straight from lamps.
pub(super) fn light_samples(
    tracer: &mut BatchTracer,
    pass: &PassLights,
    stops: &[Stop],
    radiance: &mut Vec3s,
) {
    let seed = tracer.options.seed;
    let lights = tracer.world.light_set();
    let there: Vec<&Stop> = stops.iter().filter(|stop| stop.eye.bsdf.is_smooth()).collect();
    let most = there.iter().map(|stop| pass.light_samples(stop.walk.is_seen)).max().unwrap_or(0);
    // Sample by sample, so that neighbouring rays are neighbours.
    let mut rounds: Vec<Offers> = (0..most).map(|_| Offers::default()).collect();
    for stop in &there {
        let count = pass.light_samples(stop.walk.is_seen);
        if count < MANY {
            sample(One, lights, seed, (stop, count), &mut rounds);
        } else {
            dispatch_wide!(
                tracer.options.level,
                simd => sample(Sixteen(simd), lights, seed, (stop, count), &mut rounds),
                else sample(One, lights, seed, (stop, count), &mut rounds)
            );
        }
    }
    let mut offers = Offers::default();
    rounds.iter().for_each(|round| offers.append(round));
    let asking: Vec<Asking> = there
        .iter()
        .map(|stop| Asking {
            point: &stop.eye.point,
            bsdf: &stop.eye.bsdf,
            key: stop.walk.key,
            edges: stop.walk.edges,
        })
        .collect();
    ask_plugin_lights(tracer.world, seed, &asking, |i, Offer { dir, dist, arriving }| {
        let Stop { walk, eye, lamp_gain, .. } = there[i];
        let left = left_after(dist, [eye.bsdf.absorption(dir), Vec3::ZERO]);
        let scattered = eye.throughput * eye.bsdf.eval(eye.wo, dir) * arriving * left;
        if let Some(ray) = shadow_ray(&eye.point, &eye.bsdf, dir, dist) {
            offers.push(ray, walk, scattered * (lamp_gain * there[i].rest(dir)));
        }
    });
    offers.settle(tracer, radiance);
}

/// So many light samples of a point: what the nth offers is added to the nth of the rounds.
#[inline(always)]
fn sample<W: Width>(
    width: W,
    lights: &LightSet,
    seed: u64,
    (stop, count): (&Stop, u32),
    rounds: &mut [Offers],
) {
    let Stop { walk, eye, lamp_gain, .. } = stop;
    let zero = width.zero();
    let side = sampling_normal(&eye.point, &eye.bsdf);
    let is_two_sided = side == Vec3::ZERO;
    let (p, ns) = (Vector::all(zero, eye.point.p), Vector::all(zero, eye.point.ns));
    let mut seen = None;
    let first_of = walk.key.sample.wrapping_mul(count);
    for first in (0..count).step_by(W::R::LANES) {
        let key = |n: usize| SampleKey { sample: first_of.wrapping_add(first + n as u32), ..walk.key };
        let keys: [SampleKey; LANES] = std::array::from_fn(key);
        let draws = width.draws(seed, &keys, &[walk.edges; LANES]);
        let [lamp, _] = W::pair(draws, purpose::LAMP);
        let [u, v] = W::pair(draws, purpose::PLACE);
        let wanted = (count - first).min(W::R::LANES as u32);
        let asks = zero.points((1 << wanted) - 1);
        let all_sides = zero.points(if is_two_sided { u64::from(u32::MAX) } else { 0 });
        let light = width.lights(lights, [asks, all_sides], [p, ns], [lamp, u, v]);
        if !W::R::any(light.found & asks) {
            continue;
        }
        let seen = seen.get_or_insert_with(|| eye.bsdf.seen(eye.wo));
        let (scattered, pdf) = seen.eval_pdf_all(light.dir);
        let lit = light.found & asks & !scattered.is_zero();
        for i in LanesOf(W::R::bits(lit)) {
            let (dir, dist, chosen) = (light.dir.get(i), light.dist.lane(i), light.pdf.lane(i));
            let count = count as f32;
            let share = if W::R::bits(light.delta) >> i & 1 != 0 {
                1.0
            } else {
                balance_heuristic(count * chosen, stop.mean_rays() * pdf.lane(i))
            };
            let offer =
                eye.throughput * scattered.get(i) * light.radiance.get(i) * (share / (count * chosen));
            let left = left_after(dist, [eye.bsdf.absorption(dir), Vec3::ZERO]);
            let offer = offer * left * (lamp_gain * stop.rest(dir));
            if let Some(ray) = shadow_ray(&eye.point, &eye.bsdf, dir, dist) {
                rounds[first as usize + i].push(ray, walk, offer);
            }
        }
    }
}
