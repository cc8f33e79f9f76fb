// SPDX-License-Identifier: GPL-3.0-or-later
//! Steps of a build that are worth several threads: binning and parting many references.
//! Pieces that are binned on their own are those of [Wald07]'s parallel build.
//! Invariant: cuts depend on numbers of references, never of threads, so that any number of threads builds
//! the same tree.
//! Tests: `super::tests`.

use gnurt_accel_core::threads::{Pieces, both, map};
use gnurt_simd::{Level, dispatch_two};
use rayon::prelude::*;

use super::bins::{Bins, Mapping, Split};
use super::partition::{Buffer, Parted, partition};
use super::reference::{Lanes, Part, Reference};
use super::spatial::{Grid, Plane, Slabs, cut};
use crate::primitives::Primitives;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::threads::extend;

/// More references than this are binned and parted in pieces. Tests have small scenes.
const PIECE: usize = if cfg!(test) { 1 << 9 } else { 1 << 15 };

/// Threads of a build, and thresholds of sizes.
#[derive(Clone, Copy)]
pub(super) struct TaskPool<'a> {
    pub(super) parallel: bool,
    pub(super) level: Level,
    /// Sides of boxes are multiplied with this before their area is taken.
    pub(super) scale: f32,
    pub(super) watch: &'a Watch<'a>,
}

/// A split, how it was found, and the boxes on its sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    mapping: Mapping,
    pub(super) split: Split,
    pub(super) bounds: [Lanes; 2],
}

impl TaskPool<'_> {
    /// The same, where areas are those within the box around all: its longest side is 1.
    pub(super) fn scaled_to(self, root: &Part) -> Self {
        let longest = root.bounds.bounds().extent().into_iter().fold(f64::from(f32::MIN_POSITIVE), f64::max);
        Self { scale: (1.0 / longest) as f32, ..self }
    }

    /// Runs two jobs, at the same time where there are threads.
    pub(super) fn both<A: Send, B: Send>(
        self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        both(self.parallel, a, b)
    }

    /// Appends `count` values to `all`.
    pub(super) fn extend<T: Send>(
        self,
        all: &mut Vec<T>,
        count: usize,
        value: impl Fn(usize) -> T + Send + Sync,
    ) {
        extend(self.parallel, all, count, value);
    }

    /// Puts all of `pieces` one after another into `all`, which is empty.
    pub(super) fn concat<T: Copy + Send + Sync>(self, pieces: &[Vec<T>], all: &mut Vec<T>) {
        if !self.parallel {
            all.reserve_exact(pieces.iter().map(Vec::len).sum());
            pieces.iter().for_each(|piece| all.extend_from_slice(piece));
            return;
        }
        let ends: Vec<usize> = pieces
            .iter()
            .scan(0, |end, piece| {
                *end += piece.len();
                Some(*end)
            })
            .collect();
        let count = ends.last().copied().unwrap_or(0);
        let copies = (0..count).into_par_iter().with_min_len(1024).map_init(
            // Of the piece that was last copied from: where it starts and ends.
            || (0, 0..0),
            |(piece, range), i| {
                if !range.contains(&i) {
                    *piece = ends.partition_point(|&end| end <= i);
                    *range = ends[*piece] - pieces[*piece].len()..ends[*piece];
                }
                pieces[*piece][i - range.start]
            },
        );
        all.par_extend(copies);
    }

    /// A fold over `references`: pieces first, then pairs of neighbours.
    pub(super) fn fold<R: Sync, T: Send>(
        self,
        references: &[R],
        piece: &(impl Fn(&[R]) -> T + Sync),
        joint: &(impl Fn(T, T) -> T + Sync),
    ) -> T {
        if references.len() <= PIECE {
            return piece(references);
        }
        let (left, right) = references.split_at(references.len() / 2);
        let (left, right) = self.both(|| self.fold(left, piece, joint), || self.fold(right, piece, joint));
        joint(left, right)
    }

    /// All of `references` as one part.
    pub(super) fn around(self, references: &[Reference]) -> Part {
        let piece = |piece: &[Reference]| dispatch_two!(self.level, simd => Part::around(simd, piece, 0, piece.len()));
        let joint = |left: Part, right: Part| Part {
            start: 0,
            end: left.end + right.end,
            bounds: left.bounds.union(&right.bounds),
            middles: left.middles.union(&right.middles),
        };
        self.fold(references, &piece, &joint)
    }

    /// The contents of the bins.
    fn bin(self, references: &[Reference], mapping: &Mapping) -> Bins {
        let piece = |piece: &[Reference]| {
            let mut bins = Bins::EMPTY;
            dispatch_two!(self.level, simd => bins.add(simd, piece, mapping));
            bins
        };
        let joint = |mut bins: Bins, others: Bins| {
            bins.merge(&others);
            bins
        };
        self.fold(references, &piece, &joint)
    }

    /// Parts pieces on their own, then puts them together.
    fn partition(self, references: &mut [Reference], mapping: &Mapping, split: &Split) -> Parted {
        if references.len() <= PIECE {
            let mut buffer = Buffer::EMPTY;
            return dispatch_two!(self.level, simd => partition(simd, references, mapping, split, &mut buffer));
        }
        // Each half is partitioned; then the right side of the first half is swapped with the left side of
        // the second.
        let (first, second) = references.split_at_mut(references.len() / 2);
        let (a, b) =
            self.both(|| self.partition(first, mapping, split), || self.partition(second, mapping, split));
        let wrong = &mut first[a.left..];
        let swapped = wrong.len().min(b.left);
        self.swap(&mut wrong[..swapped], &mut second[b.left - swapped..b.left]);
        let middles = [0, 1].map(|side: usize| a.middles[side].union(&b.middles[side]));
        Parted { left: a.left + b.left, middles }
    }

    fn swap(self, a: &mut [Reference], b: &mut [Reference]) {
        if a.len() <= PIECE {
            return a.swap_with_slice(b);
        }
        let (a, a_rest) = a.split_at_mut(a.len() / 2);
        let (b, b_rest) = b.split_at_mut(a.len());
        self.both(|| self.swap(a, b), || self.swap(a_rest, b_rest));
    }

    /// The best split of all of `references`, which `part` describes.
    pub(super) fn find(self, references: &[Reference], part: &Part, bins: &mut Bins) -> Option<Found> {
        let mapping = Mapping::new(&part.middles);
        if references.len() > PIECE {
            *bins = self.bin(references, &mapping);
        }
        dispatch_two!(self.level, simd => {
            if references.len() <= PIECE {
                bins.clone_from(&Bins::EMPTY);
                bins.add(simd, references, &mapping);
            }
            let split = bins.best_split(simd, self.scale)?;
            Some(Found { mapping, split, bounds: bins.sides(simd, &split) })
        })
    }

    /// Partitions `references` by a split.
    pub(super) fn part(self, references: &mut [Reference], found: &Found, buffer: &mut Buffer) -> Parted {
        let Found { mapping, split, .. } = found;
        if references.len() > PIECE {
            return self.partition(references, mapping, split);
        }
        dispatch_two!(self.level, simd => partition(simd, references, mapping, split, buffer))
    }

    /// The contents of the slabs.
    fn slabs(self, references: &[Reference], grid: &Grid) -> Slabs {
        let piece = |piece: &[Reference]| {
            let mut slabs = Slabs::EMPTY;
            dispatch_two!(self.level, simd => slabs.add(simd, piece, grid));
            slabs
        };
        let joint = |mut slabs: Slabs, others: Slabs| {
            slabs.merge(&others);
            slabs
        };
        self.fold(references, &piece, &joint)
    }

    /// The best plane through the box `whole` around `references`, with at most `capacity` parts.
    pub(super) fn find_plane(
        self,
        references: &[Reference],
        whole: &Lanes,
        capacity: usize,
    ) -> Option<Plane> {
        let grid = Grid::new(whole);
        let slabs = self.slabs(references, &grid);
        dispatch_two!(self.level, simd => slabs.best_plane(simd, &grid, capacity, self.scale))
    }

    /// Cuts `references` by a plane: the left ones stay in front, `right` takes the others. Returns the
    /// number of left ones.
    pub(super) fn cut(
        self,
        primitives: &dyn Primitives,
        references: &mut [Reference],
        plane: &Plane,
        right: &mut Vec<Reference>,
    ) -> usize {
        right.clear();
        if !self.parallel || references.len() <= PIECE {
            return cut(primitives, references, plane, right);
        }
        let pieces = Pieces::new(references, PIECE);
        let one = |i| {
            let mut right = Vec::new();
            (cut(primitives, &mut pieces.lock(i), plane, &mut right), right)
        };
        let (lefts, rights): (Vec<usize>, Vec<Vec<Reference>>) =
            map(true, pieces.count(), one).into_iter().unzip();
        let mut left = 0;
        for (piece, count) in lefts.into_iter().enumerate() {
            let start = piece * PIECE;
            references.copy_within(start..start + count, left);
            left += count;
        }
        self.concat(&rights, right);
        left
    }
}
