// SPDX-License-Identifier: GPL-3.0-or-later
//! Cost of immediate calls relative to arrays in the Rust API: the same triangles, each vertex by itself. The
//! times are printed; `cargo test --release -p openrt --test submission -- --ignored --nocapture` compares
//! those of a million triangles: less than 1.3 times is the aim.

mod common;

use std::process::Command;
use std::time::Instant;

use common::{Workshop, source};
use gnurt::render::{CommitOptions, ShaderTable, World};
use gnurt::scene::{Affine, Mesh, Scene};

/// Triangles of tests/c/million.c.
fn mesh(side: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for (j, i, k) in (0..side).flat_map(|j| (0..side).flat_map(move |i| (0..6).map(move |k| (j, i, k)))) {
        let (x, y) = (i + usize::from(matches!(k, 1 | 2 | 4)), j + usize::from(matches!(k, 2 | 4 | 5)));
        mesh.positions.push([x as f32, y as f32, ((x * 7 + y * 13) % 5) as f32]);
        mesh.normals.push([0.0, 0.0, 1.0]);
    }
    mesh.indices = (0..mesh.positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh
}

/// Seconds that it takes to fill arrays, as the C program fills its calls, and to build them; and the former alone.
fn seconds_of_arrays(triangles: usize) -> [f64; 2] {
    let pool = gnurt::thread_pool(0).expect("threads");
    let (mut scene, mut world) = (Scene::new(), World::new());
    scene.add_material(gnurt::scene::Material::matte("", [0.5; 3]));
    let start = Instant::now();
    let mesh = mesh(((triangles as f64) / 2.0).sqrt() as usize);
    let filled = start.elapsed().as_secs_f64();
    let mesh = scene.add_mesh(mesh);
    let object = scene.add_object_of("", vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
    let report = world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool);
    assert_eq!(report.expect("a sound scene").dropped_triangles, 0, "all of them");
    [start.elapsed().as_secs_f64(), filled]
}

/// Seconds of calls and build in C.
fn seconds_of_calls(workshop: &Workshop, triangles: usize) -> f64 {
    let binary = workshop.build("cc", "c99", &source("tests/c/million.c"));
    let line = workshop.run(&binary, &[&triangles.to_string()]);
    let tokens: Vec<&str> = line.split_whitespace().collect();
    eprintln!("{line}");
    tokens[tokens.len() - 4].parse().expect("seconds before 's in all'")
}

#[test]
fn both_ways_work() {
    let workshop = Workshop::new();
    assert!(seconds_of_calls(&workshop, 20_000) > 0.0, "a time");
    assert!(seconds_of_arrays(20_000)[0] > 0.0, "a time");
}

/// The result of [`seconds_of_arrays`] in a process of its own: allocators keep memory of earlier runs, but
/// the C program's memory is new each time.
fn seconds_of_new_arrays() -> [f64; 2] {
    let this = std::env::current_exe().expect("the test itself");
    let child =
        Command::new(this).args(["--ignored", "--exact", "a_million_by_arrays", "--nocapture"]).output();
    let message = String::from_utf8(child.expect("it runs again").stderr).expect("text");
    let line = message.lines().find_map(|line| line.split_once(SECONDS)).expect("its seconds").1;
    let mut seconds = line.split_whitespace().map(|token| token.parse().expect("seconds"));
    std::array::from_fn(|_| seconds.next().expect("two numbers"))
}

const SECONDS: &str = "seconds of arrays: ";

#[test]
#[ignore = "half of the measurement below"]
fn a_million_by_arrays() {
    let [all, filled] = seconds_of_arrays(1_000_000);
    eprintln!("{SECONDS}{all} {filled}");
}

#[test]
#[ignore = "a measurement: wants a machine without other work"]
fn a_million_triangles() {
    let workshop = Workshop::new();
    // In turn, so that a slow moment meets both.
    let times: Vec<_> =
        (0..7).map(|_| (seconds_of_calls(&workshop, 1_000_000), seconds_of_new_arrays())).collect();
    let calls = times.iter().map(|time| time.0).fold(f64::INFINITY, f64::min);
    let [arrays, filled] =
        times.iter().map(|time| time.1).min_by(|a, b| a[0].total_cmp(&b[0])).expect("some");
    eprintln!("calls {calls:.3} s, arrays {arrays:.3} s ({filled:.3} s to fill them): {:.2}", calls / arrays);
    assert!(calls < 1.3 * arrays, "immediate calls take {:.2} times as long", calls / arrays);
}
