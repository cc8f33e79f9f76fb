// SPDX-License-Identifier: GPL-3.0-or-later
//! Puts triangles into all cells that their boxes meet: a counting sort by slices of cells, then by cells of each slice.
//! Source: [WIK*06] section 4.4; two passes, so that counters stay in caches and threads share nothing, are original. Pieces of triangles are
//! sorted by all threads, then slices.
//! Invariant: a cell's triangles ascend; lists are the same for any number of threads. Tests: `tests/grids.rs` of `gnurt-accel`.

use std::iter;
use std::ops::Range;

use gnurt_accel_core::control::Watch;
use gnurt_accel_core::{BuildError, Threads};
use rayon::prelude::*;

use super::cells::{Cells, Span};

/// Triangles that are sorted by one thread.
const PIECE: usize = 1 << 14;

/// The lists of one slice of cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Slice {
    /// Where the list of each cell begins, and one past the last of all.
    pub(super) starts: Vec<u32>,
    /// Indices of triangles.
    pub(super) items: Vec<u32>,
}

/// Which triangles of a piece meet each slice.
struct Piece {
    starts: Vec<u32>,
    items: Vec<u32>,
}

/// A counting sort of `number` elements into `bins`, each of which may go into many: `ranges(i)` returns
/// them. Returns the start of each bin and, bin by bin, its elements under the names of `id`, in the original
/// order.
fn sort<R: Iterator<Item = Range<usize>>>(
    bins: usize,
    number: usize,
    id: impl Fn(usize) -> u32,
    ranges: impl Fn(usize) -> R,
) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; bins + 1];
    for range in (0..number).flat_map(&ranges) {
        starts[range].iter_mut().for_each(|count| *count += 1);
    }
    let mut sum = 0;
    for count in &mut starts {
        sum += *count;
        *count = sum;
    }
    // From behind: ends become starts.
    let mut items = vec![0; sum as usize];
    for i in (0..number).rev() {
        let id = id(i);
        for range in ranges(i) {
            for end in &mut starts[range] {
                *end -= 1;
                items[*end as usize] = id;
            }
        }
    }
    (starts, items)
}

/// Lists of all cells, slice by slice along the axis `along`. There are fewer than 2^32 references.
pub(super) fn slices(
    cells: &Cells,
    along: usize,
    spans: &[Span],
    threads: Threads,
    watch: &Watch,
) -> Result<Vec<Slice>, BuildError> {
    let [x, y] = [(along + 1) % 3, (along + 2) % 3];
    let slice_count = cells.count[along] as usize;
    let piece = |which: usize| {
        let first = which * PIECE;
        let spans = &spans[first..spans.len().min(first + PIECE)];
        let ranges =
            |i: usize| iter::once(usize::from(spans[i].low[along])..usize::from(spans[i].high[along]) + 1);
        let number = if watch.go_on() { spans.len() } else { 0 };
        let (starts, items) = sort(slice_count, number, |i| (first + i) as u32, ranges);
        Piece { starts, items }
    };
    let count = spans.len().div_ceil(PIECE);
    let mut pieces: Vec<Piece> = Vec::with_capacity(count);
    threads.run(|parallel| extend_each(parallel, &mut pieces, count, piece));
    watch.result()?;
    let passing: usize = pieces.iter().map(|piece| 4 * (piece.starts.len() + piece.items.len())).sum();
    watch.take(passing);
    watch.result()?;
    watch.advance(1);

    let [wide, high] = [cells.count[x] as usize, cells.count[y] as usize];
    let slice = |which: usize| {
        let of = |piece: &Piece| piece.starts[which] as usize..piece.starts[which + 1] as usize;
        let mut here = Vec::with_capacity(pieces.iter().map(|piece| of(piece).len()).sum());
        if watch.go_on() {
            pieces.iter().for_each(|piece| here.extend_from_slice(&piece.items[of(piece)]));
        }
        let ranges = |i: usize| {
            let Span { low, high } = spans[here[i] as usize];
            let rows = usize::from(low[y])..usize::from(high[y]) + 1;
            rows.map(move |row| row * wide + usize::from(low[x])..row * wide + usize::from(high[x]) + 1)
        };
        let (starts, items) = sort(wide * high, here.len(), |i| here[i], ranges);
        Slice { starts, items }
    };
    let mut slices = Vec::with_capacity(slice_count);
    threads.run(|parallel| extend_each(parallel, &mut slices, slice_count, slice));
    watch.give(passing);
    watch.result()?;
    Ok(slices)
}

/// Appends `count` values to `all`, each by a thread.
fn extend_each<T: Send>(
    parallel: bool,
    all: &mut Vec<T>,
    count: usize,
    value: impl Fn(usize) -> T + Send + Sync,
) {
    if parallel {
        all.par_extend((0..count).into_par_iter().map(value));
    } else {
        all.extend((0..count).map(value));
    }
}
