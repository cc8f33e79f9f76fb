// SPDX-License-Identifier: GPL-3.0-or-later
//! `t` is right to 1e-5 of itself for every hit: through slivers, at grazing rays, a hair's breadth from large triangles; in
//! every structure, at every level, in every mode. The truth is computed in integers.
//! Corners, origins and directions are on a lattice of 2^-20, so that all products fit 128 bits.

use crate::common::{GRID, WATERTIGHT, build, run_queries};
use gnurt_accel::{Ray, RayBatch};
use gnurt_testkit::{Random, Soup};

/// A place on the lattice.
type P = [i128; 3];

fn float(p: P) -> [f32; 3] {
    p.map(|x| x as f32 / (1 << 20) as f32)
}

fn lattice(p: [f32; 3]) -> P {
    p.map(|x| (f64::from(x) * f64::from(1 << 20)) as i128)
}

/// Where the line meets the triangle; if it passes beside it, in the nearest way, its edge: negative weights are none. `None`
/// in its plane.
fn exact_t(corners: [P; 3], org: P, dir: P) -> Option<f64> {
    let z = (0..3).max_by_key(|&k| dir[k].abs())?;
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let from = corners.map(|c| [0, 1, 2].map(|k| c[k] - org[k]));
    let px = from.map(|p| p[x] * dir[z] - p[z] * dir[x]);
    let py = from.map(|p| p[y] * dir[z] - p[z] * dir[y]);
    let weight = |b: usize, c: usize| px[c] * py[b] - py[c] * px[b];
    let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
    let side = weights.iter().sum::<i128>().signum();
    let weights = weights.map(|w| (w * side).max(0));
    let whole: i128 = weights.iter().sum();
    // In doubles only now: each factor is exact, or rounded once.
    let depth: i128 = weights.iter().zip(&from).map(|(w, p)| w * p[z]).sum();
    (side != 0).then(|| depth as f64 / (whole as f64 * dir[z] as f64))
}

/// Triangles from 2^-20 to 1 in length and width, large ones and slivers, near each other.
fn soup(random: &mut Random, count: usize) -> Soup {
    let mut soup = Soup::default();
    for _ in 0..count {
        let mut step = |bits: usize| {
            let most = 1i128 << random.below(bits + 1);
            [0; 3].map(|_: i32| random.below(2 * most as usize + 1) as i128 - most)
        };
        let (a, b, c) = (step(19), step(18), step(18));
        let plus = |p: P, q: P| [0, 1, 2].map(|k| p[k] + q[k]);
        soup.push([float(a), float(plus(a, b)), float(plus(a, c))]);
    }
    soup
}

#[test]
fn every_parameter_is_right() {
    let mut random = Random::new(5);
    let soup = soup(&mut random, 150);
    let placement = |i: usize| soup.corners(i).expect("there are as many").map(lattice);
    let mut rays = RayBatch::default();
    for _ in 0..800 {
        // From near one triangle to a point of another, or of the same.
        let mut point = || {
            let [a, b, c] = placement(random.below(150));
            let (u, v) = (random.below(257) as i128, random.below(257) as i128);
            let (u, v) = if u + v > 256 { (256 - u, 256 - v) } else { (u, v) };
            [0, 1, 2].map(|k| a[k] + (u * (b[k] - a[k]) + v * (c[k] - a[k])) / 256)
        };
        let (from, to) = (point(), point());
        let away = 1i128 << random.below(20);
        let org =
            from.map(|x| (x + random.below(2 * away as usize + 1) as i128 - away).clamp(-(1 << 20), 1 << 20));
        let dir = [0, 1, 2].map(|k| to[k] - org[k]);
        if dir != [0; 3] {
            rays.push(Ray::new(float(org), float(dir)));
        }
    }
    let mut hits_of_all = 0;
    for kind in WATERTIGHT.into_iter().chain([GRID]) {
        let object = build(std::slice::from_ref(&soup), kind);
        let hits = run_queries(&object, &rays);
        for (i, hit) in hits.iter().enumerate().filter_map(|(i, hit)| Some((i, hit.as_ref()?))) {
            let ray = rays.get(i);
            let (org, dir) = (lattice(ray.org), lattice(ray.dir));
            let Some(exact) = exact_t(placement(hit.prim_id as usize), org, dir) else { continue };
            let off = (f64::from(hit.t) - exact).abs();
            assert!(
                off <= 1e-5 * exact.abs(),
                "{kind:?}: {} is {exact} in truth, of {ray:?} and {hit:?}",
                hit.t
            );
            hits_of_all += 1;
        }
    }
    assert!(hits_of_all > 2_000, "{hits_of_all} hits are enough to tell");
}
