// SPDX-License-Identifier: GPL-3.0-or-later
//! Reconstruction filters, by importance sampling: a sample is placed around the pixel's centre with the filter as its
//! density, and then weighs 1. Pixels stay independent, which keeps pictures the same for any number of threads.
//! Source: [Ernst2006]; the window of Blackman and Harris [Har78]. Offsets are in pixels from the centre; both axes
//! are independent. Invariants: every density is >= 0, even, 0 beyond `radius`, and integrates to 1; `sample`
//! follows it exactly, except for the tables of the last two, which follow a piecewise linear density of 256
//! pieces.
//! Tests: `tests::{integrates_to_one, samples_follow_the_density, ends_are_reached}`.

use crate::Error;

/// The form of a filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FilterShape {
    /// Constant; with radius 0.5 the mean over the pixel.
    Box,
    /// A tent.
    Triangle,
    /// A normal distribution of deviation radius / 3, lowered to reach 0 at the radius.
    Gaussian,
    /// The window of Blackman and Harris with four terms: smooth, narrow, no ringing.
    #[default]
    BlackmanHarris,
}

impl FilterShape {
    /// All shapes.
    pub const ALL: [Self; 4] = [Self::Box, Self::Triangle, Self::Gaussian, Self::BlackmanHarris];

    /// The name that users write.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Triangle => "triangle",
            Self::Gaussian => "gaussian",
            Self::BlackmanHarris => "blackman-harris",
        }
    }

    /// Usual radius in pixels.
    #[must_use]
    pub fn default_radius(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Triangle => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
        }
    }

    /// Height at `x` in -1..1 (radius 1), not normalised.
    fn height(self, x: f64) -> f64 {
        match self {
            Self::Box => 1.0,
            Self::Triangle => 1.0 - x.abs(),
            Self::Gaussian => {
                let bell = |x: f64| (-4.5 * x * x).exp();
                bell(x) - bell(1.0)
            }
            Self::BlackmanHarris => {
                let angle = std::f64::consts::PI * x;
                0.358_75
                    + 0.488_29 * angle.cos()
                    + 0.141_28 * (2.0 * angle).cos()
                    + 0.011_68 * (3.0 * angle).cos()
            }
        }
    }
}

impl std::str::FromStr for FilterShape {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        Self::ALL.into_iter().find(|shape| shape.name() == name).ok_or_else(|| Error::UnknownName {
            what: "filter",
            name: name.into(),
            valid: Self::ALL.map(Self::name).join(", "),
        })
    }
}

impl std::fmt::Display for FilterShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A filter ready to be sampled.
#[derive(Clone, Debug)]
pub struct Filter {
    shape: FilterShape,
    radius: f32,
    table: HalfTable,
}

impl Filter {
    /// A filter of the usual radius.
    #[must_use]
    pub fn new(shape: FilterShape) -> Self {
        Self { shape, radius: shape.default_radius(), table: HalfTable::new(|x| shape.height(x)) }
    }

    /// A filter of this radius in pixels; `None` unless it is finite and above 0.
    #[must_use]
    pub fn with_radius(shape: FilterShape, radius: f32) -> Option<Self> {
        (radius.is_finite() && radius > 0.0).then(|| Self { radius, ..Self::new(shape) })
    }

    /// Its form.
    #[must_use]
    pub fn shape(&self) -> FilterShape {
        self.shape
    }

    /// Its radius in pixels.
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Offset from the pixel's centre in pixels, each axis in -radius..=radius, for `u` in 0..1.
    #[must_use]
    pub fn sample(&self, u: [f32; 2]) -> [f32; 2] {
        u.map(|u| self.sample_axis(u))
    }

    /// Density of [`Filter::sample`] at an offset in pixels, per square pixel.
    #[must_use]
    pub fn pdf(&self, offset: [f32; 2]) -> f32 {
        self.pdf_axis(offset[0]) * self.pdf_axis(offset[1])
    }

    fn sample_axis(&self, u: f32) -> f32 {
        // u = 0 and u = 1 are the two ends, u = 1/2 the centre: signed distance of the share from the middle.
        let share = 2.0 * u.clamp(0.0, 1.0) - 1.0;
        let distance = match self.shape {
            FilterShape::Box => share.abs(),
            FilterShape::Triangle => 1.0 - (1.0 - share.abs()).sqrt(),
            FilterShape::Gaussian | FilterShape::BlackmanHarris => self.table.invert(share.abs()),
        };
        self.radius * distance.copysign(share)
    }

    fn pdf_axis(&self, offset: f32) -> f32 {
        let x = f64::from(offset / self.radius);
        // A comparison with NaN is false: NaN has density 0.
        if x.abs() <= 1.0 {
            (self.shape.height(x) * self.table.scale * 0.5) as f32 / self.radius
        } else {
            0.0
        }
    }
}

const PIECES: usize = 256;

/// Density and cumulative density over 0..1 at the ends of equal pieces, for an even function on -1..1.
#[derive(Clone, Debug)]
struct HalfTable {
    density: [f32; PIECES + 1],
    cumulative: [f32; PIECES + 1],
    /// Height times this is the density over 0..1.
    scale: f64,
}

impl HalfTable {
    fn new(height: impl Fn(f64) -> f64) -> Self {
        let at = |i: usize| i as f64 / PIECES as f64;
        let heights: [f64; PIECES + 1] = std::array::from_fn(|i| height(at(i)).max(0.0));
        let areas = {
            let mut areas = [0.0; PIECES + 1];
            for i in 0..PIECES {
                areas[i + 1] = areas[i] + 0.5 * (heights[i] + heights[i + 1]) / PIECES as f64;
            }
            areas
        };
        let scale = 1.0 / areas[PIECES];
        Self {
            density: heights.map(|h| (h * scale) as f32),
            cumulative: areas.map(|a| (a * scale) as f32),
            scale,
        }
    }

    /// Distance in 0..1 below which this share of the density lies.
    fn invert(&self, share: f32) -> f32 {
        // The last piece that begins at or below the share.
        let piece = self.cumulative.partition_point(|&c| c <= share).saturating_sub(1).min(PIECES - 1);
        let area = share - self.cumulative[piece];
        let [d0, d1] = [self.density[piece], self.density[piece + 1]];
        // Within a piece of width w the area is d0 x + (d1 - d0) x^2 / (2 w); this form of the root never cancels.
        let width = 1.0 / PIECES as f32;
        let root = (d0 * d0 + 2.0 * area * (d1 - d0) / width).max(0.0).sqrt();
        let within = if d0 + root > 0.0 { 2.0 * area / (d0 + root) } else { 0.0 };
        piece as f32 * width + within.clamp(0.0, width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADII: [f32; 3] = [0.5, 1.0, 2.25];

    fn filters() -> impl Iterator<Item = Filter> {
        FilterShape::ALL.into_iter().flat_map(|shape| {
            RADII.map(|radius| Filter::with_radius(shape, radius).expect("the radius is finite and above 0"))
        })
    }

    #[test]
    fn integrates_to_one() {
        for filter in filters() {
            let steps = 20_000;
            let width = 2.0 * filter.radius / steps as f32;
            let sum: f64 = (0..steps)
                .map(|i| f64::from(filter.pdf_axis(-filter.radius + (i as f32 + 0.5) * width) * width))
                .sum();
            assert!(
                (sum - 1.0).abs() < 1e-4,
                "{} of radius {} integrates to {sum}",
                filter.shape,
                filter.radius
            );
        }
    }

    /// Chi-square over 40 cells of one axis with stratified positions: far stricter than with random ones.
    #[test]
    fn samples_follow_the_density() {
        const CELLS: usize = 40;
        const SAMPLES: usize = 400_000;
        for filter in filters() {
            let mut counts = [0.0_f64; CELLS];
            for i in 0..SAMPLES {
                let x = filter.sample([(i as f32 + 0.5) / SAMPLES as f32, 0.5])[0];
                let cell = ((x / filter.radius + 1.0) * 0.5 * CELLS as f32) as usize;
                counts[cell.min(CELLS - 1)] += 1.0;
            }
            let width = 2.0 * filter.radius / CELLS as f32;
            let expected = |cell: usize| {
                let fine = 64;
                let at = |k: usize| -filter.radius + (cell as f32 + (k as f32 + 0.5) / fine as f32) * width;
                let mean = (0..fine).map(|k| f64::from(filter.pdf_axis(at(k)))).sum::<f64>() / fine as f64;
                mean * f64::from(width) * SAMPLES as f64
            };
            let chi_square: f64 = (0..CELLS)
                .map(|cell| (counts[cell] - expected(cell)).powi(2) / expected(cell).max(5.0))
                .sum();
            assert!(chi_square < 40.0, "{} of radius {}: {chi_square}", filter.shape, filter.radius);
        }
    }

    #[test]
    fn both_axes_follow_their_own_number() {
        let filter = Filter::new(FilterShape::Triangle);
        let [x, y] = filter.sample([0.1, 0.9]);
        assert!((x + y).abs() < 1e-6 && x < 0.0, "0.1 and 0.9 are mirror images: {x}, {y}");
        assert!((filter.sample([0.5, 0.125])[1] + 0.5).abs() < 1e-6, "an eighth of a tent lies below -1/2");
    }

    #[test]
    fn ends_are_reached() {
        for filter in filters() {
            let ends = [filter.sample([0.0, 1.0]), filter.sample([-1.0, 2.0])];
            for [low, high] in ends {
                let close = |x: f32| (x - filter.radius).abs() < 1e-3 * filter.radius;
                assert!(close(-low) && close(high), "{} reaches {low} and {high}", filter.shape);
            }
            assert_eq!(filter.sample([0.5, 0.5]).map(f32::abs), [0.0; 2], "the middle is the centre");
            assert_eq!(filter.pdf([filter.radius * 1.01, 0.0]), 0.0, "nothing lies beyond the radius");
        }
    }

    #[test]
    fn bad_radii_are_refused() {
        for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(Filter::with_radius(FilterShape::Box, radius).is_none(), "radius {radius} was taken");
        }
    }

    #[test]
    fn names_lead_back() {
        for shape in FilterShape::ALL {
            assert_eq!(shape.name().parse::<FilterShape>().ok(), Some(shape), "name of {shape}");
        }
    }
}
