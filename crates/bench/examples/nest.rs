// SPDX-License-Identifier: GPL-3.0-or-later
//! Cost of nested objects: a million balls as one object held by others, and as a million instances. Run:
//! `cargo run --release -p gnurt-bench --example nest -- [SIDE...]` SIDE^2 instances of an object that holds
//! SIDE^2 balls of 256 triangles; two levels deeper the same as SIDE in SIDE in SIDE in SIDE. Memory is the
//! growth of the process by scene and world; edits are the median of five; rays go from the camera to the
//! first surface, 512 x 512, one thread's time.
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::error::Error;

use gnurt::ThreadPool;
use gnurt::accel::Ray;
use gnurt::render::{CommitOptions, ShaderTable, World};
use gnurt::scene::{Affine, InstanceId, Material, MaterialId, Member, Mesh, ObjectId, Scene};
use gnurt_bench::process_seconds;

const RUNS: usize = 5;
/// Rays along a side of the picture.
const PIXELS: u32 = 512;

fn main() -> Result<(), Box<dyn Error>> {
    let sides: Vec<u32> = std::env::args().skip(1).map(|side| side.parse()).collect::<Result<_, _>>()?;
    let sides = if sides.is_empty() { vec![10, 32] } else { sides };
    let pool = gnurt::thread_pool(2)?;
    println!(
        "| balls | as | scene and world, MB | first commit, CPU ms | one matrix | one member | 512 x 512 rays, CPU ms | hits |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for side in sides {
        for (name, make) in [
            ("one by one", flat as fn(u32) -> Scene),
            ("square in square", nested),
            ("row in row in row in row", deep),
        ] {
            measure(side, name, make, &pool)?;
        }
    }
    Ok(())
}

fn measure(side: u32, name: &str, make: fn(u32) -> Scene, pool: &ThreadPool) -> Result<(), Box<dyn Error>> {
    let before = resident();
    let mut scene = make(side);
    let mut world = World::new();
    let commit = |world: &mut World, scene: &Scene| {
        world.commit(scene, &ShaderTable::default(), &CommitOptions::default(), pool)
    };
    let (first, first_ms) = timed(|| commit(&mut world, &scene));
    first?;
    let megabytes = resident().saturating_sub(before) as f64 / 1e6;
    let mut edits = [const { Vec::new() }; 2];
    for run in 0..RUNS {
        let step = 0.01 * (run + 1) as f64;
        scene.edit_instance(InstanceId(0)).world_from_object.columns[3][1] += step;
        let (done, ms) = timed(|| commit(&mut world, &scene));
        done?;
        edits[0].push(ms);
        if scene.objects().len() > 1 {
            scene.edit_object(ObjectId(1)).members[0].object_from_member.columns[3][1] += step;
            let (done, ms) = timed(|| commit(&mut world, &scene));
            done?;
            edits[1].push(ms);
        }
    }
    let [matrix, member] =
        edits.map(|times| median(times).map_or_else(|| "-".to_owned(), |ms| format!("{ms:.2}")));
    let mut times = Vec::new();
    let mut hits = 0;
    for _ in 0..RUNS {
        let (count, ms) = timed(|| trace(&world, side));
        hits = count;
        times.push(ms);
    }
    let rays = median(times).unwrap_or_default();
    let balls = side.pow(4);
    println!(
        "| {balls} | {name} | {megabytes:.0} | {first_ms:.1} | {matrix} | {member} | {rays:.0} | {hits} |"
    );
    Ok(())
}

/// How many rays of a picture from above hit something.
fn trace(world: &World, side: u32) -> usize {
    let extent = (side * side) as f32;
    let pixel = |i: u32| (i as f32 + 0.5) / PIXELS as f32;
    let rays = (0..PIXELS).flat_map(|y| (0..PIXELS).map(move |x| (pixel(x), pixel(y))));
    let visible = rays.filter(|&(x, y)| {
        let from = [0.5 * extent, 0.3 * extent, -0.2 * extent];
        let to = [x * extent, 0.0, y * extent];
        world.intersect(&Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]))).is_some()
    });
    visible.count()
}

/// A result, with milliseconds of all processors.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let cpu = process_seconds();
    let result = work();
    (result, 1e3 * (process_seconds() - cpu))
}

fn median(mut times: Vec<f64>) -> Option<f64> {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied()
}

/// Resident bytes of the process; 0 if unknown.
fn resident() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    pages.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0) * 4096
}

fn at(x: u32, z: u32) -> Affine {
    Affine::translation([f64::from(x) + 0.5, 0.0, f64::from(z) + 0.5])
}

/// The positions of a square of `side` x `side`, `step` apart.
fn square(side: u32, step: u32) -> impl Iterator<Item = Affine> {
    (0..side).flat_map(move |z| {
        (0..side).map(move |x| Affine::translation([x * step, 0, z * step].map(f64::from)))
    })
}

fn ball() -> Scene {
    let mut scene = Scene::new();
    scene.add_material(Material::matte("grey", [0.5; 3]));
    let (rows, columns) = (9_u32, 16_u32);
    let point = |i: u32| {
        let (polar, azimuth) =
            ((i / columns) as f32 / (rows - 1) as f32, (i % columns) as f32 / columns as f32);
        let (polar, azimuth) = (std::f32::consts::PI * polar, std::f32::consts::TAU * azimuth);
        [0.4 * polar.sin() * azimuth.cos(), 0.4 * polar.cos(), 0.4 * polar.sin() * azimuth.sin()]
    };
    let positions = (0..rows * columns).map(point).collect();
    let quad = |i: u32| {
        let (row, column) = (i / columns, i % columns);
        let next = (column + 1) % columns;
        let [a, b] = [row * columns + column, row * columns + next];
        [[a, b, a + columns], [b, b + columns, a + columns]]
    };
    let indices = (0..(rows - 1) * columns).flat_map(quad).collect();
    let mesh = scene.add_mesh(Mesh { positions, indices, material: MaterialId(0), ..Mesh::default() });
    scene.add_object_of("ball", vec![mesh]);
    scene
}

fn flat(side: u32) -> Scene {
    let mut scene = ball();
    let all = side * side;
    (0..all * all).for_each(|i| _ = scene.instantiate(ObjectId(0), at(i % all, i / all)));
    scene
}

fn nested(side: u32) -> Scene {
    let mut scene = ball();
    let all = side * side;
    let members = (0..all).map(|i| Member::new(ObjectId(0), at(i % side, i / side)));
    let object = scene.add_object_of_members("square", members.collect());
    square(side, side).for_each(|position| _ = scene.instantiate(object, position));
    scene
}

/// Rows of balls, squares of rows, rows of squares, and a square of those.
fn deep(side: u32) -> Scene {
    let mut scene = ball();
    let mut object = ObjectId(0);
    let steps = [(at(0, 0), [1, 0]), (Affine::IDENTITY, [0, 1]), (Affine::IDENTITY, [side, 0])];
    for (first, [x, z]) in steps {
        let position = |i: u32| Affine::translation([x * i, 0, z * i].map(f64::from)) * first;
        let members = (0..side).map(|i| Member::new(object, position(i)));
        object = scene.add_object_of_members("row", members.collect());
    }
    for i in 0..side {
        scene.instantiate(object, Affine::translation([0.0, 0.0, f64::from(i * side)]));
    }
    scene
}
