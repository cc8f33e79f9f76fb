// SPDX-License-Identifier: GPL-3.0-or-later
//! Grids give the answers of the same cells as quads, bit for bit, in every way to ask; and take a third of the memory.

use crate::common::{WATERTIGHT, options, run_queries, scene_of};
use gnurt_accel::{
    Face, Geometry, Grid, Grids, Hit, Instance, Memory, ObjectTree, Quads, Quality, Query, Ray, RayBatch,
    RefitError, Structure, Threads, TriangleTest,
};
use gnurt_testkit::Random;

/// Vertices, grids, and the same cells as quads.
struct Sheets {
    positions: Vec<[f32; 3]>,
    grids: Vec<Grid>,
    quads: Vec<[u32; 4]>,
}

impl Sheets {
    fn new(positions: Vec<[f32; 3]>, grids: &[Grid]) -> Self {
        let mut quads = Vec::new();
        for grid in grids {
            let [columns, rows] = grid.cells();
            for y in 0..rows {
                quads.extend((0..columns).map(|x| grid.quad(x, y)));
            }
        }
        Self { positions, grids: grids.to_vec(), quads }
    }

    /// Bumpy sheets of several sizes over each other: even, odd, a single row, none, and parts of a larger array.
    fn bumpy(seed: u64) -> Self {
        let grids = [
            Grid { first: 0, stride: 21, width: 21, height: 14 },
            Grid { first: 300, stride: 40, width: 2, height: 9 },
            Grid { first: 303, stride: 40, width: 30, height: 2 },
            Grid { first: 345, stride: 40, width: 1, height: 9 },
            Grid { first: 347, stride: 40, width: 24, height: 7 },
        ];
        let mut random = Random::new(seed);
        let positions = (0..700).map(|i| {
            let (x, y) = if i < 300 { (i % 21, i / 21) } else { ((i - 300) % 40, (i - 300) / 40) };
            let [a, b, c] = random.point();
            [x as f32 / 10.0 + 0.03 * a, y as f32 / 10.0 + 0.03 * b, 0.1 * c - f32::from(u8::from(i < 300))]
        });
        Self::new(positions.collect(), &grids)
    }

    fn grids(&self) -> Geometry<'_> {
        Grids { positions: &self.positions, grids: &self.grids }.into()
    }

    fn quads(&self) -> Geometry<'_> {
        Quads { positions: &self.positions, indices: &self.quads }.into()
    }

    fn trees(&self, kind: usize) -> [ObjectTree; 2] {
        [self.grids(), self.quads()]
            .map(|geometry| ObjectTree::build_from(&[geometry], &options(WATERTIGHT[kind]), Threads::Single))
    }

    /// At vertices, at points of edges and of cells, and anywhere.
    fn rays(&self, seed: u64) -> RayBatch {
        let mut random = Random::new(seed);
        let aimed = (0..3000).map(|i| {
            let from = random.point().map(|x| 4.0 * x);
            let quad = self.quads[random.below(self.quads.len())];
            let corner = |k: usize| self.positions.get(quad[k] as usize).copied().unwrap_or_default();
            let share = [0.0, 0.5, random.unit()][i % 3];
            let at = [0, 1, 2].map(|k| corner(0)[k] + share * (corner(i % 4)[k] - corner(0)[k]));
            Ray::new(from, [0, 1, 2].map(|k| at[k] - from[k]))
        });
        let mut rays: Vec<Ray> = aimed.collect();
        rays.extend((0..500).map(|_| Ray::new(random.point().map(|x| 3.0 * x), random.point())));
        rays.into_iter().collect()
    }
}

fn bits(hit: &Option<Hit>) -> Option<([u32; 3], Hit)> {
    hit.map(|hit| ([hit.t, hit.u, hit.v].map(f32::to_bits), hit))
}

/// Of callbacks: which half of a cell comes first is not laid down where both meet the ray at one place.
fn id(hit: &Option<Hit>) -> Option<(u32, u32)> {
    hit.map(|hit| (hit.t.to_bits(), hit.prim_id))
}

fn assert_same(grids: &ObjectTree, quads: &ObjectTree, rays: &RayBatch, least: usize) {
    let (own, expected) = (run_queries(grids, rays), run_queries(quads, rays));
    assert!(expected.iter().flatten().count() > least, "enough are hit");
    for (i, (own, expected)) in own.iter().zip(&expected).enumerate() {
        assert_eq!(bits(own), bits(expected), "{:?}", rays.get(i));
        if let Some(hit) = own {
            assert_eq!(grids.normal(hit), quads.normal(hit), "the normal of {hit:?}");
        }
    }
}

#[test]
fn hits_are_those_of_quads() {
    let sheets = Sheets::bumpy(3);
    let rays = sheets.rays(5);
    for (i, kind) in WATERTIGHT.iter().enumerate().filter(|(_, kind)| kind.0 == Structure::Bvh) {
        let [grids, quads] = sheets.trees(i);
        assert_eq!(grids.stats().primitives, quads.stats().primitives, "{kind:?}: the same triangles");
        assert_same(&grids, &quads, &rays, 2000);
    }
}

#[test]
fn other_questions_have_the_answers_of_quads() {
    let sheets = Sheets::bumpy(11);
    let [grids, quads] = sheets.trees(0);
    let mut random = Random::new(8);
    let rays = sheets.rays(6);
    let query = Query::default();
    let (mut own, mut expected) = (Vec::new(), Vec::new());
    for i in 0..rays.len() {
        let ray = rays.get(i);
        let odd = |_: &Ray, hit: &Hit| hit.prim_id % 2 == 1;
        let found = [&grids, &quads].map(|tree| tree.intersect_filtered(&query, &ray, odd));
        assert_eq!(id(&found[0]), id(&found[1]), "odd cells of {ray:?}");
        let found = [&grids, &quads].map(|tree| tree.intersect_face(&query, &ray, Face::Front));
        assert_eq!(id(&found[0]), id(&found[1]), "fronts of {ray:?}");
        assert_eq!(grids.crossings(&ray), quads.crossings(&ray), "crossings of {ray:?}");
        grids.all_hits(&query, &ray, &mut own);
        quads.all_hits(&query, &ray, &mut expected);
        let ids = |hits: &[Hit]| hits.iter().map(|&hit| id(&Some(hit))).collect::<Vec<_>>();
        assert_eq!(ids(&own), ids(&expected), "all hits of {ray:?}");
        let hidden = ray.with_mask(2);
        assert_eq!(grids.intersect(&hidden).is_some(), !own.is_empty(), "all masks see it");
    }
    for _ in 0..300 {
        let p = random.point().map(|x| 2.0 * f64::from(x));
        let near = [&grids, &quads].map(|tree| tree.closest_point(p, f64::INFINITY));
        assert_eq!(near[0], near[1], "near {p:?}");
    }
    let instance = |tree: &ObjectTree| scene_of(&[Instance::identity(std::sync::Arc::new(tree.clone()))]);
    let scenes = [instance(&grids), instance(&quads)];
    let [own, expected] = [run_queries(&scenes[0], &rays), run_queries(&scenes[1], &rays)];
    assert_eq!(own, expected, "as instances, too");
}

#[test]
fn bad_cells_are_those_of_quads() {
    let mut sheets = Sheets::bumpy(4);
    sheets.positions[50] = [f32::NAN; 3];
    sheets.positions[120] = [0.3, f32::INFINITY, 0.0];
    sheets.positions[360] = [1e30; 3];
    sheets.positions[200] = sheets.positions[201];
    for same in [232, 252, 253] {
        sheets.positions[same] = sheets.positions[231];
    }
    sheets.grids.push(Grid { first: 690, stride: 6, width: 5, height: 4 });
    sheets.grids.push(Grid { first: u32::MAX - 5, stride: u32::MAX, width: 4, height: 3 });
    let sheets = Sheets::new(sheets.positions, &sheets.grids);
    let [grids, quads] = sheets.trees(0);
    assert_eq!(grids.bad_primitives(), quads.bad_primitives(), "the same faults");
    let bad = grids.bad_primitives();
    assert!(
        bad.nan * bad.infinite * bad.too_large * bad.zero_area * bad.bad_index > 0,
        "of all kinds: {bad:?}"
    );
    assert_same(&grids, &quads, &sheets.rays(2), 1500);
    let moved = Sheets::new(sheets.positions.iter().map(|p| p.map(|x| x + 1.0)).collect(), &sheets.grids);
    let refitted = grids.refit_from(&[moved.grids()], Threads::Single);
    assert_eq!(refitted.map(drop), Err(RefitError::OtherPrimitives), "which are left out");
}

#[test]
fn grids_follow_their_vertices() {
    let sheets = Sheets::bumpy(3);
    let mut random = Random::new(1);
    let moved =
        sheets.positions.iter().map(|p| [0, 1, 2].map(|k| p[k] + 0.02 * random.point()[k] + k as f32));
    let moved = Sheets::new(moved.collect(), &sheets.grids);
    for kind in [0, 5] {
        let [grids, _] = sheets.trees(kind);
        let refitted = grids.refit_from(&[moved.grids()], Threads::Single).expect("the same cells");
        let [_, quads] = moved.trees(kind);
        assert_same(&refitted, &quads, &moved.rays(5), 2000);
    }
    // Other grids of as many cells in all.
    let other = Grid { first: 0, stride: 13, width: 5, height: 3 };
    let [a, b] = [[8, 0], [4, 2]].map(|[columns, rows]: [u16; 2]| match rows {
        0 => Grid { width: columns + 1, height: 2, ..other },
        _ => Grid { width: columns + 1, height: rows + 1, ..other },
    });
    let [a, b] = [a, b].map(|grid| Sheets::new(sheets.positions.clone(), &[grid]));
    let [grids, _] = a.trees(0);
    let refitted = grids.refit_from(&[b.grids()], Threads::Single);
    assert_eq!(refitted.map(drop), Err(RefitError::OtherPrimitives), "patches begin elsewhere");
}

#[test]
fn saved_grids_are_the_same() {
    let sheets = Sheets::bumpy(7);
    for kind in [0, 5] {
        let [grids, quads] = sheets.trees(kind);
        let mut file = Vec::new();
        grids.save(&mut file).expect("memory takes all");
        let loaded = ObjectTree::load(&mut &file[..]).expect("it was saved");
        assert!(loaded.same_tree(&grids), "node for node");
        assert_eq!(loaded.stats(), grids.stats(), "as it was measured");
        assert_same(&loaded, &quads, &sheets.rays(9), 2000);
        let mut random = Random::new(2);
        let mut damaged = 0;
        for _ in 0..400 {
            let mut other = file.clone();
            let at = random.below(file.len());
            other[at] ^= 1 << random.below(8);
            damaged += u32::from(ObjectTree::load(&mut &other[..]).is_err());
        }
        assert_eq!(damaged, 400, "the checksum finds all");
    }
}

#[test]
fn grids_take_a_third_of_the_memory() {
    let grid = Grid { first: 0, stride: 301, width: 301, height: 301 };
    let position = |i: usize| {
        let (x, y) = ((i % 301) as f32, (i / 301) as f32);
        [x, y, 4.0 * (0.1 * x).sin() * (0.07 * y).cos()]
    };
    let sheet = Sheets::new((0..301 * 301).map(position).collect(), &[grid]);
    for (quality, memory) in [(Quality::Medium, Memory::Fast), (Quality::Medium, Memory::Compact)] {
        let kind = crate::common::Kind(Structure::Bvh, quality, TriangleTest::Watertight, memory);
        let [own, quads] = [sheet.grids(), sheet.quads()].map(|geometry| {
            let stats = ObjectTree::build_from(&[geometry], &options(kind), Threads::Single).stats();
            (stats.tree_bytes + stats.primitive_bytes) as f64 / 90_000.0
        });
        eprintln!("{memory:?}: {own:.1} bytes a cell, {quads:.1} as quads");
        let share = if memory == Memory::Fast { 1.0 / 3.0 } else { 0.6 };
        assert!(own < share * quads, "{memory:?}: {own} bytes a cell, {quads} as quads");
    }
}
