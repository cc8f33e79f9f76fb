// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays in double precision beside those in floats: processor time of one thread, in turns, over the same triangles.
//! Run in this folder: `cargo run --release -- FILE EYE TARGET UP DEGREES [--size N] [--rounds N] [--offset X]`. FILE is an OBJ, or a
//! binary PLY of triangles; EYE, TARGET and UP are three numbers with commas; DEGREES is the vertical angle. With an offset all
//! coordinates in doubles are moved by it.
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

mod mesh;
mod rays;

use gnurt_accel::doubles::{DoubleMesh, DoubleRay, DoubleScene};
use gnurt_accel::{BuildOptions, HitBatch, ObjectTree, Query, Ray, RayBatch, Record, Threads, Triangles};

use rays::View;

/// Rays of a batch.
const BATCH: usize = 4096;

fn seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// How many hits there are, and the sum of their parameters.
type Sum = (usize, f64);

fn floats(tree: &ObjectTree, batches: &[RayBatch], any: bool) -> Sum {
    let (query, mut hits, mut occluded) = (Query::default(), HitBatch::default(), Vec::new());
    let (mut count, mut sum) = (0, 0.0);
    for batch in batches {
        if any {
            tree.occluded_batch(&query, batch, &mut occluded, &mut Record::default());
            count += occluded.iter().filter(|hit| **hit).count();
        } else {
            tree.intersect_batch(&query, batch, &mut hits, &mut Record::default());
            for t in hits.t.iter().filter(|t| t.is_finite()) {
                (count, sum) = (count + 1, sum + f64::from(*t));
            }
        }
    }
    (count, sum)
}

fn doubles(scene: &DoubleScene, rays: &[DoubleRay], any: bool) -> Sum {
    let (mut count, mut sum) = (0, 0.0);
    for batch in rays.chunks(BATCH) {
        if any {
            count += scene.occluded_batch(batch, Threads::Single).iter().filter(|hit| **hit).count();
        } else {
            for hit in scene.intersect_batch(batch, Threads::Single).iter().flatten() {
                (count, sum) = (count + 1, sum + hit.t);
            }
        }
    }
    (count, sum)
}

fn three(text: &str) -> [f32; 3] {
    let numbers: Vec<f32> = text.split(',').map(|x| x.parse().expect("a number")).collect();
    numbers.try_into().expect("three numbers")
}

fn main() {
    let (mut places, mut size, mut rounds, mut offset) = (Vec::new(), 256, 7, 0.0);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|x| x.parse::<f64>().ok()).expect("a number");
        match argument.as_str() {
            "--size" => size = number() as u32,
            "--rounds" => rounds = number() as usize,
            "--offset" => offset = number(),
            _ => places.push(argument),
        }
    }
    let [file, eye, target, up, degrees] = &places[..] else { panic!("FILE EYE TARGET UP DEGREES") };
    let mesh = mesh::read(file);
    let (positions, indices) = (&mesh.positions[..], &mesh.indices[..]);
    let view = View {
        eye: three(eye),
        target: three(target),
        up: three(up),
        degrees: degrees.parse().expect("degrees"),
    };
    let options = BuildOptions::default();
    let tree = ObjectTree::build(&[Triangles { positions, indices }], &options, Threads::Single);
    let moved = |at: [f32; 3]| at.map(|x| f64::from(x) + offset);
    let far: Vec<[f64; 3]> = positions.iter().map(|&at| moved(at)).collect();
    let scene = DoubleScene::build(&[DoubleMesh::new(&far, indices)], &[], &options, Threads::Single)
        .expect("a sound mesh");
    let double = |ray: &Ray| {
        DoubleRay::new(moved(ray.org), ray.dir.map(f64::from))
            .within(f64::from(ray.t_near), f64::from(ray.t_far))
    };
    let (mut product, mut classes) = (0.0, 0);
    for (name, any, rays) in rays::classes(&mesh, &view, size, &tree) {
        let batches: Vec<RayBatch> = rays.chunks(BATCH).map(|rays| rays.iter().copied().collect()).collect();
        let doubled: Vec<DoubleRay> = rays.iter().map(double).collect();
        let (mut of_floats, mut of_doubles) = (Vec::new(), Vec::new());
        let (mut expected, mut found) = ((0, 0.0), (0, 0.0));
        for _ in 0..rounds {
            let start = seconds();
            expected = floats(&tree, &batches, any);
            let middle = seconds();
            found = doubles(&scene, &doubled, any);
            of_floats.push(middle - start);
            of_doubles.push(seconds() - middle);
        }
        let (a, b) = (median(of_floats), median(of_doubles));
        let speed = |seconds: f64| 1e-6 * rays.len() as f64 / seconds;
        println!(
            "{name:9} floats {:6.2} doubles {:6.2} Mrays/s: {:.3}   {} and {} hits, sums differ by {:.1e}",
            speed(a),
            speed(b),
            a / b,
            expected.0,
            found.0,
            (expected.1 - found.1).abs() / found.1.max(f64::MIN_POSITIVE),
        );
        (product, classes) = (product + (a / b).ln(), classes + 1);
    }
    println!("geometric mean {:.3}", (product / f64::from(classes)).exp());
}
