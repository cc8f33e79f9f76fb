// SPDX-License-Identifier: GPL-3.0-or-later
//! Crossings of rays aimed at vertices and edges equal those of integer arithmetic, in every structure, far
//! away, tiny, as soups, through instances; coincident sheets; ends of rays.

use std::sync::Arc;

use gnurt_accel::{
    BuildOptions, Instance, Level, ObjectTree, Quads, Query, Ray, Ray64, Spheres, Threads, Triangles,
};
use gnurt_testkit::{Random, Soup, Voxels, closed, lattice};

use crate::common::{WATERTIGHT, build, options, scene_of};

/// A ray from outside through a point of a grid, in half sides of its cubes.
pub(super) fn aimed(random: &mut Random, n: i64) -> ([i64; 3], [i64; 3]) {
    let target = [0; 3].map(|_: i32| random.below(2 * n as usize + 1) as i64);
    loop {
        let dir = [0; 3].map(|_: i32| random.below(9) as i64 - 4);
        if dir != [0; 3] {
            // So many steps of at least one half side lead outside.
            return ([0, 1, 2].map(|k| target[k] - (2 * n + 2) * dir[k]), dir);
        }
    }
}

#[test]
fn solids_of_cubes_equal_whole_numbers() {
    let mut random = Random::new(11);
    let mut requests = 0;
    for (round, kind) in WATERTIGHT.iter().cycle().take(28).enumerate() {
        let n = 1 + round as i64 % 5;
        let voxels = Voxels::random(round as u64, n as u32, [0.2, 0.5, 0.9][round % 3]);
        // Near, far away, tiny and huge; all of these are floats.
        let (from, side) =
            [(0.0, 1.0), (4096.0, 0.125), (0.0, 2f32.powi(-100)), (-1e6, 1.0), (0.0, 2f32.powi(50))]
                [round % 5];
        let mesh = voxels.mesh(round % 2 == 0, [from; 3], side);
        let tree = build(std::slice::from_ref(&mesh), *kind);
        let scale = 2f32.powi(round as i32 % 7 - 3);
        let mut rays = Vec::new();
        let mut expected = Vec::new();
        for _ in 0..400 {
            let (org, dir) = aimed(&mut random, n);
            expected.push(voxels.crossings(org, dir));
            let at = org.map(|x| from + 0.5 * side * x as f32);
            rays.push(Ray::new(at, dir.map(|x| scale * side * x as f32)));
        }
        let (mut counts, mut hits, query) = (Vec::new(), Vec::new(), Query::default());
        tree.crossings_batch(&query, &rays, Threads::Single, &mut counts);
        for ((ray, count), expected) in rays.iter().zip(&counts).zip(&expected) {
            assert_eq!(count, expected, "{ray:?} in {kind:?}, solid {round}");
            tree.crossing_hits(&query, ray, &mut hits);
            assert_eq!(hits.len(), *count as usize, "{ray:?} in {kind:?}: one hit each");
            assert!(hits.is_sorted_by_key(|hit| hit.t), "{hits:?} in order");
            for hit in &hits {
                let corners = mesh.corners(hit.prim_id as usize).expect("a triangle");
                let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
                let off = [0, 1, 2].map(|k| {
                    let on_mesh: f32 = (0..3).map(|i| weights[i] * (corners[i][k] - from)).sum();
                    let on_ray = f64::from(ray.org[k]) - f64::from(from) + f64::from(hit.t * ray.dir[k]);
                    (on_ray as f32 - on_mesh).abs()
                });
                let bound = 1e-5 * side * (n * n) as f32 + 1e-6 * side;
                assert!(off.iter().all(|&off| off < bound), "{hit:?} of {ray:?}: {off:?} off");
            }
        }
        for level in Level::available() {
            let query = Query { level, ..Query::default() };
            let some = (0..40).map(|i| tree.crossings_with(&query, &rays[i]));
            assert!(some.eq(counts[..40].iter().copied()), "one by one at {level}");
        }
        requests += rays.len();
    }
    assert!(requests > 10_000, "{requests} rays are enough to tell");
}

/// A mesh whose coordinates are whole multiples of 2^-12.
fn rounded(mut mesh: Soup) -> Soup {
    mesh.positions.iter_mut().flatten().for_each(|x| *x = (*x * 4096.0).round() / 4096.0);
    mesh
}

#[test]
fn round_meshes_equal_whole_numbers() {
    let mut random = Random::new(5);
    for (round, kind) in WATERTIGHT.iter().enumerate() {
        let mesh = rounded([closed::sphere(9), closed::torus(8), closed::cube(2)][round % 3].clone());
        let whole = |p: [f32; 3]| p.map(|x| (x * 4096.0) as i64);
        let tree = build(std::slice::from_ref(&mesh), *kind);
        for _ in 0..250 {
            let [a, b, c] = mesh.corners(random.below(mesh.indices.len())).expect("a triangle");
            let target = match random.below(3) {
                0 => a,
                1 => [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])),
                _ => [0, 1, 2].map(|k| 0.25 * (a[k] + b[k] + 2.0 * c[k])),
            };
            // Whole multiples of 2^-14, and a direction that leads exactly to the target.
            let org = random.point().map(|x| (3.0 * x * 4096.0).round() / 4096.0);
            let dir = [0, 1, 2].map(|k| target[k] - org[k]);
            let quarter = |p: [f32; 3]| p.map(|x| (f64::from(x) * 16384.0) as i64);
            let triangles = (0..mesh.indices.len())
                .map(|i| mesh.corners(i).expect("a triangle").map(whole).map(|p| p.map(|x| 4 * x)));
            let expected = lattice::crossings(triangles, quarter(org), quarter(dir));
            let ray = Ray::new(org, dir);
            assert_eq!(tree.crossings(&ray), expected, "{ray:?} in {kind:?}");
        }
    }
}

#[test]
fn rays_that_pierce_convex_meshes_cross_twice() {
    let mut random = Random::new(7);
    for (kind, offset, size) in [
        (WATERTIGHT[0], [0.0; 3], 1.0f32),
        (WATERTIGHT[3], [1000.0, -2000.0, 500.0], 1.0),
        (WATERTIGHT[5], [0.0; 3], 1e-20),
        (WATERTIGHT[1], [0.0; 3], 1e15),
    ] {
        for mut mesh in [closed::sphere(16), closed::cube(3)] {
            mesh.positions.iter_mut().flatten().for_each(|x| *x *= size);
            let mesh = mesh.moved(offset.map(|x| x * size));
            let tree = build(std::slice::from_ref(&mesh), kind);
            for i in 0..1500 {
                let [a, b, _] = mesh.corners(random.below(mesh.indices.len())).expect("a triangle");
                let target = if i % 2 == 0 { a } else { [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])) };
                // Through the target and a point well inside.
                let middle = random.point().map(|x| 0.4 * x * size);
                let inside = [0, 1, 2].map(|k| middle[k] + offset[k] * size);
                let dir = [0, 1, 2].map(|k| inside[k] - target[k]);
                let org = [0, 1, 2].map(|k| target[k] - 3.0 * dir[k]);
                let ray = Ray::new(org, dir);
                assert_eq!(tree.crossings(&ray), 2, "{ray:?} in {kind:?} at {offset:?}, size {size:e}");
            }
        }
    }
}

#[test]
fn instances_are_exact() {
    let mut random = Random::new(3);
    let voxels = Voxels::random(4, 4, 0.5);
    let object = Arc::new(build(&[voxels.mesh(true, [0.0; 3], 1.0)], WATERTIGHT[0]));
    // Scaled and moved by whole numbers, through two instances: the same grid in another place.
    let inner = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0], [12.0, 0.0, -8.0]];
    let outer = [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5], [1e9, -3.0, 7.0]];
    let group = Arc::new(scene_of(&[Instance::new(Arc::clone(&object), inner)]));
    let scene = scene_of(&[Instance::new(group, outer)]);
    for _ in 0..2000 {
        let (org, dir) = aimed(&mut random, 4);
        // A half side is 1 in the world.
        let start = [1e9 + 6.0, -3.0, 3.0];
        let at = [0, 1, 2].map(|k| start[k] + org[k] as f64);
        let ray = Ray64::new(at, dir.map(|x| x as f32));
        assert_eq!(scene.crossings(&ray), voxels.crossings(org, dir), "{ray:?}");
    }
    // Rotated and sheared: corners are not exact floats any more, and rays through the nearest floats still
    // cross evenly.
    let turned = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.01], [0.48, 0.64, 0.6], [1e5, 2e5, -7e4]];
    let cube = Arc::new(build(&[closed::cube(3)], WATERTIGHT[0]));
    let scene = scene_of(&[Instance::new(Arc::clone(&cube), turned), Instance::new(object, inner)]);
    let mesh = closed::cube(3);
    for _ in 0..2000 {
        let corner = mesh.positions[random.below(mesh.positions.len())].map(f64::from);
        let carry = |p: [f64; 3]| {
            [0, 1, 2].map(|k| turned[0][k] * p[0] + turned[1][k] * p[1] + turned[2][k] * p[2] + turned[3][k])
        };
        let inside = carry(random.point().map(|x| 0.5 * f64::from(x)));
        let target = carry(corner);
        let dir = [0, 1, 2].map(|k| (inside[k] - target[k]) as f32);
        let org = [0, 1, 2].map(|k| target[k] - 2.0 * f64::from(dir[k]));
        let ray = Ray64::new(org, dir);
        assert_eq!(scene.crossings(&ray), 2, "{ray:?}");
    }
}

#[test]
fn sheets_count_one_by_one() {
    let positions = [[0., 0., 0.], [2., 0., 0.], [2., 2., 0.], [0., 2., 0.]];
    let indices = [[0, 1, 2], [0, 2, 3]];
    let sheet = Triangles { positions: &positions, indices: &indices };
    let doubled = [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 3]];
    let twice = Triangles { positions: &positions, indices: &doubled };
    let quad = Quads { positions: &positions, indices: &[[0, 1, 2, 3]] };
    let ray = Ray::new([1.0, 1.0, 3.0], [0.0, 0.0, -1.0]);
    for kind in WATERTIGHT {
        let of = |meshes: &[_]| ObjectTree::build_from(meshes, &options(kind), Threads::Single);
        for (meshes, expected) in [
            (vec![sheet.into()], 1),
            (vec![quad.into()], 1),
            (vec![twice.into()], 2),
            (vec![sheet.into(), quad.into()], 2),
            (vec![sheet.into(), sheet.into(), twice.into()], 4),
        ] {
            let tree = of(&meshes);
            assert_eq!(tree.crossings(&ray), expected, "{} sheets in {kind:?}", meshes.len());
            let along = Ray::new([-1.0, 0.5, 0.0], [1.0, 0.0, 0.0]);
            assert_eq!(tree.crossings(&along), 0, "in the plane of the sheets");
        }
        let tree = of(&[sheet.into()]);
        for (near, far, expected) in
            [(0.0, 3.0, 1), (3.0, 9.0, 1), (0.0, 2.999_999_8, 0), (3.000_000_2, 9.0, 0)]
        {
            assert_eq!(tree.crossings(&ray.within(near, far)), expected, "from {near} to {far}");
        }
        assert_eq!(
            tree.crossings(&Ray::new([1.0; 3], [0.0, 0.0, f32::NAN])),
            0,
            "what is no ray crosses nothing"
        );
        assert_eq!(tree.crossings(&ray.with_mask(0)), 0, "nor what sees nothing");
    }
}

#[test]
fn spheres_are_crossed_twice() {
    let balls = Spheres { centers: &[[0.0; 3], [5.0, 0.0, 0.0]], radii: &[1.0, 2.0] };
    let tree = ObjectTree::build_from(&[balls.into()], &BuildOptions::default(), Threads::Single);
    let ray = Ray::new([-3.0, 0.25, 0.0], [2.0, 0.0, 0.0]);
    assert_eq!(tree.crossings(&ray), 4, "through both");
    assert_eq!(tree.crossings(&ray.within(1.5, 100.0)), 3, "from inside of the first");
    assert_eq!(tree.crossings(&ray.within(1.5, 4.0)), 2, "from inside to inside");
    assert_eq!(tree.crossings(&Ray::new([-3.0, 1.0, 0.0], [1.0, 0.0, 0.0])), 2, "touching is no crossing");
    let mut hits = Vec::new();
    tree.crossing_hits(&Query::default(), &ray, &mut hits);
    assert_eq!(hits.iter().map(|hit| hit.prim_id).collect::<Vec<_>>(), [0, 0, 1, 1]);
    let x = |radius: f32| (radius * radius - 0.0625).sqrt();
    for (hit, x) in hits.iter().zip([-x(1.0), x(1.0), 5.0 - x(2.0), 5.0 + x(2.0)]) {
        assert!((2.0 * hit.t - 3.0 - x).abs() < 1e-5, "{hit:?} at {x}");
    }
}
