// SPDX-License-Identifier: GPL-3.0-or-later
//! Peak memory of this program during some work. Source: proc(5). It is rough: pages are counted, and of all
//! threads. If free memory cannot be returned beforehand (other systems than Linux with glibc), memory freed
//! earlier hides the same amount.
//! Tests: `tests::a_large_array_is_seen`.

use std::fs;

use crate::ffi_malloc;

/// The resident bytes, and their peak; `None` if unknown.
fn status() -> Option<(u64, u64)> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let field = |name: &str| -> Option<u64> {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.split_whitespace().next()?.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
    };
    Some((field("VmRSS:")?, field("VmHWM:")?))
}

/// Runs it, from fresh memory, and returns by how many bytes the program grew at most meanwhile.
pub(crate) fn growth<T>(work: impl FnOnce() -> T) -> (T, Option<u64>) {
    ffi_malloc::trim();
    // 5 sets the greatest size back to the present one. Where that is not allowed, nothing is known.
    let before = fs::write("/proc/self/clear_refs", "5").ok().and_then(|()| status());
    let result = work();
    let peak = before.and_then(|(resident, _)| Some(status()?.1.saturating_sub(resident)));
    (result, peak)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_array_is_seen() {
        let (sum, peak) =
            growth(|| std::hint::black_box(vec![1u8; 64 << 20]).iter().map(|&x| u64::from(x)).sum::<u64>());
        assert_eq!(sum, 64 << 20, "the work is done");
        if let Some(peak) = peak {
            assert!((60 << 20..200 << 20).contains(&peak), "64 MiB are seen as {peak} bytes");
        }
    }
}
