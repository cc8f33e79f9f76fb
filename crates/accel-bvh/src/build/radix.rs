// SPDX-License-Identifier: GPL-3.0-or-later
//! Sorts numbers of 64 bits whose upper halves are codes of 30 bits and whose lower halves ascend: first by the highest bits
//! into buckets, by all threads, then each bucket by the others, while it is in the cache.
//! Source: radix sort of [PL10] section 4, from the highest digit on. Cost: O(n).
//! Invariant: the order is that of the codes, equal ones in their original order, for any threads. Tests:
//! `tests`.

use super::task_pool::TaskPool;
use gnurt_accel_core::threads::{Pieces, for_each, map};

/// Bits of a code.
pub(super) const BITS: u32 = 30;

/// Bits that buckets are made by, and those of each pass within one.
const HIGH: u32 = 8;
const DIGIT: u32 = (BITS - HIGH) / 2;

/// Entries that a thread distributes, or sorts by comparing. Tests have small scenes.
const PIECE: usize = if cfg!(test) { 1 << 8 } else { 1 << 15 };
const FEW: usize = 1 << 7;

/// Sorts by the codes.
pub(super) fn sorted(tasks: TaskPool, mut entries: Vec<u64>) -> Vec<u64> {
    if entries.len() <= FEW {
        entries.sort_unstable();
        return entries;
    }
    let mut others = vec![0; entries.len()];
    let sizes = distribute(tasks, &entries, &mut others);
    let mut buckets = Vec::with_capacity(sizes.len());
    let (mut rest, mut rest_of_scratch) = (&mut others[..], &mut entries[..]);
    for size in sizes {
        let (bucket, scratch);
        (bucket, rest) = rest.split_at_mut(size);
        (scratch, rest_of_scratch) = rest_of_scratch.split_at_mut(size);
        buckets.push((bucket, scratch));
    }
    let pieces = Pieces::new(&mut buckets, 1);
    for_each(tasks.parallel, pieces.count(), &|i| {
        let (bucket, scratch) = &mut pieces.lock(i)[0];
        sort_bucket(bucket, scratch);
    });
    others
}

/// Which of 2^bits buckets an entry belongs to by the bits of its code from `shift` on.
#[inline(always)]
fn bucket_of(entry: u64, shift: u32, bits: u32) -> usize {
    (entry >> (32 + shift)) as usize & ((1 << bits) - 1)
}

/// Distributes by the highest bits; returns the sizes of buckets.
fn distribute(tasks: TaskPool, entries: &[u64], into: &mut [u64]) -> Vec<usize> {
    const BUCKETS: usize = 1 << HIGH;
    let bucket = |entry| bucket_of(entry, BITS - HIGH, HIGH);
    let count = |piece: &[u64]| {
        let mut counts = [0usize; BUCKETS];
        piece.iter().for_each(|&entry| counts[bucket(entry)] += 1);
        counts
    };
    let piece = if tasks.parallel { PIECE } else { entries.len() };
    let pieces: Vec<&[u64]> = entries.chunks(piece).collect();
    let counts = map(tasks.parallel, pieces.len(), |i| count(pieces[i]));
    // Each piece has a separate range in each bucket.
    let mut targets: Vec<Vec<&mut [u64]>> = counts.iter().map(|_| Vec::with_capacity(BUCKETS)).collect();
    let mut rest = into;
    for bucket in 0..BUCKETS {
        for (counts, targets) in counts.iter().zip(&mut targets) {
            let position;
            (position, rest) = rest.split_at_mut(counts[bucket]);
            targets.push(position);
        }
    }
    let in_pieces = Pieces::new(&mut targets, 1);
    for_each(tasks.parallel, pieces.len(), &|i| {
        let (piece, targets) = (pieces[i], &mut in_pieces.lock(i)[0]);
        let mut filled = [0; BUCKETS];
        for &entry in piece {
            let bucket = bucket(entry);
            targets[bucket][filled[bucket]] = entry;
            filled[bucket] += 1;
        }
    });
    (0..BUCKETS).map(|bucket| counts.iter().map(|counts| counts[bucket]).sum()).collect()
}

/// Sorts by the bits that buckets were not made by.
fn sort_bucket(bucket: &mut [u64], scratch: &mut [u64]) {
    if bucket.len() <= FEW {
        return bucket.sort_unstable();
    }
    let mut starts = [[0u32; 1 << DIGIT]; 2];
    for &entry in &*bucket {
        starts[0][bucket_of(entry, 0, DIGIT)] += 1;
        starts[1][bucket_of(entry, DIGIT, DIGIT)] += 1;
    }
    for starts in &mut starts {
        let mut end = 0;
        for start in starts {
            (*start, end) = (end, end + *start);
        }
    }
    pass(bucket, scratch, 0, &mut starts[0]);
    pass(scratch, bucket, DIGIT, &mut starts[1]);
}

fn pass(from: &[u64], to: &mut [u64], shift: u32, starts: &mut [u32; 1 << DIGIT]) {
    for &entry in from {
        let at = &mut starts[bucket_of(entry, shift, DIGIT)];
        to[*at as usize] = entry;
        *at += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_accel_core::control::Watch;
    use gnurt_simd::Level;
    use gnurt_testkit::Random;

    #[test]
    fn as_the_standard_library_sorts() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads start");
        let watch = Watch::new(&());
        let mut random = Random::new(1);
        for count in [0, 1, 100, 5000] {
            // All bits, few of the high ones, few of the low ones, one code.
            for mask in [(1 << BITS) - 1, 0x7ff, 0x3ff0_0000, 0] {
                let code = |position: u64| (random.bits() & mask) << 32 | position;
                let entries: Vec<u64> = (0..count).map(code).collect();
                let mut expected = entries.clone();
                expected.sort_unstable();
                let tasks = TaskPool { parallel: false, level: Level::best(), scale: 1.0, watch: &watch };
                assert_eq!(sorted(tasks, entries.clone()), expected, "{count} of {mask:x}");
                let tasks = TaskPool { parallel: true, ..tasks };
                let found = pool.install(|| sorted(tasks, entries));
                assert_eq!(found, expected, "{count} of {mask:x} by threads");
            }
        }
    }
}
