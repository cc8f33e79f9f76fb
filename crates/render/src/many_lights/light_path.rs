// SPDX-License-Identifier: GPL-3.0-or-later
//! Paths that start at lights, many at a time: every surface that they meet is a virtual light.
//! Source: [Kel97] (quasi-random walks); particles under shading normals [Vea97] section 5.3. Space: world.
//! Invariant: a path is a function of its numbers, independent of other paths.
//! Tests: crates/render/tests/many_lights.rs.

use glam::Vec3;
use gnurt_accel::{Ray, RayBatch};
use gnurt_shading::bsdf::left_after;
use gnurt_shading::lights::LightKind;
use gnurt_shading::sampling::{hash_combine, sample_pair};
use gnurt_shading::{SampleKey, Vec3s};

use super::plugin_emitters::{self, Source, Start};
use super::vpl::{Vpl, is_open};
use crate::cone::{Cone, fineness};
use crate::tracer::BatchTracer;
use crate::transport::walks::{Walks, scatter_light};
use crate::transport::{Vertex, roulette};
use crate::world::World;

/// Source of a path's random numbers: path, edge (0 = the light), and the pair of that edge.
pub(crate) type Numbers<'a> = dyn Fn(u32, u32, u32) -> [f32; 2] + 'a;

/// Marks numbers for light paths.
const LIGHT_PATHS: u32 = 0x1166_7700;

/// Random numbers of the light paths of a set: a (0, 2)-sequence over the paths for each pair.
pub(super) fn numbers(seed: u64, set: u32) -> impl Fn(u32, u32, u32) -> [f32; 2] + Sync {
    let pixel = hash_combine(LIGHT_PATHS, set);
    move |path, edge, pair| {
        sample_pair(seed, SampleKey { pixel, sample: path, branch: LIGHT_PATHS }, edge, pair)
    }
}

/// A vertex of a light path.
#[derive(Clone, Debug)]
pub(crate) struct LightVertex {
    /// Which path.
    pub(crate) path: u32,
    pub(crate) vpl: Vpl,
    /// Density per area with which the path's last vertex chose this one; infinite behind mirrors and smooth glass.
    /// For the first vertex that of start and direction.
    pub(crate) pdf: f32,
    /// Whether the other strategies can make the same path: its light has an extent, and no mirror precedes
    /// this vertex.
    pub(crate) connectable: bool,
    /// Density with which a lamp's sampling would have chosen the path's start, seen from here; 1 after the first edge.
    pub(crate) reverse: f32,
    /// Probability that the path continues from here.
    pub(crate) survival: f32,
}

/// Purposes of the pairs of random numbers of an edge.
pub(crate) mod pair {
    /// The direction.
    pub(crate) const DIRECTION: u32 = 0;
    /// The lobe, and the end of the path; on edge 0 the light, and the partly transparent surfaces that the
    /// edge hits.
    pub(crate) const LOBE: u32 = 1;
    /// The position on a light; on other edges the surfaces that they hit.
    pub(crate) const POSITION: u32 = 2;
}

/// The number that decides whether an edge hits a partly transparent surface, after this number of others.
fn probability(path: u32, before: u32, numbers: &Numbers) -> f32 {
    if before == 0 { numbers(path, 0, pair::LOBE)[1] } else { numbers(path, before, pair::POSITION)[0] }
}

struct Walk {
    path: u32,
    power: Vec3,
    edges: u32,
    pdf: f32,
    smooth: bool,
    origin: Vec3,
    /// How far from the origin its light begins.
    begin: f32,
    is_far: bool,
    /// Whether its first edge comes from infinitely far away.
    is_endless: bool,
    /// How much is absorbed along the edge where it begins.
    absorption: Vec3,
    /// The lamp's triangle and normal, on the first edge.
    emitter_choice: Option<(u32, Vec3)>,
    /// On the first edge from a light of a shader plugin: its source; `power` then is the factor of its
    /// light.
    plugin: Option<Source>,
    /// Whether it comes directly from a light, by mirrors and smooth glass only.
    is_direct_light: bool,
}

/// Share of paths that start at lights of shader plugins where there are others.
const OF_PLUGINS: f32 = 0.5;

/// Share of paths that start at lights of the light set.
pub(super) fn share_of_light_set(world: &World) -> f32 {
    match (world.plugin_emitters().len(), world.light_set().len()) {
        (0, _) => 1.0,
        (_, 0) => 0.0,
        _ => 1.0 - OF_PLUGINS,
    }
}

/// The start of a path at a light of a shader plugin, if its numbers select one (`None` = it starts nowhere).
/// Otherwise the number that chooses a light, and one over the probability that it is not a plugin's.
fn start(world: &World, path: u32, numbers: &Numbers) -> Result<Option<Start>, (f32, f32)> {
    let [choice, _] = numbers(path, 0, pair::LOBE);
    let share = 1.0 - share_of_light_set(world);
    if choice >= share {
        return Err(((choice - share) / (1.0 - share), 1.0 / (1.0 - share)));
    }
    let start = world.plugin_emitters().start(
        choice / share,
        numbers(path, 0, pair::POSITION),
        numbers(path, 0, pair::DIRECTION),
    );
    Ok(start.map(|start| Start { weight: start.weight / share, ..start }))
}

/// Light from lights and environments of shader plugins at the ends of first edges.
fn query_plugins(world: &World, rays: &RayBatch, walks: &mut [Walk], vertices: &[Option<Vertex>]) {
    let of = |source: Source, walks: &[Walk]| -> Vec<usize> {
        (0..walks.len()).filter(|&i| walks[i].plugin == Some(source) && vertices[i].is_some()).collect()
    };
    let lanes = of(Source::Environment, walks);
    if let Some(environment) = world.lights().environment.as_ref().filter(|_| !lanes.is_empty()) {
        let mut dirs = Vec3s::default();
        lanes.iter().for_each(|&i| dirs.push(-Vec3::from(rays.get(i).dir)));
        let mut visible = Vec3s::splat(lanes.len(), Vec3::ZERO);
        environment.miss(&dirs, &mut visible);
        lanes.into_iter().enumerate().for_each(|(k, i)| walks[i].power *= visible.get(k));
    }
    for (light, shader) in world.lights().shaders[world.lights().plugins.clone()].iter().enumerate() {
        let lanes = of(Source::Light(light), walks);
        if lanes.is_empty() {
            continue;
        }
        let [mut p, mut normal] = [(); 2].map(|()| Vec3s::default());
        for vertex in lanes.iter().filter_map(|&i| vertices[i].as_ref()) {
            p.push(vertex.point.p);
            normal.push(vertex.point.ns);
        }
        let arriving = plugin_emitters::arriving(&**shader, &p, &normal);
        lanes.into_iter().zip(arriving).for_each(|(i, arriving)| walks[i].power *= arriving);
    }
}

/// Follows `paths` (numbers of paths) up to `max_edges`; vertices come edge by edge, in the order of the paths.
pub(crate) fn trace(
    tracer: &mut BatchTracer,
    paths: std::ops::Range<u32>,
    numbers: &Numbers,
    max_edges: u32,
) -> Vec<LightVertex> {
    let world = tracer.world;
    let lights = world.light_set();
    let mut walks = Walks::default();
    if max_edges == 0 {
        return Vec::new();
    }
    for path in paths {
        let (choice, weight) = match start(world, path, numbers) {
            Err(choice) => choice,
            Ok(None) => continue,
            Ok(Some(start)) => {
                let ray = Ray::new(start.org.into(), start.dir.into());
                walks.chances.push(probability(path, 0, numbers));
                walks.push(
                    (ray, Cone::default()),
                    key(path, numbers),
                    Walk {
                        path,
                        power: Vec3::splat(start.weight),
                        edges: 1,
                        pdf: 1.0,
                        smooth: false,
                        origin: start.org,
                        begin: 0.0,
                        is_far: true,
                        is_endless: start.source == Source::Environment,
                        absorption: Vec3::ZERO,
                        emitter_choice: None,
                        plugin: Some(start.source),
                        // Shaders of surfaces do not query the environment.
                        is_direct_light: start.source != Source::Environment,
                    },
                );
                continue;
            }
        };
        let Some(ray) =
            lights.emit(choice, numbers(path, 0, pair::POSITION), numbers(path, 0, pair::DIRECTION))
        else {
            continue;
        };
        let pdf = if ray.is_surface { ray.pdf_dir } else { f32::INFINITY };
        walks.chances.push(probability(path, 0, numbers));
        walks.push(
            (ray.point.spawn(ray.dir, f32::INFINITY), Cone::from_point(pdf)),
            key(path, numbers),
            Walk {
                path,
                power: ray.radiance_over_pdf * weight,
                edges: 1,
                pdf: ray.pdf_pos * ray.pdf_dir / weight,
                smooth: ray.is_surface,
                origin: ray.point.p,
                begin: ray.begin,
                is_far: !ray.is_surface,
                is_endless: matches!(ray.kind, LightKind::Directional(_) | LightKind::Environment),
                absorption: Vec3::ZERO,
                emitter_choice: match ray.kind {
                    LightKind::Shape(shape) => Some((shape, ray.normal)),
                    _ => None,
                },
                plugin: None,
                is_direct_light: true,
            },
        );
    }
    let mut out = Vec::new();
    while let Some(first) = walks.carried.first() {
        let found = walks.meet(tracer, first.edges);
        (0..walks.carried.len()).for_each(|i| walks.carried[i].power *= found.passed(i));
        let found = found.vertices;
        query_plugins(world, &walks.rays, &mut walks.carried, &found);
        let mut next = Walks::default();
        for (walk, vertex) in walks.carried.iter().zip(found) {
            let Some(vertex) = vertex.filter(|vertex| !vertex.is_final) else { continue };
            let (point, bsdf, from) = (vertex.point, &vertex.scattering.bsdf, vertex.wo);
            if !(is_open(&point, from) && point.ng.dot(from) > 0.0) {
                continue;
            }
            if point.p.distance_squared(walk.origin) < walk.begin * walk.begin {
                continue;
            }
            let per_area = if walk.is_far {
                // A point light's density of position is a probability, a directional one's of direction.
                f32::INFINITY
            } else {
                walk.pdf * point.ng.dot(from).abs() / (point.p - walk.origin).length_squared()
            };
            let gain = if walk.is_direct_light { vertex.light_gain } else { 1.0 };
            let offset = if walk.is_endless { f32::INFINITY } else { (point.p - walk.origin).length() };
            let power = walk.power * left_after(offset, [walk.absorption, bsdf.medium().on(true)]) * gain;
            let vpl = Vpl::new(point, bsdf.clone(), from, power, walk.edges);
            let [lobe, end] = numbers(walk.path, walk.edges, pair::LOBE);
            let direction = numbers(walk.path, walk.edges, pair::DIRECTION);
            let survival = survival(bsdf.albedo(from), walk.edges);
            out.push(LightVertex {
                path: walk.path,
                vpl,
                pdf: per_area,
                connectable: walk.smooth && per_area.is_finite(),
                reverse: walk.emitter_choice.map_or(1.0, |(shape, normal)| {
                    let dist = (walk.origin - point.p).length();
                    let visible = lights.pdf_shape(point.p, Vec3::ZERO, shape, from, dist);
                    visible * normal.dot(from).abs() / (dist * dist)
                }),
                survival,
            });
            if walk.edges >= max_edges || end >= survival {
                continue;
            }
            let u = [lobe, direction[0], direction[1]];
            let Some((ray, sample)) = scatter_light(&point, bsdf, (from, power), u) else { continue };
            let power = power * sample.weight / survival;
            if power == Vec3::ZERO || !power.is_finite() {
                continue;
            }
            // Light paths are few: they are as fine as cones get.
            let fine = fineness(u32::MAX);
            next.chances.push(probability(walk.path, walk.edges, numbers));
            next.push(
                (ray, vertex.cone.after(&sample, fine)),
                key(walk.path, numbers).fork(walk.edges),
                Walk {
                    path: walk.path,
                    power,
                    edges: walk.edges + 1,
                    pdf: if sample.delta { f32::INFINITY } else { sample.pdf * survival },
                    smooth: !sample.delta,
                    origin: point.p,
                    begin: 0.0,
                    is_far: false,
                    is_endless: false,
                    absorption: bsdf.absorption(sample.wi),
                    emitter_choice: None,
                    plugin: None,
                    is_direct_light: walk.is_direct_light && sample.delta,
                },
            );
        }
        walks = next;
    }
    out
}

/// Probability that a path continues, from its albedo, so that joined paths can compute it, too. The edge to
/// the eye has probability 1.
fn survival(albedo: Vec3, edges: u32) -> f32 {
    // No approximate albedo is too low by more than this.
    const LEAST: f32 = 0.05;
    if roulette::decides(edges + 1) { roulette::survival(albedo.max_element().max(LEAST)) } else { 1.0 }
}

/// Seed of a path's further random choices, made of its own numbers, so that no two sets share it.
fn key(path: u32, numbers: &Numbers) -> SampleKey {
    let [a, b] = numbers(path, 0, pair::DIRECTION).map(f32::to_bits);
    SampleKey { pixel: a, sample: b, branch: 0x5eed }
}

#[cfg(test)]
mod tests {
    use gnurt_scene::material::{Alpha, Opacity, OpacityChannel};
    use gnurt_scene::{Affine, Material, Mesh, Scene};

    use super::*;
    use crate::options::RenderOptions;
    use crate::world::{CommitOptions, ShaderTable};

    /// Lights at z = 2 over veils at z = 1 and less over a floor at z = 0, all much wider than high; the
    /// veils stop half of the light each.
    fn veiled(veils: u32) -> World {
        let mut scene = Scene::new();
        let opacity = Opacity { factor: 0.5, texture: None, channel: OpacityChannel::Alpha };
        let veil = Material { alpha: Alpha::Blend { opacity }, ..Material::matte("veil", [0.0; 3]) };
        let veil = scene.add_material(veil);
        let emitter_choice =
            scene.add_material(Material { emission: [1.0; 3], ..Material::matte("lamp", [0.0; 3]) });
        let floor = scene.add_material(Material::matte("floor", [0.5; 3]));
        let mut position = |z: f32, size: f32, down: bool, material| {
            let indices = if down { vec![[0, 2, 1], [0, 3, 2]] } else { vec![[0, 1, 2], [0, 2, 3]] };
            let corners = [[-size, -size, z], [size, -size, z], [size, size, z], [-size, size, z]];
            let mesh = Mesh { positions: corners.into(), indices, material, ..Mesh::default() };
            let mesh = scene.add_mesh(mesh);
            let object = scene.add_object_of("", vec![mesh]);
            scene.instantiate(object, Affine::IDENTITY);
        };
        position(0.0, 1000.0, false, floor);
        (0..veils).for_each(|k| position(1.0 - 0.1 * k as f32, 1000.0, false, veil));
        position(2.0, 0.1, true, emitter_choice);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts");
        let mut world = World::new();
        let how = CommitOptions::default();
        world.commit(&scene, &ShaderTable::default(), &how, &pool).expect("the scene is sound");
        world
    }

    /// Which paths of a set end on a veil, and which on the floor, by path.
    fn ends(world: &World, options: &RenderOptions, set: u32, paths: u32) -> Vec<bool> {
        let mut tracer = BatchTracer::new(world, options, false);
        let numbers = numbers(options.seed_of_lights(), set);
        let found = trace(&mut tracer, 0..paths, &numbers, 1);
        assert!(found.len() as u32 > paths * 9 / 10, "nearly all meet something: {} of {paths}", found.len());
        found.iter().map(|vertex| vertex.vpl.point.p.z > 0.05).collect()
    }

    /// Each set decides on its own which of its paths pass transparent surfaces: the mean over sets is the
    /// picture.
    #[test]
    fn sets_decide_about_holes() {
        let share = |ends: &[bool]| ends.iter().filter(|&&veil| veil).count() as f64 / ends.len() as f64;
        for (veils, requested) in [(1, 0.5), (3, 0.875)] {
            let world = veiled(veils);
            for seed in [3, 5] {
                let options = RenderOptions { seed, ..RenderOptions::default() };
                let all: Vec<bool> = (0..256).flat_map(|set| ends(&world, &options, set, 8)).collect();
                assert!(
                    (share(&all) - requested).abs() < 0.03,
                    "{veils} veils, seed {seed}: {}",
                    share(&all)
                );
                // Within a set they are spread as evenly as other numbers are.
                let one = share(&ends(&world, &options, 7, 256));
                assert!((one - requested).abs() < 0.02, "{veils} veils, one set of seed {seed}: {one}");
            }
        }
        // Pictures that differ in their seeds alone may share the lights.
        let world = veiled(1);
        let [a, b] = [3, 5].map(|seed| {
            let options = RenderOptions { seed, lights_seed: Some(9), ..RenderOptions::default() };
            ends(&world, &options, 1, 64)
        });
        assert_eq!(a, b, "the seed of lights decides");
    }
}
