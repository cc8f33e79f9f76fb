// SPDX-License-Identifier: GPL-3.0-or-later
//! Memory of a picture, and free memory of the machine. Proc(5) and the kernel's cgroup-v2 documentation. A
//! picture that cannot fit is rejected before the computation: with overcommitted memory the allocation
//! itself would succeed and the program be killed later.
//! Tests: `tests`, and the command line's `tests/program/arguments.rs` (a picture too large for any machine).

use std::fs::read_to_string;

use crate::Error;
pub use crate::ffi_heap::FileHeap;
use crate::render::RenderOptions;
pub use crate::size::format_bytes;

/// Colours, the sums they are made from, and the file's bytes.
const PER_PIXEL: u64 = 64;
/// Albedo, normal, position, depth, ids and background, and their bytes in the file.
const LAYERS_PER_PIXEL: u64 = 360;
/// What mirrors and glass show: sums, means, and their bytes in the file.
const SEEN_PER_PIXEL: u64 = 490;
/// A layer of light: sums, the mean, and its bytes in the file.
const LIGHT_LAYER_PER_PIXEL: u64 = 60;
/// The things of a pixel of one kind of mattes; and each rank, with its bytes in the file.
const MATTE_PER_PIXEL: u64 = 80;
const RANK_PER_PIXEL: u64 = 20;
/// Costs and their colours.
const HEAT_PER_PIXEL: u64 = 40;
/// The output of a denoiser.
const CLEAN_PER_PIXEL: u64 = 200;

/// Of a film: a frame that others borrow light from, one that waits, and the work on one.
const FILM_PER_PIXEL: [u64; 3] = [135, 225, 480];

/// Bytes that the frames of a film's window take, with `reach` frames on each side, and the work on one of them.
#[must_use]
pub fn window_bytes([width, height]: [u32; 2], reach: usize) -> u64 {
    let [borrowed, waits, work] = FILM_PER_PIXEL;
    let frames = (2 * reach as u64 + 1) * (borrowed + waits) + work;
    (u64::from(width) * u64::from(height)).saturating_mul(frames)
}

/// As many frames on each side of a film's window, up to `reach`, as fit into the free memory of the machine with `more` bytes.
///
/// # Errors
/// [`Error::Memory`] if `is_firm` and `reach` does not fit; if free memory is unknown, it fits.
pub fn fitting_reach(size: [u32; 2], reach: usize, more: u64, is_firm: bool) -> Result<usize, Error> {
    let fits = |reach: usize| check_more(size, window_bytes(size, reach).saturating_add(more));
    if is_firm {
        fits(reach)?;
    }
    Ok((1..=reach).rev().find(|&reach| fits(reach).is_ok()).unwrap_or(0))
}

/// Bytes that a picture under these options takes, its file's included, about; `is_denoised` if the noise is taken out of it.
#[must_use]
pub fn picture_bytes(options: &RenderOptions, is_denoised: bool) -> u64 {
    let layers = if options.aovs || is_denoised { LAYERS_PER_PIXEL } else { 0 };
    let seen = if options.aovs && options.seen { SEEN_PER_PIXEL } else { 0 };
    let clean = if is_denoised { CLEAN_PER_PIXEL } else { 0 };
    let light = LIGHT_LAYER_PER_PIXEL * options.light_layers.len() as u64;
    let ranks = u64::from(options.mattes.depth) * RANK_PER_PIXEL;
    let mattes = options.mattes.kinds.len() as u64 * (MATTE_PER_PIXEL + ranks);
    let heat = if options.heatmap { HEAT_PER_PIXEL } else { 0 };
    let height = options.rows.map_or(options.height, |[top, end]| end.saturating_sub(top));
    let pixels = u64::from(options.width) * u64::from(height);
    pixels.saturating_mul(PER_PIXEL + layers + seen + light + mattes + clean + heat)
}

/// Whether the picture fits into the free memory of the machine.
///
/// # Errors
/// [`Error::Memory`] if it does not; if free memory is unknown, it fits.
pub fn check_memory(options: &RenderOptions, is_denoised: bool) -> Result<(), Error> {
    check_more([options.width, options.height], picture_bytes(options, is_denoised))
}

/// Whether this number of further bytes is free, for a picture of that size: for callers that hold memory of
/// earlier pictures.
///
/// # Errors
/// As [`check_memory`].
pub fn check_more(size: [u32; 2], needed: u64) -> Result<(), Error> {
    match free_memory().filter(|&free| needed > free) {
        Some(free) => Err(Error::Memory { size, needed, free }),
        None => Ok(()),
    }
}

/// Bytes of memory that this process may still take; `None` where the system does not report it.
#[must_use]
pub fn free_memory() -> Option<u64> {
    let read = |path: &str| read_to_string(path).ok();
    let in_use =
        read("/proc/self/statm").and_then(|text| first_number(&text)).map_or(0, |pages| pages * PAGE);
    let limits = [
        read("/proc/meminfo").and_then(|text| available(&text)),
        read("/proc/self/limits")
            .and_then(|text| address_space(&text))
            .map(|limit| limit.saturating_sub(in_use)),
        read("/sys/fs/cgroup/memory.max").and_then(|text| first_number(&text)).map(|limit| {
            let used =
                read("/sys/fs/cgroup/memory.current").and_then(|text| first_number(&text)).unwrap_or(0);
            let cached = read("/sys/fs/cgroup/memory.stat").map_or(0, |text| cached(&text));
            limit.saturating_sub(used.saturating_sub(cached))
        }),
    ];
    tightest(limits)
}

/// Bytes per page that `statm` counts in, where nothing else is known.
const PAGE: u64 = 4096;

fn tightest(limits: [Option<u64>; 3]) -> Option<u64> {
    limits.into_iter().flatten().min()
}

/// The first word as a number; `max` is none.
fn first_number(text: &str) -> Option<u64> {
    text.split_whitespace().next()?.parse().ok()
}

/// `MemAvailable` of /proc/meminfo, in bytes.
fn available(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    first_number(line).map(|kibibytes| kibibytes * 1024)
}

/// Bytes of cached files of a group, which the kernel frees when memory is needed, from its memory.stat.
fn cached(stat: &str) -> u64 {
    let of = |name| stat.lines().find_map(|line| line.strip_prefix(name)).and_then(first_number);
    ["inactive_file ", "active_file "].into_iter().filter_map(of).sum()
}

/// The soft limit of the address space of /proc/self/limits, in bytes.
fn address_space(limits: &str) -> Option<u64> {
    limits.lines().find_map(|line| line.strip_prefix("Max address space")).and_then(first_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tightest_limit_counts() {
        assert_eq!(available("MemTotal: 9 kB\nMemAvailable:   2048 kB\n"), Some(2 << 20), "kibibytes");
        let limits = "Limit Soft Hard Units\nMax address space         1073741824  unlimited  bytes\n";
        assert_eq!(address_space(limits), Some(1 << 30), "the soft limit");
        assert_eq!(address_space("Max address space  unlimited  unlimited  bytes"), None, "no limit");
        assert_eq!(first_number("max\n"), None, "no limit of the group");
        let stat = "anon 100\nfile 70\nshmem 5\ninactive_file 40\nactive_file 20\nunevictable 1\n";
        assert_eq!(cached(stat), 60, "files that are only kept can go");
        assert_eq!(tightest([Some(5), None, Some(3)]), Some(3), "the least one");
    }

    #[test]
    fn pictures_that_cannot_fit_are_refused() {
        let huge = RenderOptions { width: 1 << 31, height: 1 << 31, ..RenderOptions::default() };
        let small = RenderOptions { width: 2, height: 2, ..RenderOptions::default() };
        assert!(check_memory(&small, true).is_ok(), "four pixels fit");
        let layered = RenderOptions { aovs: true, ..small.clone() };
        assert!(picture_bytes(&layered, false) > picture_bytes(&small, false), "layers take memory");
        if free_memory().is_some() {
            let error = check_memory(&huge, false).expect_err("exabytes").to_string();
            assert!(error.contains("2147483648x2147483648") && error.contains("smaller"), "{error}");
            assert!(check_more([9, 9], 1 << 62).is_err(), "more than any machine has");
            assert!(check_more([1 << 31, 1], 0).is_ok(), "no more than is there already");
        }
    }
}
