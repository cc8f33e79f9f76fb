// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays in slices and strided arrays, of floats and doubles, with any threads, are answered as single rays are.

use std::sync::Arc;

use gnurt_accel::{
    Coherence, Column, HitBatch, HitSlices, INVALID_ID, Instance, Query, Ray, Ray64, RaySlices, SceneTree,
    Threads, Vectors,
};
use gnurt_testkit::{Random, Soup, closed};

use crate::common::{WATERTIGHT, build, scene_of};

fn scene(distance: f64) -> SceneTree {
    let object = Arc::new(build(&[closed::torus(12), Soup::random(5, 60, 0.3)], WATERTIGHT[0]));
    let at = |x: f64| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [distance + x, distance, 0.0]];
    scene_of(&[Instance::new(Arc::clone(&object), at(0.0)), Instance::new(object, at(2.0))])
}

fn rays(n: usize) -> Vec<([f64; 3], [f64; 3])> {
    let mut random = Random::new(6);
    (0..n).map(|_| (random.point().map(|x| 3.0 * f64::from(x)), random.point().map(f64::from))).collect()
}

#[test]
fn slices_equal_single_rays() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
    let scene = scene(0.0);
    let plain: Vec<Ray> = rays(9000)
        .iter()
        .map(|(org, dir)| Ray::new(org.map(|x| x as f32), dir.map(|x| x as f32)).within(0.1, 5.0))
        .collect();
    let expected: Vec<_> = plain.iter().map(|ray| scene.intersect(ray)).collect();
    let count = expected.iter().flatten().count();
    assert!((1000..8000).contains(&count), "{count} rays hit");
    // Origin, direction and the ends in rows of eight, of both precisions.
    let row = |ray: &Ray| {
        let ([a, b, c], [d, e, f]) = (ray.org, ray.dir);
        [a, b, c, d, e, f, ray.t_near, ray.t_far]
    };
    let rows: Vec<f32> = plain.iter().flat_map(row).collect();
    let wide: Vec<f64> = rows.iter().map(|&x| f64::from(x)).collect();
    let masks: Vec<u32> = (0..plain.len()).map(|i| if i % 3 == 0 { 0 } else { u32::MAX }).collect();
    for threads in [Threads::Single, Threads::Pool(&pool)] {
        for coherence in [Coherence::Incoherent, Coherence::Coherent] {
            let query = Query { coherence, ..Query::default() };
            let (mut hits, mut occluded) = (HitBatch::default(), Vec::new());
            scene.intersect_rays(&query, &plain, threads, &mut hits);
            scene.occluded_rays(&query, &plain, threads, &mut occluded);
            for (i, expected) in expected.iter().enumerate() {
                assert_eq!(hits.get(i), *expected, "{:?}", plain[i]);
                assert_eq!(occluded[i], expected.is_some(), "{:?}", plain[i]);
            }
            for precise in [false, true] {
                let half = |first: usize| match precise {
                    false => Vectors::rows(&rows[..], first, 8),
                    true => Vectors::rows(&wide[..], first, 8),
                };
                let borrowed = RaySlices::new(half(0), half(3))
                    .and_then(|rays| rays.with_t_near(Column::strided(&rows[..], 6, 8)))
                    .and_then(|rays| rays.with_t_far(Column::strided(&wide[..], 7, 8)))
                    .expect("all of one length");
                assert_eq!(borrowed.len(), plain.len(), "a ray a row");
                let (mut t, mut prim_id) = (vec![0.0; plain.len()], vec![7; plain.len()]);
                let mut normal = vec![[9.0; 3]; plain.len()];
                let mut into = HitSlices {
                    t: Some(&mut t),
                    prim_id: Some(&mut prim_id),
                    normal: Some(&mut normal),
                    ..HitSlices::default()
                };
                scene.intersect_slices(&query, &borrowed, threads, &mut into).expect("room for all");
                let masked = borrowed.with_masks(&masks).expect("one each");
                let mut found = vec![true; plain.len()];
                scene.occluded_slices(&query, &masked, threads, &mut found).expect("room for all");
                for (i, hit) in expected.iter().enumerate() {
                    assert_eq!(t[i], hit.map_or(f32::INFINITY, |hit| hit.t), "ray {i}");
                    assert_eq!(prim_id[i], hit.map_or(INVALID_ID, |hit| hit.prim_id), "ray {i}");
                    let expected = hit.and_then(|hit| scene.normal(&hit));
                    assert_eq!(normal[i], expected.unwrap_or_default(), "ray {i}");
                    assert_eq!(found[i], hit.is_some() && i % 3 != 0, "ray {i}");
                }
            }
        }
    }
}

#[test]
fn origins_in_double_precision_stay_so() {
    let distance = 1e9;
    let scene = scene(distance);
    let precise: Vec<Ray64> = rays(3000)
        .iter()
        .map(|(org, dir)| Ray64::new([org[0] + distance, org[1] + distance, org[2]], dir.map(|x| x as f32)))
        .collect();
    let query = Query { coherence: Coherence::Coherent, ..Query::default() };
    let (mut hits, mut occluded) = (HitBatch::default(), Vec::new());
    scene.intersect_rays(&query, &precise, Threads::Single, &mut hits);
    scene.occluded_rays(&query, &precise, Threads::Single, &mut occluded);
    let mut differ = 0;
    for (i, ray) in precise.iter().enumerate() {
        let expected = scene.intersect(ray);
        assert_eq!(hits.get(i), expected, "{ray:?}");
        assert_eq!(occluded[i], expected.is_some(), "{ray:?}");
        let rounded = Ray::new(ray.org.map(|x| x as f32), ray.dir);
        differ += usize::from(scene.intersect(&rounded) != expected);
    }
    assert!(differ > 500, "rounded origins would be elsewhere: {differ}");
    let origins: Vec<[f64; 3]> = precise.iter().map(|ray| ray.org).collect();
    let down = [0.0, 0.0, -1.0];
    let borrowed = RaySlices::new(&origins[..], Vectors::same(&down)).expect("one direction for all");
    let mut t = vec![0.0; origins.len()];
    let mut into = HitSlices { t: Some(&mut t), ..HitSlices::default() };
    scene.intersect_slices(&query, &borrowed, Threads::Single, &mut into).expect("room for all");
    for (org, t) in origins.iter().zip(t) {
        let expected = scene.intersect(&Ray64::new(*org, down)).map_or(f32::INFINITY, |hit| hit.t);
        assert_eq!(t, expected, "from {org:?}");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let (three, two) = ([[0.0f32; 3]; 3], [[1.0f32; 3]; 2]);
    let reported = RaySlices::new(&three[..], &two[..]).expect_err("too few directions").to_string();
    assert_eq!(reported, "directions: 2 values where there are 3 rays", "what, and how many");
    let rays = RaySlices::new(&three[..], &three[..]).expect("they fit");
    assert!(
        rays.with_masks(&[1, 2]).is_err() && rays.with_t_far(Column::new(&[1.0f32][..])).is_err(),
        "too few"
    );
    let mut t = [0.0; 2];
    let mut hits = HitSlices { t: Some(&mut t), ..HitSlices::default() };
    let reported = scene(0.0).intersect_slices(&Query::default(), &rays, Threads::Single, &mut hits);
    assert_eq!(
        reported.expect_err("too few").to_string(),
        "t: 2 values where there are 3 rays",
        "and for hits"
    );
    let x = [1.0f32, 2.0];
    let other = Vectors::columns(Column::new(&x[..]), Column::same(&x[..], 0), Column::new(&x[..1]));
    assert!(other.is_err(), "columns of different lengths");
    assert_eq!(Vectors::rows(&x[..], 0, 3).count(), Some(0), "no whole row");
}
