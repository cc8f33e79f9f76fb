// SPDX-License-Identifier: GPL-3.0-or-later
//! Regions of searches for primitives: lines and boxes, transformed into the spaces of instances.
//! Source: slabs, [KK86], in double precision. Plain loops over eight boxes, which compilers turn into lanes:
//! one body for all levels, because exact arithmetic decides about the results afterwards.
//! Invariant: a primitive that meets the region lies in no skipped box. Boxes are widened by their own
//! rounding (`SLACK`), by the rounding of doubles, and by the error in the space of an instance, which is
//! measured by the inverse transform.
//! Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/overlaps.rs`.

use crate::blocks::WIDTH;
use crate::exact::Line;

/// Coordinates along a row of eight boxes: x lo, x hi, y lo, y hi, z lo, z hi.
pub type Rows = [[f32; WIDTH]; 6];

/// Sides of boxes are right up to this fraction of the greatest coordinate: twice the need of `kd/slab.rs`
/// and of the clipped boxes of spatial splits.
const SLACK: f64 = 2e-6;

/// The error of a few roundings of doubles.
const ROUNDING: f64 = 1e-14;

/// A part of space.
#[derive(Clone, Copy, Debug)]
pub enum Region {
    /// Along a line, between its ends.
    Line(LineRegion),
    /// In a box.
    Box(BoxRegion),
}

/// A line that may be off.
#[derive(Clone, Copy, Debug)]
pub struct LineRegion {
    pub org: [f64; 3],
    pub dir: [f64; 3],
    pub near: f64,
    pub far: f64,
    /// How far off the origin and the direction may be.
    off: [f64; 2],
}

/// A box that may be off.
#[derive(Clone, Copy, Debug)]
pub struct BoxRegion {
    pub min: [f64; 3],
    pub max: [f64; 3],
    off: f64,
}

/// A region made ready for the boxes of one tree.
#[derive(Clone, Copy, Debug)]
pub enum RegionFilter {
    Line { org: [f64; 3], inv: [f64; 3], ends: [f64; 2], slack: f64 },
    Box { min: [f64; 3], max: [f64; 3] },
}

fn largest(v: [f64; 3]) -> f64 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// An affine map out of a space and one back into it, its inverse up to the rounding of doubles.
#[derive(Clone, Copy, Debug)]
pub struct Map<'a> {
    /// Images of the axes, then of the origin, of the outward map.
    pub columns: &'a [[f64; 3]; 4],
    /// Rows of the linear part of the inward map.
    pub rows: &'a [[f64; 3]; 3],
}

impl Map<'_> {
    /// Transforms a point or vector with an error bound inward; returns its error bound there, from the
    /// inverse transform and its rounding.
    fn inward(&self, v: [f64; 3], origin: [f64; 3], off: f64) -> ([f64; 3], f64) {
        let from = [0, 1, 2].map(|k| v[k] - origin[k]);
        let inside = self.rows.map(|row| row[0] * from[0] + row[1] * from[1] + row[2] * from[2]);
        let [x, y, z, _] = self.columns;
        let mut missing = 0.0f64;
        let mut size = 0.0f64;
        for k in 0..3 {
            let back = x[k] * inside[0] + y[k] * inside[1] + z[k] * inside[2];
            missing = missing.max((back - from[k]).abs());
            size = size.max(v[k].abs() + origin[k].abs()).max(
                x[k].abs() * inside[0].abs() + y[k].abs() * inside[1].abs() + z[k].abs() * inside[2].abs(),
            );
        }
        // The rows are precise enough for the growth of vectors.
        let growth = self.rows.map(length).map(|x| x * x).iter().sum::<f64>().sqrt();
        (inside, 2.0 * growth * (off + 2.0 * missing + ROUNDING * size))
    }
}

impl Region {
    /// All of a line.
    pub fn line(line: &Line) -> Self {
        let Line { org, dir, near, far, .. } = *line;
        Self::Line(LineRegion { org, dir, near, far, off: [0.0; 2] })
    }

    /// The points of a box, its sides included.
    pub fn within(min: [f64; 3], max: [f64; 3]) -> Self {
        Self::Box(BoxRegion { min, max, off: 0.0 })
    }

    /// The same, or more, in the space that a map comes from.
    pub fn inside(&self, map: &Map) -> Self {
        let translation = map.columns[3];
        match self {
            Self::Line(line) => {
                let (org, off_org) = map.inward(line.org, translation, line.off[0]);
                let (dir, off_dir) = map.inward(line.dir, [0.0; 3], line.off[1]);
                Self::Line(LineRegion { org, dir, off: [off_org, off_dir], ..*line })
            }
            Self::Box(region) => {
                let half = [0, 1, 2].map(|k| 0.5 * (region.max[k] - region.min[k]));
                let middle = [0, 1, 2].map(|k| region.min[k] + half[k]);
                let (middle, off) = map.inward(middle, translation, region.off + ROUNDING * largest(half));
                let half = map.rows.map(|row| (0..3).map(|i| row[i].abs() * half[i]).sum::<f64>());
                let off = off + 2.0 * ROUNDING * (largest(half) + largest(middle));
                let side = |sign: f64| [0, 1, 2].map(|k| middle[k] + sign * half[k]);
                Self::Box(BoxRegion { min: side(-1.0), max: side(1.0), off })
            }
        }
    }

    /// The same relative to another origin.
    pub fn moved(&self, origin: [f32; 3]) -> Self {
        if origin == [0.0; 3] {
            return *self;
        }
        let to = |v: [f64; 3]| [0, 1, 2].map(|k| v[k] - f64::from(origin[k]));
        let more = |v: [f64; 3]| ROUNDING * (largest(v) + largest(origin.map(f64::from)));
        match self {
            Self::Line(line) => {
                let off = [line.off[0] + more(line.org), line.off[1]];
                Self::Line(LineRegion { org: to(line.org), off, ..*line })
            }
            Self::Box(region) => {
                let off = region.off + more(region.min) + more(region.max);
                Self::Box(BoxRegion { min: to(region.min), max: to(region.max), off })
            }
        }
    }

    /// For a tree whose greatest coordinate is `reach`.
    pub fn region_filter(&self, reach: f32) -> RegionFilter {
        let reach = f64::from(reach);
        match self {
            Self::Line(line) => {
                let away = largest(line.org) + reach;
                let turned = line.off[1] / largest(line.dir) * away;
                let slack = SLACK * reach + ROUNDING * away + line.off[0] + turned;
                let inv = line.dir.map(|x| if x == 0.0 { 0.0 } else { 1.0 / x });
                RegionFilter::Line { org: line.org, inv, ends: [line.near, line.far], slack }
            }
            Self::Box(region) => {
                let slack =
                    SLACK * reach + region.off + ROUNDING * (largest(region.min) + largest(region.max));
                RegionFilter::Box { min: region.min.map(|x| x - slack), max: region.max.map(|x| x + slack) }
            }
        }
    }
}

impl RegionFilter {
    /// Which of eight boxes may hold some of the region, as bits; boxes from +inf to -inf hold nothing.
    pub fn overlap_mask(&self, rows: &Rows) -> u32 {
        let mut is_met = [true; WIDTH];
        match self {
            Self::Line { org, inv, ends, slack } => {
                let (mut near, mut far) = ([ends[0]; WIDTH], [ends[1]; WIDTH]);
                for k in 0..3 {
                    let (low, high) = (&rows[2 * k], &rows[2 * k + 1]);
                    let (low_from, high_from) = (org[k] + slack, org[k] - slack);
                    if inv[k] == 0.0 {
                        for i in 0..WIDTH {
                            is_met[i] &= f64::from(low[i]) <= low_from && f64::from(high[i]) >= high_from;
                        }
                        continue;
                    }
                    for i in 0..WIDTH {
                        let low = (f64::from(low[i]) - low_from) * inv[k];
                        let high = (f64::from(high[i]) - high_from) * inv[k];
                        let (first, last) = if inv[k] > 0.0 { (low, high) } else { (high, low) };
                        near[i] = if first > near[i] { first } else { near[i] };
                        far[i] = if last < far[i] { last } else { far[i] };
                    }
                }
                for i in 0..WIDTH {
                    is_met[i] &= near[i] <= far[i];
                }
            }
            Self::Box { min, max } => {
                for k in 0..3 {
                    for i in 0..WIDTH {
                        is_met[i] &=
                            f64::from(rows[2 * k][i]) <= max[k] && f64::from(rows[2 * k + 1][i]) >= min[k];
                    }
                }
            }
        }
        is_met.iter().rev().fold(0, |bits, &met| bits << 1 | u32::from(met))
    }
}
