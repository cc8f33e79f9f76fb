// SPDX-License-Identifier: GPL-3.0-or-later
//! Axis-parallel rays in all combinations of signs, 0.0 and -0.0, and rays that are no rays.

use crate::common::{TESTS, WATERTIGHT, assert_hits, batch, build, run_queries};
use gnurt_accel::{Ray, RayBatch};
use gnurt_testkit::{OracleInstance, Soup, closed, rays};

#[test]
fn every_sign_and_zero() {
    for (name, soup) in
        [("random", Soup::random(1, 150, 0.5)), ("grid", Soup::grid(2, 150)), ("cube", closed::cube(2))]
    {
        let meshes = [soup];
        for (test, margin) in TESTS {
            let rays = batch(&rays::axis_parallel(3, 30));
            let hits = run_queries(&build(&meshes, test), &rays);
            assert!(hits.iter().any(Option::is_some), "{name} is hit with {test:?}");
            assert_hits(&[OracleInstance::identity(&meshes)], &rays, &hits, margin);
        }
    }
}

#[test]
fn both_zeros_are_the_same_direction() {
    for kind in WATERTIGHT {
        let object = build(&[Soup::grid(4, 200)], kind);
        let positive = batch(&rays::axis_parallel(5, 30));
        let mut negated = positive.clone();
        negated.dir.iter_mut().flatten().filter(|x| **x == 0.0).for_each(|x| *x = -*x);
        for (i, (a, b)) in
            run_queries(&object, &positive).iter().zip(&run_queries(&object, &negated)).enumerate()
        {
            assert_eq!(a.map(|h| h.t), b.map(|h| h.t), "the sign of zeros in {:?}", positive.get(i));
        }
    }
}

#[test]
fn what_is_no_ray_misses() {
    for kind in WATERTIGHT {
        let object = build(&[closed::cube(2)], kind);
        let good = Ray::new([0.1, 0.2, 0.3], [0.5, 1.0, -0.25]);
        let mut rays = RayBatch::default();
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for k in 0..3 {
                let (mut org, mut dir) = (good, good);
                org.org[k] = bad;
                dir.dir[k] = bad;
                // Good ones between them: they share packets.
                rays.extend([org, good, dir]);
            }
        }
        rays.extend([
            Ray::new([0.0; 3], [0.0, -0.0, 0.0]),
            good.within(2.0, 1.0),
            good.within(f32::NAN, 1.0),
        ]);
        rays.extend([good.within(0.0, f32::NAN), good]);
        for (i, hit) in run_queries(&object, &rays).iter().enumerate() {
            assert_eq!(hit.is_some(), rays.get(i) == good, "{:?}", rays.get(i));
        }
    }
}

#[test]
fn any_length_of_direction_will_do() {
    for kind in WATERTIGHT {
        let object = build(&[closed::sphere(10)], kind);
        let unit = object.intersect(&Ray::new([0.1, 0.2, 0.3], [0.5, 1.0, -0.25])).expect("from inside");
        for exponent in [-120, -64, -21, -3, 3, 21, 64, 120] {
            let scale = 2f32.powi(exponent);
            let ray = Ray::new([0.1, 0.2, 0.3], [0.5 * scale, scale, -0.25 * scale]);
            let hits = run_queries(&object, &[ray, ray].into_iter().collect());
            let hit = hits[0].expect("the same ray");
            assert_eq!(
                (hit.prim_id, hit.t * scale),
                (unit.prim_id, unit.t),
                "direction scaled by 2^{exponent}"
            );
        }
    }
}

#[test]
fn both_ends_of_the_interval_count() {
    for kind in WATERTIGHT {
        let object = build(&[closed::cube(1)], kind);
        let ray = Ray::new([0.25, 0.5, -3.0], [0.0, 0.0, 1.0]);
        let hit_in = |t_near, t_far| object.intersect(&ray.within(t_near, t_far)).map(|hit| hit.t);
        assert_eq!(hit_in(2.0, 2.0), Some(2.0), "an interval of one point");
        assert_eq!(hit_in(0.0, 2.0f32.next_down()), None, "ends before");
        assert_eq!(hit_in(2.0f32.next_up(), f32::INFINITY), Some(4.0), "starts behind the front");
        let mut next = Some(ray);
        let mut met = Vec::new();
        while let Some(hit) = next.and_then(|ray| object.intersect(&ray)) {
            met.push(hit.t);
            next = Some(ray.beyond(hit.t));
        }
        assert_eq!(met, [2.0, 4.0], "from hit to hit, and an end");
    }
}
