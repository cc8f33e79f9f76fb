// SPDX-License-Identifier: GPL-3.0-or-later
//! The built-in denoiser: a regression of direct and of indirect light, without albedo and fireflies, on the features of
//! camera rays' hits, in two passes, and a third one where light is in rare samples.
//! Source: \[BRM*16\], with weights from sampled variances instead of two half pictures. The second pass
//! reaches three times as far, on the result of the first: it removes blotches, as the coarser scales of
//! \[DSHL10\]'s wavelets do.
//!
//! ```text
//! radiance --+- seen directly ------------------------------------------------------------------+
//! emission --+                                                                                  +
//!            +- direct / albedo ----+- the rest --> near fits --> wide fits --> what stands out +--> sum
//!            +- indirect / albedo --+- rare bright samples ------------- given back, wide ------+
//! ```
//! Invariants: finite and not negative for any input; the same bits on any number of threads and any
//! processor.
//! Tests: crates/denoise/tests/filter.rs.

use gnurt_simd::Level;

use crate::details;
use crate::explain::{Explained, Layers};
use crate::light::{Light, Part};
use crate::noisy::{Noisy, Triple};
use crate::outliers::Outliers;
use crate::patches::Reach;
use crate::variance;

/// Neighbourhoods of the first pass, whose results are averaged: patches of noisy light, of two sizes, around centres that
/// alternate.
const NEAR: [Reach; 2] = [
    Reach { side: 4, step: 1, patch: 2, first: 0, sharpness: 0.6 },
    Reach { side: 5, step: 1, patch: 1, first: 1, sharpness: 0.6 },
];
/// The second time: smaller patches of light with little noise, farther apart.
const WIDE: Reach = Reach { side: 5, step: 3, patch: 1, first: 0, sharpness: 0.6 };
/// The third time, where light is in rare samples: as wide as blotches of the second one.
const FAR: Reach = Reach { side: 3, step: 9, patch: 1, first: 0, sharpness: 0.6 };
/// The remaining fraction of the variance of independent pixels: each has been in many fits.
const LEFT: f32 = 0.5;
/// The same after the second pass, where light is in rare samples: blotches are as wide as its fits.
const LEFT_OF_RARE: f32 = 6.0;
/// Squares of differences exceed the variance by so much where light is in rare samples.
const HEAVY: f32 = 3.0;
/// Where fewer pixels are similar, the second and third time count less.
const FEW: f32 = 3.0;

/// The light of a part.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Direct,
    Indirect,
    /// Direct light is not known by itself.
    Both,
}

impl Kind {
    /// No pixel is brighter than this times its bright neighbours: direct light has few rare samples and many highlights.
    fn brighter(self) -> f32 {
        if self == Self::Direct { 4.0 } else { 1.5 }
    }
}

/// The colours of the region without noise, row by row; `None` if `stop` has returned true.
pub(crate) fn filter(
    noisy: &Noisy,
    pool: &rayon::ThreadPool,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Triple>> {
    pool.install(|| {
        let Light { unscattered, divisor, parts } = Light::of(noisy);
        let mut clean = vec![[0.0; 3]; unscattered.len()];
        let kinds = if parts[0].is_black() { [Kind::Both; 2] } else { [Kind::Direct, Kind::Indirect] };
        for (part, kind) in parts.into_iter().zip(kinds).filter(|(part, _)| !part.is_black()) {
            let part = without_noise(noisy, &divisor, (part, kind), stop)?;
            clean
                .as_flattened_mut()
                .iter_mut()
                .zip(part.as_flattened())
                .for_each(|(sum, part)| *sum += part.max(0.0));
        }
        let whole = |(p, light): (usize, &Triple)| {
            [0, 1, 2].map(|k| {
                let color = light[k] * divisor[p][k] + unscattered[p][k];
                if color.is_finite() { color.max(0.0) } else { noisy.color[p][k].max(0.0) }
            })
        };
        Some(clean.iter().enumerate().map(whole).collect())
    })
}

/// A part of the scattered light, divided, without noise.
fn without_noise(
    noisy: &Noisy,
    divisor: &[Triple],
    (part, kind): (Part, Kind),
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Triple>> {
    let (level, width, height) = (Level::default(), noisy.width, noisy.height);
    let Part { mut color, mut variance } = part;
    let is_known = variance.iter().any(|v| *v != [0.0; 3]);
    let outliers = Outliers::take(width, &noisy.normal, kind.brighter(), (&mut color, &mut variance));
    if !is_known {
        variance = variance::spatial(&color, width, height);
    }
    let mut smooth = variance::smooth(&variance, (&noisy.normal, &outliers.rare), width);
    let unsure = |(v, _): (&mut Triple, &bool)| *v = v.map(|v| v * HEAVY);
    smooth.iter_mut().zip(&outliers.rare).filter(|(_, rare)| **rare).for_each(unsure);
    let layers = Layers { noisy, color: &color, variance: &smooth, only: None };
    let [mut near, other] = NEAR.map(|reach| Explained::of(level, &layers, reach, stop));
    near.as_mut()?.average(&other?);
    let near = near?;
    let left = left_of(&smooth, &near.support, LEFT);
    let layers = Layers { noisy, color: &near.color, variance: &left, only: None };
    let wide = Explained::of(level, &layers, WIDE, stop)?;
    let mut clean = near.color;
    blend(&mut clean, &wide, |_| true);
    if outliers.rare.contains(&true) {
        let left = left_of(&left, &wide.support, LEFT_OF_RARE);
        let layers = Layers { noisy, color: &clean, variance: &left, only: Some(&outliers.rare) };
        let far = Explained::of(level, &layers, FAR, stop)?;
        blend(&mut clean, &far, |p| outliers.rare[p]);
    }
    outliers.give_back(width, divisor, &mut clean);
    // What stands out of indirect light is noise.
    if is_known && kind != Kind::Indirect {
        details::bring_back(width, &color, &variance, (&smooth, &outliers.rare), &mut clean);
    }
    Some(clean)
}

/// The variance that fits of this support leave, times a factor.
fn left_of(variance: &[Triple], support: &[f32], left: f32) -> Vec<Triple> {
    let of = |(variance, support): (&Triple, &f32)| variance.map(|v| v * left / support.max(1.0));
    variance.iter().zip(support).map(of).collect()
}

/// Takes some pixels of wider fits, as far as these have support.
fn blend(clean: &mut [Triple], wider: &Explained, is_taken: impl Fn(usize) -> bool) {
    for (p, clean) in clean.iter_mut().enumerate().filter(|(p, _)| is_taken(*p)) {
        let share = (wider.support[p] / FEW).min(1.0);
        for (clean, wider) in clean.iter_mut().zip(wider.color[p]) {
            *clean += (wider - *clean) * share;
        }
    }
}
