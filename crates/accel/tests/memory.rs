// SPDX-License-Identifier: GPL-3.0-or-later
//! Building takes less than three times the memory of its input and output, and about the reported memory.
//!
//! The system is asked for the peak of the whole process, so this file holds one test only. Counting in an allocator
//! would need unsafe code.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use gnurt_accel::{BuildControl, BuildOptions, ObjectTree, Threads, Triangles};
use gnurt_testkit::closed;

/// A line of the process's status in bytes, where the system tells.
fn status(line: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let number =
        status.lines().find_map(|l| l.strip_prefix(line))?.trim().trim_end_matches(" kB").parse::<u64>();
    Some(1024 * number.ok()?)
}

/// The most that a build said it held.
struct Reported(AtomicU64);

impl BuildControl for Reported {
    fn memory(&self, bytes: u64) {
        self.0.fetch_max(bytes, Relaxed);
    }
}

#[test]
fn a_build_peaks_below_three_times_its_data() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    let mesh = closed::torus(230);
    let input = (size_of_val(&mesh.positions[..]) + size_of_val(&mesh.indices[..])) as u64;
    let mesh = Triangles { positions: &mesh.positions, indices: &mesh.indices };
    let reported = Reported(AtomicU64::new(0));
    let (Some(before), Some(_)) = (status("VmRSS:"), status("VmHWM:")) else {
        eprintln!("SKIPPED: this system does not tell how much memory a process takes");
        return;
    };
    let tree = ObjectTree::try_build(&[mesh], &BuildOptions::default(), Threads::Pool(&pool), &reported);
    let stats = tree.expect("nobody stops it").stats();
    let taken = status("VmHWM:").unwrap_or(0).saturating_sub(before);
    let reported = reported.0.into_inner();
    let ratio = reported as f64 / taken as f64;
    assert!((0.8..1.2).contains(&ratio), "{reported} bytes told, {taken} taken, {ratio:.2} times");
    let peak = taken + input;
    let data = input + stats.tree_bytes + stats.primitive_bytes;
    assert!(peak > data, "{peak} bytes hold at least the {data} that come out");
    assert!(peak < 3 * data, "{peak} bytes for {data}, {:.2} times", peak as f64 / data as f64);
}
