// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays of a pencil have the hits of the same rays traced singly: wide and narrow ones, full and with holes,
//! in objects and scenes.

use std::sync::Arc;

use crate::common::{TESTS, build, scene_of};
use gnurt_accel::{Instance, Level, Pencil, Query, Ray, Record};
use gnurt_testkit::{Random, Soup};

/// About `width` wide around one direction, each up to somewhere; some lanes hold no ray, or one that cannot hit.
fn pencil(random: &mut Random, width: f32, gaps: f32) -> Pencil {
    let org = random.point().map(|x| 2.0 * x);
    let mut pencil = Pencil::EMPTY;
    pencil.org = org;
    let (aim, (dir, t_far)) = (random.point(), pencil.lanes());
    for i in 0..Pencil::MOST {
        let there = random.point();
        for k in 0..3 {
            dir[k][i] = aim[k] + width * there[k] - org[k];
        }
        t_far[i] = random.between(0.2, 2.0);
        if random.between(0.0, 1.0) < gaps {
            match i % 4 {
                0 => (0..3).for_each(|k| dir[k][i] = 0.0),
                1 => dir[i % 3][i] = f32::NAN,
                2 => t_far[i] = f32::NAN,
                _ => t_far[i] = -1.0,
            }
        }
    }
    pencil
}

fn single(pencil: &Pencil, occluded: impl Fn(&Ray) -> bool) -> u64 {
    let (org, mut pencil) = (pencil.org, pencil.clone());
    let (dir, t_far) = pencil.lanes();
    let ray = |i: usize| Ray::new(org, [0, 1, 2].map(|k| dir[k][i])).within(0.0, t_far[i]);
    (0..Pencil::MOST).map(|i| u64::from(occluded(&ray(i))) << i).sum()
}

#[test]
fn pencils_hit_what_rays_hit() {
    for (kind, _) in TESTS {
        let object = Arc::new(build(&[Soup::random(3, 300, 0.2)], kind));
        let mut moved = Instance::identity(Arc::clone(&object));
        moved.world_from_object = [[0.0, 0.5, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.0, 0.5], [0.5, 0.1, -0.2]];
        let one = scene_of(&[Instance::identity(Arc::clone(&object))]);
        let two = scene_of(&[Instance::identity(Arc::clone(&object)).with_mask(1), moved]);
        let (mut random, mut hit, mut missed) = (Random::new(5), 0, 0);
        for n in 0..120 {
            let width = [0.02, 0.2, 1.0][n % 3];
            let gaps = [0.0, 0.1, 0.7, 1.0][n / 3 % 4];
            let pencil = pencil(&mut random, width, gaps);
            for level in Level::available() {
                let query = Query { level, ..Query::default() };
                let mut record = Record::default();
                let expected = single(&pencil, |ray| object.occluded(ray));
                assert_eq!(
                    object.occluded_pencil(&query, &mut pencil.clone(), &mut record),
                    expected,
                    "{kind:?} {level}: {n}"
                );
                assert_eq!(
                    one.occluded_pencil(&query, &mut pencil.clone(), &mut record),
                    expected,
                    "in a scene"
                );
                let expected = single(&pencil, |ray| two.occluded(ray));
                assert_eq!(
                    two.occluded_pencil(&query, &mut pencil.clone(), &mut record),
                    expected,
                    "in a scene of two: {n}"
                );
                let query = Query { mask: 2, ..query };
                let expected = single(&pencil, |ray| two.occluded(&ray.with_mask(2)));
                assert_eq!(
                    two.occluded_pencil(&query, &mut pencil.clone(), &mut record),
                    expected,
                    "with a mask: {n}"
                );
            }
            let hits = single(&pencil, |ray| object.occluded(ray)).count_ones();
            (hit, missed) = (hit + hits, missed + Pencil::MOST as u32 - hits);
        }
        assert!(hit > 500 && missed > 500, "{hit} hits and {missed} misses are something to test");
    }
}
