// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a saved tree, with the checksum that they should have: an error of one line, or a tree that rays may
//! go through.
#![no_main]

use gnurt_accel::{Coherence, HitBatch, Level, ObjectTree, Pencil, Query, Ray, RayBatch, Record};

#[path = "../../crates/accel/tests/common/signed.rs"]
mod signed;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut file = bytes.to_vec();
    signed::sign(&mut file);
    match ObjectTree::load(&mut &file[..]) {
        Ok(tree) => {
            trace(&tree);
            come_back(&tree);
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "an error is one line: {error}"),
    }
});

/// Rays of several directions and lengths, one by one and together.
fn trace(tree: &ObjectTree) {
    let ray = |i: u32| {
        let [a, b, c] = [i % 7, i % 5, i % 3].map(|x| x as f32 - 1.0);
        let scale = [1.0, 1e-30, 1e30][i as usize % 3];
        Ray::new([3.0 * c, a, 2.0 * b], [a * scale, b * scale, c * scale])
    };
    let rays: RayBatch = (0..105).map(ray).collect();
    for i in 0..21 {
        let (ray, query) = (ray(i), Query::default());
        let mut all = Vec::new();
        tree.all_hits(&query, &ray, &mut all);
        let _ = (tree.intersect_with(&query, &ray), tree.occluded_with(&query, &ray));
        let point = ray.org.map(f64::from);
        let _ = (tree.closest_point(point, f64::INFINITY), tree.crossings(&ray), tree.signed_distance(point));
        let (mut ids, mut near) = (Vec::new(), Vec::new());
        tree.touching_box(&query, point, point.map(|x| x + 1.0), &mut ids);
        tree.touching_sphere(&query, point, 1.0, &mut ids);
        tree.nearest_primitives(&query, point, f64::INFINITY, 3, &mut near);
    }
    let (mut hits, mut occluded, mut record) = (HitBatch::default(), Vec::new(), Record::default());
    for coherence in [Coherence::Incoherent, Coherence::Coherent, Coherence::Fanned] {
        let query = Query { level: Level::best(), coherence, mask: u32::MAX };
        tree.intersect_batch(&query, &rays, &mut hits, &mut record);
        tree.occluded_batch(&query, &rays, &mut occluded, &mut record);
    }
    let mut pencil = Pencil::EMPTY;
    pencil.org = [0.5, -0.25, 2.0];
    let (directions, far) = pencil.lanes();
    for i in 0..40 {
        let towards = ray(i as u32).dir;
        far[i] = if towards == [0.0; 3] { -1.0 } else { 1.0 };
        directions.iter_mut().zip(towards).for_each(|(lanes, x)| lanes[i] = x);
    }
    tree.occluded_pencil(&Query::default(), &mut pencil, &mut record);
    let _ = (tree.stats(), tree.bad_primitives().total(), tree.bounds());
}

/// A loaded tree can be saved and loaded again, bit for bit.
fn come_back(tree: &ObjectTree) {
    let save = |tree: &ObjectTree| {
        let mut file = Vec::new();
        tree.save(&mut file).expect("memory takes all");
        file
    };
    let file = save(tree);
    let again = ObjectTree::load(&mut &file[..]).expect("it was saved");
    assert!(save(&again) == file, "word for word");
}
