// SPDX-License-Identifier: GPL-3.0-or-later
//! Building trees over primitives of one kind, and fitting them to primitives that have moved. Source: [WBS06] section 4
//! for the latter. Space: object.
//! Invariant: a tree that left something out when it was built, or would now, is not refitted. Tests: `tests/mixed.rs`,
//! `tests/refit.rs` of `gnurt-accel`.

use gnurt_accel_core::geometry::{Numbering, geometry_of};
use gnurt_accel_core::threads::{Pieces, map};
use gnurt_accel_core::{
    Aabb, BadPrimitives, BuildError, Geometry, INVALID_ID, Memory, Quality, RefitError, Threads,
};

use gnurt_simd::prefer_huge_pages;

use super::{BlockKind, Blocked, Shared, lanes};
use crate::build::build;
use crate::node::WIDTH;
use crate::primitives::Primitives;

/// Blocks that a thread fits at a time.
const PIECE: usize = 1 << 8;

/// The geometries of a tree, among all of an object.
pub struct Inputs<'a> {
    /// Those of the object.
    pub geometries: &'a [Geometry<'a>],
    /// Their numbers.
    pub numbering: &'a Numbering,
    /// Which of them are the tree's; all of them are of its kind.
    pub accept: &'a (dyn Fn(&Geometry) -> bool + Sync),
}

impl<'a> Inputs<'a> {
    /// The tree's geometries, and their indices.
    pub(crate) fn own(&self) -> impl Iterator<Item = (usize, &'a Geometry<'a>)> {
        self.geometries.iter().enumerate().filter(|(_, geometry)| (self.accept)(geometry))
    }

    /// How many primitives they have.
    fn count(&self) -> u64 {
        self.own().map(|(i, _)| self.numbering.range(i).len() as u64).sum()
    }

    /// Calls `each` with all items and the numbers of the first primitives in them, which ascend; untraceable primitives are
    /// counted. Returns how many primitives can be traced.
    fn all_items<B: BlockKind>(&self, bad: &mut BadPrimitives, mut each: impl FnMut(u32, B::Item)) -> u64 {
        let mut primitives = 0;
        for (i, geometry) in self.own() {
            let numbers = self.numbering.range(i);
            let mut own = |prim_id, item| each(numbers.start + prim_id, item);
            primitives += B::all_items(&geometry.kind, numbers.len() as u32, bad, &mut own);
        }
        primitives
    }

    pub(crate) fn shared<B: BlockKind>(&self) -> Shared<B> {
        let own = self.own();
        Shared(own.map(|(i, geometry)| (self.numbering.starts[i], B::data(&geometry.kind))).collect())
    }
}

/// The pieces that can be traced, and the numbers of their primitives.
struct Gathered<B: BlockKind> {
    items: Vec<B::Item>,
    numbers: Vec<u32>,
}

impl<B: BlockKind> Primitives for Gathered<B> {
    fn count(&self) -> usize {
        self.items.len()
    }

    fn bounds(&self, i: usize) -> Aabb {
        B::bounds(&self.items[i])
    }
}

impl<B: BlockKind> Blocked<B> {
    /// Over all primitives; untraceable ones are counted.
    ///
    /// # Errors
    /// There are too many.
    pub(crate) fn build(
        inputs: &Inputs,
        bad: &mut BadPrimitives,
        quality: Quality,
        memory: Memory,
        threads: Threads,
    ) -> Result<Self, BuildError> {
        // Pieces may be more; their memory is taken as it fills.
        let most = 2 * inputs.count() as usize / B::IN_LANE;
        let mut gathered =
            Gathered::<B> { items: Vec::with_capacity(most), numbers: Vec::with_capacity(most) };
        prefer_huge_pages(&gathered.items);
        let primitives = inputs.all_items::<B>(bad, |number, item| {
            gathered.items.push(item);
            gathered.numbers.push(number);
        });
        let mut tree = build(&gathered, quality, threads)?;
        tree.settle(memory);
        let mut stats = tree.measure();
        stats.primitives = primitives;
        let block = |indices: &[u32; WIDTH]| {
            let mut block = B::empty();
            block.frame(&indices.map(|i| gathered.items.get(i as usize)));
            for (lane, &i) in indices.iter().enumerate().filter(|&(_, &i)| i != INVALID_ID) {
                block.set(lane, &gathered.items[i as usize], gathered.numbers[i as usize]);
            }
            block
        };
        let mut blocks = Vec::with_capacity(tree.blocks.len());
        prefer_huge_pages(&blocks);
        blocks.extend(std::mem::take(&mut tree.blocks).iter().map(block));
        Ok(Self { blocks, shared: inputs.shared(), greatest: tree.greatest(), tree, stats })
    }

    /// Fits the tree to primitives that have moved, or to others of the same number.
    ///
    /// # Errors
    /// That it has to be built again. It is of no use then.
    pub(crate) fn refit(&mut self, inputs: &Inputs, threads: Threads) -> Result<(), RefitError> {
        if inputs.count() != self.stats.primitives {
            return Err(RefitError::OtherPrimitives);
        }
        self.shared = inputs.shared();
        let mut several = Vec::new();
        if B::IN_LANE > 1 {
            let keep = |number, item| several.push((number, item));
            if inputs.all_items::<B>(&mut BadPrimitives::default(), keep) != inputs.count() {
                return Err(RefitError::OtherPrimitives);
            }
        }
        let fit = |block: &mut B| {
            let mut items = [const { None }; WIDTH];
            for (lane, number) in lanes(block) {
                let geometry = geometry_of(&inputs.numbering.starts, number);
                let kind = &inputs.geometries[geometry].kind;
                if !B::is_kind_of(kind) {
                    return Err(RefitError::OtherGeometry);
                }
                let item = if B::IN_LANE > 1 {
                    let found = several.binary_search_by_key(&number, |&(number, _)| number);
                    found.ok().map(|at| several[at].1.clone())
                } else {
                    block.moved(lane, kind, number - inputs.numbering.starts[geometry])
                };
                items[lane] = Some(item.ok_or(RefitError::OtherPrimitives)?);
            }
            block.frame(&items.each_ref().map(Option::as_ref));
            let mut all = Aabb::EMPTY;
            for (lane, number) in lanes(block) {
                if let Some(item) = &items[lane] {
                    block.set(lane, item, number);
                    all = all.union(&B::bounds(item));
                }
            }
            Ok(all)
        };
        let Self { tree, blocks, .. } = self;
        let cost = threads.run(|parallel| {
            let pieces = Pieces::new(blocks, PIECE);
            let fit_all = |i| pieces.lock(i).iter_mut().map(fit).collect::<Result<Vec<Aabb>, RefitError>>();
            let boxes = map(parallel, pieces.count(), fit_all).into_iter().collect::<Result<Vec<_>, _>>()?;
            Ok(tree.refit(&boxes.concat(), parallel, &mut Vec::new()))
        })?;
        (self.greatest, self.stats.sah_cost) = (self.tree.greatest(), cost);
        Ok(())
    }
}
