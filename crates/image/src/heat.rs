// SPDX-License-Identifier: GPL-3.0-or-later
//! False colours for heat maps: from black over blue, red and yellow to white.
//! In: a measure from 0 to 1. Out: linear light. Invariant: luminance rises with the measure, so that
//! a heat map also reads in grey. Tests: `tests::luminance_rises`.

use crate::{Picture, srgb};

/// Encoded colours at equal steps of the measure.
const STOPS: [[f32; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [0.12, 0.10, 0.55],
    [0.60, 0.12, 0.55],
    [0.92, 0.33, 0.22],
    [1.0, 0.76, 0.22],
    [1.0, 1.0, 0.94],
];

/// Linear colour of a measure; below 0 and NaN as 0, above 1 as 1.
#[must_use]
pub fn heat_color(measure: f32) -> [f32; 3] {
    // `clamp` keeps a NaN; `max` returns the other number.
    let position = measure.clamp(0.0, 1.0).max(0.0) * (STOPS.len() - 1) as f32;
    let stop = (position as usize).min(STOPS.len() - 2);
    let share = position - stop as f32;
    std::array::from_fn(|c| srgb::decode(STOPS[stop][c] + share * (STOPS[stop + 1][c] - STOPS[stop][c])))
}

/// A picture of costs, `width * height` of them: white is the highest one. All black if none is above 0.
#[must_use]
pub fn heat_map(width: u32, height: u32, costs: &[f32]) -> Picture {
    let highest = costs.iter().copied().filter(|cost| cost.is_finite()).fold(0.0, f32::max);
    let gain = if highest > 0.0 { 1.0 / highest } else { 0.0 };
    let mut picture = Picture::new(width, height);
    for (pixel, &cost) in picture.color.iter_mut().zip(costs) {
        let [r, g, b] = heat_color(cost * gain);
        *pixel = [r, g, b, 1.0];
    }
    picture.set_metadata("heatMapMaximum", highest.to_string());
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminance_rises() {
        let mut last = -1.0;
        for i in 0..=1000 {
            let luminance = srgb::luminance(heat_color(i as f32 / 1000.0));
            assert!(luminance > last, "luminance falls at {}", i as f32 / 1000.0);
            last = luminance;
        }
    }

    #[test]
    fn odd_measures_have_colours() {
        assert_eq!(heat_color(f32::NAN), heat_color(0.0), "NaN is cold");
        assert_eq!(heat_color(9.0), heat_color(1.0), "too much is white");
    }

    #[test]
    fn the_highest_cost_is_white() {
        let map = heat_map(2, 1, &[4.0, 8.0]);
        assert_eq!(map.color[1][..3], heat_color(1.0), "the highest cost");
        assert_eq!(map.color[0][..3], heat_color(0.5), "half of it");
    }
}
