// SPDX-License-Identifier: GPL-3.0-or-later
//! A million rays and a million points, aimed at vertices and edges, near, far away, tiny and huge, at every level, in all structures that
//! never leak: none may be counted wrongly or found on the wrong side. The oracle is whole numbers.
//!
//! Takes minutes: `cargo test -p gnurt-accel --test suite -- --ignored million`.

use gnurt_accel::{Level, ObjectTree, Query, Ray, Side, Threads};
use gnurt_testkit::{Random, Voxels, Where};

use super::crossings::aimed;
use crate::common::{WATERTIGHT, build};

/// Of each: at each level.
const MILLION: usize = 1_000_000;
/// From how many solids.
const SOLIDS: usize = 70;

/// Where the solid's first corner lies, and the side of its cubes; all of its corners are floats.
const PLACES: [(f32, f32); 6] = [
    (0.0, 1.0),
    (4096.0, 0.125),
    (0.0, f32::MIN_POSITIVE * (1 << 26) as f32),
    (-1e6, 1.0),
    (0.0, (1u64 << 50) as f32),
    (65536.0, 0.25),
];

struct Solid {
    n: i64,
    from: f32,
    side: f32,
    voxels: Voxels,
    tree: ObjectTree,
}

impl Solid {
    fn new(round: usize) -> Self {
        let n = 1 + round as i64 % 5;
        let (from, side) = PLACES[round % 6];
        let voxels = Voxels::random(round as u64, n as u32, [0.2, 0.5, 0.9][round % 3]);
        let kind = WATERTIGHT[round % WATERTIGHT.len()];
        let tree = build(&[voxels.mesh(round.is_multiple_of(2), [from; 3], side)], kind);
        Self { n, from, side, voxels, tree }
    }

    fn is_in(&self, cube: [i64; 3]) -> bool {
        self.voxels.locate(cube.map(|x| 2 * x + 1)) == Where::Inside
    }

    /// The square of the distance to the surface, in half sides; `faces` are all of it.
    fn distance(&self, point: [i64; 3], faces: &[([i64; 3], usize)]) -> Option<i64> {
        let to = |&(cube, axis): &([i64; 3], usize)| -> i64 {
            let offset = |k: usize| match point[k] - 2 * cube[k] {
                x if k == axis => x,
                x if x < 0 => x,
                x => (x - 2).max(0),
            };
            (0..3).map(|k| offset(k) * offset(k)).sum()
        };
        faces.iter().map(to).min()
    }

    /// The lower faces of cubes along each axis where inside and outside meet.
    fn faces(&self) -> Vec<([i64; 3], usize)> {
        let all = |n: i64| 0..n;
        let mut faces = Vec::new();
        for axis in 0..3 {
            for x in all(self.n + 1) {
                for y in all(self.n + 1) {
                    for z in all(self.n + 1) {
                        let (cube, mut below) = ([x, y, z], [x, y, z]);
                        below[axis] -= 1;
                        if self.is_in(cube) != self.is_in(below) {
                            faces.push((cube, axis));
                        }
                    }
                }
            }
        }
        faces
    }
}

#[test]
#[ignore = "takes minutes"]
fn a_million_rays_are_counted_rightly() {
    let (mut random, mut requests, mut wrong) = (Random::new(17), 0, 0);
    for round in 0..SOLIDS {
        let solid = Solid::new(round);
        let scale = 2f32.powi(round as i32 % 7 - 3);
        let count = MILLION.div_ceil(SOLIDS);
        let plain: Vec<_> = (0..count).map(|_| aimed(&mut random, solid.n)).collect();
        let rays: Vec<Ray> = plain
            .iter()
            .map(|(org, dir)| {
                let at = org.map(|x| solid.from + 0.5 * solid.side * x as f32);
                Ray::new(at, dir.map(|x| scale * solid.side * x as f32))
            })
            .collect();
        let expected: Vec<u32> = plain.iter().map(|&(org, dir)| solid.voxels.crossings(org, dir)).collect();
        for level in Level::available() {
            let (query, mut found) = (Query { level, ..Query::default() }, Vec::new());
            solid.tree.crossings_batch(&query, &rays, Threads::Single, &mut found);
            wrong += found.iter().zip(&expected).filter(|(a, b)| a != b).count();
        }
        requests += count;
    }
    let levels = Level::available().len();
    assert!(
        requests >= MILLION && wrong == 0,
        "{wrong} counted wrongly of {requests} rays at each of {levels} levels"
    );
}

#[test]
#[ignore = "takes minutes"]
fn a_million_points_are_on_the_right_side() {
    let (mut random, mut requests) = (Random::new(19), 0);
    let (mut wrong_side, mut wrong_contains, mut wrong_sign, mut wrong_distance) = (0, 0, 0, 0);
    for round in 0..SOLIDS {
        let solid = Solid::new(round);
        let faces = solid.faces();
        let (mut points, mut expected) = (Vec::new(), Vec::new());
        for i in 0..MILLION.div_ceil(SOLIDS) {
            // Corners, edges, faces and middles of cubes, and beside each of them by as little as a double can be.
            let half = [0; 3].map(|_: i32| random.below(2 * solid.n as usize + 3) as i64 - 1);
            let towards = [0, 1, -1][i % 3];
            let offset = half.map(|x| 4 * x + if x % 2 == 0 { towards } else { 0 });
            let cube = offset.map(|x| x.div_euclid(8));
            let placement = if towards == 0 {
                solid.voxels.locate(half)
            } else {
                solid.voxels.locate(cube.map(|x| 2 * x + 1))
            };
            points.push([0, 1, 2].map(|k| {
                let x = f64::from(solid.from) + 0.5 * f64::from(solid.side) * half[k] as f64;
                match towards {
                    1 if half[k] % 2 == 0 => x.next_up(),
                    -1 if half[k] % 2 == 0 => x.next_down(),
                    _ => x,
                }
            }));
            let side = match placement {
                Where::Outside => Side::Outside,
                Where::Surface => Side::Surface,
                Where::Inside => Side::Inside,
            };
            let distance = solid.distance(half, &faces).filter(|_| towards == 0);
            expected
                .push((side, distance.map(|square| 0.5 * f64::from(solid.side) * (square as f64).sqrt())));
        }
        for level in Level::available() {
            let (query, threads) = (Query { level, ..Query::default() }, Threads::Single);
            let (mut sides, mut contained, mut distances) = (Vec::new(), Vec::new(), Vec::new());
            solid.tree.side_batch(&query, &points, threads, &mut sides);
            solid.tree.contains_batch(&query, &points, threads, &mut contained);
            solid.tree.signed_distance_batch(&query, &points, threads, &mut distances);
            for (i, &(side, distance)) in expected.iter().enumerate() {
                wrong_side += usize::from(sides[i] != side);
                wrong_contains += usize::from(contained[i] != (side != Side::Outside));
                // A distance of less than 1e-162 may be rounded to zero.
                wrong_sign += usize::from(match side {
                    Side::Outside => distances[i] < 0.0,
                    Side::Surface => distances[i] != 0.0,
                    Side::Inside => distances[i] > 0.0,
                });
                let is_off = |distance: f64| (distances[i].abs() - distance).abs() > 4e-15 * distance;
                wrong_distance += usize::from(distance.is_some_and(is_off));
            }
        }
        requests += points.len();
    }
    let wrong = wrong_side + wrong_contains + wrong_sign + wrong_distance;
    assert!(
        requests >= MILLION && wrong == 0,
        "of {requests} points at each of {} levels {wrong_side} are on the wrong side, {wrong_contains} contained wrongly, \
         {wrong_sign} signs and {wrong_distance} distances wrong",
        Level::available().len()
    );
}
