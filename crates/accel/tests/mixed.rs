// SPDX-License-Identifier: GPL-3.0-or-later
//! Quads, spheres and user geometry, alone and mixed with triangles in one object, equal brute force in double precision
//! in every structure, at every level, one by one and in tiles.

use std::sync::Arc;

use crate::common::{QueryTarget, WATERTIGHT, batch, options, run_queries, scene_of};
use gnurt_accel::{
    Aabb, BadPrimitives, Geometry, Hit, Instance, ObjectTree, Quads, Ray, RayBatch, Spheres, Threads,
    Triangles, UserGeometry, UserHit,
};
use gnurt_testkit::{Random, Soup, rays};

/// Random spheres, some of them bad.
#[derive(Clone, Debug)]
struct Balls {
    centers: Vec<[f32; 3]>,
    radii: Vec<f32>,
}

impl Balls {
    fn random(seed: u64, n: usize, size: f32) -> Self {
        let mut random = Random::new(seed);
        let centers = (0..n).map(|_| random.point()).collect();
        Self { centers, radii: (0..n).map(|_| random.between(0.05, 1.0) * size).collect() }
    }

    /// Both parameters in double precision, and how near to the rim the ray passes (0 at the rim, 1 through the centre).
    fn meet(&self, i: usize, ray: &Ray) -> Option<([f64; 2], f64)> {
        let (c, r) = (self.centers[i].map(f64::from), f64::from(self.radii[i]));
        let (o, d) = (ray.org.map(f64::from), ray.dir.map(f64::from));
        let f = [0, 1, 2].map(|k| o[k] - c[k]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (a, b) = (dot(d, d), dot(f, d));
        let across = [0, 1, 2].map(|k| f[k] - b / a * d[k]);
        let left = r * r - dot(across, across);
        (left >= 0.0).then(|| {
            let root = (left / a).sqrt();
            ([-b / a - root, -b / a + root], left / (r * r))
        })
    }
}

impl UserGeometry for Balls {
    fn count(&self) -> u32 {
        self.radii.len() as u32
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        let (c, r) = (self.centers[prim_id as usize], self.radii[prim_id as usize]);
        Aabb { min: c.map(|x| (x - r).next_down()), max: c.map(|x| (x + r).next_up()) }
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        if let Some((at, _)) = self.meet(prim_id as usize, ray) {
            // Out of order, and whether they are in the interval or not.
            hit(UserHit { t: at[1] as f32, u: 0.25, v: 2.0 });
            hit(UserHit { t: at[0] as f32, u: 0.5, v: 3.0 });
        }
    }
}

fn build(geometries: &[Geometry], kind: crate::common::Kind) -> ObjectTree {
    ObjectTree::build_from(geometries, &options(kind), Threads::Single)
}

/// Camera-like rays and random ones, some of them with an end, some inside of things.
fn some_rays() -> RayBatch {
    let aimed = rays::aimed(&gnurt_testkit::closed::sphere(4), [0.2, -0.1, 3.0], 2);
    let mut rays = batch(&aimed);
    rays.extend(rays::random(1, 400).into_iter().map(|(org, dir)| Ray::new(org, dir)));
    let random = rays::random(2, 200).into_iter();
    rays.extend(random.map(|(org, dir)| Ray::new(org.map(|x| 0.5 * x), dir).within(0.1, 0.9)));
    rays
}

/// Every hit of spheres is a root, and every root that is no matter of rounding is hit.
fn assert_balls(balls: &Balls, geom_id: u32, rays: &RayBatch, hits: impl Fn(usize) -> Vec<Hit>) {
    let mut met = 0;
    for i in 0..rays.len() {
        let ray = rays.get(i);
        let hits: Vec<Hit> = hits(i).into_iter().filter(|hit| hit.geom_id == geom_id).collect();
        let scale = f64::from(ray.dir.iter().fold(0.0f32, |m, x| m.max(x.abs())));
        let slack = 1e-5 / scale;
        let roots: Vec<_> = (0..balls.radii.len())
            .filter_map(|ball| balls.meet(ball, &ray).map(|(at, clear)| (ball as u32, at, clear)))
            .collect();
        for hit in &hits {
            let near = |at: &[f64; 2], clear: f64| {
                at.iter().any(|t| (t - f64::from(hit.t)).abs() <= slack / clear.max(1e-4).sqrt())
            };
            let root = roots.iter().any(|(ball, at, clear)| *ball == hit.prim_id && near(at, *clear));
            assert!(root || ray_grazes(balls, hit, &ray), "{hit:?} is no root of {ray:?}");
        }
        for (ball, at, clear) in roots.iter().filter(|(_, _, clear)| *clear > 1e-3) {
            for t in at {
                let inside = *t > f64::from(ray.t_near) + slack && *t < f64::from(ray.t_far) - slack;
                let near = |hit: &&Hit| hit.prim_id == *ball && (f64::from(hit.t) - t).abs() <= 40.0 * slack;
                let found = hits.iter().filter(near).count();
                assert!(!inside || found >= 1, "{ray:?} meets ball {ball} at {t} ({clear}): {hits:?}");
                met += found;
            }
        }
    }
    assert!(met > 100, "{met} hits");
}

/// Whether a hit is at the rim, where either answer is right.
fn ray_grazes(balls: &Balls, hit: &Hit, ray: &Ray) -> bool {
    let mut larger = balls.clone();
    larger.radii[hit.prim_id as usize] *= 1.0 + 1e-5;
    larger.meet(hit.prim_id as usize, ray).is_some_and(|(_, clear)| clear < 1e-3)
}

#[test]
fn spheres_equal_double_precision() {
    for (seed, n, size) in [(1, 1, 1.0), (2, 9, 0.5), (3, 500, 0.1), (4, 60, 0.7)] {
        let balls = Balls::random(seed, n, size);
        let geometry = Geometry::from(Spheres { centers: &balls.centers, radii: &balls.radii });
        let object = build(std::slice::from_ref(&geometry), WATERTIGHT[0]);
        let rays = some_rays();
        let closest = run_queries(&object, &rays);
        let all = |i: usize| object.all(&rays.get(i));
        for (i, hit) in closest.iter().enumerate() {
            assert_eq!(*hit, all(i).first().copied(), "the closest is the first of all");
        }
        assert_balls(&balls, 0, &rays, all);
    }
}

#[test]
fn spheres_far_and_small_keep_their_precision() {
    // The textbook quadratic in floats loses these: a small sphere seen from far, a ray that starts on a huge one.
    let geometry = Spheres { centers: &[[0.0, 0.0, 2000.0], [0.0, -1e5, 0.0]], radii: &[0.01, 1e5] };
    let object = build(&[geometry.into()], WATERTIGHT[0]);
    let hit = object.intersect(&Ray::new([0.0, 1.0, 0.0], [0.0, -0.0005, 1.0])).expect("the small one");
    assert!(hit.prim_id == 0 && (hit.t - 1999.99).abs() < 0.01, "{hit:?}");
    let hit = object.intersect(&Ray::new([0.0, 1.0, 0.0], [0.0, -1.0, 0.0])).expect("the huge one");
    assert!(hit.prim_id == 1 && (hit.t - 1.0).abs() < 1e-5, "{hit:?}");
}

#[test]
fn bad_spheres_are_counted() {
    let geometry = Spheres {
        centers: &[[0.0; 3], [f32::NAN; 3], [1.0; 3], [f32::INFINITY; 3], [2.0; 3], [1e19; 3], [9.0; 3]],
        radii: &[1.0, 1.0, 0.0, 1.0, -1.0, 1.0],
    };
    let object = build(&[geometry.into()], WATERTIGHT[0]);
    let expected =
        BadPrimitives { nan: 1, zero_area: 2, infinite: 1, too_large: 1, ..BadPrimitives::default() };
    assert_eq!(object.bad_primitives(), expected, "all but one; what has no radius is not counted");
    assert_eq!(object.stats().primitives, 1, "one is left");
}

#[test]
fn user_geometry_equals_spheres() {
    let balls = Balls::random(5, 200, 0.3);
    let user = build(&[Geometry::user(Arc::new(balls.clone()))], WATERTIGHT[0]);
    let rays = some_rays();
    let closest = run_queries(&user, &rays);
    let all = |i: usize| user.all(&rays.get(i));
    for (i, hit) in closest.iter().enumerate() {
        assert_eq!(*hit, all(i).first().copied(), "the closest is the first of all");
        for hit in all(i) {
            let enters = (hit.u, hit.v) == (0.5, 3.0);
            assert!(enters || (hit.u, hit.v) == (0.25, 2.0), "{hit:?} has its own parameters");
        }
    }
    assert_balls(&balls, 0, &rays, all);
}

/// A wavy grid of quads; every vertex is shared.
fn quads(n: u32) -> (Vec<[f32; 3]>, Vec<[u32; 4]>) {
    let at = |i: u32| 2.0 * i as f32 / n as f32 - 1.0;
    let height = |x: f32, y: f32| 0.3 * (3.0 * x).sin() * (2.0 * y).cos();
    let vertices = (0..(n + 1) * (n + 1)).map(|i| (at(i % (n + 1)), at(i / (n + 1))));
    let positions = vertices.map(|(x, y)| [x, y, height(x, y)]).collect();
    let corner = |i: u32| i / n * (n + 1) + i % n;
    let indices = (0..n * n).map(corner).map(|i| [i, i + 1, i + n + 2, i + n + 1]).collect();
    (positions, indices)
}

#[test]
fn quads_are_their_halves() {
    let (positions, indices) = quads(12);
    let halves: Vec<[u32; 3]> = indices.iter().flat_map(|&[a, b, c, d]| [[a, b, d], [c, d, b]]).collect();
    let soup = Soup { positions: positions.clone(), indices: halves.clone() };
    let mut rays = some_rays();
    rays.extend(rays::aimed(&soup, [0.1, 0.2, 2.0], 1).into_iter().map(|(org, dir)| Ray::new(org, dir)));
    for kind in WATERTIGHT {
        let object = build(&[Quads { positions: &positions, indices: &indices }.into()], kind);
        let twin = build(&[Triangles { positions: &positions, indices: &halves }.into()], kind);
        let (hits, halves) = (run_queries(&object, &rays), run_queries(&twin, &rays));
        for (i, (hit, half)) in hits.iter().zip(&halves).enumerate() {
            let whole = half.map(|half| {
                let (u, v) =
                    if half.prim_id % 2 == 0 { (half.u, half.v) } else { (1.0 - half.u, 1.0 - half.v) };
                Hit { u, v, prim_id: half.prim_id / 2, ..half }
            });
            assert_eq!(*hit, whole, "{:?}", rays.get(i));
            let Some(hit) = hit else { continue };
            // Bilinear on the edges, and on each half: u and v tell the place.
            let [a, b, c, d] = indices[hit.prim_id as usize].map(|i| positions[i as usize]);
            let (u, v) = (hit.u, hit.v);
            for k in 0..3 {
                let placement = if u + v <= 1.0 {
                    a[k] + u * (b[k] - a[k]) + v * (d[k] - a[k])
                } else {
                    c[k] + (1.0 - u) * (d[k] - c[k]) + (1.0 - v) * (b[k] - c[k])
                };
                let at = rays.get(i).at(hit.t)[k];
                assert!((placement - at).abs() < 1e-4, "{hit:?} is at {placement}, not {at}");
            }
        }
        let found = hits.iter().flatten().count();
        assert!(found > 500, "{found} hits");
    }
}

#[test]
fn a_diagonal_is_one_hit() {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for kind in WATERTIGHT {
        let object = build(&[Quads { positions: &positions, indices: &[[0, 1, 2, 3]] }.into()], kind);
        for i in 1..16 {
            let x = i as f32 / 16.0;
            for dir in [[0.0, 0.0, -1.0], [0.5, 0.25, -1.0], [0.3, -0.7, -0.9]] {
                let ray = Ray::new([0, 1, 2].map(|k| [x, 1.0 - x, 0.0][k] - 2.0 * dir[k]), dir);
                assert_eq!(object.all(&ray).len(), 1, "{ray:?} meets one quad: {:?}", object.all(&ray));
            }
        }
    }
}

#[test]
fn mixed_kinds_are_one_object() {
    let soups = [Soup::random(6, 60, 0.4), Soup::random(7, 60, 0.4)];
    let triangles = [0, 1].map(|i| Triangles { positions: &soups[i].positions, indices: &soups[i].indices });
    let (positions, indices) = quads(5);
    let balls = [Balls::random(8, 30, 0.3), Balls::random(9, 30, 0.3)];
    let geometries = [
        Geometry::from(Spheres { centers: &balls[0].centers, radii: &balls[0].radii }),
        triangles[0].into(),
        Geometry::user(Arc::new(balls[1].clone())),
        Quads { positions: &positions, indices: &indices }.into(),
        triangles[1].into(),
        Geometry::from(triangles[0]).with_mask(1),
    ];
    let rays = some_rays();
    for kind in WATERTIGHT {
        let object = Arc::new(build(&geometries, kind));
        let single: Vec<ObjectTree> =
            geometries.iter().map(|geometry| build(std::slice::from_ref(geometry), kind)).collect();
        let total: u64 = single.iter().map(|object| object.stats().primitives).sum();
        assert_eq!(object.stats().primitives, total, "all are in it");
        let hits = run_queries(&*object, &rays);
        let mut kinds = [0; 6];
        for (i, hit) in hits.iter().enumerate() {
            let ray = rays.get(i);
            let mut expected: Vec<Hit> = Vec::new();
            for (geom_id, object) in single.iter().enumerate() {
                let own = object.all(&ray).into_iter();
                expected.extend(own.map(|hit| Hit { geom_id: geom_id as u32, ..hit }));
            }
            expected.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive().cmp(&b.primitive())));
            assert_eq!(*hit, expected.first().copied(), "the nearest of all kinds for {ray:?}");
            assert_eq!(object.all(&ray), expected, "all of all kinds for {ray:?}");
            expected.iter().for_each(|hit| kinds[hit.geom_id as usize] += 1);
        }
        assert!(kinds.iter().all(|&n| n > 20), "all kinds are hit: {kinds:?}");

        let mut instances = vec![Instance::identity(Arc::clone(&object)); 3];
        instances[1].world_from_object =
            [[0.0, 0.5, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.0, 0.5], [1.0, 0.0, 0.5]];
        instances[2].world_from_object[3] = [0.0, 2.0, 0.0];
        let found = run_queries(&scene_of(&instances), &rays).iter().flatten().count();
        assert!(found > hits.iter().flatten().count(), "instances of it are hit, too");
    }
}
