// SPDX-License-Identifier: GPL-3.0-or-later
//! Path tracing: the reference. From the eye, one scattered ray per vertex, lights sampled at each.
//! Source: [Kaj86] (path tracing), [VG95] (both samples combined by the power heuristic), [AK90] (Russian roulette);
//! wavefronts after the paper's section 8: all paths of a tile take a step together, vertices shaded by material.
//! Space: world. An edge is a way between two vertices, the eye being one: light found at the end of edge k was scattered
//! k - 1 times. Straight on through holes is no new edge.
//! Invariants: unbiased without `clamp`; what a lane gets depends on its ray and key only.
//! Proof: crates/render/tests/{path,references}.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, Ray, RayBatch};
use gnurt_shading::bsdf::Bsdf;
use gnurt_shading::lights::LightSet;
use gnurt_shading::sampling::{Draws, purpose, sample_pair};
use gnurt_shading::{LightBatch, RayRequest, SampleKey, Tracer, Vec3s};

use crate::tracer::BatchTracer;
use crate::transport::{Vertex, power_heuristic};
use crate::world::HitLanes;

/// Paths of fewer edges are never ended by chance.
const ROULETTE_FROM: u32 = 4;
/// See-through surfaces that a path may pass between two vertices; behind more it is dark.
const MOST_LAYERS: u32 = 256;
/// Branch of a path's key where it goes straight on.
const STRAIGHT: u32 = 2;

/// A path that goes on.
struct Path {
    /// Whose radiance it brings.
    lane: u32,
    key: SampleKey,
    /// What light at its end is multiplied with.
    throughput: Vec3,
    /// Edges up to the next hit, that one included.
    edges: u32,
    /// Surfaces passed straight through since the last vertex.
    layers: u32,
    /// Where the ray was scattered; `None` where no light sample could have found what it meets.
    from: Option<Origin>,
}

/// Where a ray was scattered with a density.
#[derive(Clone, Copy)]
struct Origin {
    p: Vec3,
    /// The normal that lights were asked with.
    ns: Vec3,
    /// Density of the ray's direction per solid angle.
    pdf: f32,
}

/// Light on its way to vertices, unless something is in between.
#[derive(Default)]
struct Unshadowed {
    /// The parents are places in the list of vertices.
    request: RayRequest,
    /// Radiance per ray, at the eye.
    radiance: Vec<Vec3>,
}

impl Unshadowed {
    fn push(&mut self, i: usize, path: &Path, ray: Ray, radiance: Vec3) {
        self.request.rays.push(ray);
        self.request.parent.push(i as u32);
        self.request.key.push(path.key);
        self.radiance.push(radiance);
    }
}

pub(super) fn radiance(tracer: &mut BatchTracer, camera: HitLanes, radiance: &mut Vec3s) {
    radiance.reset(camera.rays.len(), Vec3::ZERO);
    let paths = camera.keys.iter().enumerate().map(|(i, &key)| Path {
        lane: i as u32,
        key,
        throughput: Vec3::ONE,
        edges: 1,
        layers: 0,
        from: None,
    });
    let mut step = Step { paths: paths.collect(), ..Step::default() };
    step.next(tracer, camera, radiance);
    for round in 1.. {
        if step.paths.is_empty() {
            break;
        }
        let rays = std::mem::take(&mut step.rays);
        let keys: Vec<SampleKey> = step.paths.iter().map(|path| path.key).collect();
        tracer.stats.secondary_rays += rays.len() as u64;
        let hits: HitBatch = tracer.intersect(&rays, &keys, Coherence::Incoherent);
        if let Some(log) = &mut tracer.log {
            log.rays(round, &rays, &hits);
        }
        let from = HitLanes { rays: &rays, keys: &keys, hits: &hits, depth: round, epsilon: camera.epsilon };
        step.next(tracer, from, radiance);
    }
}

/// All paths between two edges.
#[derive(Default)]
struct Step {
    paths: Vec<Path>,
    /// The next ray of each.
    rays: RayBatch,
}

impl Step {
    /// Takes the light at the ends of the paths' rays, then scatters them.
    fn next(&mut self, tracer: &mut BatchTracer, from: HitLanes, radiance: &mut Vec3s) {
        let options = tracer.options;
        self.environment(tracer, from, radiance);
        let vertices = tracer.vertices(from);
        let mut alive: Vec<(Path, &Vertex)> = Vec::with_capacity(self.paths.len());
        self.rays = RayBatch::with_capacity(self.paths.len());
        let mut straight = Vec::new();
        for (mut path, vertex) in self.paths.drain(..).zip(&vertices) {
            let Some(vertex) = vertex else { continue };
            if !is_there(vertex, &path, options.seed) {
                path.layers += 1;
                path.key = path.key.fork(STRAIGHT);
                if path.layers <= MOST_LAYERS {
                    straight.push((path, vertex.point.spawn(-vertex.wo, f32::INFINITY)));
                }
                continue;
            }
            let found = vertex.scattering.emission;
            if found != Vec3::ZERO {
                let found = weigh(found, tracer.world.light_set(), &path, vertex);
                add(radiance, &path, path.throughput * found, path.edges, options.clamp);
            }
            if !vertex.is_final && path.edges < options.max_depth {
                alive.push((path, vertex));
            }
        }
        self.sample_lights(tracer, &alive, radiance);
        for (path, vertex) in alive {
            if let Some((path, ray)) = scatter(path, vertex, options.seed) {
                self.paths.push(path);
                self.rays.push(ray);
            }
        }
        for (path, ray) in straight {
            self.paths.push(path);
            self.rays.push(ray);
        }
    }

    /// What paths see that left the scene.
    fn environment(&self, tracer: &mut BatchTracer, from: HitLanes, radiance: &mut Vec3s) {
        let missed: Vec<usize> = (0..from.rays.len()).filter(|&i| from.hits.get(i).is_none()).collect();
        let seen = tracer.environment(from.rays, &missed);
        let lights = tracer.world.light_set();
        for (k, &i) in missed.iter().enumerate().filter(|&(k, _)| seen.get(k) != Vec3::ZERO) {
            let path = &self.paths[i];
            let dir = Vec3::from(from.rays.get(i).dir);
            let weight = path.from.map_or(1.0, |origin| {
                power_heuristic(origin.pdf, lights.pdf_environment(origin.p, origin.ns, dir))
            });
            add(radiance, path, path.throughput * seen.get(k) * weight, path.edges, tracer.options.clamp);
        }
    }

    /// Light that reaches vertices without a further one.
    fn sample_lights(&self, tracer: &mut BatchTracer, alive: &[(Path, &Vertex)], radiance: &mut Vec3s) {
        let (world, options) = (tracer.world, tracer.options);
        let lights = world.light_set();
        let mut unshadowed = Unshadowed::default();
        for (i, (path, vertex)) in alive.iter().enumerate() {
            if !vertex.scattering.bsdf.is_smooth() {
                continue;
            }
            let draws = Draws::new(options.seed, path.key, path.edges);
            let ([x, y], [choice, _]) = (draws.pair(purpose::LIGHT_PLACE), draws.pair(purpose::LIGHT_CHOICE));
            let bsdf = &vertex.scattering.bsdf;
            let Some(light) = lights.sample(vertex.point.p, asking_normal(vertex), [choice, x, y]) else {
                continue;
            };
            let value = bsdf.eval(vertex.wo, light.dir);
            if value == Vec3::ZERO || light.radiance == Vec3::ZERO {
                continue;
            }
            let weight =
                if light.delta { 1.0 } else { power_heuristic(light.pdf, bsdf.pdf(vertex.wo, light.dir)) };
            if let Some(ray) = shadow_ray(vertex, light.dir, light.dist) {
                let arriving = light.radiance * (weight / light.pdf);
                unshadowed.push(i, path, ray, path.throughput * value * arriving);
            }
        }
        self.ask_plugins(tracer, alive, &mut unshadowed);
        let mut through = Vec3s::default();
        tracer.occluded(&unshadowed.request, &mut through);
        for (k, (&i, &light)) in unshadowed.request.parent.iter().zip(&unshadowed.radiance).enumerate() {
            let path = &alive[i as usize].0;
            add(radiance, path, light * through.get(k), path.edges + 1, options.clamp);
        }
    }

    /// Lights that only know `illuminate`.
    fn ask_plugins(&self, tracer: &mut BatchTracer, alive: &[(Path, &Vertex)], unshadowed: &mut Unshadowed) {
        let shading = tracer.world.shading();
        if shading.plugin_lights.is_empty() || alive.is_empty() {
            return;
        }
        let (mut p, mut normal) = (Vec3s::default(), Vec3s::default());
        for (_, vertex) in alive {
            p.push(vertex.point.p);
            normal.push(vertex.point.ns);
        }
        let mut arriving = LightBatch::default();
        for light in shading.plugin_lights.clone() {
            let draw = |(path, _): &(Path, &Vertex)| {
                tracer.random(path.key, path.edges, purpose::LIGHT + light as u32)
            };
            let random: Vec<_> = alive.iter().map(draw).collect();
            arriving.reset(alive.len());
            shading.lights[light].illuminate(&p, &normal, &random, &mut arriving);
            for (i, (path, vertex)) in alive.iter().enumerate() {
                let (dir, light) = (arriving.dir.get(i), arriving.radiance.get(i));
                if light == Vec3::ZERO {
                    continue;
                }
                let value = path.throughput * vertex.scattering.bsdf.eval(vertex.wo, dir) * light;
                let ray = shadow_ray(vertex, dir, arriving.dist[i]);
                if let Some(ray) = ray.filter(|_| value != Vec3::ZERO) {
                    unshadowed.push(i, path, ray, value);
                }
            }
        }
    }
}

/// Whether the path meets the surface, or goes through a hole of it.
fn is_there(vertex: &Vertex, path: &Path, seed: u64) -> bool {
    let coverage = vertex.scattering.coverage;
    coverage >= 1.0 || sample_pair(seed, path.key, path.edges, purpose::COVERAGE)[0] < coverage
}

/// What counts of the light that a scattered ray met: light samples find it, too. Of surfaces that only tell their
/// radiance, they find what the description lets shine.
fn weigh(found: Vec3, lights: &LightSet, path: &Path, vertex: &Vertex) -> Vec3 {
    let [instance, mesh, triangle] = vertex.ids;
    let (Some(origin), Some(triangle)) = (path.from, lights.triangle(instance, mesh, triangle)) else {
        return found;
    };
    let dist = (vertex.point.p - origin.p).length();
    let pdf = lights.pdf_triangle(origin.p, origin.ns, triangle, -vertex.wo, dist);
    let weight = power_heuristic(origin.pdf, pdf);
    if vertex.is_final && vertex.front {
        let shines = lights.radiance_of_triangle(triangle, vertex.place);
        return found - shines * (1.0 - weight);
    }
    found * weight
}

/// The normal that lights are asked with. No lobe that light samples can meet lets light through: glass is smooth.
fn asking_normal(vertex: &Vertex) -> Vec3 {
    vertex.point.ns
}

/// The ray that decides whether light from `dir` reaches the vertex, on whichever side of it.
fn shadow_ray(vertex: &Vertex, dir: Vec3, dist: f32) -> Option<Ray> {
    let point = &vertex.point;
    if point.ns.dot(dir) > 0.0 { point.shadow_ray(dir, dist) } else { point.shadow_ray_through(dir, dist) }
}

/// The path after its vertex, and its ray; `None` where it ends.
fn scatter(mut path: Path, vertex: &Vertex, seed: u64) -> Option<(Path, Ray)> {
    let draws = Draws::new(seed, path.key, path.edges);
    let ([x, y], [choice, survival]) = (draws.pair(purpose::DIRECTION), draws.pair(purpose::CHOICE));
    let bsdf: &Bsdf = &vertex.scattering.bsdf;
    let sample = bsdf.sample(vertex.wo, [choice, x, y])?;
    path.throughput *= sample.weight;
    if path.edges >= ROULETTE_FROM {
        let keep = path.throughput.max_element().min(0.95);
        if survival >= keep {
            return None;
        }
        path.throughput /= keep;
    }
    if path.throughput == Vec3::ZERO || !path.throughput.is_finite() {
        return None;
    }
    let ray = vertex.point.scatter_ray(sample.wi, sample.transmitted, f32::INFINITY)?;
    path.from =
        (!sample.delta).then_some(Origin { p: vertex.point.p, ns: asking_normal(vertex), pdf: sample.pdf });
    path.edges += 1;
    path.layers = 0;
    Some((path, ray))
}

/// Adds light that came over `edges` edges; no more than `clamp` in any channel if it was scattered more than once.
fn add(radiance: &mut Vec3s, path: &Path, mut light: Vec3, edges: u32, clamp: Option<f32>) {
    if let Some(most) = clamp.filter(|&most| edges > 2 && light.max_element() > most) {
        light *= most / light.max_element();
    }
    radiance.add(path.lane as usize, light);
}
