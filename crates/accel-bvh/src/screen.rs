// SPDX-License-Identifier: GPL-3.0-or-later
//! The input of a wide BVH over triangles: the traceable ones, as references, or as centres for a fast build,
//! in one pass over them.
//! Space: object. Invariant: takes and counts the same triangles as `accel_core::valid_triangles`. Tests:
//! `tests::both_screens_agree`, `tests/brute_force.rs` of `gnurt-accel`.

use gnurt_accel_core::threads::map;
use std::ops::Range;

use gnurt_accel_core::clip::split_boxes;
use gnurt_accel_core::surfaces::{Mesh, Surfaces};
use gnurt_accel_core::{Aabb, BadPrimitives, Quality, Threads};
use gnurt_simd::{Level, Simd, dispatch_two, prefer_huge_pages, prelude::*};

use crate::build::{Lanes, Middle, Reference};
use crate::gather::{Eight, are_certain};
use crate::node::WIDTH;
use crate::primitives::Primitives;

/// Numbers that one thread processes: eights, and so whole quads. Tests have small scenes.
const PIECE: u32 = if cfg!(test) { 1 << 4 } else { 1 << 14 };

/// Triangles that can be traced.
pub struct Screen<'a> {
    pub(crate) surfaces: Surfaces<'a>,
    /// Their numbers, ascending; not for a fast build.
    pub(crate) good: Vec<u32>,
    /// Their boxes, each with its index in `good`.
    references: Vec<Reference>,
    /// The middles of their boxes, for a fast build.
    middles: Vec<Middle>,
    count: usize,
    /// The others.
    pub bad: BadPrimitives,
}

/// Of some numbers.
#[derive(Default)]
struct Piece {
    good: Vec<u32>,
    references: Vec<Reference>,
    middles: Vec<Middle>,
    bad: BadPrimitives,
}

impl Piece {
    /// Reserves memory for this many.
    fn reserve(&mut self, count: usize, is_fast: bool) {
        if is_fast {
            self.middles.reserve_exact(count);
            prefer_huge_pages(&self.middles);
        } else {
            self.good.reserve_exact(count);
            self.references.reserve_exact(count);
            prefer_huge_pages(&self.references);
        }
    }

    fn count(&self) -> usize {
        self.good.len() + self.middles.len()
    }
}

impl<'a> Screen<'a> {
    /// Visits all triangles once, for a build of this quality.
    #[must_use]
    pub fn over(surfaces: Surfaces<'a>, quality: Quality, threads: Threads) -> Self {
        let is_fast = quality == Quality::Fast;
        let (level, ranges) = (Level::best(), surfaces.numbers().collect::<Vec<Range<u32>>>());
        let check_range = |range: &Range<u32>, piece: &mut Piece| {
            dispatch_two!(level, simd => piece.add(simd, &surfaces, range.clone(), is_fast));
        };
        let piece = threads.run(|parallel| {
            let mut all = Piece::default();
            if !parallel {
                all.reserve(ranges.iter().map(Range::len).sum(), is_fast);
                ranges.iter().for_each(|range| check_range(range, &mut all));
                return all;
            }
            let cut = |range: &Range<u32>| {
                let end = range.end;
                range.clone().step_by(PIECE as usize).map(move |at| at..end.min(at.saturating_add(PIECE)))
            };
            let cut: Vec<Range<u32>> = ranges.iter().flat_map(cut).collect();
            let one = |range: &Range<u32>| {
                let mut piece = Piece::default();
                check_range(range, &mut piece);
                piece
            };
            let pieces: Vec<Piece> = map(parallel, cut.len(), |i| one(&cut[i]));
            all.reserve(pieces.iter().map(Piece::count).sum(), is_fast);
            for Piece { good, references, middles, bad } in pieces {
                let first = all.good.len() as u32;
                all.good.extend_from_slice(&good);
                all.references.extend(references.iter().map(|reference| reference.moved(first)));
                all.middles.extend_from_slice(&middles);
                all.bad += bad;
            }
            all
        });
        let count = piece.count();
        let Piece { good, references, middles, bad } = piece;
        Self { surfaces, good, references, middles, count, bad }
    }

    /// Most bytes that are taken for each triangle, for a build of this quality.
    #[must_use]
    pub fn bytes_each(quality: Quality) -> usize {
        match quality {
            Quality::Fast => size_of::<Middle>(),
            _ => size_of::<u32>() + size_of::<Reference>(),
        }
    }

    /// Bytes that stay taken through all of the build; others are counted there, as long as they are needed.
    #[must_use]
    pub fn retained_bytes(&self) -> usize {
        size_of_val(&self.good[..])
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The middles, for once.
    pub(crate) fn take_middles(&mut self) -> Vec<Middle> {
        std::mem::take(&mut self.middles)
    }

    /// The references, for once.
    pub(crate) fn take_references(&mut self) -> Vec<Reference> {
        std::mem::take(&mut self.references)
    }
}

impl Piece {
    /// Takes the good ones among `numbers` of one geometry.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, surfaces: &Surfaces, numbers: Range<u32>, is_fast: bool) {
        let mut mesh = Mesh::NONE;
        for first in numbers.clone().step_by(WIDTH) {
            let mut eight = [first; WIDTH];
            for (lane, number) in (0..).zip(&mut eight) {
                *number = (first + lane).min(numbers.end - 1);
            }
            let triangles = Eight::gather(simd, surfaces, &mut mesh, &eight, None);
            let are_certain = are_certain(simd, &triangles.rows(), &triangles.bounds());
            let count = WIDTH.min((numbers.end - first) as usize);
            let index = self.good.len() as u32;
            if are_certain {
                let [a, b, c] = &triangles.0;
                if is_fast {
                    let mut middles = [Middle::new([0.0; 3], 0); WIDTH];
                    for (lane, middle) in middles.iter_mut().enumerate() {
                        let low = a[lane].min(b[lane]).min(c[lane]);
                        let high = a[lane].max(b[lane]).max(c[lane]);
                        let [x, y, z, _] = (low + high).to_array();
                        *middle = Middle::new([x, y, z], eight[lane]);
                    }
                    self.middles.extend_from_slice(&middles[..count]);
                    continue;
                }
                let mut references = [Reference::ZERO; WIDTH];
                for (lane, reference) in references.iter_mut().enumerate() {
                    let low = a[lane].min(b[lane]).min(c[lane]);
                    let high = a[lane].max(b[lane]).max(c[lane]);
                    *reference = Lanes::of_corners((-low).to_array(), high.to_array(), index + lane as u32);
                }
                self.references.extend_from_slice(&references[..count]);
                self.good.extend_from_slice(&eight[..count]);
                continue;
            }
            for &number in &eight[..count] {
                if surfaces.judge(number, &mut self.bad) {
                    let bounds = Aabb::around(&surfaces.corners(number));
                    if is_fast {
                        self.middles.push(Middle::of(&bounds, number));
                        continue;
                    }
                    self.references.push(Reference::new(self.good.len() as u32, &bounds));
                    self.good.push(number);
                }
            }
        }
    }
}

impl Primitives for Screen<'_> {
    fn count(&self) -> usize {
        self.count
    }

    fn bounds(&self, i: usize) -> Aabb {
        Aabb::around(&self.surfaces.corners(self.good[i]))
    }

    fn split(&self, i: usize, cell: &Aabb, axis: usize, at: f32) -> Option<[Option<Aabb>; 2]> {
        Some(split_boxes(&self.surfaces.corners(self.good[i]), cell, axis, at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_accel_core::geometry::Numbering;
    use gnurt_accel_core::valid_triangles::ValidTriangles;
    use gnurt_accel_core::{Geometry, Quads, Triangles};
    use gnurt_testkit::Soup;

    #[test]
    fn both_screens_agree() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
        for seed in 0..20 {
            let soups = [Soup::degenerate(seed, 150), Soup::random(seed, 37, 0.5), Soup::grid(seed, 40)];
            let quads: Vec<[u32; 4]> = soups[0]
                .indices
                .windows(2)
                .map(|pair| [pair[0][0], pair[0][1], pair[1][1], pair[1][0]])
                .collect();
            let mut geometries: Vec<Geometry> = soups
                .iter()
                .map(|soup| Triangles { positions: &soup.positions, indices: &soup.indices }.into())
                .collect();
            geometries.push(Quads { positions: &soups[0].positions, indices: &quads }.into());
            let numbering = Numbering::new(&geometries);
            let valid_triangles = ValidTriangles::over(&geometries, &numbering, |_| true, Threads::Single);
            assert!(valid_triangles.bad.total() > 0, "there is something to find: {:?}", valid_triangles.bad);
            for threads in [Threads::Single, Threads::Pool(&pool)] {
                let surfaces = Surfaces::new(&geometries, &numbering, |_| true);
                let screen = Screen::over(surfaces, Quality::Medium, threads);
                assert_eq!(
                    (&screen.good, screen.bad),
                    (&valid_triangles.good, valid_triangles.bad),
                    "seed {seed}"
                );
                for (i, reference) in screen.references.iter().enumerate() {
                    assert_eq!(reference.number() as usize, i, "places in a row");
                    let bounds = Aabb::around(&valid_triangles.corners(valid_triangles.good[i]));
                    assert_eq!(reference.bounds(), bounds, "seed {seed}, triangle {i}");
                }
                let surfaces = Surfaces::new(&geometries, &numbering, |_| true);
                let fast = Screen::over(surfaces, Quality::Fast, threads);
                assert_eq!((fast.count(), fast.bad), (screen.count(), screen.bad), "seed {seed}");
                for (i, (middle, reference)) in fast.middles.iter().zip(&screen.references).enumerate() {
                    let same = Middle::of(&reference.bounds(), screen.good[i]);
                    assert_eq!(middle, &same, "seed {seed}, triangle {i}");
                }
            }
        }
    }
}
