// SPDX-License-Identifier: GPL-3.0-or-later
//! Building takes less than three times the memory of what goes in and comes out. Source: original.
//!
//! The system is asked for the peak of the whole process, so this file holds one test only. Counting in an allocator
//! would need unsafe code.

mod common;

use gnurt_accel::{BuildOptions, Threads};
use gnurt_testkit::closed;

/// A line of the process's status in bytes, where the system tells.
fn status(line: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let number =
        status.lines().find_map(|l| l.strip_prefix(line))?.trim().trim_end_matches(" kB").parse::<u64>();
    Some(1024 * number.ok()?)
}

#[test]
fn a_build_peaks_below_three_times_its_data() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    let mesh = closed::torus(230);
    let input = (size_of_val(&mesh.positions[..]) + size_of_val(&mesh.indices[..])) as u64;
    let meshes = [mesh];
    let (Some(before), Some(_)) = (status("VmRSS:"), status("VmHWM:")) else {
        eprintln!("SKIPPED: this system does not tell how much memory a process takes");
        return;
    };
    let stats = common::build_with(&meshes, &BuildOptions::default(), Threads::Pool(&pool)).stats();
    let peak = status("VmHWM:").unwrap_or(0).saturating_sub(before) + input;
    let data = input + stats.tree_bytes + stats.primitive_bytes;
    assert!(peak > data, "{peak} bytes hold at least the {data} that come out");
    assert!(peak < 3 * data, "{peak} bytes for {data}, {:.2} times", peak as f64 / data as f64);
}
