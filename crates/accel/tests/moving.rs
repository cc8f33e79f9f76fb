// SPDX-License-Identifier: GPL-3.0-or-later
//! A tree that follows its geometry has the hits of a fresh one in every frame, with any hint about the
//! motion. Frames that still hold an older tree keep its hits, and its cost stays near that of a fresh tree.

use std::sync::Arc;

use crate::common::{batch, run_queries};
use gnurt_accel::{
    BuildOptions, Geometry, Hit, Motion, MovingTree, ObjectTree, Quality, Structure, Threads, Triangles,
    Update,
};
use gnurt_testkit::{Random, Soup, rays};

fn mesh(soup: &Soup) -> [Geometry<'_>; 1] {
    [Triangles { positions: &soup.positions, indices: &soup.indices }.into()]
}

const MOTIONS: [Motion; 5] = [Motion::Auto, Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Known];

#[test]
fn every_frame_has_the_hits_of_a_fresh_tree() {
    let rays = batch(&rays::random(1, 60));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    for motion in MOTIONS {
        for quality in [Quality::Medium, Quality::High] {
            let options = BuildOptions { quality, ..BuildOptions::default() };
            let mut random = Random::new(2);
            let mut soup = Soup::random(3, 500, 0.2);
            let mut moving = MovingTree::build(&mesh(&soup), &options, motion, Threads::Single);
            let mut in_flight: Vec<(Arc<ObjectTree>, Vec<Option<Hit>>)> = Vec::new();
            for frame in 0..8 {
                if frame == 5 {
                    soup.append(&Soup::random(9, 10, 0.2));
                }
                for p in &mut soup.positions {
                    let by = random.point();
                    *p = [0, 1, 2].map(|k| p[k] + 0.02 * by[k]);
                }
                let threads = if frame % 2 == 0 { Threads::Single } else { Threads::Pool(&pool) };
                let update = moving.update(&mesh(&soup), &options, threads);
                let is_fixed = matches!(motion, Motion::Static | Motion::Rigid);
                assert!(
                    update == Update::Rebuilt || !is_fixed && frame != 5,
                    "{update:?} of {motion:?}, frame {frame}"
                );
                let fresh = ObjectTree::build_from(&mesh(&soup), &options, Threads::Single);
                let hits = run_queries(&**moving.tree(), &rays);
                assert_eq!(hits, run_queries(&fresh, &rays), "frame {frame} of {motion:?}");
                if random.below(2) == 0 {
                    in_flight.push((moving.tree().clone(), hits));
                }
                if random.below(3) == 0 {
                    in_flight.clear();
                }
                for (tree, hits) in &in_flight {
                    assert_eq!(&run_queries(&**tree, &rays), hits, "a frame in flight, {motion:?}");
                }
            }
        }
    }
}

/// Without anybody asking for it trees that have suffered are built again; poses that come back are only refitted.
#[test]
fn what_has_suffered_is_built_again() {
    let options = BuildOptions::default();
    for motion in MOTIONS {
        let mut random = Random::new(4);
        let mut soup = Soup::random(5, 2000, 0.02);
        let mut moving = MovingTree::build(&mesh(&soup), &options, motion, Threads::Single);
        let steps: Vec<[f32; 3]> = (0..2000).map(|_| random.point()).collect();
        let mut updates = Vec::new();
        for _ in 0..40 {
            for (triangle, step) in soup.positions.chunks_mut(3).zip(&steps) {
                triangle.iter_mut().for_each(|p| *p = [0, 1, 2].map(|k| p[k] + 0.05 * step[k]));
            }
            updates.push(moving.update(&mesh(&soup), &options, Threads::Single));
        }
        let fresh = ObjectTree::build_from(&mesh(&soup), &options, Threads::Single);
        let growth = moving.tree().stats().sah_cost / fresh.stats().sah_cost;
        match motion {
            Motion::Known => {
                assert!(updates.iter().all(|update| *update == Update::Refitted), "{updates:?}");
                assert!(growth > 2.0, "an explosion spoils it: {growth}");
            }
            _ => assert!(growth < 1.15, "{motion:?} is rebuilt in time: {growth}, {updates:?}"),
        }
    }
}

#[test]
fn a_structure_without_refit_is_built_again() {
    let options = BuildOptions { structure: Structure::Kd, ..BuildOptions::default() };
    let soup = Soup::random(5, 100, 0.2);
    let mut moving = MovingTree::build(&mesh(&soup), &options, Motion::Deforming, Threads::Single);
    assert_eq!(moving.update(&mesh(&soup), &options, Threads::Single), Update::Rebuilt, "a kd-tree");
}
