// SPDX-License-Identifier: GPL-3.0-or-later
//! Fuzzy kd-trees: hits in all poses, given and others, are those of a tree that is built for the pose, bit for bit, and those of brute
//! force.

use gnurt_accel::{FuzzyError, FuzzyTree, Hit, Ray};
use gnurt_testkit::{OracleInstance, Random, Soup, closed, rays};

use crate::common::{WATERTIGHT, assert_hits, batch, build};

type V3 = [f32; 3];

/// A torus that is cut in halves, which turn against each other, and wave.
fn torn(share: f32, wave: f32, p: V3) -> V3 {
    let angle = if p[0] > 0.0 { 1.7 * share } else { -0.6 * share };
    let (sin, cos) = angle.sin_cos();
    let [x, y, z] = p;
    [cos * x - sin * z + share, y + wave * share * (9.0 * x).sin(), sin * x + cos * z]
}

/// One that twists about an axis: no part of it is rigid.
fn twisted(share: f32, _: f32, p: V3) -> V3 {
    let (sin, cos) = (2.5 * share * p[1]).sin_cos();
    [cos * p[0] - sin * p[2], p[1], sin * p[0] + cos * p[2]]
}

/// The mesh in a pose.
fn posed(rest: &Soup, mut shape: impl FnMut(V3) -> V3) -> Soup {
    let mut soup = rest.clone();
    soup.positions.iter_mut().for_each(|p| *p = shape(*p));
    soup
}

/// Random rays, those at corners and edges, and those along axes; of all lengths.
fn all_rays(soup: &Soup, seed: u64) -> Vec<Ray> {
    let mut plain = rays::random(seed, 60);
    plain.extend(rays::axis_parallel(seed, 2));
    plain.extend(rays::aimed(soup, [0.3, 2.0, -2.5], 2).into_iter().step_by(7));
    plain.extend(rays::aimed(soup, [3.0e4, -1.0e4, 2.0e4], 1).into_iter().step_by(19));
    let mut rays: Vec<Ray> = plain.into_iter().map(|(org, dir)| Ray::new(org, dir)).collect();
    for i in (0..rays.len()).step_by(11) {
        let Ray { org, dir, .. } = rays[i];
        rays.push(Ray::new(org, dir.map(|x| x * [1e-9, 3e7][i % 2])));
    }
    rays
}

fn check(tree: &FuzzyTree, soup: &Soup, seed: u64, what: &str) {
    let (meshes, rays) = (std::slice::from_ref(soup), all_rays(soup, seed));
    let bvh = build(meshes, WATERTIGHT[0]);
    let bits = |hit: &Option<Hit>| hit.map(|hit| ([hit.t, hit.u, hit.v].map(f32::to_bits), hit.prim_id));
    let hits: Vec<Option<Hit>> = rays.iter().map(|ray| tree.intersect(ray)).collect();
    for (ray, hit) in rays.iter().zip(&hits) {
        assert_eq!(bits(hit), bits(&bvh.intersect(ray)), "{what}: {ray:?}");
        assert_eq!(tree.occluded(ray), hit.is_some(), "{what}: any hit of {ray:?}");
        let Some(hit) = hit else { continue };
        let short = ray.within(0.0, hit.t.next_down());
        assert_eq!(bits(&tree.intersect(&short)), bits(&bvh.intersect(&short)), "{what}: {short:?}");
        let rest = ray.beyond(hit.t);
        assert_eq!(bits(&tree.intersect(&rest)), bits(&bvh.intersect(&rest)), "{what}: {rest:?}");
    }
    let plain: Vec<(V3, V3)> = rays.iter().take(60).map(|ray| (ray.org, ray.dir)).collect();
    assert_hits(&[OracleInstance::identity(meshes)], &batch(&plain), &hits[..plain.len()], 2e-5);
    assert!(hits.iter().flatten().count() > rays.len() / 4, "{what}: enough hits");
}

#[test]
fn hits_are_those_of_every_pose() {
    let rest = closed::torus(10);
    for (name, shape) in [("torn", torn as fn(f32, f32, V3) -> V3), ("twisted", twisted)] {
        let poses: Vec<Soup> = (0..5).map(|i| posed(&rest, |p| shape(i as f32 / 4.0, 0.03, p))).collect();
        let given: Vec<&[V3]> = poses.iter().map(|pose| &pose.positions[..]).collect();
        let mut tree = FuzzyTree::build(&given, &rest.indices).expect("sound poses");
        assert!(tree.parts() > 1, "{name} moves in parts");
        check(&tree, &poses[0], 1, name);
        // Back and forth, to the poses that were given.
        for i in [4, 1, 3, 0, 2] {
            assert_eq!(tree.update(given[i]), Ok(0), "{name}: pose {i} was given");
            check(&tree, &poses[i], i as u64, name);
        }
        // Between them, and far beyond.
        let mut rebuilt = 0;
        for share in [0.125, 0.9, 1.6, -1.0] {
            let other = posed(&rest, |p| shape(share, 0.2, p));
            rebuilt += tree.update(&other.positions).expect("sound");
            check(&tree, &other, 7, name);
        }
        assert!(rebuilt > 0, "{name}: boxes grew");
        assert_eq!(tree.update(given[1]), Ok(0), "{name}: what was there before still is");
        check(&tree, &poses[1], 8, name);
    }
}

#[test]
fn what_moves_at_random_is_hit_too() {
    let rest = Soup::random(3, 300, 0.2);
    let mut random = Random::new(12);
    let mut pose = || {
        posed(&rest, |p| {
            let by = random.point();
            [0, 1, 2].map(|k| p[k] + 0.5 * by[k])
        })
    };
    let poses = [rest.clone(), pose(), pose()];
    let given: Vec<&[V3]> = poses.iter().map(|pose| &pose.positions[..]).collect();
    let mut tree = FuzzyTree::build(&given, &rest.indices).expect("sound poses");
    for pose in poses.iter().chain([&pose()]) {
        tree.update(&pose.positions).expect("sound");
        let (meshes, rays) = (std::slice::from_ref(pose), rays::random(5, 300));
        let bvh = build(meshes, WATERTIGHT[0]);
        for (org, dir) in rays {
            let ray = Ray::new(org, dir);
            assert_eq!(tree.intersect(&ray), bvh.intersect(&ray), "{ray:?}");
        }
    }
}

#[test]
fn bad_poses_are_rejected() {
    let soup = closed::torus(4);
    let (good, count) = (&soup.positions[..], soup.positions.len());
    let build = |poses: &[&[V3]], triangles: &[[u32; 3]]| FuzzyTree::build(poses, triangles).err();
    assert_eq!(build(&[], &soup.indices), Some(FuzzyError::NoPose));
    assert_eq!(build(&[good, &good[1..]], &soup.indices), Some(FuzzyError::Vertices { pose: 1 }));
    assert_eq!(build(&[good], &[[0, 1, count as u32]]), Some(FuzzyError::Index { triangle: 0 }));
    let mut wrong = soup.positions.clone();
    wrong[2][1] = f32::NAN;
    assert_eq!(build(&[good, &wrong], &soup.indices), Some(FuzzyError::Coordinate { vertex: 2 }));
    let mut tree = FuzzyTree::build(&[good], &soup.indices).expect("sound");
    assert_eq!(tree.update(&wrong), Err(FuzzyError::Coordinate { vertex: 2 }));
    assert_eq!(tree.update(&good[1..]), Err(FuzzyError::Vertices { pose: 0 }));
    check(&tree, &soup, 3, "as before");
    let nothing = FuzzyTree::build(&[&[]], &[]).expect("nothing is fine");
    assert_eq!(nothing.intersect(&Ray::new([0.0; 3], [1.0; 3])), None);
    assert_eq!((nothing.parts(), nothing.stats().primitives), (0, 0), "nothing is in it");
}
