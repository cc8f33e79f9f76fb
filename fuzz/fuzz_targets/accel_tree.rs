// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a saved tree, with the checksum that they should have: an error of one line, or a tree that rays may
//! go through.
#![no_main]

use gnurt_accel::{Coherence, HitBatch, Level, ObjectTree, Query, Ray, RayBatch, Record};

#[path = "../../crates/accel/tests/common/signed.rs"]
mod signed;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut file = bytes.to_vec();
    signed::sign(&mut file);
    match ObjectTree::load(&mut &file[..]) {
        Ok(tree) => trace(&tree),
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "an error is one line: {error}"),
    }
});

/// Rays of several headings and lengths, one by one and together.
fn trace(tree: &ObjectTree) {
    let ray = |i: u32| {
        let [a, b, c] = [i % 7, i % 5, i % 3].map(|x| x as f32 - 1.0);
        let scale = [1.0, 1e-30, 1e30][i as usize % 3];
        Ray::new([3.0 * c, a, 2.0 * b], [a * scale, b * scale, c * scale])
    };
    let rays: RayBatch = (0..105).map(ray).collect();
    let (mut hits, mut occluded, mut record) = (HitBatch::default(), Vec::new(), Record::default());
    for coherence in [Coherence::Incoherent, Coherence::Coherent] {
        let query = Query { level: Level::best(), coherence, mask: u32::MAX };
        tree.intersect_batch(&query, &rays, &mut hits, &mut record);
        tree.occluded_batch(&query, &rays, &mut occluded, &mut record);
    }
    let _ = (tree.stats(), tree.bad_primitives().total(), tree.bounds());
}
