// SPDX-License-Identifier: GPL-3.0-or-later
//! Path tracing: the reference. From the eye, one scattered ray per vertex, lights sampled at each.
//! Source: [Kaj86] (path tracing), [VG95] (both samples combined by the power heuristic), [AK90] (Russian roulette);
//! wavefronts after the paper's section 8: all paths of a batch take a step together. Vertices of Lambert's reflector go
//! by lanes (`transport::lambert`), others are shaded by material, here.
//! A floor that only catches shadow shows what lies behind, less the light that a light sample finds kept from it, plus what
//! scattered rays bring from other surfaces: no noise where nothing is kept away [Deb98].
//! Space: world. An edge is a way between two vertices, the eye being one: light found at the end of edge k was scattered
//! k - 1 times. Straight on through holes is no new edge.
//! Invariants: unbiased without `clamp`; what a lane gets depends on its ray and key only.
//! Proof: crates/render/tests/{path,agreement,references,lanes}.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, Ray};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::Bsdf;
use gnurt_shading::lights::LightSet;
use gnurt_shading::sampling::{Draws, purpose, sample_pair};
use gnurt_shading::{Tracer, Vec3s};
use gnurt_simd::dispatch_wide;

use crate::tracer::{BatchTracer, Wanted};
use crate::transport::lambert::{self, Surroundings};
use crate::transport::{
    Asking, Offer, Origin, Path, ROULETTE_FROM, SURVIVAL, Unshadowed, Vertex, Wavefront, add,
    ask_plugin_lights, power_heuristic, sampling_normal, shadow_ray, weigh,
};
use crate::world::HitLanes;

/// See-through surfaces that a path may pass between two vertices; behind more it is dark.
const MOST_LAYERS: u32 = 256;
/// Branch of a path's key where it goes straight on.
const STRAIGHT: u32 = 2;

pub(super) fn radiance(tracer: &mut BatchTracer, camera: HitLanes, radiance: &mut Vec3s) {
    radiance.reset(camera.rays.len(), Vec3::ZERO);
    let mut wavefront = std::mem::take(&mut tracer.wavefront);
    wavefront.paths.start(camera.rays.len());
    step(tracer, camera, &mut wavefront, radiance);
    let mut hits = std::mem::take(&mut wavefront.hits);
    for round in 1.. {
        std::mem::swap(&mut wavefront.paths, &mut wavefront.next);
        if wavefront.paths.is_empty() {
            break;
        }
        // Lent out while the step is taken.
        let (rays, keys) = wavefront.paths.lend();
        tracer.stats.secondary_rays += rays.len() as u64;
        tracer.intersect_into(RayMask::OTHER, &rays, &keys, Coherence::Incoherent, &mut hits);
        if let Some(log) = &mut tracer.log {
            log.rays(round, &rays, &hits);
        }
        let from = HitLanes { rays: &rays, keys: &keys, hits: &hits, depth: round, epsilon: camera.epsilon };
        step(tracer, from, &mut wavefront, radiance);
        wavefront.paths.take_back(rays, keys);
    }
    wavefront.hits = hits;
    tracer.wavefront = wavefront;
}

/// Takes the light at the ends of the paths' rays, then scatters them.
fn step(tracer: &mut BatchTracer, from: HitLanes, wavefront: &mut Wavefront, radiance: &mut Vec3s) {
    let (world, options) = (tracer.world, tracer.options);
    // Those of what the camera sees start side by side and aim at few lamps; later ones start wherever paths went.
    tracer.shadows = if from.depth == 0 { Coherence::Fanned } else { Coherence::Incoherent };
    if tracer.log.is_some() {
        tracer.for_each_surface(from, Wanted::Light, |tracer, _, _, points| {
            if let Some(log) = &mut tracer.log {
                log.surface(points);
            }
        });
    }
    let by_shader = !world.lights().plugins.is_empty();
    let around = Surroundings { world, options, from, by_shader };
    dispatch_wide!(
        options.level,
        simd => lambert::step(simd, &around, wavefront, radiance),
        else lambert::list(&around, wavefront)
    );
    environment(tracer, from, wavefront, radiance);
    wavefront.finals.clear();
    if !wavefront.by_shader.is_empty() {
        step_by_shader(tracer, from, wavefront, radiance);
    }
    if options.aovs && from.depth == 0 {
        note_seen(tracer, &wavefront.finals, radiance);
    }
    let Wavefront { unshadowed, through, .. } = wavefront;
    tracer.occluded(&unshadowed.request, through);
    for k in 0..through.len() {
        let share = through.get(k);
        if share != Vec3::ZERO {
            let (lane, light, edges) = unshadowed.get(k);
            add(radiance, lane, light * share, edges, options.clamp);
        }
    }
}

/// The step of the paths that met other surfaces than Lambert's reflector.
fn step_by_shader(tracer: &mut BatchTracer, from: HitLanes, wavefront: &mut Wavefront, radiance: &mut Vec3s) {
    let (lights, options) = (tracer.world.light_set(), tracer.options);
    let mut order = std::mem::take(&mut wavefront.by_shader);
    order.sort_unstable();
    let mut alive: Vec<(Path, Vertex)> = Vec::with_capacity(order.len());
    tracer.for_each_surface_of(&order, from, Wanted::Light, |tracer, shader, lanes, points| {
        tracer.vertices_of(shader, lanes, points, &mut |lane, vertex| {
            let mut path = wavefront.paths.get(lane, from.keys[lane]);
            if !is_there(&vertex, &path, options.seed) {
                path.layers += 1;
                path.key = path.key.fork(STRAIGHT);
                if path.layers <= MOST_LAYERS {
                    wavefront.next.push(path, vertex.point.spawn(-vertex.wo, f32::INFINITY));
                }
                return;
            }
            if let Some(behind) = vertex.backdrop {
                add(radiance, path.lane, path.throughput * behind, path.edges, options.clamp);
            }
            let found = vertex.scattering.emission;
            if found != Vec3::ZERO {
                let found = counted(found, lights, &path, &vertex);
                add(radiance, path.lane, path.throughput * found, path.edges, options.clamp);
            }
            // The backdrop of a shadow catcher stands for scattered light, and light is taken from it.
            if vertex.is_final || vertex.backdrop.is_some() {
                wavefront.finals.push(lane);
            }
            if !vertex.is_final && path.edges < options.max_depth {
                alive.push((path, vertex));
            }
        });
    });
    wavefront.by_shader = order;
    sample_lights(tracer, &alive, &mut wavefront.unshadowed, radiance);
    for (path, vertex) in alive {
        if let Some((path, ray)) = scatter(path, &vertex, options.seed) {
            wavefront.next.push(path, ray);
        }
    }
}

/// Keeps what camera rays see without anything scattered, for a layer of its own: all light there is before lamps are asked.
/// What surfaces send back whose shaders do not tell why is none of that.
fn note_seen(tracer: &mut BatchTracer, finals: &[usize], radiance: &Vec3s) {
    tracer.seen.clone_from(radiance);
    finals.iter().for_each(|&lane| tracer.seen.set(lane, Vec3::ZERO));
}

/// What paths see that left the scene.
fn environment(tracer: &mut BatchTracer, from: HitLanes, wavefront: &Wavefront, radiance: &mut Vec3s) {
    let missed = &wavefront.missed;
    if missed.is_empty() || tracer.world.lights().environment.is_none() {
        return;
    }
    let seen = tracer.environment(from.rays, missed);
    let lights = tracer.world.light_set();
    for (k, &i) in missed.iter().enumerate().filter(|&(k, _)| seen.get(k) != Vec3::ZERO) {
        let path = wavefront.paths.get(i, from.keys[i]);
        let dir = Vec3::from(from.rays.get(i).dir);
        let weight = path.from.map_or(1.0, |origin| {
            power_heuristic(origin.pdf, lights.pdf_environment(origin.p, origin.ns, dir))
        });
        let light = path.throughput * seen.get(k) * weight;
        add(radiance, path.lane, light, path.edges, tracer.options.clamp);
    }
}

/// Light that reaches vertices without a further one.
fn sample_lights(
    tracer: &mut BatchTracer,
    alive: &[(Path, Vertex)],
    unshadowed: &mut Unshadowed,
    radiance: &mut Vec3s,
) {
    let (world, options) = (tracer.world, tracer.options);
    let lights = world.light_set();
    for (path, vertex) in alive {
        if !vertex.scattering.bsdf.is_smooth() {
            continue;
        }
        let draws = Draws::new(options.seed, path.key, path.edges);
        let ([x, y], [choice, _]) = (draws.pair(purpose::LIGHT_PLACE), draws.pair(purpose::LIGHT_CHOICE));
        let bsdf = &vertex.scattering.bsdf;
        let normal = sampling_normal(&vertex.point, bsdf);
        let Some(light) = lights.sample(vertex.point.p, normal, [choice, x, y]) else { continue };
        let value = bsdf.eval(vertex.wo, light.dir);
        if value == Vec3::ZERO || light.radiance == Vec3::ZERO {
            continue;
        }
        let weight = match vertex.backdrop {
            None if !light.delta => power_heuristic(light.pdf, bsdf.pdf(vertex.wo, light.dir)),
            _ => 1.0,
        };
        if let Some(ray) = shadow_ray(&vertex.point, bsdf, light.dir, light.dist) {
            let arriving = light.radiance * (weight / light.pdf);
            let light_here = path.throughput * value * arriving;
            // The backdrop holds what the environment brings: it is taken away, and comes back where nothing is in between.
            if vertex.backdrop.is_some() && !light.delta && light.dist.is_infinite() {
                add(radiance, path.lane, -light_here, path.edges + 1, options.clamp);
            }
            unshadowed.push(path, ray, light_here);
        }
    }
    let asking: Vec<Asking> = alive
        .iter()
        .map(|(path, vertex)| Asking {
            point: &vertex.point,
            bsdf: &vertex.scattering.bsdf,
            key: path.key,
            edges: path.edges,
        })
        .collect();
    ask_plugin_lights(world, options.seed, &asking, |i, Offer { dir, dist, arriving }| {
        let (path, vertex) = &alive[i];
        let bsdf = &vertex.scattering.bsdf;
        let value = path.throughput * bsdf.eval(vertex.wo, dir) * arriving;
        if value != Vec3::ZERO
            && let Some(ray) = shadow_ray(&vertex.point, bsdf, dir, dist)
        {
            unshadowed.push(path, ray, value);
        }
    });
}

/// Whether the path meets the surface, or goes through a hole of it.
fn is_there(vertex: &Vertex, path: &Path, seed: u64) -> bool {
    let coverage = vertex.scattering.coverage;
    coverage >= 1.0 || sample_pair(seed, path.key, path.edges, purpose::COVERAGE)[0] < coverage
}

/// What counts of the light that a scattered ray met: light samples find it, too. Of surfaces that only tell their
/// radiance, they find what the description lets shine.
fn counted(found: Vec3, lights: &LightSet, path: &Path, vertex: &Vertex) -> Vec3 {
    let weight = weigh(lights, path, vertex.ids, vertex.point.p, -vertex.wo);
    let [instance, mesh, triangle] = vertex.ids;
    match lights.triangle(instance, mesh, triangle) {
        Some(triangle) if vertex.is_final && vertex.front && path.from.is_some() => {
            found - lights.radiance_of_triangle(triangle, vertex.place) * (1.0 - weight)
        }
        _ => found * weight,
    }
}

/// The path after its vertex, and its ray; `None` where it ends.
fn scatter(mut path: Path, vertex: &Vertex, seed: u64) -> Option<(Path, Ray)> {
    let draws = Draws::new(seed, path.key, path.edges);
    let ([x, y], [choice, survival]) = (draws.pair(purpose::DIRECTION), draws.pair(purpose::CHOICE));
    let bsdf: &Bsdf = &vertex.scattering.bsdf;
    let sample = bsdf.sample_by_series(vertex.wo, [choice, x, y])?;
    path.throughput *= sample.weight;
    if path.edges >= ROULETTE_FROM {
        let keep = path.throughput.max_element().min(SURVIVAL);
        if survival >= keep {
            return None;
        }
        path.throughput /= keep;
    }
    if path.throughput == Vec3::ZERO || !path.throughput.is_finite() {
        return None;
    }
    let ray = vertex.point.scatter_ray(sample.wi, sample.transmitted, f32::INFINITY)?;
    let ns = sampling_normal(&vertex.point, bsdf);
    // What catches shadow leaves all that light samples can find to them.
    let pdf = if vertex.backdrop.is_some() { 0.0 } else { sample.pdf };
    path.from = (!sample.delta).then_some(Origin { p: vertex.point.p, ns, pdf });
    path.edges += 1;
    path.layers = 0;
    Some((path, ray))
}
