// SPDX-License-Identifier: GPL-3.0-or-later
//! Primitives in the order of a space-filling curve, eight to a leaf block, blocks that lie near each other in clusters of at
//! most eight: the lower levels of a tree are a matter of comparing bits.
//! Source: [PL10] section 3 for codes and how they part primitives. Differs: cells are cubes, for any shape
//! of the whole. If one cell holds more than a cluster, its primitives get codes of their own, so that
//! details much smaller than a scene are separated as well. Cost: O(n). In: middles of boxes. Out: numbers of
//! primitives, block by block.
//! Invariant: each primitive is in one block; threads do not matter. Tests: `tests`.

use gnurt_accel_core::threads::{Pieces, for_each};
use gnurt_accel_core::{Aabb, INVALID_ID};
use gnurt_simd::{Simd, dispatch_two, f32x4, prelude::*};

use super::radix::{BITS, sorted};
use super::task_pool::TaskPool;
use crate::node::WIDTH;
use crate::pools::transposed;

/// The largest number of primitives of a cluster: the capacity of a node's blocks.
const CLUSTER: usize = WIDTH * WIDTH;

/// Ranges of more primitives are cut by several threads. Tests have small scenes.
const PIECE: usize = if cfg!(test) { 1 << 9 } else { 1 << 14 };

/// Twice the middle of a primitive's box, and the bits of its number.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub(crate) struct Middle(pub(crate) [f32; 4]);

impl Middle {
    /// `twice` the middle.
    #[inline(always)]
    pub(crate) fn new([x, y, z]: [f32; 3], number: u32) -> Self {
        Self([x, y, z, f32::from_bits(number)])
    }

    /// That of a box.
    #[inline(always)]
    pub(crate) fn of(bounds: &Aabb, number: u32) -> Self {
        Self::new([0, 1, 2].map(|k| bounds.min[k] + bounds.max[k]), number)
    }

    fn number(&self) -> u32 {
        self.0[3].to_bits()
    }
}

/// Primitives in order.
#[derive(Default)]
pub(crate) struct Curve {
    /// Numbers, padded with `INVALID_ID`.
    pub(crate) blocks: Vec<[u32; WIDTH]>,
    /// Blocks of each cluster, one after another: 1 to 8.
    pub(super) clusters: Vec<u8>,
}

impl Curve {
    /// Through `middles`, whose numbers ascend.
    pub(super) fn through(tasks: TaskPool, middles: &[Middle]) -> Self {
        let grid = Grid::around(tasks, middles);
        let mut entries = sorted(tasks, grid.entries(tasks, middles));
        let mut curve = Self::default();
        curve.blocks.reserve(middles.len() / 6);
        curve.cut(tasks, middles, &mut entries, BITS);
        curve
    }

    /// Appends clusters of `entries`, whose codes may differ in the lowest `bits`.
    fn cut(&mut self, tasks: TaskPool, middles: &[Middle], entries: &mut [u64], bits: u32) {
        let count = entries.len();
        if count <= CLUSTER {
            return self.push(entries);
        }
        if count > PIECE && !tasks.watch.go_on() {
            return;
        }
        let differing = (entries[0] ^ entries[count - 1]) >> 32;
        if differing == 0 {
            return self.part_cell(tasks, middles, entries);
        }
        let bits = bits.min(64 - differing.leading_zeros()) - 1;
        let middle = entries.partition_point(|entry| entry >> (32 + bits) & 1 == 0);
        let (left, right) = entries.split_at_mut(middle);
        if tasks.parallel && count > PIECE {
            let mut other = Self::default();
            tasks.both(|| self.cut(tasks, middles, left, bits), || other.cut(tasks, middles, right, bits));
            self.blocks.append(&mut other.blocks);
            self.clusters.append(&mut other.clusters);
        } else {
            self.cut(tasks, middles, left, bits);
            self.cut(tasks, middles, right, bits);
        }
    }

    /// Primitives of one cell get codes within their own box.
    fn part_cell(&mut self, tasks: TaskPool, middles: &[Middle], entries: &mut [u64]) {
        let at = |&entry: &u64| {
            let found = middles.binary_search_by_key(&(entry as u32), Middle::number);
            middles[found.expect("all numbers are there")]
        };
        let inside: Vec<Middle> = entries.iter().map(at).collect();
        let single = TaskPool { parallel: false, ..tasks };
        let grid = Grid::around(single, &inside);
        if grid.per_unit == 0.0 {
            // In one point.
            return entries.chunks(CLUSTER).for_each(|some| self.push(some));
        }
        let mut finer = sorted(single, grid.entries(single, &inside));
        self.cut(tasks, middles, &mut finer, BITS);
    }

    /// Appends a cluster.
    fn push(&mut self, entries: &[u64]) {
        for some in entries.chunks(WIDTH) {
            let mut block = [INVALID_ID; WIDTH];
            block.iter_mut().zip(some).for_each(|(number, &entry)| *number = entry as u32);
            self.blocks.push(block);
        }
        self.clusters.push(entries.len().div_ceil(WIDTH) as u8);
    }
}

/// Cubes that space is cut into.
struct Grid {
    least: [f32; 3],
    /// Cells for each unit of twice a middle; 0 where all are one.
    per_unit: f32,
}

/// Added to a cell's number, less than 2^10, its lowest bits are those of the float.
const WHOLE: f32 = (1 << 23) as f32;

impl Grid {
    fn around(tasks: TaskPool, middles: &[Middle]) -> Self {
        let piece = |middles: &[Middle]| dispatch_two!(tasks.level, simd => range(simd, middles));
        let joint = |[low, high]: [[f32; 4]; 2], [other_low, other_high]: [[f32; 4]; 2]| {
            [[0, 1, 2, 3].map(|k| low[k].min(other_low[k])), [0, 1, 2, 3].map(|k| high[k].max(other_high[k]))]
        };
        let [low, high] = tasks.fold(middles, &piece, &joint);
        let longest = [0, 1, 2].map(|k| high[k] - low[k]).into_iter().fold(0.0, f32::max);
        let cells = (1 << (BITS / 3)) as f32 * 0.999;
        let per_unit = cells / longest;
        let per_unit = if per_unit.is_finite() && longest.is_finite() { per_unit } else { 0.0 };
        Self { least: [low[0], low[1], low[2]], per_unit }
    }

    /// Morton codes in the upper half, numbers in the lower one.
    fn entries(&self, tasks: TaskPool, middles: &[Middle]) -> Vec<u64> {
        let mut entries = vec![0; middles.len()];
        let piece = |entries: &mut [u64], middles: &[Middle]| {
            dispatch_two!(tasks.level, simd => {
                for (entries, some) in entries.chunks_mut(WIDTH).zip(middles.chunks(WIDTH)) {
                    entries.copy_from_slice(&self.eight(simd, some)[..some.len()]);
                }
            });
        };
        let pieces = Pieces::new(&mut entries, PIECE);
        for_each(tasks.parallel, pieces.count(), &|i| {
            let entries = &mut *pieces.lock(i);
            piece(entries, &middles[i * PIECE..i * PIECE + entries.len()]);
        });
        entries
    }

    /// Those of eight or fewer.
    #[inline(always)]
    fn eight<S: Simd>(&self, simd: S, some: &[Middle]) -> [u64; WIDTH] {
        let at = |lane: usize| f32x4::from_slice(simd, &some[lane.min(some.len() - 1)].0);
        let low = transposed([at(0), at(1), at(2), at(3)]);
        let high = transposed([at(4), at(5), at(6), at(7)]);
        let mut codes = [0u32; WIDTH];
        for (axis, (low, high)) in low.into_iter().zip(high).enumerate() {
            let cells = (low.combine(high) - self.least[axis]) * self.per_unit + WHOLE;
            for (code, cell) in codes.iter_mut().zip(cells.to_array()) {
                *code |= spread(cell.to_bits() & 1023) << axis;
            }
        }
        let mut entries = [0; WIDTH];
        for (lane, entry) in entries.iter_mut().enumerate() {
            let number = some[lane.min(some.len() - 1)].number();
            *entry = u64::from(codes[lane]) << 32 | u64::from(number);
        }
        entries
    }
}

/// Least and greatest coordinates; the fourth are anything.
#[inline(always)]
fn range<S: Simd>(simd: S, middles: &[Middle]) -> [[f32; 4]; 2] {
    let (mut low, mut high) = (f32x4::splat(simd, f32::INFINITY), f32x4::splat(simd, f32::NEG_INFINITY));
    for middle in middles {
        let middle = f32x4::from_slice(simd, &middle.0);
        low = low.min(middle);
        high = high.max(middle);
    }
    [low.to_array(), high.to_array()]
}

/// Puts two zeros between the ten bits of a number.
#[inline(always)]
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_accel_core::control::Watch;
    use gnurt_simd::Level;
    use gnurt_testkit::Random;

    #[test]
    fn every_third_bit() {
        assert_eq!(spread(0b11_1111_1111), 0x0924_9249, "all ten");
        assert_eq!(spread(0b10_0000_0101), 1 << 27 | 1 << 6 | 1, "three of them");
    }

    #[test]
    fn all_are_in_one_block_and_details_are_parted() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads start");
        let watch = Watch::new(&());
        let mut random = Random::new(1);
        // A large cloud, a small one in one of its cells, and a pile in one point of that.
        let mut points: Vec<[f32; 3]> = (0..4000).map(|_| random.point()).collect();
        points.extend((0..1000).map(|_| random.point().map(|x| 0.3 + 1e-5 * x)));
        points.extend([points[4500]; 300]);
        let middles: Vec<Middle> =
            points.iter().enumerate().map(|(i, &point)| Middle::new(point, 2 * i as u32)).collect();
        for level in Level::available() {
            let tasks = TaskPool { parallel: false, level, scale: 1.0, watch: &watch };
            let curve = Curve::through(tasks, &middles);
            let blocks = curve.clusters.iter().map(|&blocks| usize::from(blocks)).sum::<usize>();
            assert_eq!(blocks, curve.blocks.len(), "clusters hold all blocks at {level}");
            assert!(curve.clusters.iter().all(|blocks| (1..=8).contains(blocks)), "as many as a node has");
            let numbers = curve.blocks.iter().flatten().filter(|&&number| number != INVALID_ID);
            let mut numbers: Vec<u32> = numbers.copied().collect();
            numbers.sort_unstable();
            assert!(numbers.iter().copied().eq((0..5300).map(|i| 2 * i)), "each is there once at {level}");
            // Some 125 blocks hold the small cloud: by chance nearly all of them would reach through half of it.
            let small = |number: &&u32| (4000..5000).contains(&(**number / 2));
            let is_wide = |block: &&[u32; WIDTH]| {
                let inside: Vec<[f32; 3]> =
                    block.iter().filter(small).map(|&number| points[number as usize / 2]).collect();
                !inside.is_empty() && Aabb::around(&inside).extent()[0] > 0.5e-5
            };
            let wide = curve.blocks.iter().filter(is_wide).count();
            assert!(wide < 50, "{wide} blocks go through half of the detail at {level}");
            let tasks = TaskPool { parallel: true, ..tasks };
            let same = pool.install(|| Curve::through(tasks, &middles));
            assert_eq!(
                (same.blocks, same.clusters),
                (curve.blocks, curve.clusters),
                "threads make no difference"
            );
        }
    }
}
