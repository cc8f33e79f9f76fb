// SPDX-License-Identifier: GPL-3.0-or-later
//! Every tree hit equals brute force: all soups, both triangle tests, single rays and packets at every level.

use crate::common::{TESTS, WATERTIGHT, assert_hits, batch, build, run_queries};
use gnurt_accel::Ray;
use gnurt_testkit::{OracleInstance, Soup, oracle, rays};

fn check(name: &str, meshes: &[Soup], rays: &[rays::PlainRay]) {
    for (test, margin) in TESTS {
        let object = build(meshes, test);
        let rays = batch(rays);
        let hits = run_queries(&object, &rays);
        let found = hits.iter().flatten().count();
        assert!(found > 0, "{name}: no ray of {} hits anything with {test:?}", rays.len());
        assert_hits(&[OracleInstance::identity(meshes)], &rays, &hits, margin);
    }
}

#[test]
fn random_soups() {
    for (seed, n, size) in [(1, 1, 1.0), (2, 7, 0.8), (3, 60, 0.5), (4, 400, 0.1), (5, 800, 0.4)] {
        check("random", &[Soup::random(seed, n, size)], &rays::random(seed, 400));
    }
}

#[test]
fn several_meshes() {
    let meshes = [Soup::random(6, 50, 0.3), Soup::default(), Soup::grid(7, 50), Soup::random(8, 1, 0.9)];
    check("several", &meshes, &rays::random(9, 400));
}

#[test]
fn grids_of_axis_aligned_triangles() {
    check("grid", &[Soup::grid(10, 300)], &rays::random(11, 600));
}

#[test]
fn flat_but_for_one_bit() {
    for seed in 30..33 {
        let rays: Vec<_> =
            rays::random(seed, 600).into_iter().map(|(o, d)| (o.map(|x| 8.0 * x), d)).collect();
        check("flat but for one bit", &[Soup::flat_but_for_one_bit(seed, 600)], &rays);
    }
}

#[test]
fn degenerate_soups() {
    for kind in WATERTIGHT {
        for seed in 12..18 {
            let soup = Soup::degenerate(seed, 120);
            let bad = build(std::slice::from_ref(&soup), kind).bad_primitives();
            assert!(bad.total() > 10, "bad triangles are counted: {bad:?}");
            check("degenerate", &[soup], &rays::random(seed, 300));
        }
    }
}

/// Distance of a point from a triangle in double precision: to its plane where it is above the triangle, else to the
/// nearest edge. Flat ones are their edges.
fn distance(point: [f64; 3], corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let n = cross(minus(b, a), minus(c, a));
    let edges = [(a, b), (b, c), (c, a)];
    let above = edges.iter().all(|&(p, q)| dot(cross(minus(q, p), minus(point, p)), n) >= 0.0);
    if above && dot(n, n) > 0.0 {
        return dot(minus(point, a), n).abs() / dot(n, n).sqrt();
    }
    let to_edge = |(p, q): ([f64; 3], [f64; 3])| {
        let (along, from) = (minus(q, p), minus(point, p));
        let f = (dot(along, from) / dot(along, along)).clamp(0.0, 1.0);
        let off = minus(from, along.map(|x| f * x));
        dot(off, off).sqrt()
    };
    edges.map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
}

/// Distance between the lines of a ray and an edge, which decides the side of an edge, also at grazing
/// angles.
fn from_edge(ray: &Ray, (p, q): ([f32; 3], [f32; 3])) -> f64 {
    let minus = |p: [f32; 3], q: [f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(q[k]));
    let (along, from, dir) = (minus(q, p), minus(p, ray.org), ray.dir.map(f64::from));
    let n = [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        along[i] * dir[j] - along[j] * dir[i]
    });
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    (0..3).map(|k| n[k] * from[k]).sum::<f64>().abs() / length
}

/// How far along a ray a hit may lie beside a triangle: weights across a sliver are as uncertain as it is thin.
fn uncertainty(corners: [[f32; 3]; 3], tolerance: f64) -> f64 {
    let [a, b, c] = corners;
    let height = [(a, b, c), (b, c, a), (c, a, b)]
        .map(|(p, q, r)| distance(r.map(f64::from), [p, q, q]))
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    tolerance * (1.0 + 0.1 / height)
}

#[test]
fn slivers() {
    // Compared are places: a hit lies on its triangle, and nothing that is met clearly inside lies clearly before it.
    let meshes = [Soup::slivers(19, 300)];
    let instances = [OracleInstance::identity(&meshes)];
    let corners = |prim_id: u32| meshes[0].corners(prim_id as usize).expect("a triangle");
    for (test, tolerance) in [(TESTS[0].0, 1e-5), (TESTS[1].0, 1e-3)] {
        let object = build(&meshes, test);
        let rays = batch(&rays::aimed(&meshes[0], [0.1, 0.2, 3.0], 1));
        let hits = run_queries(&object, &rays);
        let (mut found, mut clear) = (0usize, 0usize);
        for (i, hit) in hits.iter().enumerate() {
            let ray = rays.get(i);
            let at = |t: f64| [0, 1, 2].map(|k| f64::from(ray.org[k]) + t * f64::from(ray.dir[k]));
            let mut last = f64::INFINITY;
            if let Some(hit) = hit {
                found += 1;
                let (off, allowed) = (
                    distance(at(f64::from(hit.t)), corners(hit.prim_id)),
                    uncertainty(corners(hit.prim_id), tolerance),
                );
                assert!(
                    off < allowed,
                    "{test:?}: {ray:?}: {hit:?} lies {off:e} beside its triangle, not {allowed:e}"
                );
                last = f64::from(hit.t) - allowed;
            }
            for surely in oracle::all_hits(&instances, (ray.org, ray.dir), [0.0, last], 0.0) {
                let [a, b, c] = corners(surely.prim_id);
                let to_edges = [(a, b), (b, c), (c, a)].map(|edge| from_edge(&ray, edge));
                let inside = to_edges.iter().all(|&margin| margin > tolerance);
                let before = surely.t + uncertainty([a, b, c], tolerance) < last;
                assert!(!inside || !before, "{test:?}: {ray:?} hits {hit:?}, but meets {surely:?} before");
            }
            let all = oracle::all_hits(&instances, (ray.org, ray.dir), [0.0, f64::INFINITY], 0.0);
            clear += usize::from(!all.is_empty());
        }
        assert!(
            found > 300 && found.abs_diff(clear) < clear / 2,
            "{found} hits, {clear} in double precision"
        );
    }
}

#[test]
fn copies_of_one_triangle() {
    for kind in WATERTIGHT {
        let object = build(&[Soup::copies(1000)], kind);
        let hits =
            run_queries(&object, &batch(&[([0.1, 0.0, 3.0], [0.0, 0.0, -1.0]), ([3.0; 3], [0.0, 1.0, 0.0])]));
        let hit = hits[0].expect("it aims at all of them");
        assert_eq!((hit.prim_id, hits[1]), (0, None), "the first of equals is reported");
        assert!(object.stats().references <= 6000, "{:?} keeps the budget", object.stats());
    }
}

#[test]
fn nothing_is_hit_in_nothing() {
    for kind in WATERTIGHT {
        for meshes in
            [vec![], vec![Soup::default()], vec![Soup { positions: vec![], indices: vec![[0, 1, 2]] }]]
        {
            let object = build(&meshes, kind);
            assert!(object.bounds().is_empty(), "no triangle, no box");
            let hits = run_queries(&object, &batch(&rays::random(20, 20)));
            assert!(hits.iter().all(Option::is_none), "and no hit");
        }
    }
}

#[test]
fn far_from_the_origin() {
    for kind in WATERTIGHT {
        // Coordinates near a million are multiples of 1/16: that is the soup which is traced, and the oracle sees it too.
        let offset = [1e6, -1e6, 5e5];
        let soup = Soup::random(21, 200, 30.0).moved(offset);
        let rays: Vec<_> = rays::random(22, 200)
            .into_iter()
            .map(|(org, dir)| ([0, 1, 2].map(|k| 40.0 * org[k] + offset[k]), dir))
            .collect();
        let meshes = [soup];
        let object = build(&meshes, kind);
        let rays = batch(&rays);
        assert_hits(&[OracleInstance::identity(&meshes)], &rays, &run_queries(&object, &rays), 1e-4);
    }
}
