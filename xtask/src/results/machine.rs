// SPDX-License-Identifier: GPL-3.0-or-later
//! The machine that results are measured on, and whether it is idle. Tests: none; the data comes from Linux.

use serde_json::{Value, json};

use crate::command;
use crate::failure::Failure;

/// Processes that run or wait to run, on average over the last minute, where the system reports it.
pub(super) fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split(' ').next()?.parse().ok()
}

/// Why this machine is not fit for measuring.
pub(super) fn complaint(load: Option<f64>) -> Option<String> {
    match load {
        None => Some("this system does not tell its load".into()),
        Some(load) if load > 0.5 => Some(format!("the machine is not idle: its load is {load}, above 0.5")),
        Some(_) => None,
    }
}

/// CPU, commit, load and date.
pub(super) fn describe(before: Option<f64>) -> Result<Value, Failure> {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = text.lines().find(|line| line.starts_with(name))?;
        line.split_once(':').map(|(_, value)| value.trim().to_owned())
    };
    // The page itself changes at the end of each run, also of one that stopped later.
    let status = [
        "status",
        "--porcelain",
        "--untracked-files=no",
        "--",
        ":/",
        ":(top,exclude)docs/explanation/results.md",
    ];
    let changed = !command::output_of("git", &status)?.is_empty();
    if changed {
        eprintln!("WARNING: the work tree differs from the commit");
    }
    Ok(json!({
        "date": command::output_of("date", &["+%Y-%m-%d"])?,
        "commit": command::output_of("git", &["rev-parse", "--short=8", "HEAD"])?,
        "changed": changed,
        "cpu": field("model name"),
        "flags": field("flags"),
        "threads": std::thread::available_parallelism().map_or(1, usize::from),
        "rustc": command::output_of("rustc", &["--version"])?,
        "rustflags": std::env::var("RUSTFLAGS").unwrap_or_default(),
        "load_before": before,
        // Our own threads are in it.
        "load_after": load(),
    }))
}
