// SPDX-License-Identifier: GPL-3.0-or-later
//! Small scenes and pictures for the tests of this crate.
#![allow(dead_code, unreachable_pub, reason = "each test file uses some of it")]

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

pub mod chains;
mod divided;

use std::sync::Arc;

pub use divided::*;
use gnurt_image::{BACKGROUND, ChannelData, Picture};
use gnurt_render::{CommitOptions, Frame, RenderOptions, SceneCamera, ShaderTable, Silent, World, render};
use gnurt_scene::{Affine, Camera, Light, Material, MaterialId, Mesh, Primitives, Scene};
use gnurt_shading::SurfaceShader;

/// A pool of this many threads.
pub fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started")
}

/// The results of several jobs, in order. Two threads work side by side, each in a pool of its own: pictures of a few pixels
/// take up to three times as long if threads divide each of them.
pub fn side_by_side<T: Send>(count: usize, one: impl Fn(usize, &rayon::ThreadPool) -> T + Sync) -> Vec<T> {
    let (next, results) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
        let alone = alone.expect("a pool of this thread");
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                return;
            }
            let result = one(number, &alone);
            results.lock().expect("no panic").push((number, result));
        }
    };
    std::thread::scope(|scope| (0..2).for_each(|_| _ = scope.spawn(work)));
    let mut results = results.into_inner().expect("no panic");
    results.sort_by_key(|&(number, _)| number);
    results.into_iter().map(|(_, result)| result).collect()
}

/// A parallelogram from `corner` along two edges; its normal is `a x b`.
pub fn quad(corner: [f32; 3], a: [f32; 3], b: [f32; 3], material: MaterialId) -> Mesh {
    let at = |s: f32, t: f32| [0, 1, 2].map(|k| corner[k] + s * a[k] + t * b[k]);
    Mesh {
        positions: vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)],
        texcoords: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    }
}

/// A sphere of triangles with smooth normals.
pub fn sphere(centre: [f32; 3], radius: f32, rings: u32, material: MaterialId) -> Mesh {
    let (columns, mut mesh) = (2 * rings, Mesh { material, ..Mesh::default() });
    for (i, j) in (0..=rings).flat_map(|i| (0..=columns).map(move |j| (i, j))) {
        let (polar, azimuth) = (
            std::f64::consts::PI * f64::from(i) / f64::from(rings),
            std::f64::consts::TAU * f64::from(j) / f64::from(columns),
        );
        let n = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()].map(|x| x as f32);
        mesh.normals.push(n);
        mesh.positions.push([0, 1, 2].map(|k| centre[k] + radius * n[k]));
    }
    for (i, j) in (0..rings).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        let [a, b] = [i, i + 1].map(|ring| ring * (columns + 1) + j);
        if i > 0 {
            mesh.indices.push([a, b, a + 1]);
        }
        if i + 1 < rings {
            mesh.indices.push([a + 1, b, b + 1]);
        }
    }
    mesh
}

/// A sphere that is one primitive.
pub fn ball(center: [f32; 3], radius: f32, material: MaterialId) -> Mesh {
    Mesh {
        positions: vec![center],
        primitives: Primitives::Spheres(vec![radius]),
        material,
        ..Default::default()
    }
}

/// Adds an object of one mesh where it stands.
pub fn put_mesh(scene: &mut Scene, mesh: Mesh) {
    let mesh = scene.add_mesh(mesh);
    let object = scene.add_object_of("", vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
}

/// The walls, floor and ceiling of a closed room of 6 x 4 x 3 around the z axis, which face inward.
pub fn room(scene: &mut Scene, material: MaterialId) {
    let [x, y, z] = [[6.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 3.0]];
    let back = |v: [f32; 3]| v.map(|k| -k);
    for (corner, a, b) in [
        ([-3.0, -2.0, 0.0], x, y),
        ([-3.0, -2.0, 3.0], y, x),
        ([-3.0, -2.0, 0.0], y, z),
        ([3.0, -2.0, 0.0], z, y),
        ([-3.0, 2.0, 0.0], x, z),
        ([3.0, -2.0, 0.0], back(x), z),
    ] {
        put_mesh(scene, quad(corner, a, b, material));
    }
}

/// A Lambertian material.
pub fn matte(scene: &mut Scene, albedo: [f32; 3]) -> MaterialId {
    scene.add_material(Material::matte("matte", albedo))
}

/// A black material that shines.
pub fn emitter(scene: &mut Scene, radiance: [f32; 3]) -> MaterialId {
    scene.add_material(Material { emission: radiance, ..Material::matte("light", [0.0; 3]) })
}

/// A matte floor `z = 0` of half size `half`, seen from above by `camera`.
pub fn floor(albedo: f32, half: f32) -> Scene {
    let mut scene = Scene::new();
    let material = matte(&mut scene, [albedo; 3]);
    let edge = 2.0 * half;
    put_mesh(&mut scene, quad([-half, -half, 0.0], [edge, 0.0, 0.0], [0.0, edge, 0.0], material));
    scene
}

/// Looks from `eye` to `target` under a narrow angle: a picture of it is one point of the target.
pub fn camera(eye: [f32; 3], target: [f32; 3], fov_y: f32) -> SceneCamera {
    let up = [0.0, 0.1, 1.0];
    SceneCamera::new(&Camera { name: String::new(), eye, target, up, fov_y, ..Camera::default() })
        .expect("a view")
}

/// A constant environment.
pub fn environment(radiance: [f32; 3]) -> Light {
    Light::Environment { radiance, texture: None, world_from_light: Affine::IDENTITY }
}

/// The world of a scene.
pub fn world_of(scene: &Scene, force_diffuse: bool) -> World {
    let mut world = World::new();
    let options = CommitOptions { force_diffuse, ..CommitOptions::default() };
    world.commit(scene, &ShaderTable::default(), &options, &pool(1)).expect("the scene is sound");
    world
}

/// The world of a scene whose surface shader 0 this is.
pub fn world_with(scene: &Scene, shader: impl SurfaceShader + 'static) -> World {
    let table = ShaderTable { surfaces: vec![Arc::new(shader)], ..ShaderTable::default() };
    let mut world = World::new();
    world.commit(scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
    world
}

/// Small options.
pub fn options(width: u32, height: u32, spp: u32) -> RenderOptions {
    RenderOptions { width, height, spp, ..RenderOptions::default() }
}

/// Renders on one thread: tests run side by side.
pub fn frame(scene: &Scene, camera: &SceneCamera, options: &RenderOptions) -> Frame {
    render(&world_of(scene, false), camera, options, &pool(1), &Silent).expect("the options are sound")
}

/// White things under a white sky: a furnace, whose picture is white if all light is scattered on.
pub fn white_under_white(options: &RenderOptions) -> Frame {
    let mut scene = floor(1.0, 3.0);
    let white = matte(&mut scene, [1.0; 3]);
    put_mesh(&mut scene, sphere([0.0, 0.0, 1.0], 0.9, 24, white));
    put_mesh(&mut scene, quad([1.5, -2.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 3.0], white));
    scene.add_light(environment([1.0; 3]));
    let view = camera([-6.0, -4.0, 3.0], [0.0, 0.0, 0.8], 40.0);
    // Face normals: interpolated ones are no closed system, their facets neither keep nor lose light exactly.
    let world = world_of(&scene, true);
    render(&world, &view, options, &pool(1), &Silent).expect("the options are sound")
}

/// Mean colour of a picture.
pub fn mean(picture: &Picture) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in &picture.color {
        (0..3).for_each(|k| sum[k] += f64::from(pixel[k]));
    }
    sum.map(|s| s / picture.pixel_count() as f64)
}

/// The layer of the background.
pub fn background(picture: &Picture) -> Vec<[f32; 4]> {
    let layer = picture.layer(BACKGROUND).expect("the layer");
    let values = |name: &str| match &layer.channel(name).expect("the channel").data {
        ChannelData::F32(values) => values.clone(),
        ChannelData::U32(_) => panic!("floats"),
    };
    let [r, g, b, a] = ["R", "G", "B", "A"].map(values);
    (0..a.len()).map(|i| [r[i], g[i], b[i], a[i]]).collect()
}

/// Radiance that a narrow view sees at a point.
pub fn radiance_at(scene: &Scene, eye: [f32; 3], target: [f32; 3], spp: u32) -> [f64; 3] {
    mean(&frame(scene, &camera(eye, target, 0.01), &options(4, 4, spp)).picture)
}

/// Asserts that two numbers agree within a share of the wanted one.
pub fn assert_close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs().max(1e-12),
        "{what}: {found} instead of {expected}"
    );
}
