// SPDX-License-Identifier: GPL-3.0-or-later
//! How a box is divided into cells of one size. Source: [WIK*06] section 4.4: the cube root rule. Space: object.
//! Invariant: [`Cells::of`] never falls where coordinates rise. So a point of a triangle is in one of the
//! cells from that of its box's least corner to that of its greatest; the rounded planes between cells are
//! not used. Tests: `tests`.

use gnurt_accel_core::Aabb;
use gnurt_accel_core::float::{least, most};

/// Most cells along one axis: the limit of a [`Span`].
const MOST_ALONG: f64 = 65535.0;
/// Most cells in all.
const MOST: f64 = (1u64 << 30) as f64;
/// Boxes are not divided along axes shorter than this: floats could not separate cells.
const FLAT: f64 = 1e-30;

/// A number of cells along each axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cells {
    /// One or more along each axis.
    pub(super) count: [u32; 3],
    low: [f32; 3],
    size: [f32; 3],
    /// 1 / `size`, and 0 along axes with one cell.
    over: [f32; 3],
    /// Number of the last cell.
    last: [f32; 3],
}

/// Cells from one corner to the other, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) low: [u16; 3],
    pub(super) high: [u16; 3],
}

impl Span {
    /// How many cells.
    pub(super) fn cells(&self) -> u64 {
        (0..3).map(|k| u64::from(self.high[k] - self.low[k]) + 1).product()
    }
}

impl Cells {
    /// About `expected` cells in `bounds`, which are not empty, as nearly cubes as can be.
    pub(super) fn new(bounds: &Aabb, expected: f64) -> Self {
        let extent = bounds.extent();
        let mut long: Vec<usize> = (0..3).filter(|&k| extent[k] > FLAT).collect();
        let mut count = [1u32; 3];
        // In logarithms: volumes of huge boxes are no numbers.
        while !long.is_empty() {
            let sum: f64 = long.iter().map(|&k| extent[k].ln()).sum();
            let over_edge = ((expected.clamp(1.0, MOST).ln() - sum) / long.len() as f64).exp();
            let many = |k: usize| extent[k] * over_edge;
            // An axis with less than one cell leaves its share to the others.
            let before = long.len();
            long.retain(|&k| many(k) >= 1.0 || !many(k).is_finite());
            if long.len() == before {
                for &k in &long {
                    count[k] = many(k).round().clamp(1.0, MOST_ALONG) as u32;
                }
                break;
            }
        }
        let edge = |k: usize| (extent[k] / f64::from(count[k])) as f32;
        let over = |k: usize| if count[k] > 1 { (f64::from(count[k]) / extent[k]) as f32 } else { 0.0 };
        Self {
            count,
            low: bounds.min,
            size: [0, 1, 2].map(edge),
            over: [0, 1, 2].map(over),
            last: count.map(|count| (count - 1) as f32),
        }
    }

    /// How many there are.
    pub(super) fn total(&self) -> usize {
        self.count.iter().map(|&count| count as usize).product()
    }

    /// The axis with the most cells.
    pub(super) fn longest(&self) -> usize {
        (0..3).fold(0, |most, k| if self.count[k] > self.count[most] { k } else { most })
    }

    /// The cell that a coordinate is in; the first or the last where it is beyond.
    #[inline(always)]
    pub(super) fn of(&self, axis: usize, x: f32) -> u32 {
        // No number, which is infinity times zero, is where there is but one cell.
        least(most((x - self.low[axis]) * self.over[axis], 0.0), self.last[axis]) as u32
    }

    /// About where a cell begins: right up to some 12 units of 2^-24 of the greatest coordinate.
    #[inline(always)]
    pub(super) fn plane(&self, axis: usize, cell: u32) -> f32 {
        self.low[axis] + cell as f32 * self.size[axis]
    }

    /// The cells of a triangle's box.
    #[inline(always)]
    pub(super) fn span(&self, corners: &[[f32; 3]; 3]) -> Span {
        let [a, b, c] = corners;
        let mut span = Span { low: [0; 3], high: [0; 3] };
        for k in 0..3 {
            span.low[k] = self.of(k, least(least(a[k], b[k]), c[k])) as u16;
            span.high[k] = self.of(k, most(most(a[k], b[k]), c[k])) as u16;
        }
        span
    }

    /// Cost of a cell by the surface area heuristic: the share of the rays through the box that hit it.
    pub(super) fn share(&self, bounds: &Aabb) -> f64 {
        let whole = bounds.half_area();
        let [x, y, z] = self.size.map(f64::from);
        if whole > 0.0 { ((x * y + y * z + z * x) / whole).min(1.0) } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    #[test]
    fn boxes_are_divided_into_cubes() {
        let of = |max: [f32; 3], expected: f64| Cells::new(&Aabb { min: [0.0; 3], max }, expected).count;
        assert_eq!(of([1.0; 3], 1000.0), [10; 3], "a cube");
        assert_eq!(of([4.0, 2.0, 1.0], 8.0), [4, 2, 1], "as long as wide");
        assert_eq!(of([1.0, 0.0, 1.0], 100.0), [10, 1, 10], "a square");
        assert_eq!(of([1.0, 1e-6, 1.0], 100.0), [10, 1, 10], "almost one");
        assert_eq!(of([0.0; 3], 100.0), [1; 3], "a point");
        assert_eq!(of([1e-38; 3], 100.0), [1; 3], "hardly more");
        assert_eq!(of([1.0; 3], 0.0), [1; 3], "at least one");
        assert_eq!(of([1e18, 0.0, 0.0], 1e9), [65535, 1, 1], "no more than can be numbered");
        assert_eq!(of([1.8e18; 3], 1e3), [10; 3], "as large as can be");
    }

    #[test]
    fn cells_rise_with_coordinates() {
        let mut random = Random::new(3);
        for (from, size) in [(0.0, 1.0), (-1e6, 3.0), (1e18, 1e17), (0.0, 1e-20), (-1.0, 2.0)] {
            let bounds = Aabb { min: [from; 3], max: [from + size; 3] };
            let cells = Cells::new(&bounds, 1e5);
            let mut points: Vec<f32> =
                (0..2000).map(|_| from + size * (0.5 + 0.6 * random.point()[0])).collect();
            points.extend([bounds.min[0], bounds.max[0], f32::INFINITY, f32::NEG_INFINITY]);
            points.sort_by(f32::total_cmp);
            assert!(points.windows(2).all(|two| cells.of(0, two[0]) <= cells.of(0, two[1])), "{cells:?}");
            assert_eq!((cells.of(0, bounds.min[0]), cells.of(0, f32::INFINITY)), (0, cells.count[0] - 1));
            let slack = 12.0 * f32::EPSILON / 2.0 * bounds.greatest();
            for x in points.into_iter().filter(|&x| x >= bounds.min[0] && x <= bounds.max[0]) {
                let i = cells.of(0, x);
                let [low, high] = [cells.plane(0, i), cells.plane(0, i + 1)];
                assert!(low - slack <= x && x <= high + slack, "{x} is in {i}, from {low} to {high}");
            }
        }
    }
}
