// SPDX-License-Identifier: GPL-3.0-or-later
//! Lists of lobes of sixteen points of a batch, written lobe by lobe for many of them at once, for callers
//! that know the common lobes. Points have lists of different lengths; a lobe goes to the end of each point's
//! own list.
//! Invariant: equals the result of [`Lobes`] for the same lobes in the same order, point by point. Tests:
//! crates/sl-shading/tests/scripts/lanes.rs.

use glam::Vec3;

use super::batch::{Block, ClosureBatch, LobeRows, numbers};
use super::lobe::Lobe;
use super::lobes::{Lobes, MOST};
use crate::lanes::{LANES, LanesOf};

/// A number of each point.
type Row = [f32; LANES];

/// Where each point's list ends.
pub type Ends = [u8; LANES];

/// Sixteen points' lists. Points are named by bits.
#[derive(Debug)]
pub struct Lists<'a> {
    block: &'a mut Block,
    ends: Ends,
    /// By position, points that have a lobe there.
    taken: [u32; MOST],
    /// Points of which a lobe was left out.
    full: u32,
    /// Points with a lobe that has its own normal.
    bent: u32,
}

/// Ones for the points of a set.
fn mask(lanes: u32) -> [u32; LANES] {
    std::array::from_fn(|i| 0_u32.wrapping_sub(lanes >> i & 1))
}

/// Writes the points of a mask.
#[inline(always)]
fn blend(row: &mut Row, mask: &[u32; LANES], x: &Row) {
    for ((row, &mask), x) in row.iter_mut().zip(mask).zip(x) {
        *row = f32::from_bits(x.to_bits() & mask | row.to_bits() & !mask);
    }
}

/// Bits of the points for which this holds.
#[inline(always)]
fn bits(holds: impl Fn(usize) -> bool) -> u32 {
    (0..LANES).fold(0, |bits, i| bits | u32::from(holds(i)) << i)
}

impl<'a> Lists<'a> {
    /// Of the points from `first` on, a multiple of sixteen, of a batch that has been reset: once for them,
    /// instead of [`ClosureBatch::set`].
    #[must_use]
    pub fn of(batch: &'a mut ClosureBatch, first: usize) -> Self {
        let block = &mut batch.blocks[first / LANES];
        block.count = 0;
        Self { block, ends: [0; LANES], taken: [0; MOST], full: 0, bent: 0 }
    }

    /// Where the lists end now.
    #[must_use]
    pub fn ends(&self) -> Ends {
        self.ends
    }

    /// Points of which a lobe was left out.
    #[must_use]
    pub fn full(&self) -> u32 {
        self.full
    }

    /// Points with a lobe around its own normal.
    #[must_use]
    pub fn bent(&self) -> u32 {
        self.bent
    }

    /// Points that have a lobe.
    #[must_use]
    pub fn lit(&self) -> u32 {
        bits(|i| self.ends[i] > 0)
    }

    /// Calls `write(rows, points, whether other points' numbers may be overwritten)` for each position where
    /// lists of these points end, and makes these one longer.
    fn each_end(&mut self, lanes: u32, mut write: impl FnMut(&mut LobeRows, u32, bool)) {
        let mut left = lanes;
        while left != 0 {
            let end = self.ends[left.trailing_zeros() as usize];
            let same = left & bits(|i| self.ends[i] == end);
            left &= !same;
            let entry = usize::from(end);
            let Some(rows) = self.block.lobes.get_mut(entry) else {
                self.full |= same;
                continue;
            };
            if entry as u32 == self.block.count {
                self.block.count += 1;
                rows.clear();
            }
            write(rows, same, self.taken[entry] == 0);
            self.taken[entry] |= same;
            LanesOf(u64::from(same)).for_each(|i| self.ends[i] += 1);
        }
    }

    /// Appends the same lobe to the lists of some points. A lobe below others must keep its cover among them.
    pub fn push(&mut self, lanes: u32, lobe: &Lobe) {
        let numbers = numbers(lobe);
        self.each_end(lanes, |rows, same, free| {
            if lobe.rare() != 0 {
                LanesOf(u64::from(same)).for_each(|i| rows.set(i, lobe));
                return;
            }
            let mask = mask(same);
            blend(&mut rows.kind.0, &mask, &[lobe.kind as u32 as f32; LANES]);
            for (row, x) in rows.numbers.iter_mut().zip(numbers) {
                if free {
                    row.0 = [x; LANES];
                } else {
                    blend(&mut row.0, &mask, &[x; LANES]);
                }
            }
            if lobe.layers_above != 0 {
                LanesOf(u64::from(same)).for_each(|i| rows.layers_above.0[i] = lobe.layers_above);
                rows.any_layer_above |= lobe.layers_above;
            }
            rows.kinds |= lobe.kind.bit();
            rows.covers |= lobe.covers();
            rows.any_subsurface |= lobe.is_subsurface();
        });
    }

    /// Appends a lobe to the list of one point.
    pub fn push_to(&mut self, i: usize, lobe: &Lobe) {
        let entry = usize::from(self.ends[i]);
        let Some(rows) = self.block.lobes.get_mut(entry) else {
            self.full |= 1 << i;
            return;
        };
        if entry as u32 == self.block.count {
            self.block.count += 1;
            rows.clear();
        }
        rows.set(i, lobe);
        self.taken[entry] |= 1 << i;
        self.ends[i] += 1;
    }

    /// Gives the entries in the lists of some points from `from` on their own unit normals; zero = the
    /// point's.
    pub fn tilt(&mut self, lanes: u32, from: &Ends, normals: &[Row; 3]) {
        let own = lanes & bits(|i| (0..3).any(|k| normals[k][i] != 0.0));
        if own == 0 {
            return;
        }
        self.bent |= own;
        self.each_since(own, from, |rows, same| {
            let mask = mask(same);
            let [_, _, _, x, y, z, ..] = &mut rows.numbers;
            [x, y, z].into_iter().zip(normals).for_each(|(row, normals)| blend(&mut row.0, &mask, normals));
        });
    }

    /// Calls `with(rows, points)` for each position behind `from` in the lists of some points.
    fn each_since(&mut self, lanes: u32, from: &Ends, mut with: impl FnMut(&mut LobeRows, u32)) {
        for entry in 0..self.block.count as usize {
            let same =
                lanes & bits(|i| usize::from(from[i]) <= entry) & bits(|i| entry < usize::from(self.ends[i]));
            if same != 0 {
                with(&mut self.block.lobes[entry], same);
            }
        }
    }

    /// Multiplies the entries in the lists of some points from `from` on by colours.
    pub fn times(&mut self, lanes: u32, from: &Ends, weights: &[Row; 3]) {
        self.each_since(lanes, from, |rows, same| {
            for (row, weights) in rows.numbers.iter_mut().zip(weights) {
                for (i, (x, weight)) in row.0.iter_mut().zip(weights).enumerate() {
                    *x *= if same >> i & 1 != 0 { *weight } else { 1.0 };
                }
            }
        });
    }

    /// Layers the entries in the lists of some points from `top` to `base` over the following ones:
    /// [`Lobes::over`](super::Lobes::over).
    pub fn layer(&mut self, lanes: u32, top: &Ends, base: &Ends) {
        let (mut hidden, mut above) = ([[0.0_f32; LANES]; 3], [0_u32; LANES]);
        for entry in 0..self.block.count as usize {
            let rows = &mut self.block.lobes[entry];
            for i in LanesOf(u64::from(lanes)) {
                if !(usize::from(top[i])..usize::from(base[i])).contains(&entry) {
                    continue;
                }
                let [cover, hides] = rows.get(i).above();
                for (k, (cover, hides)) in cover.to_array().into_iter().zip(hides.to_array()).enumerate() {
                    hidden[k][i] += hides;
                    rows.numbers[COVER + k].0[i] = cover;
                    rows.covers |= cover > 0.0;
                }
                above[i] |= 1 << entry;
            }
        }
        let shown = hidden.map(|row| row.map(|hidden| (1.0 - hidden).max(0.0)));
        self.times(lanes, base, &shown);
        self.each_since(lanes, base, |rows, same| {
            for i in LanesOf(u64::from(same)) {
                rows.layers_above.0[i] |= above[i];
                rows.any_layer_above |= above[i];
            }
        });
    }

    /// A point's list.
    #[must_use]
    pub fn lobes(&self, i: usize) -> Lobes {
        let mut lobes = Lobes::default();
        self.block.lobes[..usize::from(self.ends[i])].iter().for_each(|rows| lobes.push(rows.get(i)));
        lobes
    }

    /// Around which normal the heaviest lobe of a point lies; zero if that is the point's own.
    #[must_use]
    pub fn main_normal(&self, i: usize) -> Vec3 {
        let lobes = self.block.lobes[..usize::from(self.ends[i])].iter().map(|rows| rows.get(i));
        let heaviest = lobes.max_by(|a, b| a.weight.element_sum().total_cmp(&b.weight.element_sum()));
        heaviest.map_or(Vec3::ZERO, |lobe| lobe.normal)
    }

    /// Sets the unit shading normals of the points, as [`face`](Self::face) does; the lobes' own normals
    /// stay.
    pub fn face_all(&mut self, normals: &[Row; 3]) {
        for (row, x) in self.block.normal.iter_mut().zip(normals) {
            row.0 = *x;
        }
    }

    /// Sets the unit shading normal of a point, on the side of the first ray, and replaces those of its
    /// lobes, if some have their own.
    pub fn face(&mut self, i: usize, ns: Vec3, of: impl Fn(Vec3) -> Vec3) {
        for (row, x) in self.block.normal.iter_mut().zip(ns.to_array()) {
            row.0[i] = x;
        }
        if self.bent >> i & 1 == 0 {
            return;
        }
        for rows in &mut self.block.lobes[..usize::from(self.ends[i])] {
            let [_, _, _, x, y, z, ..] = &mut rows.numbers;
            let normal = of(Vec3::new(x.0[i], y.0[i], z.0[i]));
            (x.0[i], y.0[i], z.0[i]) = normal.into();
        }
    }
}

/// The index of the first of a lobe's covers among its numbers.
const COVER: usize = 17;
