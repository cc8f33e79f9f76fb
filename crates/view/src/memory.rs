// SPDX-License-Identifier: GPL-3.0-or-later
//! How much memory this process holds. Source: proc(5).

/// Bytes in memory; 0 where the system does not report it.
pub(crate) fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    kibibytes.unwrap_or(0) * 1024
}
