// SPDX-License-Identifier: GPL-3.0-or-later
//! The leaf blocks of a wide BVH over triangles, as tests take them, in less memory, or shared by poses.
//! Invariant: there are blocks, pools or a pose, one of them. Tests: `tests/brute_force.rs`.

use gnurt_simd::{Level, Simd, dispatch_two, prefer_huge_pages, prefetch};

use gnurt_accel_core::blocks::TriangleBlock;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::surfaces::Mesh;
use gnurt_accel_core::threads::{extend, extend_two};
use gnurt_accel_core::{Aabb, BuildError, INVALID_ID, Memory, Threads};

use crate::build::Lanes;
use crate::gather::{Eight, store};
use crate::node::{Child, WIDTH};
use crate::pools::{Filling, Pools};
use crate::pose::PosedLeaves;
use crate::screen::Screen;
use crate::tree::Tree;

/// Blocks between two checks for a stop, and the distance of prefetches of a block's triangles.
const STEP: usize = 1 << 10;
const AHEAD: usize = 4;

/// Blocks by their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Leaves {
    pub(super) blocks: Vec<TriangleBlock>,
    pub(super) pools: Pools,
    pub(super) posed: Option<PosedLeaves>,
}

impl Leaves {
    /// From numbers of triangles. Their memory stays counted.
    pub(super) fn build(
        screen: &Screen,
        memory: Memory,
        in_blocks: &[[u32; WIDTH]],
        threads: Threads,
        watch: &Watch,
    ) -> Result<Self, BuildError> {
        let mut leaves = Self::default();
        let level = Level::best();
        let block =
            |numbers: &[u32; WIDTH]| dispatch_two!(level, simd => block(simd, screen, numbers, None).0);
        if memory == Memory::Fast {
            watch.take(size_of::<TriangleBlock>() * in_blocks.len());
            watch.result()?;
            leaves.blocks = Vec::with_capacity(in_blocks.len());
            prefer_huge_pages(&leaves.blocks);
            let blocks = &mut leaves.blocks;
            threads.run(|parallel| extend(parallel, blocks, in_blocks.len(), |i| block(&in_blocks[i])));
            return Ok(leaves);
        }
        let mut filling = Filling::new(in_blocks.len());
        let mut held = 0;
        for some in in_blocks.chunks(1 << 12) {
            watch.recount(&mut held, filling.memory_bytes());
            watch.result()?;
            for numbers in some {
                let numbers = without_gaps(numbers);
                filling.push(&numbers, |number| screen.surfaces.corners(number));
            }
        }
        leaves.pools = filling.finish();
        watch.recount(&mut held, leaves.pools.memory_bytes());
        watch.result()?;
        Ok(leaves)
    }

    /// The same with the boxes of blocks.
    pub(super) fn boxed(
        screen: &Screen,
        memory: Memory,
        in_blocks: &[[u32; WIDTH]],
        threads: Threads,
        watch: &Watch,
    ) -> Result<(Vec<Lanes>, Self), BuildError> {
        let count = in_blocks.len();
        let mut boxes = Vec::with_capacity(count);
        if memory == Memory::Compact {
            let leaves = Self::build(screen, memory, in_blocks, threads, watch)?;
            let around = |numbers: &[u32; WIDTH]| {
                let corners = without_gaps(numbers).map(|number| screen.surfaces.corners(number));
                Lanes::new(0, &Aabb::around(corners.as_flattened()))
            };
            threads.run(|parallel| extend(parallel, &mut boxes, count, |i| around(&in_blocks[i])));
            return Ok((boxes, leaves));
        }
        watch.take(size_of::<TriangleBlock>() * count);
        watch.result()?;
        let mut leaves = Self { blocks: Vec::with_capacity(count), ..Self::default() };
        prefer_huge_pages(&leaves.blocks);
        let level = Level::best();
        let boxed = |i: usize| {
            if i.is_multiple_of(STEP) {
                watch.advance(STEP.min(count - i) * WIDTH);
                watch.go_on();
            }
            let ahead = in_blocks.get(i + AHEAD);
            dispatch_two!(level, simd => block(simd, screen, &in_blocks[i], ahead))
        };
        let blocks = &mut leaves.blocks;
        threads.run(|parallel| extend_two(parallel, blocks, &mut boxes, count, boxed));
        Ok((boxes, leaves))
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.blocks.len()
            + self.pools.blocks.len()
            + self.posed.as_ref().map_or(0, |posed| posed.blocks().len())
    }

    /// Block `index`: where it lies in memory as tests take it, or expanded into `buffer`.
    ///
    /// Compact leaves have no such blocks, and are detected by the check of the index, which is needed
    /// anyway.
    #[inline(always)]
    pub(super) fn block<'a, S: Simd>(
        &'a self,
        simd: S,
        index: usize,
        buffer: &'a mut Option<TriangleBlock>,
    ) -> &'a TriangleBlock {
        match self.blocks.get(index) {
            Some(block) => block,
            None => {
                let expanded = buffer.insert(TriangleBlock::ZERO);
                self.expand(simd, index, expanded);
                expanded
            }
        }
    }

    /// Block `index` of a compact tree.
    #[inline(always)]
    pub(super) fn expand<S: Simd>(&self, simd: S, index: usize, into: &mut TriangleBlock) {
        match &self.posed {
            None => self.pools.expand(simd, index, into),
            Some(posed) => posed.expand(simd, index, into),
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        let posed = self.posed.as_ref().map_or(0, PosedLeaves::memory_bytes);
        size_of_val(&self.blocks[..]) + self.pools.memory_bytes() + posed
    }
}

/// The first number in place of those that are `INVALID_ID`; the first is not.
fn without_gaps(numbers: &[u32; WIDTH]) -> [u32; WIDTH] {
    numbers.map(|number| if number == INVALID_ID { numbers[0] } else { number })
}

/// A block of these triangles, and its box; `INVALID_ID` where there is none, which is not so for the first.
#[inline(always)]
fn block<S: Simd>(
    simd: S,
    screen: &Screen,
    numbers: &[u32; WIDTH],
    ahead: Option<&[u32; WIDTH]>,
) -> (TriangleBlock, Lanes) {
    let numbers = without_gaps(numbers);
    let mut block = TriangleBlock { numbers, ..TriangleBlock::ZERO };
    let triangles = Eight::gather(simd, &screen.surfaces, &mut { Mesh::NONE }, &numbers, ahead);
    store(&triangles.rows(), &mut block);
    (block, Lanes::new(0, &triangles.bounds()))
}

/// Prefetches the memory of the next visit: a node, or the first block of a leaf. Not for compact trees.
#[inline(always)]
pub(super) fn prefetch_child(tree: &Tree, leaves: &Leaves, child: Child) {
    if child.is_leaf() {
        prefetch(&leaves.blocks, child.blocks().start);
    } else {
        prefetch(&tree.nodes, child.index());
    }
}
