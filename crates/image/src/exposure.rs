// SPDX-License-Identifier: GPL-3.0-or-later
//! The exposure of a picture, from only the picture.
//! Source: [Rei02] section 3 (the log-average shows as a key value), [Rei03] (the key from the log-average
//! relative to the darkest and the brightest); robust here: percentiles represent darkest and brightest, the
//! average is taken between them. In: linear light of any unit. Out: stops, in hundredths, so that a printed
//! value can be given as input.
//!
//! The rule, with L the luminances above 0 of all pixels, in order:
//! 1. `dark` and `bright` are the 2nd and the 98th percentile of L, at most ten stops apart: darker values
//!    are raised to that;
//! 2. `mean` is the geometric mean of L, cut to `dark..bright`;
//! 3. `key` = (2 log mean - log dark - log bright) / (log bright - log dark), -1..1: is the picture mostly bright or dark?
//! 4. the mean shows as 0.18 * 2^place: mid-grey, up to a stop more or less, so that snow stays white and
//!    night stays dark;
//! 5. if the 90th percentile then shows brighter than 2, the exposure falls until it does not, by a stop and a half at most.
//!
//! Invariants: a picture k times as bright gets log2 k stops less; order and position of pixels do not
//! matter; a picture without light, or without a number in it, gets 0. Tests: `tests`.

use crate::Picture;
use crate::srgb::luminance;

/// The displayed value of a mean in the middle: the card of photographers.
const MID_GREY: f64 = 0.18;
/// Stops by which the key moves for pictures that are mostly bright or dark.
const KEY_RANGE: f64 = 1.0;
/// Shares of the pixels below the darkest and the brightest luminance that count.
const ENDS: [f64; 2] = [0.02, 0.98];
/// Stops between these two, at most.
const MOST_CONTRAST: f64 = 10.0;
/// Share of the pixels whose colour must stay, their greatest displayed value, and the greatest reduction in
/// stops.
const HIGHLIGHTS: (f64, f64, f64) = (0.90, 2.0, 1.5);
/// Largest magnitude, as for given numbers.
const MOST_STOPS: f64 = 64.0;

/// The exposure in stops that shows the picture well; see the head of this file for the rule.
#[must_use]
pub fn exposure_for(picture: &Picture) -> f32 {
    let light = picture.color.iter().map(|&[r, g, b, _]| f64::from(luminance([r, g, b])));
    // Comparisons with NaN are false.
    let mut logs: Vec<f64> = light.filter(|&l| l > 0.0 && l.is_finite()).map(f64::log2).collect();
    if logs.is_empty() {
        return 0.0;
    }
    logs.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| logs[(share * (logs.len() - 1) as f64).round() as usize];
    let [dark, bright] = ENDS.map(at);
    let dark = dark.max(bright - MOST_CONTRAST);
    let mean = logs.iter().map(|log| log.clamp(dark, bright)).sum::<f64>() / logs.len() as f64;
    let contrast = bright - dark;
    let key = if contrast > 0.0 { (2.0 * mean - dark - bright) / contrast } else { 0.0 };
    let stops = MID_GREY.log2() + KEY_RANGE * key.clamp(-1.0, 1.0) - mean;
    let (share, most, cost) = HIGHLIGHTS;
    let excess = (at(share) + stops - most.log2()).clamp(0.0, cost);
    let stops = (stops - excess).clamp(-MOST_STOPS, MOST_STOPS);
    // Adding 0 makes a positive zero of a negative one.
    ((stops * 100.0).round() / 100.0 + 0.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: impl IntoIterator<Item = f32>) -> Picture {
        let color: Vec<_> = values.into_iter().map(|x| [x, x, x, 1.0]).collect();
        Picture { width: color.len() as u32, height: 1, color, ..Picture::default() }
    }

    /// Half a room in shade, half in light, as a picture of 1,000 pixels; a ramp over five stops.
    fn ramp() -> Vec<f32> {
        (0..1000).map(|i| (5.0 * i as f32 / 999.0).exp2() * 0.05).collect()
    }

    #[test]
    fn one_grey_becomes_mid_grey() {
        for grey in [1e-6_f32, 0.18, 3.0, 1e5] {
            let shown = grey * exposure_for(&of([grey; 64])).exp2();
            assert!((shown / 0.18 - 1.0).abs() < 0.01, "{grey} shows as {shown}");
        }
    }

    #[test]
    fn brighter_light_gets_less() {
        let base = exposure_for(&of(ramp()));
        for stops in [-17_i32, -3, 1, 9] {
            let other = exposure_for(&of(ramp().into_iter().map(|x| x * (stops as f32).exp2())));
            assert!((base - other - stops as f32).abs() < 0.02, "{stops} stops brighter: {base} and {other}");
        }
    }

    #[test]
    fn few_odd_pixels_do_not_matter() {
        let base = exposure_for(&of(ramp()));
        let odd = [f32::NAN, f32::INFINITY, 1e30, 0.0, -5.0, 1e-30, 1e20, 3e4];
        let with = exposure_for(&of(ramp().into_iter().chain(odd)));
        assert!((base - with).abs() < 0.1, "{base} and {with}");
        let reversed = exposure_for(&of(ramp().into_iter().rev()));
        assert_eq!(base, reversed, "order does not matter");
    }

    #[test]
    fn bright_pictures_stay_bright_and_dark_ones_dark() {
        let mostly = |many: f32, few: f32| of((0..1000).map(|i| if i % 8 == 0 { few } else { many }));
        let shown = |picture: &Picture, value: f32| value * exposure_for(picture).exp2();
        let snow = shown(&mostly(1.0, 0.05), 1.0);
        let night = shown(&mostly(0.05, 1.0), 0.05);
        assert!(snow > 0.25 && night < 0.14, "snow {snow}, night {night}");
    }

    #[test]
    fn a_lit_thing_before_the_dark_is_not_burnt() {
        // A fifth of the picture is a lit object, all else a dim wall behind it.
        let picture = of((0..1000).map(|i| if i % 5 == 0 { 4.0 } else { 0.02 }));
        let thing = 4.0 * exposure_for(&picture).exp2();
        assert!(thing < 10.0, "it shows as {thing}");
    }

    #[test]
    fn nothing_gets_nothing() {
        for dark in [vec![], vec![0.0; 9], vec![f32::NAN; 9], vec![-1.0; 9]] {
            let stops = exposure_for(&of(dark));
            assert!(stops == 0.0 && stops.is_sign_positive(), "{stops}");
        }
    }
}
