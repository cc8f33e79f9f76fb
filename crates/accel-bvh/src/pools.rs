// SPDX-License-Identifier: GPL-3.0-or-later
//! Leaf blocks in less memory: neighbours share a pool of corners, each of which is stored once.
//! Space: object.
//!
//! ```text
//!  block, 64 bytes = a cache line                                        corners, 12 bytes each
//!       | a: 8 bytes | b: 8 bytes | c: 8 bytes | pool | numbers |  --->  | x y z | x y z | ...   up to 85 of one pool
//! ```
//!
//! The bytes give, by corner and slot, its offset in the pool, in floats. Spare slots repeat the first
//! triangle. A pool is closed when one more block might not fit into it, so the data of a block lies within
//! 259 floats.
//! Invariant: expanded, a block has its original corners and numbers, bit for bit. Tests: `tests`,
//! `tests/brute_force.rs`.

use gnurt_simd::{Simd, f32x4, prefer_huge_pages, prelude::*};

use gnurt_accel_core::blocks::{TriangleBlock, WIDTH};

/// Floats that may be read from the start of a pool on, for any bytes: four from the last corner on.
const WINDOW: usize = u8::MAX as usize + 4;
/// Corners of a pool: the last one's offset must fit in a byte.
const MOST: usize = u8::MAX as usize / 3;

/// Eight triangles, whose corners are in a pool.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct PooledBlock {
    /// By corner, then by slot of the block.
    pub(super) offsets: [[u8; WIDTH]; 3],
    /// First float of the pool.
    pub(super) pool: u64,
    /// Numbers in the object.
    pub(super) numbers: [u32; WIDTH],
}

/// Blocks by their numbers, and the corners of all of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pools {
    pub(super) blocks: Vec<PooledBlock>,
    pub(super) corners: Vec<f32>,
}

impl Pools {
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&self.blocks[..]) + size_of_val(&self.corners[..])
    }

    /// Block `index` in the form of the tests.
    ///
    /// A separate function for the compiler, once for each level. The result goes to memory and not through
    /// registers twice, because a block is larger than all of them. Cold, so that traversals of tiles through
    /// fast trees keep their registers.
    #[cold]
    #[inline(never)]
    pub(crate) fn expand<S: Simd>(&self, simd: S, index: usize, into: &mut TriangleBlock) {
        simd.vectorize(
            #[inline(always)]
            || {
                let Some(block) = self.blocks.get(index) else {
                    panic!(
                        "a tree of {} compact blocks is damaged: it refers to block {index}",
                        self.blocks.len()
                    );
                };
                let rest = &self.corners[block.pool as usize..];
                let padded;
                let window = match rest.first_chunk() {
                    Some(window) => window,
                    None => {
                        padded = with_zeros(rest);
                        &padded
                    }
                };
                expand(simd, block, window, into);
            },
        );
    }
}

/// The end of the corners, and zeros behind it.
#[cold]
fn with_zeros(rest: &[f32]) -> [f32; WINDOW] {
    let mut padded = [0.0; WINDOW];
    padded[..rest.len()].copy_from_slice(rest);
    padded
}

#[inline(always)]
fn expand<S: Simd>(simd: S, block: &PooledBlock, pool: &[f32; WINDOW], into: &mut TriangleBlock) {
    for (rows, offsets) in into.corners.iter_mut().zip(&block.offsets) {
        let at = |lane: usize| {
            let at = usize::from(offsets[lane]);
            f32x4::from_slice(simd, &pool[at..at + 4])
        };
        let low = transposed([at(0), at(1), at(2), at(3)]);
        let high = transposed([at(4), at(5), at(6), at(7)]);
        for (row, (low, high)) in rows.iter_mut().zip(low.into_iter().zip(high)) {
            low.combine(high).store_slice(row);
        }
    }
    into.numbers = block.numbers;
}

/// From points, with anything behind their three coordinates, to coordinates.
#[inline(always)]
pub(crate) fn transposed<S: Simd>([a, b, c, d]: [f32x4<S>; 4]) -> [f32x4<S>; 3] {
    let (ac, bd) = (a.zip_low(c), b.zip_low(d));
    [ac.zip_low(bd), ac.zip_high(bd), a.zip_high(c).zip_low(b.zip_high(d))]
}

/// Pools that are being filled.
pub(super) struct Filling {
    pools: Pools,
    /// Where the last one starts.
    pool: usize,
    /// Corners of the last pool by a hash of their bits, counted from 1; 0 is nothing.
    known: [u8; 256],
}

impl Filling {
    /// With memory for this many blocks.
    pub(super) fn new(blocks: usize) -> Self {
        let mut pools = Pools { blocks: Vec::with_capacity(blocks), corners: Vec::new() };
        prefer_huge_pages(&pools.blocks);
        // Most blocks bring four corners or fewer that are new.
        pools.corners.reserve_exact(12 * blocks);
        prefer_huge_pages(&pools.corners);
        Self { pools, pool: 0, known: [0; 256] }
    }

    /// Puts a block behind the others.
    pub(super) fn push(&mut self, numbers: &[u32; WIDTH], corners: impl Fn(u32) -> [[f32; 3]; 3]) {
        if (self.pools.corners.len() - self.pool) / 3 + 3 * WIDTH > MOST {
            self.pool = self.pools.corners.len();
            self.known = [0; 256];
        }
        let pool = self.pool as u64;
        let mut block = PooledBlock { offsets: [[0; WIDTH]; 3], pool, numbers: *numbers };
        for (lane, &number) in numbers.iter().enumerate() {
            if lane > 0 && number == numbers[0] {
                block.offsets.iter_mut().for_each(|offsets| offsets[lane] = offsets[0]);
                continue;
            }
            for (offsets, corner) in block.offsets.iter_mut().zip(corners(number)) {
                offsets[lane] = self.offset(corner);
            }
        }
        self.pools.blocks.push(block);
    }

    /// Where in the last pool a corner is. It is put there if it was not.
    fn offset(&mut self, corner: [f32; 3]) -> u8 {
        let bits = corner.map(f32::to_bits);
        let [x, y, z] = bits;
        let mixed = (x.wrapping_mul(0x9e37_79b1) ^ y).wrapping_mul(0x85eb_ca6b) ^ z;
        let mut slot = (mixed.wrapping_mul(0xc2b2_ae35) >> 24) as usize;
        // At most a third of the slots is taken.
        while self.known[slot] != 0 {
            let offset = 3 * (self.known[slot] - 1);
            let at = self.pool + usize::from(offset);
            if [0, 1, 2].map(|k| self.pools.corners[at + k].to_bits()) == bits {
                return offset;
            }
            slot = (slot + 1) % self.known.len();
        }
        let offset = self.pools.corners.len() - self.pool;
        self.known[slot] = (offset / 3) as u8 + 1;
        self.pools.corners.extend(corner);
        offset as u8
    }

    /// Bytes that are taken.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of::<PooledBlock>() * self.pools.blocks.capacity()
            + size_of::<f32>() * self.pools.corners.capacity()
    }

    /// The pools, without excess memory.
    pub(super) fn finish(mut self) -> Pools {
        self.pools.corners.shrink_to_fit();
        self.pools
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_simd::{Level, dispatch};
    use gnurt_testkit::Random;

    /// Triangle `number` of a strip that winds about, or of a soup.
    fn triangle(number: u32) -> [[f32; 3]; 3] {
        let corner = |i: u32| Random::new(u64::from(i)).point().map(|x| if x < 0.0 { -0.0 } else { x });
        let first = if number < 1000 { number } else { 3 * number };
        [corner(first), corner(first + 1), corner(first + 2)]
    }

    #[test]
    fn what_goes_in_comes_out() {
        assert_eq!(size_of::<PooledBlock>(), 64, "a cache line");
        let first = |block: u32| 7 * block + if block % 20 < 10 { 0 } else { 1000 };
        let numbers: Vec<[u32; WIDTH]> = (0..140)
            .map(|block| {
                let count = 1 + block % 8;
                [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| first(block) + if lane < count { lane } else { 0 })
            })
            .collect();
        let mut filling = Filling::new(numbers.len());
        numbers.iter().for_each(|numbers| filling.push(numbers, triangle));
        let pools = filling.finish();
        let all: usize = numbers.iter().map(|n| n.iter().filter(|&&m| m != n[0]).count() + 1).sum();
        assert!(pools.corners.len() < 8 * all, "{} floats for {all} triangles", pools.corners.len());
        for level in Level::available() {
            for (i, numbers) in numbers.iter().enumerate() {
                let mut block = TriangleBlock::ZERO;
                dispatch!(level, simd => pools.expand(simd, i, &mut block));
                assert_eq!(block.numbers, *numbers, "block {i} at {level}");
                for (lane, &number) in numbers.iter().enumerate() {
                    let bits = |corners: [[f32; 3]; 3]| corners.map(|corner| corner.map(f32::to_bits));
                    let expanded = block.corners_of(lane, [0, 1, 2]);
                    assert_eq!(bits(expanded), bits(triangle(number)), "block {i}, place {lane} at {level}");
                }
            }
        }
    }
}
