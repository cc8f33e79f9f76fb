// SPDX-License-Identifier: GPL-3.0-or-later
//! An integrator of one's own: ambient occlusion with the world's single-ray queries.
//!
//! Each pixel sends a camera ray. From the hit, 32 rays leave over the hemisphere; the share of those that meet nothing
//! within reach is the brightness. Renderers of one's own need no more than `World::intersect` and `World::occluded`.
//!
//! `cargo run --release -p gnurt-examples --bin own_integrator [PICTURE]`

use glam::Vec3;
use gnurt::accel::{Ray, RayBatch};
use gnurt::image::{Opacity, Picture, WriteOptions};
use gnurt::render::{CommitOptions, SceneCamera, ShaderTable, World};
use gnurt::shading::{CameraSamples, CameraShader};

const WIDTH: u32 = 320;
const HEIGHT: u32 = 240;
const RAYS: u32 = 32;

/// The `i`-th of `n` cosine-weighted directions around +z, on a spiral of the golden angle.
fn direction(i: u32, n: u32, turn: f32) -> Vec3 {
    let radius = ((i as f32 + 0.5) / n as f32).sqrt();
    let angle = 2.399_963 * i as f32 + turn;
    Vec3::new(radius * angle.cos(), radius * angle.sin(), (1.0 - radius * radius).max(0.0).sqrt())
}

/// The share of the hemisphere above `p` that is free within `reach` world units.
fn openness(world: &World, p: Vec3, normal: Vec3, reach: f32, turn: f32) -> f32 {
    let (x, y) = normal.any_orthonormal_pair();
    let is_free = |i: u32| {
        let d = direction(i, RAYS, turn);
        let towards = x * d.x + y * d.y + normal * d.z;
        let start = p + normal * (1e-4 * reach); // off the surface itself
        !world.occluded(&Ray::new(start.to_array(), towards.to_array()).within(0.0, reach))
    };
    (0..RAYS).filter(|&i| is_free(i)).count() as f32 / RAYS as f32
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args().nth(1).unwrap_or_else(|| "own_integrator.png".into());
    let scene = gnurt::load_scene("builtin:cornell")?.scene;
    let pool = gnurt::thread_pool(0)?;
    let mut world = World::new();
    world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool)?;
    let (low, high) = world.bounds().ok_or("the scene is empty")?;
    let reach = 0.25 * (Vec3::from(high) - Vec3::from(low)).length();

    // One ray through the centre of each pixel; the camera counts rows upwards.
    let camera = SceneCamera::new(&scene.cameras()[0]).ok_or("the camera has no view")?;
    let pixels = (0..HEIGHT).rev().flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    let centres: Vec<[f32; 2]> =
        pixels.map(|(x, y)| [(x as f32 + 0.5) / WIDTH as f32, (y as f32 + 0.5) / HEIGHT as f32]).collect();
    let mut rays = RayBatch::default();
    camera.rays(&CameraSamples::sharp(&centres), WIDTH as f32 / HEIGHT as f32, &mut rays);

    let shade = |i: usize| {
        let ray = rays.get(i);
        let Some(hit) = world.intersect(&ray) else { return 0.0 };
        let normal = world.normal(&hit).map_or(Vec3::Z, Vec3::from);
        let facing = if normal.dot(Vec3::from(ray.dir)) > 0.0 { -normal } else { normal };
        openness(&world, Vec3::from(ray.at(hit.t)), facing, reach, i as f32)
    };
    let color = (0..rays.len()).map(shade).map(|grey| [grey, grey, grey, 1.0]).collect();
    let picture = Picture {
        width: WIDTH,
        height: HEIGHT,
        color,
        opacity: Opacity::default(),
        layers: Vec::new(),
        metadata: Vec::new(),
    };
    gnurt::image::write(&picture, output.as_ref(), &WriteOptions::default())?;
    println!("wrote {output}");
    Ok(())
}
