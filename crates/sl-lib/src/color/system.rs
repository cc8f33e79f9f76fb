// SPDX-License-Identifier: GPL-3.0-or-later
//! Definitions of red, green and blue: primaries and a white point, and the values derived from them.
//! Source: the chromaticities are those of the named standards; the table of black bodies is OSL's: even in
//! (T - 800)^(2/3), fifth roots, within 0.1 %. Tests: `tests/colors.rs`.

use std::sync::OnceLock;

use super::convert::{
    RGB_FROM_YIQ, Single, XYZ_to_xyY, YIQ_FROM_RGB, hsl_to_rgb, hsv_to_rgb, linear_to_srgb, rgb_to_hsl,
    rgb_to_hsv, row_times, srgb_to_linear, xyY_to_XYZ,
};
use super::spectrum::{blackbody_xyz, wavelength_xyz};
use crate::math::cbrt;

/// x and y of red, green, blue and white.
type Chromaticities = [[f32; 2]; 4];

const C: [f32; 2] = [0.3101, 0.3162];
const D65: [f32; 2] = [0.3127, 0.3291];
const E: [f32; 2] = [0.333_333_33; 2];
const ACES: [f32; 2] = [0.321_68, 0.337_67];

const SYSTEMS: [(&str, Chromaticities); 13] = [
    ("Rec709", [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], D65]),
    ("sRGB", [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], D65]),
    ("NTSC", [[0.67, 0.33], [0.21, 0.71], [0.14, 0.08], C]),
    ("EBU", [[0.64, 0.33], [0.29, 0.6], [0.15, 0.06], D65]),
    ("PAL", [[0.64, 0.33], [0.29, 0.6], [0.15, 0.06], D65]),
    ("SECAM", [[0.64, 0.33], [0.29, 0.6], [0.15, 0.06], D65]),
    ("SMPTE", [[0.63, 0.34], [0.31, 0.595], [0.155, 0.07], D65]),
    ("HDTV", [[0.67, 0.33], [0.21, 0.71], [0.15, 0.06], D65]),
    ("CIE", [[0.7355, 0.2645], [0.2658, 0.7243], [0.1669, 0.0085], E]),
    ("AdobeRGB", [[0.64, 0.33], [0.21, 0.71], [0.15, 0.06], D65]),
    ("XYZ", [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], E]),
    ("ACES2065-1", [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], ACES]),
    ("ACEScg", [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], ACES]),
];

/// Below this no black body is seen to glow.
const DRAPER: f32 = 800.0;
/// From this temperature on black bodies are computed, below it they are looked up.
const TABLE_END: f32 = 12_000.0;
const TABLE_SIZE: usize = 317;

/// A working space of colours.
#[derive(Clone, Debug)]
pub struct ColorSystem {
    name: &'static str,
    rgb_from_xyz: [[f32; 3]; 3],
    xyz_from_rgb: [[f32; 3]; 3],
    luminance: [f32; 3],
    /// Fifth roots of black bodies' colours; made when the first is asked for, because it takes milliseconds.
    blackbodies: OnceLock<Vec<[f32; 3]>>,
}

impl Default for ColorSystem {
    /// Rec. 709, the language's.
    fn default() -> Self {
        Self::of(&SYSTEMS[0])
    }
}

/// An unknown colour space.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownColorSpace {
    /// Where colours were to come from.
    pub from: String,
    /// Where they were to go.
    pub to: String,
}

impl std::fmt::Display for UnknownColorSpace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Unknown color space transformation \"{}\" -> \"{}\"", self.from, self.to)
    }
}

impl std::error::Error for UnknownColorSpace {}

impl ColorSystem {
    /// The names that [`named`](Self::named) accepts.
    pub fn names() -> impl Iterator<Item = &'static str> {
        SYSTEMS.iter().map(|(name, _)| *name)
    }

    /// The system of this name: `Rec709`, `sRGB`, `NTSC`, `EBU`, `PAL`, `SECAM`, `SMPTE`, `HDTV`, `CIE`, `AdobeRGB`, `XYZ`,
    /// `ACES2065-1` or `ACEScg`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        SYSTEMS.iter().find(|(known, _)| *known == name).map(Self::of)
    }

    fn of((name, chromaticities): &(&'static str, Chromaticities)) -> Self {
        let [r, g, b, white] = chromaticities.map(|[x, y]| [x, y, 1.0 - (x + y)]);
        let cross = |a: [f32; 3], b: [f32; 3]| {
            [a[1] * b[2] - b[1] * a[2], b[0] * a[2] - a[0] * b[2], a[0] * b[1] - b[0] * a[1]]
        };
        let scaled = |v: [f32; 3]| {
            let to_white = (v[0] * white[0] + v[1] * white[1] + v[2] * white[2]) * (1.0 / white[1]);
            v.map(|x| x / to_white)
        };
        let [r, g, b] = [cross(g, b), cross(b, r), cross(r, g)].map(scaled);
        let rgb_from_xyz = [[r[0], g[0], b[0]], [r[1], g[1], b[1]], [r[2], g[2], b[2]]];
        let xyz_from_rgb = inverse(&rgb_from_xyz);
        let mut luminance = [xyz_from_rgb[0][1], xyz_from_rgb[1][1], xyz_from_rgb[2][1]];
        // Where only rounding keeps the sum from being 1.
        let rest = 1.0 - luminance[0] - luminance[1];
        if (rest - luminance[2]).abs() < 0.001 {
            luminance[2] = rest;
        }
        Self { name, rgb_from_xyz, xyz_from_rgb, luminance, blackbodies: OnceLock::new() }
    }

    fn table_of_blackbodies(&self) -> Vec<[f32; 3]> {
        let entry = |i| {
            let root = (i as f32).sqrt();
            self.computed_blackbody((root * root * root) * 2.0 + DRAPER).map(|x| x.powf(0.2))
        };
        (0..TABLE_SIZE).map(entry).collect()
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The weights of red, green and blue in luminance; their sum is 1.
    #[must_use]
    pub fn luminance_weights(&self) -> [f32; 3] {
        self.luminance
    }

    /// The luminance of a colour.
    #[inline]
    #[must_use]
    pub fn luminance<N: crate::Number>(&self, rgb: [N; 3]) -> N {
        rgb[0] * self.luminance[0] + rgb[1] * self.luminance[1] + rgb[2] * self.luminance[2]
    }

    fn computed_blackbody(&self, kelvin: f32) -> [f32; 3] {
        row_times(blackbody_xyz(kelvin), &self.rgb_from_xyz).map(above_zero)
    }

    /// The colour of a black body's radiant exitance, in W/m^2; nearly black below 800 kelvin.
    #[must_use]
    pub fn blackbody(&self, kelvin: f32) -> [f32; 3] {
        if kelvin < DRAPER || kelvin.is_nan() {
            return [1e-6, 0.0, 0.0];
        }
        if kelvin >= TABLE_END {
            return self.computed_blackbody(kelvin);
        }
        let root = cbrt((kelvin - DRAPER) / 2.0);
        let parameter = root * root;
        let i = parameter as usize;
        let rest = parameter - i as f32;
        let table = self.blackbodies.get_or_init(|| self.table_of_blackbodies());
        let (low, high) = (table[i], table[i + 1]);
        [0, 1, 2].map(|k| {
            let x = low[k] * (1.0 - rest) + high[k] * rest;
            let square = x * x;
            (square * square) * x
        })
    }

    /// The colour of light of one wavelength, scaled so that all components are at most 1.
    #[must_use]
    pub fn wavelength_color(&self, nanometres: f32) -> [f32; 3] {
        let rgb = row_times(wavelength_xyz(nanometres), &self.rgb_from_xyz);
        rgb.map(|x| above_zero(x * (1.0 / 2.52_f64) as f32))
    }

    /// A colour of a named space in this one: `color("hsv", ..)`. Known are `RGB`, `rgb`, `linear`, this system's own name,
    /// `hsv`, `hsl`, `YIQ`, `XYZ`, `xyY` and `sRGB`, whose numbers are encoded.
    fn to_rgb<N: Single>(&self, from: &str, c: [N; 3]) -> Option<[N; 3]> {
        Some(match from {
            "RGB" | "rgb" | "linear" => c,
            _ if from == self.name => c,
            "hsv" => hsv_to_rgb(c),
            "hsl" => hsl_to_rgb(c),
            "YIQ" => row_times(c, &RGB_FROM_YIQ),
            "XYZ" => row_times(c, &self.rgb_from_xyz),
            "xyY" => row_times(xyY_to_XYZ(c), &self.rgb_from_xyz),
            "sRGB" => srgb_to_linear(c),
            _ => return None,
        })
    }

    fn out_of_rgb<N: Single>(&self, to: &str, c: [N; 3]) -> Option<[N; 3]> {
        Some(match to {
            "RGB" | "rgb" | "linear" => c,
            _ if to == self.name => c,
            "hsv" => rgb_to_hsv(c),
            "hsl" => rgb_to_hsl(c),
            "YIQ" => row_times(c, &YIQ_FROM_RGB),
            "XYZ" => row_times(c, &self.xyz_from_rgb),
            "xyY" => XYZ_to_xyY(row_times(c, &self.xyz_from_rgb)),
            "sRGB" => linear_to_srgb(c),
            _ => return None,
        })
    }

    /// A colour of one named space in another: `transformc`, and `color("hsv", ..)` with "rgb" as the space to go to.
    ///
    /// # Errors
    /// Where a space has no name that is known. OSL leaves the colour as it is then, and reports the error's text.
    pub fn transform<N: crate::Number<Real = f32, Mask = bool>>(
        &self,
        from: &str,
        to: &str,
        c: [N; 3],
    ) -> Result<[N; 3], UnknownColorSpace> {
        let converted = self.to_rgb(from, c).and_then(|rgb| self.out_of_rgb(to, rgb));
        converted.ok_or_else(|| UnknownColorSpace { from: from.into(), to: to.into() })
    }
}

fn above_zero(x: f32) -> f32 {
    if x < 0.0 { 0.0 } else { x }
}

/// The inverse of a matrix that has one.
fn inverse(m: &[[f32; 3]; 3]) -> [[f32; 3]; 3] {
    let part = |a: usize, b: usize, c: usize, d: usize| m[a][c] * m[b][d] - m[b][c] * m[a][d];
    let s = [
        [part(1, 2, 1, 2), -part(0, 2, 1, 2), part(0, 1, 1, 2)],
        [-part(1, 2, 0, 2), part(0, 2, 0, 2), -part(0, 1, 0, 2)],
        [part(1, 2, 0, 1), -part(0, 2, 0, 1), part(0, 1, 0, 1)],
    ];
    let determinant = m[0][0] * s[0][0] + m[0][1] * s[1][0] + m[0][2] * s[2][0];
    s.map(|row| row.map(|x| x / determinant))
}
