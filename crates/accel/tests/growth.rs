// SPDX-License-Identifier: GPL-3.0-or-later
//! Memory of loading saved trees: for any numbers in a file, it stays below three times the file's length, as
//! `load` guarantees. Every allocation of the program is counted. One test only, so that nothing else is
//! counted.

mod common;
#[path = "common/signed.rs"]
mod signed;

use common::{TESTS, build, options};
use gnurt_accel::{Geometry, ObjectTree, Quads, Spheres, Threads};
use gnurt_testkit::closed;
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATIONS: PeakAlloc = PeakAlloc;

/// Memory of reading any file: a buffer.
const SPACE: usize = 1 << 20;
const GROWTH: usize = 3;

/// Numbers in place of two words: of a list of many bytes, of more than memory has, and of more than can be counted.
const NUMBERS: [u64; 3] = [1 << 22, (1 << 32) - 1, u64::MAX];

fn save(tree: &ObjectTree) -> Vec<u8> {
    let mut file = Vec::new();
    tree.save(&mut file).expect("memory takes all");
    file
}

/// The most that was taken at once while it was loaded.
fn cost(file: &[u8]) -> usize {
    ALLOCATIONS.reset_peak_usage();
    let before = ALLOCATIONS.current_usage();
    let loaded = ObjectTree::load(&mut &file[..]);
    let peak = ALLOCATIONS.peak_usage() - before;
    drop(loaded);
    peak
}

#[test]
fn trees_cost_what_their_lengths_account_for() {
    let mesh = closed::torus(4);
    let corners = [[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [1.0, 1.0, 0.5], [-1.0, 1.0, 0.5]];
    for (kind, _) in TESTS {
        let geometries = [
            Quads { positions: &corners, indices: &[[0, 1, 2, 3]] }.into(),
            Geometry::from(Spheres { centers: &corners, radii: &[0.25; 4] }),
        ];
        let others = ObjectTree::build_from(&geometries, &options(kind), Threads::Single);
        for sound in [save(&build(std::slice::from_ref(&mesh), kind)), save(&others)] {
            let allowed = SPACE + GROWTH * sound.len();
            // Any two words may be a number of things.
            for at in (0..sound.len() - 16).step_by(4) {
                for number in NUMBERS {
                    let mut file = sound.clone();
                    file[at..at + 8].copy_from_slice(&number.to_le_bytes());
                    signed::sign(&mut file);
                    let peak = cost(&file);
                    assert!(peak <= allowed, "{kind:?}: {number} at {at}: {peak} bytes for {}", file.len());
                }
            }
        }
        let large = save(&build(&[closed::torus(60)], kind));
        let peak = cost(&large);
        assert!(peak <= SPACE + GROWTH * large.len(), "{kind:?}: {peak} bytes for {}", large.len());
        // It declares its full size, but ends.
        let half = cost(&large[..large.len() / 2]);
        assert!(
            half <= SPACE + GROWTH * large.len() / 2,
            "{kind:?}: {half} bytes for half of {}",
            large.len()
        );
    }
}
