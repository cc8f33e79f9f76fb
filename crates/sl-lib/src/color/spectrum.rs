// SPDX-License-Identifier: GPL-3.0-or-later
//! Spectra as colours: black bodies and light of one wavelength, in XYZ.
//! Source: Planck's law; the idea of a table and its spacing from OSL, with John Walker's constants (specrend, public domain).
//! Temperatures are in kelvin, wavelengths in nanometres, radiant exitance in W/m^2.
//! Tests: `tests/colors.rs`.

use super::matching::MATCHING;
use crate::math::expm1;

/// Emission of a black body at one wavelength, in W/m^2 for a metre of the spectrum.
fn planck(wavelength_nm: f32, kelvin: f32) -> f32 {
    const C1: f32 = 3.741_83e-16;
    const C2: f32 = 1.438_8e-2;
    let metres = wavelength_nm * 1e-9;
    let square = metres * metres;
    let fifth = (square * square) * metres;
    (C1 * (1.0 / fifth)) / expm1(C2 / (metres * kelvin))
}

/// XYZ of a black body's radiant exitance.
pub(super) fn blackbody_xyz(kelvin: f32) -> [f32; 3] {
    const WIDTH: f32 = 5e-9;
    let mut sum = [0.0; 3];
    for (i, matching) in MATCHING.iter().enumerate() {
        let exitance = planck(380.0 + 5.0 * i as f32, kelvin) * WIDTH;
        for (sum, matching) in sum.iter_mut().zip(matching) {
            *sum += exitance * matching;
        }
    }
    sum
}

/// XYZ of light of one wavelength in nanometres by the CIE's observer of 1931; black outside of the visible range, 380 to 780 nm.
#[must_use]
pub fn wavelength_xyz(wavelength_nm: f32) -> [f32; 3] {
    let parameter = (wavelength_nm - 380.0) / 5.0;
    let i = parameter as i32;
    if !(0..80).contains(&i) || parameter.is_nan() {
        return [0.0; 3];
    }
    let (low, high) = (MATCHING[i as usize], MATCHING[i as usize + 1]);
    let rest = parameter - i as f32;
    [0, 1, 2].map(|k| low[k] * (1.0 - rest) + high[k] * rest)
}
