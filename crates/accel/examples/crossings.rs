// SPDX-License-Identifier: GPL-3.0-or-later
//! Sends a million rays through vertices and edges of closed meshes, near, far away and tiny, in every kind
//! of tree, and counts those whose crossings differ from integer arithmetic. As many points at vertices, on
//! edges and beside them are tested for their side. Run: `cargo run --release -p gnurt-accel --example
//! crossings [RAYS]`
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use std::time::Instant;

use gnurt_accel::{
    BuildOptions, Memory, ObjectTree, Quality, Query, Ray, Side, Structure, Threads, Triangles,
};
use gnurt_testkit::{Random, Soup, Voxels, Where, closed, lattice};

const KINDS: [(Structure, Quality, Memory); 4] = [
    (Structure::Bvh, Quality::Medium, Memory::Fast),
    (Structure::Bvh, Quality::High, Memory::Fast),
    (Structure::Bvh, Quality::Medium, Memory::Compact),
    (Structure::Kd, Quality::Medium, Memory::Fast),
];

fn build(mesh: &Soup, (structure, quality, memory): (Structure, Quality, Memory)) -> ObjectTree {
    let triangles = [Triangles { positions: &mesh.positions, indices: &mesh.indices }];
    let options = BuildOptions { structure, quality, memory, ..BuildOptions::default() };
    ObjectTree::build(&triangles, &options, Threads::Single)
}

/// Counts of queries and of wrong answers, and their time.
#[derive(Default)]
struct Tally {
    rays: usize,
    wrong_rays: usize,
    points: usize,
    wrong_points: usize,
    seconds: [f64; 2],
}

impl Tally {
    fn rays(&mut self, tree: &ObjectTree, rays: &[Ray], expected: &[u32]) {
        let (mut counts, start) = (Vec::new(), Instant::now());
        tree.crossings_batch(&Query::default(), rays, Threads::Single, &mut counts);
        self.seconds[0] += start.elapsed().as_secs_f64();
        for ((ray, count), expected) in rays.iter().zip(&counts).zip(expected) {
            if count != expected {
                println!("{ray:?}: {count} crossings, not {expected}");
                self.wrong_rays += 1;
            }
        }
        self.rays += rays.len();
    }

    fn points(&mut self, tree: &ObjectTree, points: &[[f64; 3]], expected: &[Side]) {
        let (mut sides, start) = (Vec::new(), Instant::now());
        tree.side_batch(&Query::default(), points, Threads::Single, &mut sides);
        self.seconds[1] += start.elapsed().as_secs_f64();
        for ((point, side), expected) in points.iter().zip(&sides).zip(expected) {
            if side != expected {
                println!("{point:?}: {side:?}, not {expected:?}");
                self.wrong_points += 1;
            }
        }
        self.points += points.len();
    }

    /// Solids of cubes: rays through points of their grid, and those points.
    fn cubes(&mut self, random: &mut Random, round: usize) {
        let n = 2 + round as i64 % 4;
        let voxels = Voxels::random(round as u64, n as u32, [0.3, 0.6, 0.9][round % 3]);
        let places =
            [(0.0, 1.0), (65536.0, 0.125), (0.0, 2f32.powi(-100)), (-1e6, 1.0), (0.0, 2f32.powi(50))];
        let (from, side) = places[round % 5];
        let tree = build(&voxels.mesh(round.is_multiple_of(2), [from; 3], side), KINDS[round % 4]);
        let (mut rays, mut counts, mut points, mut sides) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for _ in 0..5000 {
            let target = [0; 3].map(|_: i32| random.below(2 * n as usize + 1) as i64);
            let dir = [0; 3].map(|_: i32| random.below(9) as i64 - 4);
            points.push(target.map(|x| f64::from(from) + 0.5 * f64::from(side) * x as f64));
            sides.push(match voxels.locate(target) {
                Where::Outside => Side::Outside,
                Where::Surface => Side::Surface,
                Where::Inside => Side::Inside,
            });
            if dir != [0; 3] {
                let org = [0, 1, 2].map(|k| target[k] - (2 * n + 2) * dir[k]);
                counts.push(voxels.crossings(org, dir));
                let at = org.map(|x| from + 0.5 * side * x as f32);
                rays.push(Ray::new(at, dir.map(|x| side * x as f32)));
            }
        }
        self.rays(&tree, &rays, &counts);
        self.points(&tree, &points, &sides);
    }

    /// Round meshes on a fine grid: rays through vertices, middles of edges and of triangles, from anywhere; and their origins.
    fn rounds(&mut self, random: &mut Random, round: usize) {
        const GRID: f32 = 4096.0;
        let mut mesh = [closed::sphere(9), closed::torus(9)][round % 2].clone();
        mesh.positions.iter_mut().flatten().for_each(|x| *x = (*x * GRID).round() / GRID);
        let tree = build(&mesh, KINDS[round / 2 % 4]);
        let quarter = |p: [f32; 3]| p.map(|x| (x * 4.0 * GRID) as i64);
        let whole: Vec<[[i64; 3]; 3]> =
            (0..mesh.indices.len()).filter_map(|i| Some(mesh.corners(i)?.map(quarter))).collect();
        let (mut rays, mut counts, mut points, mut sides) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for _ in 0..1000 {
            let Some([a, b, c]) = mesh.corners(random.below(mesh.indices.len())) else { continue };
            let target = match random.below(3) {
                0 => a,
                1 => [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])),
                _ => [0, 1, 2].map(|k| 0.25 * (a[k] + b[k] + 2.0 * c[k])),
            };
            let org = random.point().map(|x| (2.0 * x * GRID).round() / GRID);
            let dir = [0, 1, 2].map(|k| target[k] - org[k]);
            let crossings = |dir: [i64; 3]| lattice::crossings(whole.iter().copied(), quarter(org), dir);
            counts.push(crossings(quarter(dir)));
            rays.push(Ray::new(org, dir));
            points.push(org.map(f64::from));
            sides.push(if crossings([16384, 397, 211]) % 2 == 1 { Side::Inside } else { Side::Outside });
        }
        self.rays(&tree, &rays, &counts);
        self.points(&tree, &points, &sides);
    }
}

fn main() -> Result<(), String> {
    let requested: usize = match std::env::args().nth(1) {
        Some(text) => text.parse().map_err(|_| format!("'{text}' is not a number of rays"))?,
        None => 1_000_000,
    };
    let (mut random, mut tally) = (Random::new(1), Tally::default());
    for round in 0.. {
        tally.cubes(&mut random, round);
        tally.rounds(&mut random, round);
        if tally.rays >= requested && tally.points >= requested {
            break;
        }
    }
    let Tally { rays, wrong_rays, points, wrong_points, seconds } = tally;
    println!("{rays} rays, {wrong_rays} wrong counts; {points} points, {wrong_points} wrong sides");
    let rate = |n: usize, seconds: f64| n as f64 / seconds / 1e6;
    println!(
        "million per second: {:.2} rays, {:.2} points",
        rate(rays, seconds[0]),
        rate(points, seconds[1])
    );
    if wrong_rays + wrong_points == 0 { Ok(()) } else { Err("wrong answers".into()) }
}
