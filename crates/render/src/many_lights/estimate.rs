// SPDX-License-Identifier: GPL-3.0-or-later
//! Radiance along camera rays, given the virtual lights of a pass: the common part of all integrators with
//! virtual lights.
//! Source: [Kel97]; rays return the energy that the bound removes from virtual lights [KK06]; direct light by
//! light samples and scattered rays, weighted [VG95]. Space: world. A path ends at a light. The last segment
//! but one, seen from the eye, is the first whose ends both scatter smoothly. Virtual lights bring their
//! share of that segment; a few rays that the eye's BSDF chooses bring the rest. From their hits the same is
//! repeated, with one ray and few randomly chosen virtual lights. Mirrors and smooth glass are followed,
//! because virtual lights never lie on them.
//! Tests: crates/render/tests/many_lights.rs.

use std::borrow::Cow;
use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use gnurt_accel::{INVALID_ID, RayBatch};
use gnurt_shading::bsdf::BsdfSample;
use gnurt_shading::sampling::{Basis, cosine_hemisphere, sample_pair};
use gnurt_shading::{SampleKey, SurfaceBatch, Vec3s};

use super::caustics;
use super::contribution::Contributions;
use super::cut::{MOST, cut};
use super::direct::light_samples;
use super::eye::EyePoint;
use super::gather::gather;
use super::interleave::{Texel, key_of_place, place_of, share_of_key};
use super::lanes::{BLOCK, END, Source};
use super::mixing::mix;
use super::offers::Offers;
use super::parts::Parts;
use super::pass::PassLights;
use super::vpl;
use super::walk::{Last, Stop, Walk, purpose};
use crate::behind::Behind;
use crate::cone::{Cone, ConeHit, fineness};
use crate::tracer::{BatchTracer, Sharing};
use crate::transport::manifold::{Caustics, Chain};
use crate::transport::mis::balance_heuristic;
use crate::transport::walks::{Stops, Walks};
use crate::transport::{Vertex, roulette, sampling_normal};
use crate::world::HitLanes;

/// Share of light that a surface must scatter to be averaged.
const LEAST_SHARE: f32 = 1e-3;

/// The number of rays from a visible point, and the probability of each. Several rays leave a point that only
/// scatters smoothly. If the point is matte and pictures are reused, the number is below one, because virtual
/// lights bring nearly all light there.
fn rays_from(pass: &PassLights, eye: &EyePoint) -> (u32, f32) {
    let bsdf = &eye.bsdf;
    let has_branches = || bsdf.has_deltas() && bsdf.delta_branches(eye.wo).iter().any(Option::is_some);
    match bsdf.lambertian() {
        Some(_) => (pass.rays, pass.ray_probability),
        None if bsdf.is_smooth() && !has_branches() => (pass.rays, 1.0),
        None => (1, 1.0),
    }
}

/// Writes the radiance against each camera ray.
pub(crate) fn radiance(tracer: &mut BatchTracer, pass: &PassLights, camera: HitLanes, radiance: &mut Vec3s) {
    all_radiance(tracer, pass, camera, radiance, None);
}

fn all_radiance(
    tracer: &mut BatchTracer,
    pass: &PassLights,
    camera: HitLanes,
    radiance: &mut Vec3s,
    texels: Option<&mut [Texel]>,
) {
    radiance.reset(camera.rays.len(), Vec3::ZERO);
    if tracer.options.max_depth == 0 {
        return;
    }
    Behind::begin(&mut tracer.behind, camera.rays.len());
    let options = tracer.options;
    let keys: Option<Vec<SampleKey>> = options
        .pattern()
        .filter(|_| texels.is_some())
        .map(|n| camera.keys.iter().map(|&key| key_of_place(key, options.width, n)).collect());
    tracer.sharing = match keys {
        _ if pass.is_few => Sharing::Random,
        Some(_) => Sharing::Pattern,
        None => Sharing::All,
    };
    let pixels = camera.keys;
    let camera = HitLanes { keys: keys.as_deref().unwrap_or(pixels), ..camera };
    let walk = |(lane, &key): (usize, &SampleKey)| Walk {
        lane: lane as u32,
        key,
        throughput: Vec3::ONE,
        start: camera.rays.get(lane).org.into(),
        absorption: Vec3::ZERO,
        edges: 1,
        last: None,
        is_directly_visible: true,
        light_gain: 1.0,
        siblings: 1.0,
        chain: Chain::default(),
    };
    let carried = camera.keys.iter().enumerate().map(walk).collect();
    let walks = Walks {
        rays: camera.rays.clone(),
        keys: camera.keys.to_vec(),
        cones: None,
        carried,
        ..Walks::default()
    };
    // The radiance of directly visible radiance-only shaders is used as it is.
    let probes = std::mem::replace(&mut tracer.probes, false);
    let mut passed = Vec::new();
    let stops = tracer.stopped(camera, &[], &mut |lane, vertex| passed.push((lane, vertex)));
    tracer.probes = probes;
    let mut parts = tracer.wavefront.ledger.is_some().then(Parts::default);
    let out = Out { radiance: &mut *radiance, texels, parts: parts.as_mut() };
    go_on(tracer, pass, (walks, Ends { stops, passed }), pixels, 1, out);
    if let (Some(parts), Some(ledger)) = (parts, &mut tracer.wavefront.ledger) {
        parts.write(radiance, &options.light_layers, &mut ledger.layers);
    }
    tracer.sharing = Sharing::All;
}

/// The same, with light and surfaces separate, each pixel with its subset of the virtual lights.
pub(crate) fn split_radiance(
    tracer: &mut BatchTracer,
    pass: &PassLights,
    camera: HitLanes,
    radiance: &mut Vec3s,
    texels: &mut [Texel],
) {
    all_radiance(tracer, pass, camera, radiance, Some(&mut *texels));
    for (lane, texel) in texels.iter_mut().enumerate() {
        let radiance_there = radiance.get(lane);
        if texel.instance == INVALID_ID {
            texel.plain = radiance_there;
            continue;
        }
        for k in 0..3 {
            // The emission of a surface that scatters nothing is not irradiance.
            if texel.share[k] > LEAST_SHARE {
                texel.light[k] = radiance_there[k] / texel.share[k];
            } else {
                (texel.share[k], texel.plain[k]) = (0.0, texel.plain[k] + radiance_there[k]);
            }
        }
    }
}

/// The sums to which walks add their light.
struct Out<'a> {
    radiance: &'a mut Vec3s,
    /// Light and surfaces separate, if pixels are interleaved.
    texels: Option<&'a mut [Texel]>,
    /// Layers of light, if some are requested; for walks that begin at the camera.
    parts: Option<&'a mut Parts>,
}

/// Continues walks from their hits to their ends. `keys` are those of the camera rays, `depth` the bounces so
/// far.
fn go_on(
    tracer: &mut BatchTracer,
    pass: &PassLights,
    (mut walks, mut ends): (Walks<Walk>, Ends),
    keys: &[SampleKey],
    depth: u32,
    Out { radiance, mut texels, mut parts }: Out,
) {
    for (step, depth) in (depth..).enumerate() {
        if let Some(texels) = &mut texels {
            split_radiance_only(tracer, &ends.dim(&walks.carried), &ends.stops.vertices, texels);
        }
        // Only light of the first and the second edge is told apart.
        let mut parts = parts.as_deref_mut().filter(|_| step < 2);
        let passed = parts.as_ref().filter(|_| step == 0).map(|_| visible_parts(tracer, &walks, &ends));
        if let Some(parts) = &mut parts {
            parts.begin(radiance);
        }
        let stops = arrive(tracer, pass, &walks, ends, radiance);
        if let Some(parts) = &mut parts {
            match passed {
                Some((emission, missed)) => parts.take_visible(radiance, &emission, &missed),
                None => parts.take_direct(radiance),
            }
        }
        if let Some(texels) = &mut texels {
            split_texels(tracer, &stops, radiance, texels);
        }
        light_samples(tracer, pass, &stops, radiance);
        if let Some(parts) = parts.filter(|_| step == 0) {
            parts.take_direct(radiance);
        }
        let radiance_there: Vec<&EyePoint> =
            stops.iter().filter(|stop| stop.walk.is_directly_visible).map(|stop| &stop.eye).collect();
        caustics::search(tracer, &stops, radiance);
        if pass.is_few {
            // Visible points of this kind use a random subset, too.
        } else if texels.is_none() {
            gather(tracer, &radiance_there, keys, pass.whole(), &pass.bound, radiance);
        } else if let Some(n) = tracer.options.pattern() {
            let position = |eye: &EyePoint| place_of(keys[eye.lane as usize].pixel, tracer.options.width, n);
            for (number, share) in pass.sources.iter().enumerate() {
                let there: Vec<&EyePoint> =
                    radiance_there.iter().copied().filter(|eye| position(eye) == number).collect();
                gather(tracer, &there, keys, share, &pass.bound, radiance);
            }
        }
        few_virtual_lights(tracer, pass, &stops, radiance);
        walks = scatter(tracer, pass, &stops);
        if walks.is_empty() {
            return;
        }
        ends = next(tracer, &walks, depth);
    }
}

/// From the first smoothly scattering surface on, the light of a pixel counts as light on that surface.
fn split_texels(tracer: &BatchTracer, stops: &[Stop], radiance: &mut Vec3s, texels: &mut [Texel]) {
    for stop in stops.iter().filter(|stop| stop.walk.is_directly_visible && stop.eye.bsdf.is_smooth()) {
        let lane = stop.walk.lane as usize;
        if texels[lane].instance != INVALID_ID {
            continue;
        }
        let eye = &stop.eye;
        texels[lane] = Texel {
            plain: radiance.get(lane),
            share: eye.throughput * eye.bsdf.albedo(eye.wo),
            light: Vec3::ZERO,
            p: eye.point.p,
            ns: eye.point.ns,
            width: tracer.cone.width_at(stop.distance),
            instance: stop.instance,
            is_diffuse: eye.bsdf.lambertian().is_some(),
        };
        radiance.set(lane, Vec3::ZERO);
    }
}

/// The same for radiance-only shaders: their radiance counts as light on their surface.
fn split_radiance_only(
    tracer: &BatchTracer,
    walks: &[Walk],
    vertices: &[Option<Vertex>],
    texels: &mut [Texel],
) {
    for (walk, vertex) in walks.iter().zip(vertices) {
        let Some(vertex) = vertex.as_ref().filter(|vertex| vertex.is_final && walk.is_directly_visible)
        else {
            continue;
        };
        let texel = &mut texels[walk.lane as usize];
        if texel.instance == INVALID_ID {
            *texel = Texel {
                share: walk.throughput * vertex.scattering.bsdf.albedo(vertex.wo),
                p: vertex.point.p,
                ns: vertex.point.ns,
                width: tracer.cone.width_at(vertex.t),
                instance: vertex.ids[0],
                ..Texel::default()
            };
        }
    }
}

/// Where walks lead.
struct Ends {
    stops: Stops,
    /// Emitting surfaces that they pass on the way, with the number of the walk.
    passed: Vec<(usize, Vertex)>,
}

impl Ends {
    /// The walks with the light that comes from where they stop.
    fn dim<'a>(&self, walks: &'a [Walk]) -> Cow<'a, [Walk]> {
        if !self.stops.is_tinted() {
            return walks.into();
        }
        let dim =
            |(i, walk): (usize, &Walk)| Walk { throughput: walk.throughput * self.stops.passed(i), ..*walk };
        walks.iter().enumerate().map(dim).collect()
    }
}

/// The hits of walks; radiance-only shaders seen directly or by mirrors show their own radiance.
fn next(tracer: &mut BatchTracer, walks: &Walks<Walk>, depth: u32) -> Ends {
    let first_is_seen = walks.carried.first().is_some_and(|walk| walk.is_directly_visible);
    if walks.carried.iter().all(|walk| walk.is_directly_visible == first_is_seen) {
        return meet(tracer, walks, first_is_seen, depth);
    }
    let mut ends = Ends { stops: Stops::none(walks.carried.len()), passed: Vec::new() };
    for is_directly_visible in [true, false] {
        let mut some = Walks::default();
        for (i, walk) in walks
            .carried
            .iter()
            .enumerate()
            .filter(|(_, walk)| walk.is_directly_visible == is_directly_visible)
        {
            let cone = walks.cones.as_ref().map_or_else(Cone::default, |cones| cones.get(i));
            some.push((walks.rays.get(i), cone), walk.key, i);
        }
        let found = meet(tracer, &some, is_directly_visible, depth);
        let passed = found.passed.into_iter().map(|(k, vertex)| (some.carried[k], vertex));
        ends.passed.extend(passed);
        some.carried.iter().enumerate().for_each(|(k, &i)| ends.stops.tint(i, found.stops.passed(k)));
        let found = some.carried.into_iter().zip(found.stops.vertices);
        found.for_each(|(i, vertex)| ends.stops.vertices[i] = vertex);
    }
    ends
}

/// The hits of walks of which all, or none, are directly visible.
fn meet<W>(tracer: &mut BatchTracer, walks: &Walks<W>, is_directly_visible: bool, depth: u32) -> Ends {
    let probes = std::mem::replace(&mut tracer.probes, !is_directly_visible);
    let mut passed = Vec::new();
    let stops = walks.meet_all(tracer, depth, &mut |lane, vertex| passed.push((lane, vertex)));
    tracer.probes = probes;
    Ends { stops, passed }
}

/// The light that virtual lights leave to rays, found by one ray.
pub(super) struct Rest {
    /// Unit, where it was found; chosen by the cosine.
    pub(super) dir: Vec3,
    /// To the shading normal.
    pub(super) cos: f32,
    /// How far it was; infinite where there is nothing.
    pub(super) dist: f32,
    pub(super) radiance: Vec3,
}

/// One ray from each point of a shader that loops over lights itself, and the light along it that neither
/// lights nor virtual lights bring there.
pub(super) fn rest_at(
    tracer: &mut BatchTracer,
    pass: &PassLights,
    points: &SurfaceBatch,
) -> Vec<Option<Rest>> {
    let mut found: Vec<Option<Rest>> = (0..points.len()).map(|_| None).collect();
    let edges = points.depth + 1;
    if edges >= tracer.options.max_depth {
        return found;
    }
    let mut walks = Walks::default();
    for (i, found) in found.iter_mut().enumerate() {
        let (point, key) = (points.point(i), points.key[i]);
        let local = cosine_hemisphere(sample_pair(tracer.options.seed, key, edges, purpose::DIRECTION));
        let dir = Basis::around(point.ns).to_world(local).normalize();
        let cos = point.ns.dot(dir);
        let Some(ray) = point.scatter_ray(dir, false, f32::INFINITY).filter(|_| cos > 0.0) else { continue };
        let pdf = cos * FRAC_1_PI;
        let last = Last { point, pdf, side: point.ns, light_samples: 1.0, bound: pass.bound };
        let sample =
            BsdfSample { wi: dir, weight: Vec3::ONE, pdf, delta: false, transmitted: false, wide: true };
        let cone = ConeHit::of(points, i).after(&sample, fineness(key.sample));
        walks.push(
            (ray, cone),
            key,
            Walk {
                lane: i as u32,
                key,
                throughput: Vec3::ONE,
                start: point.p,
                absorption: Vec3::ZERO,
                edges: edges + 1,
                last: Some(last),
                is_directly_visible: false,
                // The shader samples lights itself.
                light_gain: 0.0,
                siblings: 1.0,
                chain: Chain::default(),
            },
        );
        *found = Some(Rest { dir, cos, dist: f32::INFINITY, radiance: Vec3::ZERO });
    }
    let ends = next(tracer, &walks, edges);
    for (walk, vertex) in walks.carried.iter().zip(&ends.stops.vertices) {
        if let (Some(found), Some(vertex)) = (&mut found[walk.lane as usize], vertex) {
            found.dist = vertex.t;
        }
    }
    let mut radiance = Vec3s::splat(points.len(), Vec3::ZERO);
    go_on(
        tracer,
        pass,
        (walks, ends),
        &points.key,
        edges + 1,
        Out { radiance: &mut radiance, texels: None, parts: None },
    );
    for (i, found) in found.iter_mut().enumerate() {
        if let Some(found) = found {
            found.radiance = radiance.get(i);
        }
    }
    found
}

/// The emission that camera rays pass on their way, and which of them meet nothing in the end, by lane.
fn visible_parts(tracer: &BatchTracer, walks: &Walks<Walk>, ends: &Ends) -> (Vec3s, Vec<bool>) {
    let mut emission = Vec3s::splat(walks.carried.len(), Vec3::ZERO);
    for (i, vertex) in &ends.passed {
        let walk = walks.carried[*i].absorbed(Some(vertex));
        emitted(tracer, &walk, vertex, &mut emission);
    }
    (emission, ends.stops.vertices.iter().map(Option::is_none).collect())
}

/// Adds the light at the end of each ray; returns the walks that may continue.
fn arrive(
    tracer: &mut BatchTracer,
    pass: &PassLights,
    walks: &Walks<Walk>,
    ends: Ends,
    radiance: &mut Vec3s,
) -> Vec<Stop> {
    let lights = tracer.world.light_set();
    let mut stops = Vec::with_capacity(ends.stops.vertices.len());
    let Walks { rays, carried, .. } = walks;
    for (i, vertex) in &ends.passed {
        emitted(tracer, &carried[*i].absorbed(Some(vertex)), vertex, radiance);
    }
    let carried = &ends.dim(carried)[..];
    environment_of_shaders(tracer, carried, &ends.stops.vertices, rays, radiance);
    for (i, (walk, vertex)) in carried.iter().zip(ends.stops.vertices).enumerate() {
        let lane = walk.lane as usize;
        let walk = &walk.absorbed(vertex.as_ref());
        let Some(mut vertex) = vertex else {
            let dir = Vec3::from(rays.get(i).dir);
            let is_straight = walk.edges == 1;
            if is_straight {
                Behind::leave(&mut tracer.behind, lane, walk.throughput);
            }
            let is_backdrop = is_straight && tracer.world.lights().backdrop.is_some();
            let radiance_there = match is_backdrop {
                true => tracer.environment(rays, &[i], |_| true).get(0),
                false => lights.environment(dir),
            };
            if radiance_there != Vec3::ZERO {
                let pdf = walk.last.map_or(0.0, |last| lights.pdf_environment(last.point.p, last.side, dir));
                let light = walk.throughput * radiance_there * (walk.light_gain * share_of(walk, pdf));
                radiance.add(lane, light);
                if is_straight {
                    Behind::add(&mut tracer.behind, lane, light);
                }
            }
            continue;
        };
        emitted(tracer, walk, &vertex, radiance);
        if vertex.is_final || walk.edges >= tracer.options.max_depth {
            continue;
        }
        let Vertex { light_gain, ids: [instance, ..], t: distance, cone, .. } = vertex;
        let smooth = vertex.smooth.take();
        let eye = EyePoint::new(vertex, walk.throughput, walk.edges, walk.lane);
        let (rays, probability) = if walk.is_directly_visible { rays_from(pass, &eye) } else { (1, 1.0) };
        let stop = Stop { walk: *walk, eye, light_gain, rays, probability, instance, distance, cone, smooth };
        if !stop.is_spent() {
            stops.push(stop);
        }
    }
    stops
}

/// The weight of light at the end of a walk that light samples find with density `pdf_light`, too.
fn share_of(walk: &Walk, pdf_light: f32) -> f32 {
    walk.last.map_or(1.0, |last| balance_heuristic(last.pdf, last.light_samples * pdf_light))
}

/// Adds the emission of a surface that a walk met.
fn emitted(tracer: &BatchTracer, walk: &Walk, vertex: &Vertex, radiance: &mut Vec3s) {
    let lights = tracer.world.light_set();
    let emission = vertex.scattering.emission;
    if emission == Vec3::ZERO {
        return;
    }
    let lane = walk.lane as usize;
    let light = lights.shape(vertex.ids, -vertex.wo);
    let pdf = walk.last.map_or(0.0, |last| {
        let dist = (vertex.point.p - last.point.p).length();
        light
            .filter(|_| !vertex.is_final)
            .map_or(0.0, |light| lights.pdf_shape(last.point.p, last.side, light, -vertex.wo, dist))
    });
    // Light samples find the described emission, without the additional radiance of a probed shader.
    let shown = vertex.shown;
    let gain = if light.is_some() { walk.light_gain } else { 1.0 };
    let share = share_of(walk, pdf) * caustics::beside_searches(tracer, walk, vertex);
    radiance.add(lane, walk.throughput * (emission - shown) * (gain * share));
    radiance.add(lane, walk.throughput * shown);
}

/// Radiance of walks that left the scene, if only a shader knows the environment.
fn environment_of_shaders(
    tracer: &mut BatchTracer,
    walks: &[Walk],
    vertices: &[Option<Vertex>],
    rays: &RayBatch,
    radiance: &mut Vec3s,
) {
    if tracer.world.light_set().has_environment() || tracer.world.lights().environment.is_none() {
        return;
    }
    let missed: Vec<usize> = (0..walks.len()).filter(|&i| vertices[i].is_none()).collect();
    let radiance_there = tracer.environment(rays, &missed, |lane| walks[lane].edges == 1);
    for (k, &i) in missed.iter().enumerate() {
        let walk = walks[i].absorbed(None);
        let (lane, light) = (walk.lane as usize, walk.throughput * radiance_there.get(k));
        radiance.add(lane, light);
        if walk.edges == 1 {
            Behind::add(&mut tracer.behind, lane, light);
        }
    }
}

/// Whether all that virtual lights bring there is brought by a few of them.
fn uses_few(pass: &PassLights, stop: &Stop) -> bool {
    pass.is_few || !stop.walk.is_directly_visible
}

/// Light from a few virtual lights at the hits of scattered rays. They are chosen by unoccluded contribution
/// [TCE05], computed in lanes, from a subset that differs from block to block, or from the lights that the
/// pixel itself gathers.
fn few_virtual_lights(tracer: &mut BatchTracer, pass: &PassLights, stops: &[Stop], radiance: &mut Vec3s) {
    let there: Vec<&Stop> =
        stops.iter().filter(|stop| uses_few(pass, stop) && stop.eye.bsdf.is_smooth()).collect();
    if there.is_empty() || pass.vpls.is_empty() {
        return;
    }
    let mut offers = Offers::default();
    let shares = pass.unseen();
    // In patterns each point uses its pixel's subset, else its block's, so that blocks are full.
    let (own, mut others) = match tracer.sharing {
        Sharing::Pattern => (there, Vec::new()),
        Sharing::All | Sharing::Random => (Vec::new(), there),
    };
    if let Some(first) = others.first() {
        // Blocks use the subsets in rotation, from a random start.
        let Walk { key, edges, .. } = first.walk;
        let [u, v] = sample_pair(tracer.options.seed, key, edges, purpose::SHARE);
        let begin = (u * shares.len() as f32) as usize;
        mix(&mut others, v.to_bits());
        for (n, stops) in others.chunks(BLOCK).enumerate() {
            query_few(tracer, pass, &shares[(begin + n) % shares.len()], stops, &mut offers);
        }
    }
    if !own.is_empty() {
        let mut by_share: Vec<Vec<&Stop>> = vec![Vec::new(); shares.len()];
        for stop in own {
            by_share[share_of_key(tracer.sharing, stop.walk.key, shares.len())].push(stop);
        }
        for (share, of_share) in shares.iter().zip(&by_share) {
            for stops in of_share.chunks(BLOCK) {
                query_few(tracer, pass, share, stops, &mut offers);
            }
        }
    }
    offers.settle(tracer, radiance);
}

/// The same for neighbours that use some of the virtual lights, `BLOCK` at most.
fn query_few(
    tracer: &BatchTracer,
    pass: &PassLights,
    share: &[Source],
    stops: &[&Stop],
    offers: &mut Offers,
) {
    let (seed, level, max_edges) = (tracer.options.seed, tracer.options.level, tracer.options.max_depth);
    let eyes: Vec<&EyePoint> = stops.iter().map(|stop| &stop.eye).collect();
    let [u, _] = sample_pair(seed, stops[0].walk.key, stops[0].walk.edges, purpose::CUT);
    let fewer = cut(&eyes, share, MOST, u);
    let bound = pass.bound_at(false);
    let mut contributions = Contributions::new(fewer.as_deref().unwrap_or(share), bound, max_edges);
    contributions.query(level, &eyes);
    for (lane, Stop { walk, eye, .. }) in stops.iter().enumerate() {
        let [u, _] = sample_pair(seed, walk.key, walk.edges, purpose::CHOICE);
        contributions.choose(lane, pass.few_at(walk.edges), u, |vpl, brought| {
            let offset = vpl.point.p - eye.point.p;
            let offer = brought * stops[lane].rest(offset.normalize());
            let Some(start) = vpl::start(eye, offset) else { return };
            let offset = vpl::end(&vpl.point, -offset) - start;
            let ray = gnurt_accel::Ray::new(start.into(), offset.into()).within(0.0, END);
            offers.push(ray, walk, offer);
        });
    }
}

/// Where walks go on.
fn scatter(tracer: &BatchTracer, pass: &PassLights, stops: &[Stop]) -> Walks<Walk> {
    let mut walks = Walks::default();
    for stop in stops {
        for n in 0..stop.rays {
            if let Some((from, walk)) = scattered((tracer.options.seed, tracer.caustics), pass, stop, n) {
                walks.push(from, walk.key, walk);
            }
        }
    }
    walks
}

/// The `n`th of the rays that go on from a stop.
fn scattered(
    (seed, caustics): (u64, Option<&Caustics>),
    pass: &PassLights,
    stop: &Stop,
    n: u32,
) -> Option<((gnurt_accel::Ray, Cone), Walk)> {
    let Stop { walk, eye, rays: count, probability, .. } = stop;
    let (count, probability) = (*count, *probability);
    let key = SampleKey { sample: walk.key.sample.wrapping_mul(count).wrapping_add(n), ..walk.key };
    let [u, v] = sample_pair(seed, key, walk.edges, purpose::DIRECTION);
    let [lobe, end] = sample_pair(seed, key, walk.edges, purpose::LOBE);
    if walk.is_directly_visible && end >= probability {
        return None;
    }
    let (ray, sample) = eye.scatter([lobe, u, v])?;
    let rest = if sample.delta { 1.0 } else { stop.rest(sample.wi) };
    let mut throughput = walk.throughput * sample.weight * rest;
    // The edge to a virtual light is still to come, and siblings are not ended for being many.
    if roulette::decides(walk.edges + 1) && !walk.is_directly_visible {
        let survival = roulette::survival(throughput.max_element() * walk.siblings);
        if end >= survival {
            return None;
        }
        throughput /= survival;
    }
    throughput /= stop.mean_rays();
    if throughput == Vec3::ZERO || !throughput.is_finite() {
        return None;
    }
    let last = Last {
        point: eye.point,
        pdf: sample.pdf,
        side: sampling_normal(&eye.point, &eye.bsdf),
        light_samples: pass.light_samples(walk.is_directly_visible) as f32 / stop.mean_rays(),
        bound: pass.bound_at(walk.is_directly_visible),
    };
    let next = Walk {
        key: if count > 1 { walk.key.fork(n) } else { walk.key },
        throughput,
        start: eye.point.p,
        absorption: eye.bsdf.absorption(sample.wi),
        edges: walk.edges + 1,
        last: (!sample.delta).then_some(last),
        is_directly_visible: walk.is_directly_visible && sample.delta,
        light_gain: stop.light_gain,
        siblings: walk.siblings * count as f32,
        chain: caustics::chain(caustics, stop, &sample),
        ..*walk
    };
    Some(((ray, stop.cone.after(&sample, fineness(walk.key.sample))), next))
}
