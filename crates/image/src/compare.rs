// SPDX-License-Identifier: GPL-3.0-or-later
//! The difference of two pictures, in linear light. Relative MSE as in [Rousselle2011], structural similarity
//! in `ssim`. In: pictures of one size, the second one the reference. Sums run over pixels and R, G, B in one
//! order, in 64 bits. A NaN on either side is an infinite difference; equal infinities are no difference.
//! Tests: `tests`.

use std::fmt;

use crate::{Error, Opacity, Picture, ssim};

/// Keeps relative errors of black pixels finite.
const RELATIVE_FLOOR: f64 = 0.01;

/// How far a picture is from a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean of (a - b)^2 over pixels and colours.
    pub mse: f64,
    /// Mean of (a - b)^2 / (b^2 + 0.01) over pixels and colours.
    pub rel_mse: f64,
    /// 10 log10(1 / mse) in decibels: the peak is 1. Infinite for equal pictures, -infinite with a NaN.
    pub psnr: f64,
    /// Structural similarity, -1..=1; 1 for equal pictures. See `ssim` for its input.
    pub ssim: f64,
    /// Largest |a - b| of a colour.
    pub max_difference: f64,
    /// Largest |a - b| of the opacity, which is in none of the values above.
    pub max_opacity_difference: f64,
    /// Pixels whose colour or opacity differs in any bit (0 equals -0).
    pub differing_pixels: u64,
}

/// A picture of the differences between two of one size: false colours where `seen` has those that people see
/// (of [`flip`](crate::flip())), else the values as they are, in linear light.
#[must_use]
pub fn differences(a: &Picture, b: &Picture, seen: Option<&[f32]>) -> Picture {
    let mut picture = Picture::new(a.width, a.height);
    let values = a.color.iter().zip(&b.color).enumerate();
    for (pixel, (i, (a, b))) in picture.color.iter_mut().zip(values) {
        let [red, green, blue] = match seen {
            Some(seen) => crate::heat_color(seen[i]),
            None => [0, 1, 2].map(|k| (a[k] - b[k]).abs()),
        };
        *pixel = [red, green, blue, 1.0];
    }
    picture
}

impl Comparison {
    /// Whether no pixel differs.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.differing_pixels == 0
    }

    /// Names and values, in the order of a table.
    #[must_use]
    pub fn rows(&self) -> [(&'static str, f64); 7] {
        [
            ("MSE", self.mse),
            ("relMSE", self.rel_mse),
            ("PSNR", self.psnr),
            ("SSIM", self.ssim),
            ("max difference", self.max_difference),
            ("max opacity difference", self.max_opacity_difference),
            ("differing pixels", self.differing_pixels as f64),
        ]
    }

    /// One JSON object; values that are not finite are `null`.
    #[must_use]
    pub fn to_json(&self) -> String {
        let number = |value: f64| if value.is_finite() { value.to_string() } else { "null".into() };
        let member =
            |(name, value): (&str, f64)| format!("\"{}\": {}", name.replace(' ', "_"), number(value));
        format!("{{{}}}", self.rows().map(member).join(", "))
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in self.rows() {
            writeln!(f, "{name:<22} {}", decimal(value))?;
        }
        Ok(())
    }
}

/// Up to seven digits, without an exponent where it is readable without.
fn decimal(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || value.is_infinite() || (value.fract() == 0.0 && magnitude < 1e15) {
        value.to_string()
    } else if (1e-3..1e7).contains(&magnitude) {
        format!("{value:.6}")
    } else {
        format!("{value:.6e}")
    }
}

/// Compares a picture with a reference. Layers and metadata are not compared.
///
/// # Errors
/// [`Error::SizesDiffer`], or [`Error::Shape`] for a picture whose parts do not fit.
pub fn compare(picture: &Picture, reference: &Picture) -> Result<Comparison, Error> {
    picture.check()?;
    reference.check()?;
    let sizes = [[picture.width, picture.height], [reference.width, reference.height]];
    if sizes[0] != sizes[1] {
        return Err(Error::SizesDiffer { a: sizes[0], b: sizes[1] });
    }
    let mut sums = Sums::default();
    // For two kinds of opacity, both as colours over black.
    let is_mixed = picture.opacity != reference.opacity;
    let seen = |picture: &Picture, [r, g, b, a]: [f32; 4]| match picture.opacity {
        Opacity::Straight if is_mixed && a != 1.0 => [r * a, g * a, b * a, a],
        _ => [r, g, b, a],
    };
    for (&a, &b) in picture.color.iter().zip(&reference.color) {
        sums.add(&seen(picture, a), &seen(reference, b));
    }
    let values = picture.pixel_count() as f64 * 3.0;
    let mse = sums.squares / values;
    Ok(Comparison {
        mse,
        rel_mse: sums.relative_squares / values,
        // 1 / 0 is infinite, and so is its logarithm.
        psnr: 10.0 * (1.0 / mse).log10(),
        ssim: ssim::ssim(picture, reference),
        max_difference: sums.max_difference,
        max_opacity_difference: sums.max_opacity_difference,
        differing_pixels: sums.differing_pixels,
    })
}

#[derive(Default)]
struct Sums {
    squares: f64,
    relative_squares: f64,
    max_difference: f64,
    max_opacity_difference: f64,
    differing_pixels: u64,
}

impl Sums {
    fn add(&mut self, a: &[f32; 4], b: &[f32; 4]) {
        for c in 0..3 {
            let difference = difference(a[c], b[c]);
            let square = difference * difference;
            let scale = f64::from(b[c]).powi(2) + RELATIVE_FLOOR;
            self.squares += square;
            // Infinite over infinite is an infinite difference, not a NaN.
            self.relative_squares += if square.is_infinite() { square } else { square / scale };
            self.max_difference = self.max_difference.max(difference);
        }
        self.max_opacity_difference = self.max_opacity_difference.max(difference(a[3], b[3]));
        self.differing_pixels += u64::from(a != b);
    }
}

/// |a - b|; infinite with a NaN, 0 for equal infinities.
fn difference(a: f32, b: f32) -> f64 {
    if a == b {
        return 0.0;
    }
    let difference = (f64::from(a) - f64::from(b)).abs();
    if difference.is_nan() { f64::INFINITY } else { difference }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(value: f32) -> Picture {
        Picture { color: vec![[value, value, value, 1.0]; 256], ..Picture::new(16, 16) }
    }

    #[test]
    fn flat_pictures_have_closed_forms() {
        let c = compare(&flat(0.75), &flat(0.5)).expect("sizes are equal");
        assert_eq!(c.mse, 0.0625, "(1/4)^2");
        assert!((c.rel_mse - 0.0625 / 0.26).abs() < 1e-12, "(1/4)^2 / (1/4 + 0.01): {}", c.rel_mse);
        assert!((c.psnr - 12.041_199_8).abs() < 1e-6, "20 log10(4): {}", c.psnr);
        assert_eq!(c.max_difference, 0.25, "3/4 - 1/2");
        assert_eq!(c.differing_pixels, 256, "every pixel");
    }

    #[test]
    fn one_value_of_many() {
        let mut picture = flat(0.5);
        picture.color[17][1] = 0.0;
        let c = compare(&picture, &flat(0.5)).expect("sizes are equal");
        assert!((c.mse - 0.25 / 768.0).abs() < 1e-15, "one square of 768 values: {}", c.mse);
        assert_eq!(c.differing_pixels, 1, "one pixel");
        assert!(c.ssim < 1.0, "structure differs: {}", c.ssim);
    }

    #[test]
    fn equal_pictures_are_equal() {
        let c = compare(&flat(0.3), &flat(0.3)).expect("sizes are equal");
        assert!(c.is_equal(), "no pixel differs");
        assert_eq!(
            (c.mse, c.rel_mse, c.psnr, c.max_difference),
            (0.0, 0.0, f64::INFINITY, 0.0),
            "no difference"
        );
        assert!((c.ssim - 1.0).abs() < 1e-12, "the same structure: {}", c.ssim);
    }

    #[test]
    fn nan_is_an_infinite_difference() {
        let nan = flat(f32::NAN);
        for (a, b) in [(&nan, &flat(0.5)), (&flat(0.5), &nan), (&nan, &nan)] {
            let c = compare(a, b).expect("sizes are equal");
            assert_eq!(
                (c.mse, c.rel_mse, c.max_difference),
                (f64::INFINITY, f64::INFINITY, f64::INFINITY),
                "NaN"
            );
            assert!(!c.is_equal() && c.psnr == f64::NEG_INFINITY && c.ssim.is_finite(), "NaN differs: {c:?}");
        }
        let infinite = flat(f32::INFINITY);
        assert!(
            compare(&infinite, &infinite).expect("sizes are equal").is_equal(),
            "equal infinities are equal"
        );
        let c = compare(&flat(0.0), &infinite).expect("sizes are equal");
        assert_eq!(c.rel_mse, f64::INFINITY, "an infinite reference is infinitely far");
    }

    #[test]
    fn opacity_is_compared_apart() {
        let mut picture = flat(0.5);
        picture.color[3][3] = 0.25;
        let c = compare(&picture, &flat(0.5)).expect("sizes are equal");
        assert_eq!(
            (c.mse, c.max_opacity_difference, c.differing_pixels),
            (0.0, 0.75, 1),
            "only opacity differs"
        );
        assert!(!c.is_equal(), "the pictures are not equal");
    }

    #[test]
    fn sizes_must_be_equal() {
        let error = compare(&Picture::new(2, 3), &Picture::new(3, 2)).expect_err("sizes differ");
        assert!(matches!(error, Error::SizesDiffer { a: [2, 3], b: [3, 2] }), "{error}");
    }

    #[test]
    fn json_holds_no_infinity() {
        let json = compare(&flat(0.5), &flat(0.5)).expect("sizes are equal").to_json();
        assert!(json.contains("\"PSNR\": null") && json.contains("\"MSE\": 0"), "{json}");
        assert!(!json.contains("inf") && !json.contains("NaN"), "{json}");
    }
}
