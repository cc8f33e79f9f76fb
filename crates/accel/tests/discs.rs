// SPDX-License-Identifier: GPL-3.0-or-later
//! Discs with normals and discs that face rays equal their definition, at every level and in every way to ask.

use crate::common::{WATERTIGHT, options, run_queries};
use gnurt_accel::{BadPrimitives, Discs, ObjectTree, Ray, RayBatch, Threads};
use gnurt_testkit::Random;

#[test]
fn discs_equal_their_definition() {
    let mut random = Random::new(4);
    let centers: Vec<[f32; 3]> = (0..200).map(|_| random.point()).collect();
    let normals: Vec<[f32; 3]> = (0..200).map(|_| random.point()).collect();
    let radii: Vec<f32> = (0..200).map(|_| random.between(0.05, 0.3)).collect();
    let rays: RayBatch = (0..1000)
        .map(|_| {
            let (from, to) = (random.point(), random.point());
            Ray::new(from.map(|x| 3.0 * x), [0, 1, 2].map(|k| to[k] - 3.0 * from[k]))
        })
        .collect();
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    for has_normals in [true, false] {
        let discs = Discs { centers: &centers, radii: &radii, normals: has_normals.then_some(&normals[..]) };
        let object = ObjectTree::build_from(&[discs.into()], &options(WATERTIGHT[0]), Threads::Single);
        let hits = run_queries(&object, &rays);
        assert!(hits.iter().flatten().count() > 300, "most are hit");
        for (i, hit) in hits.iter().enumerate() {
            let (org, dir) = (rays.get(i).org.map(f64::from), rays.get(i).dir.map(f64::from));
            let mut best: Option<(f64, u32)> = None;
            for disc in 0..200 {
                let to = [0, 1, 2].map(|k| f64::from(centers[disc][k]) - org[k]);
                let normal = if has_normals { normals[disc].map(f64::from) } else { dir };
                let t = dot(to, normal) / dot(dir, normal);
                let off = [0, 1, 2].map(|k| to[k] - t * dir[k]);
                let is_in = dot(off, off).sqrt() <= f64::from(radii[disc]);
                if is_in && t >= 0.0 && best.is_none_or(|(before, _)| t < before) {
                    best = Some((t, disc as u32));
                }
            }
            let found = hit.map(|hit| (hit.t, hit.prim_id));
            assert_eq!(found, best.map(|(t, disc)| (t as f32, disc)), "{:?}", rays.get(i));
        }
        let mut file = Vec::new();
        object.save(&mut file).expect("memory takes all");
        let loaded = ObjectTree::load(&mut &file[..]).expect("it was saved");
        assert!(loaded.same_tree(&object), "node for node");
        let p = [2.0, 0.5, -0.25];
        let near = object.closest_point(p, f64::INFINITY).expect("all is near enough");
        for center in &centers {
            let off = [0, 1, 2].map(|k| f64::from(center[k]) - p[k]);
            assert!(near.distance <= dot(off, off).sqrt(), "no centre is nearer than {near:?}");
        }
    }
}

#[test]
fn bad_discs_are_counted() {
    let discs = Discs {
        centers: &[[0.0; 3], [f32::NAN; 3], [1.0; 3], [2.0; 3]],
        radii: &[1.0, 1.0, 0.0, 1.0],
        normals: Some(&[[0.0, 0.0, 2.0], [1.0; 3], [1.0; 3], [0.0; 3]]),
    };
    let object = ObjectTree::build_from(&[discs.into()], &options(WATERTIGHT[0]), Threads::Single);
    let expected = BadPrimitives { nan: 1, zero_area: 2, ..BadPrimitives::default() };
    assert_eq!(object.bad_primitives(), expected, "all but one");
    let hit = object.intersect(&Ray::new([0.5, 0.5, 3.0], [0.0, 0.0, -1.0])).expect("the first");
    assert_eq!((hit.t, object.normal(&hit)), (3.0, Some([0.0, 0.0, 1.0])), "its plane and its side");
}
