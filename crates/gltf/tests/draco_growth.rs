// SPDX-License-Identifier: GPL-3.0-or-later
//! Draco's streams cut off at every byte, and with 10,000 changes: no panic, no wait, at most 64 MiB. Every
//! allocation of the program is counted. One test only, so that nothing else is counted.

#[path = "../../scene/tests/common/mod.rs"]
mod common;

use std::time::{Duration, Instant};

use common::load;
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATIONS: PeakAlloc = PeakAlloc;

const MOST: usize = 64 << 20;
/// A file takes a millisecond where nothing else runs.
const LONGEST: Duration = Duration::from_secs(10);

#[test]
fn broken_streams_cost_little() {
    let files: [&[u8]; 4] = [
        include_bytes!("data/draco-sequential.glb"),
        include_bytes!("data/draco-standard.glb"),
        include_bytes!("data/draco-valence.glb"),
        include_bytes!("data/draco-fallback.glb"),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("t.glb");
    let (mut worst, mut refused) = (0, 0);
    let mut attempt = |bytes: &[u8]| {
        // A new file: file systems write an overwritten one to the disk at once, in milliseconds.
        let _ = std::fs::remove_file(&path);
        std::fs::write(&path, bytes).expect("a file");
        ALLOCATIONS.reset_peak_usage();
        let start = Instant::now();
        match load(&path) {
            Ok(loaded) => loaded.scene.check().expect("a whole scene"),
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().contains('\n'), "one line: {error}");
            }
        }
        assert!(start.elapsed() < LONGEST, "{:?}", start.elapsed());
        worst = worst.max(ALLOCATIONS.peak_usage());
    };
    let mut number: u64 = 1;
    let mut next = |below: usize| {
        number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (number >> 33) as usize % below
    };
    for bytes in files {
        let stream = bytes.windows(5).position(|part| part == b"DRACO").expect("a stream");
        // The stream loses its end; the file keeps its length.
        for end in stream..bytes.len() {
            let mut cut = bytes.to_vec();
            cut[end..].fill(0);
            attempt(&cut);
        }
        for i in 0..2500 {
            let mut changed = bytes.to_vec();
            // Half of the changes are in the first bytes, which hold counts and methods.
            let span = if i % 2 == 0 { bytes.len() - stream } else { 64 };
            for _ in 0..=next(3) {
                changed[stream + next(span)] = next(256) as u8;
            }
            attempt(&changed);
        }
    }
    assert!(worst <= MOST, "{worst} bytes");
    assert!(refused > 1000, "{refused} of them were refused");
}
