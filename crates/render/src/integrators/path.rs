// SPDX-License-Identifier: GPL-3.0-or-later
//! Path tracing: the reference. From the eye, one scattered ray per vertex, lights sampled at each.
//! Source: [Kaj86] (path tracing), [VG95] (both samples combined by the power heuristic), [AK90] (Russian
//! roulette); wavefronts after [SIP06], section 8: all paths of a batch take a step together, grouped by
//! shader (`transport::step`). A shadow catcher shows the background, minus the light that its light samples
//! find occluded, plus the light that scattered rays bring from other surfaces; unshadowed parts have no
//! noise [Deb98].
//! Space: world. An edge is a path segment between two vertices, the eye included: light found at the end of
//! edge k was scattered k - 1 times. A ray that passes through transparent parts stays on its edge.
//! Invariants: unbiased without `clamp`; the result of a lane depends on its ray and key only.
//! Tests: crates/render/tests/{path,agreement,references,lanes}.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::left_after;
use gnurt_shading::lights::LightId;
use gnurt_shading::{SampleKey, Vec3s};
use gnurt_simd::dispatch_wide;

use crate::behind::Behind;
use crate::seen::most_edges;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::transport::absorption::absorb;
use crate::transport::links::LinkedPaths;
use crate::transport::manifold;
use crate::transport::step::{self, Met, Onward};
use crate::transport::width::{One, Sixteen};
use crate::transport::{
    Blockers, Known, LightQuery, Offer, Path, Wavefront, add, media, panes, query_plugin_lights, shadow_ray,
    unguided_share, weigh_environment,
};
use crate::world::HitLanes;

pub(super) fn radiance(tracer: &mut BatchTracer, camera: HitLanes, radiance: &mut Vec3s) {
    radiance.reset(camera.rays.len(), Vec3::ZERO);
    let mut wavefront = std::mem::take(&mut tracer.wavefront);
    let media = tracer.world.media();
    let has_media = media.is_empty() && tracer.world.materials().has_media();
    for paths in [&mut wavefront.paths, &mut wavefront.next] {
        paths.set_media(has_media);
        paths.set_bodies(media.has_bodies());
        paths.set_guided(tracer.guide.is_some());
        paths.set_chains(tracer.caustics.is_some());
    }
    wavefront.paths.start(camera.rays);
    Behind::begin(&mut tracer.behind, camera.rays.len());
    let lanes = if tracer.options.seen { camera.rays.len() } else { 0 };
    wavefront.seen.reset(lanes, most_edges(tracer.options));
    if let Some(ledger) = &mut wavefront.ledger {
        ledger.start(camera.rays.len());
    }
    if let Some(linked) = &mut wavefront.linked {
        linked.start(camera.rays.len());
    }
    let mut hits = std::mem::take(&mut wavefront.hits);
    if media.is_empty() {
        step(tracer, camera, &mut wavefront, radiance);
    } else {
        wavefront.paths.begin_inside(media::inside_at(tracer, camera.rays, camera.keys));
        hits.clone_from(camera.hits);
        fly(tracer, (camera.rays, camera.keys), &mut hits, &mut wavefront, radiance);
        step(tracer, HitLanes { hits: &hits, ..camera }, &mut wavefront, radiance);
    }
    for round in 1.. {
        std::mem::swap(&mut wavefront.paths, &mut wavefront.next);
        if let Some(ledger) = &mut wavefront.ledger {
            ledger.end_step();
        }
        if let Some(linked) = &mut wavefront.linked {
            linked.end_step();
        }
        if wavefront.paths.is_empty() {
            break;
        }
        // Lent out while the step is taken.
        let (mut rays, keys, cones) = wavefront.paths.lend();
        tracer.stats.secondary_rays += rays.len() as u64;
        let differs = || *tracer.differs_for_camera.get_or_init(|| tracer.world.differs_for_camera());
        let kinds = if wavefront.paths.has_straight() && differs() {
            wavefront.paths.set_kinds(&mut rays);
            RayMask::CAMERA | RayMask::OTHER
        } else {
            RayMask::OTHER
        };
        tracer.intersect_into(kinds, &rays, &keys, Coherence::Incoherent, &mut hits);
        rays.mask.clear();
        if let Some(log) = &mut tracer.log {
            log.rays(round, &rays, &hits);
        }
        if !tracer.world.media().is_empty() {
            fly(tracer, (&rays, &keys), &mut hits, &mut wavefront, radiance);
        }
        let from = HitLanes { rays: &rays, keys: &keys, hits: &hits, cones: Some(&cones), depth: round };
        step(tracer, from, &mut wavefront, radiance);
        wavefront.paths.take_back((rays, keys, cones));
    }
    wavefront.hits = hits;
    std::mem::swap(&mut tracer.seen, &mut wavefront.seen);
    tracer.wavefront = wavefront;
}

/// Flies along rays up to their hits.
fn fly(
    tracer: &BatchTracer,
    (rays, keys): (&RayBatch, &[SampleKey]),
    hits: &mut HitBatch,
    wavefront: &mut Wavefront,
    radiance: &mut Vec3s,
) {
    let Wavefront { paths, in_media, near_lamps, ledger, recorder, .. } = wavefront;
    let light = (radiance, ledger.as_mut(), recorder.as_mut());
    media::fly((tracer.world, tracer.options), (rays, keys), paths, hits, [in_media, near_lamps], light);
}

/// Takes the light at the ends of the paths' rays, then scatters them.
fn step(tracer: &mut BatchTracer, from: HitLanes, wavefront: &mut Wavefront, radiance: &mut Vec3s) {
    let options = tracer.options;
    // Shadow rays from directly visible points start close together and aim at few lights; later ones start
    // anywhere.
    tracer.shadows = if from.depth == 0 { Coherence::Fanned } else { Coherence::Incoherent };
    environment(tracer, from, wavefront, radiance);
    wavefront.radiance_only.clear();
    wavefront.next.begin();
    wavefront.unshadowed.begin();
    if let Some(ledger) = &mut wavefront.ledger {
        ledger.begin_step();
    }
    if let Some(linked) = &mut wavefront.linked {
        linked.begin_step();
    }
    surfaces(tracer, from, wavefront, radiance);
    leave(tracer, from, wavefront, radiance);
    if !tracer.world.media().is_empty() {
        let Wavefront { paths, next, unshadowed, in_media, near_lamps, ledger, linked, recorder, .. } =
            &mut *wavefront;
        let (ledger, linked, recorder) = (ledger.as_mut(), linked.as_mut(), recorder.as_mut());
        let (seen, held) = (None, None);
        let mut onward = Onward { next, unshadowed, radiance, ledger, linked, recorder, seen, held };
        let (of, from) = ((tracer.world, options, tracer.guide), (&*paths, from.keys));
        for vertices in [(&*in_media, true), (&*near_lamps, false)] {
            dispatch_wide!(
                options.level,
                simd => media::scatter(Sixteen(simd), of, from, vertices, &mut onward),
                else media::scatter(One, of, from, vertices, &mut onward)
            );
        }
    }
    wavefront.next.end();
    wavefront.unshadowed.end();
    if options.aovs && from.depth == 0 {
        note_direct(tracer, &wavefront.radiance_only, radiance);
    }
    let Wavefront { unshadowed, through, ledger, linked, recorder, seen, .. } = wavefront;
    let blockers = linked.as_ref().map(|LinkedPaths { links, blockers: sets, .. }| Blockers { links, sets });
    let passes = (unshadowed.through(tracer.world.media()), blockers);
    tracer.passed(&unshadowed.request, passes, through);
    let media = Some(tracer.world.media()).filter(|media| !media.is_empty());
    panes::trace_through(tracer, &unshadowed.request, media, unshadowed.delta_requests(), through);
    for k in 0..through.len() {
        let share = through.get(k);
        if share != Vec3::ZERO {
            let (lane, light, edges) = unshadowed.get(k);
            let light = add(radiance, lane, light * share, edges, options.clamp);
            if let Some(ledger) = ledger {
                ledger.arrived(k, (lane, light));
            }
            if let Some(recorder) = recorder {
                recorder.found(unshadowed.trail_of(k), light);
            }
            if options.seen {
                seen.add(lane, light, unshadowed.way_of(k));
            }
        }
    }
}

/// The step of the paths that met surfaces, shader by shader.
fn surfaces(tracer: &mut BatchTracer, from: HitLanes, wavefront: &mut Wavefront, radiance: &mut Vec3s) {
    let (world, options, pixel_order) = (tracer.world, tracer.options, tracer.pixel_order);
    let Wavefront {
        paths,
        next,
        unshadowed,
        order,
        radiance_only,
        closures,
        ledger,
        linked,
        recorder,
        below,
        seen,
        ..
    } = wavefront;
    below.begin();
    world.sort_by_material(from.hits, 0..from.hits.len(), order);
    tracer.for_each_surface_of(order, from, AttributeRequests::Light, |tracer, shader, numbers, points| {
        if let Some(log) = &mut tracer.log {
            log.surface(shader, points);
        }
        let is_final = tracer.closures_of(shader, points, closures) == Known::Shown;
        absorb(options, (&mut *paths, from), numbers, points, closures);
        let backdrop = shader.backdrop();
        // The backdrop of a shadow catcher represents scattered light, and occluded light is subtracted from
        // it.
        if is_final || backdrop.is_some() {
            radiance_only.extend(numbers.iter().map(|&number| paths.lane[number as usize]));
        }
        let medium = world.media().of_points(world, points);
        let mut shares: &[f32] = &[];
        if !is_final && closures.has_subsurface() {
            below.enter((world, options), (&*paths, from), (numbers, points), closures);
            shares = &below.shares;
        }
        let met = Met {
            world,
            options,
            pixel_order,
            from,
            paths,
            numbers,
            points,
            closures,
            backdrop,
            is_final,
            medium,
            shares,
            guide: tracer.guide,
            caustics: tracer.caustics,
        };
        let mut onward = Onward {
            next,
            unshadowed,
            radiance,
            ledger: ledger.as_mut(),
            linked: linked.as_mut(),
            recorder: recorder.as_mut(),
            seen: options.seen.then_some(&mut *seen),
            held: Some(&mut tracer.held).filter(|held| !held.is_empty()),
        };
        scatter(&met, &mut onward);
        if met.caustics.is_some() {
            let (ledger, linked) = (ledger.as_mut(), linked.as_mut());
            let (recorder, seen) = (recorder.as_mut(), options.seen.then_some(&mut *seen));
            let mut onward =
                Onward { next, unshadowed, radiance, ledger, linked, recorder, seen, held: None };
            manifold::connect(tracer, &met, &mut onward);
        }
    });
}

/// Takes the light at some points, and sends their paths on.
fn scatter(met: &Met, onward: &mut Onward) {
    dispatch_wide!(
        met.options.level,
        simd => step::step(Sixteen(simd), met, onward),
        else step::step(One, met, onward)
    );
    if !(met.is_final || met.world.lights().plugins.is_empty()) {
        query_plugins(met, onward);
    }
}

/// The step of paths below surfaces, from where they leave.
fn leave(tracer: &mut BatchTracer, from: HitLanes, wavefront: &mut Wavefront, radiance: &mut Vec3s) {
    if wavefront.below.is_empty() {
        return;
    }
    let (world, options, pixel_order) = (tracer.world, tracer.options, tracer.pixel_order);
    let guide = tracer.guide;
    let Wavefront { paths, next, unshadowed, ledger, linked, recorder, below, .. } = wavefront;
    below.leave(tracer, paths, from, |paths, from, numbers, points, closures| {
        let (backdrop, is_final, medium, shares) = (None, false, 0, &[][..]);
        let met = Met {
            world,
            options,
            pixel_order,
            from,
            paths,
            numbers,
            points,
            closures,
            backdrop,
            is_final,
            medium,
            shares,
            guide,
            // Lamps beyond are found by chance.
            caustics: None,
        };
        let (ledger, linked) = (ledger.as_mut(), linked.as_mut());
        let (recorder, seen, held) = (recorder.as_mut(), None, None);
        let mut onward = Onward { next, unshadowed, radiance, ledger, linked, recorder, seen, held };
        scatter(&met, &mut onward);
    });
}

/// Light of lights that only have `illuminate`.
fn query_plugins(met: &Met, onward: &mut Onward) {
    let paths: Vec<_> = (0..met.numbers.len()).map(|k| met.path(k)).collect();
    let there = |&k: &usize| paths[k].edges < met.options.max_depth && met.is_there(k, &paths[k]);
    let alive: Vec<usize> = (0..paths.len()).filter(there).collect();
    let vertices: Vec<_> =
        alive.iter().map(|&k| (k, met.points.point(k), met.closures.point(k).bsdf)).collect();
    let queries: Vec<LightQuery> = vertices
        .iter()
        .map(|(k, point, bsdf)| LightQuery { point, bsdf, key: paths[*k].key, edges: paths[*k].edges })
        .collect();
    query_plugin_lights(met.world, met.options.seed, &queries, |i, Offer { dir, dist, arriving }| {
        let (k, point, bsdf) = &vertices[i];
        let wo = -met.points.ray_dir.get(*k);
        let absorption = if met.absorbs() { bsdf.absorption(dir) } else { Vec3::ZERO };
        let left = left_after(dist, [absorption, Vec3::ZERO]);
        let value = paths[*k].throughput * bsdf.eval(wo, dir) * arriving * left;
        if value != Vec3::ZERO
            && let Some(ray) = shadow_ray(point, bsdf, dir, dist)
        {
            onward.unshadowed.reserve(1);
            let mut path = Path { ..paths[*k] };
            if met.medium != 0 && bsdf.is_transmitted(dir) {
                path.inside = path.inside.crossing(met.medium, met.points.front(*k));
            }
            onward.unshadowed.push(&path, ray, value, absorption == Vec3::ZERO);
            if let Some(linked) = &mut onward.linked {
                linked.blockers.push(0);
            }
            if let Some(ledger) = &mut onward.ledger {
                let events = met.events(ledger, *k, [wo, dir], (bsdf.is_transmitted(dir), false));
                let end = ledger.paths.classes.plugin();
                ledger.light(met.numbers[*k] as usize, &events, end);
            }
        }
    });
}

/// Copies the directly visible light to a layer of its own, before lights are sampled. The radiance of
/// radiance-only shaders is excluded.
fn note_direct(tracer: &mut BatchTracer, radiance_only: &[u32], radiance: &Vec3s) {
    tracer.direct.clone_from(radiance);
    radiance_only.iter().for_each(|&lane| tracer.direct.set(lane as usize, Vec3::ZERO));
}

/// The part of light from infinity that absorption leaves.
fn beyond(path: &Path) -> Vec3 {
    left_after(f32::INFINITY, [path.absorption, Vec3::ZERO])
}

/// Radiance of paths that left the scene.
fn environment(tracer: &mut BatchTracer, from: HitLanes, wavefront: &mut Wavefront, radiance: &mut Vec3s) {
    let missed: Vec<usize> = (0..from.hits.len()).filter(|&i| media::is_missed(from.hits, i)).collect();
    for &i in &missed {
        let path = wavefront.paths.get(i, from.keys[i]);
        if path.is_straight() {
            Behind::leave(&mut tracer.behind, path.lane as usize, path.throughput * beyond(&path));
        }
    }
    if missed.is_empty() || tracer.world.lights().environment.is_none() {
        return;
    }
    let direct = tracer.environment(from.rays, &missed, |lane| from.is_of_camera(lane));
    let lights = tracer.world.light_set();
    for (k, &i) in missed.iter().enumerate().filter(|&(k, _)| direct.get(k) != Vec3::ZERO) {
        let path = wavefront.paths.get(i, from.keys[i]);
        // The environment is the last light.
        let number = LightId((lights.len() as u32).saturating_sub(1));
        let is_linked = wavefront.linked.as_ref().filter(|_| lights.has_environment());
        if is_linked.is_some_and(|linked| !linked.counts(i, number, path.from.is_some())) {
            continue;
        }
        let dir = Vec3::from(from.rays.get(i).dir);
        let weight = weigh_environment(lights, &path, dir);
        let light = path.throughput * direct.get(k) * weight * beyond(&path);
        let light = add(radiance, path.lane, light, path.edges, tracer.options.clamp);
        if path.is_straight() {
            Behind::add(&mut tracer.behind, path.lane as usize, light);
        }
        if tracer.options.seen {
            wavefront.seen.add(path.lane, light, (path.scattered, path.edges));
        }
        if let Some(recorder) = &mut wavefront.recorder {
            let share = unguided_share(recorder, &path, dir, |path| weigh_environment(lights, path, dir));
            recorder.found(path.trail, light * share);
        }
        if let Some(ledger) = &mut wavefront.ledger {
            let end = ledger.paths.classes.background();
            ledger.found(i, (path.lane, light), end);
        }
    }
}
