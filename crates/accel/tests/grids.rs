// SPDX-License-Identifier: GPL-3.0-or-later
//! Grids: hits are those of the other structures, bit for bit, and those of brute force, at every level, alone and in tiles; nothing leaks
//! between cells; large triangles do not fill memory.

use gnurt_accel::{
    BuildControl, BuildError, BuildOptions, Motion, MovingTree, ObjectTree, Ray, RayBatch, RefitError,
    Threads, Update,
};
use gnurt_testkit::{Random, Soup, closed, rays};

use crate::common::{GRID, WATERTIGHT, batch, build, options, run_queries};
use crate::intervals::{check, stadium, triangles};

/// Tiles of rays that stay together: out of a point, side by side, or both; along the axes and across them; of which some start beside
/// planes between cells, and on them.
fn beams(seed: u64, count: usize) -> RayBatch {
    let mut random = Random::new(seed);
    let mut all = Vec::new();
    for beam in 0..count {
        let (org, mut dir) = (random.point().map(|x| 2.5 * x), random.point());
        if beam % 3 == 0 {
            let axis = beam / 3 % 3;
            dir = [0, 1, 2].map(|k| if k == axis { dir[k] } else { 0.02 * dir[k] });
        }
        let [wide, separation] = [[0.02, 0.0], [0.0, 0.05], [0.01, 0.03]][beam / 5 % 3];
        for _ in 0..64 {
            let (a, b) = (random.point(), random.point());
            let org = [0, 1, 2].map(|k| org[k] + separation * a[k]);
            all.push(Ray::new(org, [0, 1, 2].map(|k| dir[k] + wide * b[k])));
        }
    }
    all.into_iter().collect()
}

#[test]
fn hits_are_those_of_others() {
    let soups = [
        vec![Soup::random(1, 500, 0.3), Soup::random(2, 100, 0.02)],
        vec![Soup::random(8, 3000, 0.05)],
        vec![Soup::grid(3, 12)],
        vec![Soup::flat_but_for_one_bit(4, 200)],
        vec![Soup::slivers(4, 150)],
        vec![Soup::degenerate(5, 60)],
        vec![Soup::copies(40)],
        vec![Soup::random(6, 1, 1.0)],
        vec![Soup::default()],
        stadium(100.0).to_vec(),
        vec![closed::cube(10), closed::torus(20)],
    ];
    for (i, meshes) in soups.iter().enumerate() {
        let grid = build(meshes, GRID);
        check(&grid, meshes, GRID, i as u64);
        let rays = beams(i as u64, 30);
        assert_eq!(
            run_queries(&grid, &rays),
            run_queries(&build(meshes, WATERTIGHT[0]), &rays),
            "beams through soup {i}"
        );
    }
}

#[test]
fn nothing_leaks() {
    for (distance, size) in [(0.0, 1.0), (1e3f32, 1.0f32), (1e6, 64.0), (0.0, 1e-18)] {
        let offset = [distance, -distance, 0.5 * distance];
        for mut mesh in [closed::sphere(12), closed::cube(8), closed::cube(1)] {
            mesh.positions.iter_mut().flatten().for_each(|x| *x *= size);
            let mesh = mesh.moved(offset);
            let object = build(std::slice::from_ref(&mesh), GRID);
            for from in [[0.0f32; 3], [0.3, 0.1, -0.5], [0.5, 0.5, 0.25]] {
                let from = [0, 1, 2].map(|k| size * from[k] + offset[k]);
                let rays = batch(&rays::aimed(&mesh, from, 1));
                let leaks = run_queries(&object, &rays).iter().filter(|hit| hit.is_none()).count();
                assert_eq!(leaks, 0, "of {} rays from {from:?}, {distance} away, size {size}", rays.len());
            }
        }
    }
}

/// Says no when it is asked so often.
struct No(std::sync::atomic::AtomicU64);

impl BuildControl for No {
    fn keep_going(&self) -> bool {
        self.0.fetch_sub(1, std::sync::atomic::Ordering::Relaxed) > 1
    }
}

#[test]
fn threads_make_no_difference() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    let meshes = [Soup::random(7, 40_000, 0.05)];
    let of = |threads| ObjectTree::build(&triangles(&meshes), &options(GRID), threads);
    let single = of(Threads::Single);
    assert!(of(Threads::Pool(&pool)).same_tree(&single), "cell by cell");
    for requests in [1, 2, 4, 20] {
        let no = No(requests.into());
        let stopped = ObjectTree::try_build(&triangles(&meshes), &options(GRID), Threads::Pool(&pool), &no);
        assert_eq!(stopped.err(), Some(BuildError::Cancelled), "it was told so at the {requests}th question");
    }
}

/// A few triangles that are as large as all: their boxes meet all cells.
#[test]
fn large_triangles_lie_in_few_cells() {
    let mut large = Soup::random(3, 20, 0.1);
    large.positions.iter_mut().for_each(|p| *p = p.map(|x| 40.0 * x));
    let meshes = [Soup::random(2, 4000, 0.02), large, Soup::copies(500)];
    let grid = build(&meshes, GRID);
    let stats = grid.stats();
    let most = stats.primitives as f32 * options(GRID).reference_budget;
    assert!(stats.references as f32 <= most, "{stats:?} keeps the budget");
    assert!(stats.nodes > 100 && stats.empty_leaves < stats.leaves, "and is one: {stats:?}");
    let rays = beams(3, 20);
    assert_eq!(
        run_queries(&grid, &rays),
        run_queries(&build(&meshes, WATERTIGHT[0]), &rays),
        "with the hits of others"
    );
    let few = build_with_budget(&meshes, 0.0);
    assert_eq!(
        (few.nodes, few.references),
        (1, few.primitives),
        "one cell, where no triangle may lie in two"
    );
}

fn build_with_budget(meshes: &[Soup], reference_budget: f32) -> gnurt_accel::TreeStats {
    let options = BuildOptions { reference_budget, ..options(GRID) };
    ObjectTree::build(&triangles(meshes), &options, Threads::Single).stats()
}

#[test]
fn they_are_built_anew() {
    let mut meshes = [closed::torus(12)];
    let grid = build(&meshes, GRID);
    let refused = grid.clone().refit(&triangles(&meshes), Threads::Single).expect_err("not a grid");
    assert_eq!(refused, RefitError::Structure, "{refused}");
    let refused = grid.save(&mut Vec::new()).expect_err("nor can it be saved");
    assert!(refused.to_string().contains("grid"), "{refused}");
    let mut moving = MovingTree::of(std::sync::Arc::new(grid), Motion::Deforming);
    meshes[0].positions.iter_mut().for_each(|p| p[0] *= 1.0 + p[1]);
    let geometries: Vec<_> = triangles(&meshes).into_iter().map(Into::into).collect();
    assert_eq!(moving.update(&geometries, &options(GRID), Threads::Single), Update::Rebuilt);
    check(moving.tree(), &meshes, GRID, 5);
}
