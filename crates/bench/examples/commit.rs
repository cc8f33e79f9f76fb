// SPDX-License-Identifier: GPL-3.0-or-later
//! Cost of a commit after one edit of a scene of many instances, and of the lazy work of the first sample
//! after it. Run: `cargo run --release -p gnurt-bench --example commit -- [INSTANCES...]` A grid of instances
//! of sixteen spheres of 8,192 triangles each, a light of 10,000 triangles, an environment of 1024 x 512
//! texels, 100 materials. Median of five edits; seconds of all processors, and on the wall. A snapshot of the
//! earlier world is held during the commit of an edit, as by a frame in flight. One path through one pixel
//! follows each commit, so that parts built at first use (the light tree) count, too.
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use gnurt::ThreadPool;
use gnurt::image::{TexelData, Texels};
use gnurt::render::{
    CommitOptions, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
};
use gnurt::scene::material::{Color, Surface};
use gnurt::scene::texture::{Filter, Texture, Wrap};
use gnurt::scene::{
    Affine, Camera, InstanceId, Light, LightId, Material, MaterialId, Mesh, MeshId, Scene, TextureId,
};
use gnurt_bench::process_seconds;

const RUNS: usize = 5;
/// Objects that the instances show.
const BALLS: u32 = 16;
const MATERIALS: u32 = 100;
/// Squares along an edge of the light.
const LIGHT_MESH: u32 = 71;

/// The edit, by the number of the run.
type Change = fn(&mut Scene, usize);

const EDITS: [(&str, Change); 9] = [
    ("nothing", |_, _| ()),
    ("camera", |scene, run| scene.edit_camera(gnurt::scene::CameraId(0)).eye[0] += run as f32 + 1.0),
    ("one matrix", |scene, run| {
        let middle = InstanceId(scene.instances().len() as u32 / 2);
        scene.edit_instance(middle).world_from_object.columns[3][1] += 0.1 * (run + 1) as f64;
    }),
    ("1,000 matrices", |scene, run| {
        let count = scene.instances().len();
        for id in (0..count as u32).step_by(count.div_ceil(1000)).skip(1) {
            scene.edit_instance(InstanceId(id)).world_from_object.columns[3][1] += 0.1 * (run + 1) as f64;
        }
    }),
    ("one shader parameter", |scene, run| {
        let base_color = Color::constant([0.1 * run as f32 + 0.2; 3]);
        scene.edit_material(MaterialId(3)).surface = Surface::Matte { base_color };
    }),
    ("one mesh", |scene, run| {
        let positions = &mut scene.edit_mesh(MeshId(5)).positions;
        positions.iter_mut().for_each(|p| p[0] *= 1.0 + 0.01 * (run + 1) as f32);
    }),
    ("one point light", |scene, run| {
        if let Light::Point { position, .. } = scene.edit_light(LightId(1)) {
            position[0] = run as f32;
        }
    }),
    ("the lamp's matrix", |scene, run| {
        scene.edit_instance(InstanceId(0)).world_from_object.columns[3][1] += 0.1 * (run + 1) as f64;
    }),
    ("the environment", |scene, run| {
        if let Light::Environment { radiance, .. } = scene.edit_light(LightId(0)) {
            *radiance = [1.0 + run as f32; 3];
        }
    }),
];

fn main() -> Result<(), Box<dyn Error>> {
    let counts: Vec<u32> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let counts = if counts.is_empty() { vec![1, 1_000, 100_000, 1_000_000] } else { counts };
    let pool = gnurt::thread_pool(2)?;
    println!("| instances | edit | commit, CPU ms | wall ms | first sample, CPU ms |");
    println!("|---|---|---|---|---|");
    for count in counts {
        let mut scene = scene_of(count);
        let mut world = World::new();
        let (first, cpu, wall_time) = timed(|| commit(&mut world, &scene, &pool));
        first?;
        let sample = first_sample(&world, &scene, &pool)?;
        println!("| {count} | all of it | {:.2} | {:.2} | {sample:.2} |", cpu, wall_time);
        for (name, change) in EDITS {
            let mut times = [const { Vec::new() }; 3];
            for run in 0..RUNS {
                change(&mut scene, run);
                let snapshot = world.clone();
                let (done, cpu, wall_time) = timed(|| commit(&mut world, &scene, &pool));
                done?;
                drop(snapshot);
                let sample = first_sample(&world, &scene, &pool)?;
                times.iter_mut().zip([cpu, wall_time, sample]).for_each(|(times, time)| times.push(time));
            }
            let [cpu, wall_time, sample] = times.map(median);
            println!("| {count} | {name} | {cpu:.3} | {wall_time:.3} | {sample:.2} |");
        }
    }
    Ok(())
}

fn commit(world: &mut World, scene: &Scene, pool: &ThreadPool) -> Result<(), Box<dyn Error>> {
    world.commit(scene, &ShaderTable::default(), &CommitOptions::default(), pool)?;
    Ok(())
}

/// Milliseconds of the processors for one path through one pixel.
fn first_sample(world: &World, scene: &Scene, pool: &ThreadPool) -> Result<f64, Box<dyn Error>> {
    let camera = SceneCamera::new(&scene.cameras()[0]).ok_or("the camera has no view")?;
    let integrator = Integrator::Path;
    let options = RenderOptions { width: 1, height: 1, spp: 1, integrator, ..RenderOptions::default() };
    let (frame, cpu, _) = timed(|| render(world, &camera, &options, pool, &Silent));
    assert!(frame?.picture.color[0].iter().all(|x| x.is_finite()), "a sound picture");
    Ok(cpu)
}

/// A result, with milliseconds of all processors and on the wall.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64, f64) {
    let (cpu, wall_time) = (process_seconds(), Instant::now());
    let result = work();
    (result, 1e3 * (process_seconds() - cpu), 1e3 * wall_time.elapsed().as_secs_f64())
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// `count` spheres and a light above them.
fn scene_of(count: u32) -> Scene {
    let mut scene = Scene::new();
    for i in 0..MATERIALS {
        scene.add_material(Material::matte(format!("m{i}"), [0.3 + 0.005 * i as f32; 3]));
    }
    let shining = Material { emission: [20.0; 3], ..Material::matte("lamp", [0.5; 3]) };
    let shining = scene.add_material(shining);
    let light_mesh = grid_mesh(LIGHT_MESH, shining, |u, v| [200.0 * u - 100.0, 60.0, 200.0 * v - 100.0]);
    let light_mesh = scene.add_mesh(light_mesh);
    let light_mesh = scene.add_object_of("lamp", vec![light_mesh]);
    scene.instantiate(light_mesh, Affine::IDENTITY);
    let mut balls = Vec::new();
    for i in 0..BALLS {
        let ball = grid_mesh(64, MaterialId(i % MATERIALS), |u, v| {
            let (azimuth, polar) = (std::f32::consts::TAU * u, std::f32::consts::PI * v);
            let radius = 0.3 * polar.sin();
            [radius * azimuth.cos(), 0.3 * polar.cos(), radius * azimuth.sin()]
        });
        let ball = scene.add_mesh(ball);
        balls.push(scene.add_object_of("ball", vec![ball]));
    }
    let side = f64::from(count).sqrt().ceil() as u32;
    for i in 0..count {
        let grid_position = [i % side, i / side].map(|x| f64::from(x) - 0.5 * f64::from(side));
        scene.instantiate(
            balls[(i % BALLS) as usize],
            Affine::translation([grid_position[0], 0.0, grid_position[1]]),
        );
    }
    let texture = scene.add_texture(sky());
    scene.add_light(sky_light(texture));
    scene.add_light(Light::Point { position: [0.0, 50.0, 0.0], intensity: [100.0; 3], radius: 0.0 });
    let eye = [0.0, 30.0, 0.5 * side as f32 + 5.0];
    let target = [0.0; 3];
    scene.add_camera(Camera {
        name: String::new(),
        eye,
        target,
        up: [0.0, 1.0, 0.0],
        fov_y: 40.0,
        ..Camera::default()
    });
    scene
}

/// A square of `side` x `side` quadrangles, bent by `grid_position`.
fn grid_mesh(side: u32, material: MaterialId, grid_position: impl Fn(f32, f32) -> [f32; 3]) -> Mesh {
    let at = |i: u32| i as f32 / side as f32;
    let positions = (0..=side).flat_map(|j| (0..=side).map(move |i| (i, j)));
    let positions = positions.map(|(i, j)| grid_position(at(i), at(j))).collect();
    let quad = |i: u32, j: u32| {
        let a = j * (side + 1) + i;
        let b = a + side + 1;
        [[a, a + 1, b], [b, a + 1, b + 1]]
    };
    let indices = (0..side).flat_map(|j| (0..side).flat_map(move |i| quad(i, j))).collect();
    Mesh { positions, indices, material, ..Mesh::default() }
}

fn sky() -> Texture {
    let (width, height) = (1024, 512);
    let texel = |i: u32| {
        [0.2 + (i % width) as f32 / width as f32, 0.5, 1.0 - (i / width) as f32 / height as f32, 1.0]
    };
    let texels = Texels { width, height, data: TexelData::Float((0..width * height).map(texel).collect()) };
    Texture { texels: Arc::new(texels), wrap: [Wrap::Repeat; 2], filter: Filter::Linear, name: String::new() }
}

fn sky_light(texture: TextureId) -> Light {
    Light::Environment { radiance: [1.0; 3], texture: Some(texture), world_from_light: Affine::IDENTITY }
}
