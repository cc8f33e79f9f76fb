// SPDX-License-Identifier: GPL-3.0-or-later
//! Memory of checkpoints: at most twice the requested picture, for any file. Every allocation of the program
//! is counted. One test only, so that nothing else is counted.

#[path = "common/signed.rs"]
mod signed;

use gnurt_render::{Accumulation, RenderOptions};
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATIONS: PeakAlloc = PeakAlloc;

/// Peak memory of some work.
fn cost<T>(work: impl FnOnce() -> T) -> usize {
    ALLOCATIONS.reset_peak_usage();
    let before = ALLOCATIONS.current_usage();
    let result = work();
    let peak = ALLOCATIONS.peak_usage() - before;
    drop(result);
    peak
}

#[test]
fn checkpoints_cost_what_their_pictures_take() {
    let options = RenderOptions { width: 96, height: 64, aovs: true, heatmap: true, ..Default::default() };
    let new = || Accumulation::new(options.clone()).expect("sound");
    let allowed = 2 * cost(new) + (1 << 20);
    let sound = new().to_bytes(7);
    let check = |what: &str, mut file: Vec<u8>| {
        signed::sign(&mut file);
        let peak = cost(|| Accumulation::from_bytes(options.clone(), 7, &file));
        assert!(peak <= allowed, "{what}: {peak} bytes, {allowed} are allowed");
    };
    check("sound", sound.clone());
    // The head, the counters, and the first tile: its number of samples among them.
    for at in 0..40 {
        for value in [1 << 20, (1 << 31) - 1, (1 << 32) - 1, 1 << 40, u64::MAX] {
            let mut file = sound.clone();
            file[8 * at..8 * at + 8].copy_from_slice(&u64::to_le_bytes(value));
            check(&format!("word {at} is {value:#x}"), file);
        }
    }
    for length in (0..sound.len()).step_by(sound.len() / 64 / 8 * 8) {
        check("short", sound[..length].to_vec());
    }
    check("long", [&sound[..], &vec![0; 64 << 20]].concat());
}
