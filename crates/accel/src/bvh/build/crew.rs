// SPDX-License-Identifier: GPL-3.0-or-later
//! Steps of a build that are worth several threads: binning and parting many references.
//! Source: original; pieces that are binned on their own are those of [Wald07]'s parallel build.
//! Invariant: what is cut where depends on numbers of references, not of threads, so that all build the same tree.
//! Proof: `super::tests`.

use gnurt_simd::{Level, dispatch};

use super::bins::{Bins, Mapping, Split};
use super::partition::{Buffer, Parted, partition};
use super::reference::{Lanes, Part, Reference};
use crate::control::Watch;

/// More references than this are binned and parted in pieces. Tests have small scenes.
const PIECE: usize = if cfg!(test) { 1 << 9 } else { 1 << 15 };

/// Who builds, and how large things are.
#[derive(Clone, Copy)]
pub(super) struct Crew<'a> {
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

impl Crew<'_> {
    /// Runs two jobs, at the same time where there are threads.
    pub(super) fn both<A: Send, B: Send>(
        self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        if self.parallel { rayon::join(a, b) } else { (a(), b()) }
    }

    /// All of `references` as one part.
    pub(super) fn around(self, references: &[Reference]) -> Part {
        if references.len() <= PIECE {
            return dispatch!(self.level, simd => Part::around(simd, references, 0, references.len()));
        }
        let (left, right) = references.split_at(references.len() / 2);
        let (left, right) = self.both(|| self.around(left), || self.around(right));
        Part {
            start: 0,
            end: references.len(),
            bounds: left.bounds.union(&right.bounds),
            middles: left.middles.union(&right.middles),
        }
    }

    /// What is in the bins; pieces are binned on their own.
    fn bin(self, references: &[Reference], mapping: &Mapping) -> Bins {
        if references.len() <= PIECE {
            let mut bins = Bins::EMPTY;
            dispatch!(self.level, simd => bins.add(simd, references, mapping));
            return bins;
        }
        let (left, right) = references.split_at(references.len() / 2);
        let (mut bins, others) = self.both(|| self.bin(left, mapping), || self.bin(right, mapping));
        bins.merge(&others);
        bins
    }

    /// Parts pieces on their own, then puts them together.
    fn partition(self, references: &mut [Reference], mapping: &Mapping, split: &Split) -> Parted {
        if references.len() <= PIECE {
            let mut buffer = Buffer::EMPTY;
            return dispatch!(self.level, simd => partition(simd, references, mapping, split, &mut buffer));
        }
        // Each half is parted; then what the first has on its right changes places with the second's left.
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
        dispatch!(self.level, simd => {
            if references.len() <= PIECE {
                bins.clone_from(&Bins::EMPTY);
                bins.add(simd, references, &mapping);
            }
            let split = bins.best_split(simd, self.scale)?;
            Some(Found { mapping, split, bounds: bins.sides(simd, &split) })
        })
    }

    /// Parts `references` by what was found.
    pub(super) fn part(self, references: &mut [Reference], found: &Found, buffer: &mut Buffer) -> Parted {
        let Found { mapping, split, .. } = found;
        if references.len() > PIECE {
            return self.partition(references, mapping, split);
        }
        dispatch!(self.level, simd => partition(simd, references, mapping, split, buffer))
    }
}
