// SPDX-License-Identifier: GPL-3.0-or-later
//! Conversions between models of colour that need no primaries.
//! Source: Foley and van Dam, Computer Graphics (hues); IEC 61966-2-1 for sRGB's curve; the NTSC matrices for YIQ that OSL uses.
//! Hues are in [0, 1]. Tests: `tests/colors.rs`.

use crate::math::div;
use crate::number::Number;

/// A number whose comparisons are yes or no: a float, perhaps with derivatives.
pub(crate) trait Single: Number<Real = f32, Mask = bool> {}

impl<N: Number<Real = f32, Mask = bool>> Single for N {}

/// Hue, saturation, value to red, green, blue.
pub(super) fn hsv_to_rgb<N: Single>([h, s, v]: [N; 3]) -> [N; 3] {
    if s.value() < 0.0001 {
        return [v, v, v];
    }
    let h = (h - h.value().floor()) * 6.0;
    let sextant = h.value().floor();
    let f = h - sextant;
    let p = v * s.subtracted_from(1.0);
    let q = v * (s * f).subtracted_from(1.0);
    let t = v * (s * f.subtracted_from(1.0)).subtracted_from(1.0);
    match sextant as i32 {
        0 => [v, t, p],
        1 => [q, v, p],
        2 => [p, v, t],
        3 => [p, q, v],
        4 => [t, p, v],
        _ => [v, p, q],
    }
}

fn smallest<N: Single>([r, g, b]: [N; 3]) -> N {
    let gb = if b.value() > g.value() { g } else { b };
    if gb.value() > r.value() { r } else { gb }
}

fn largest<N: Single>([r, g, b]: [N; 3]) -> N {
    let gb = if b.value() > g.value() { b } else { g };
    if gb.value() > r.value() { gb } else { r }
}

/// Red, green, blue to hue, saturation, value.
pub(super) fn rgb_to_hsv<N: Single>(rgb: [N; 3]) -> [N; 3] {
    let [r, g, b] = rgb;
    let (low, v) = (smallest(rgb), largest(rgb));
    let chroma = v - low;
    let s = if v.value() > 0.0 { chroma / v } else { v.constant(0.0) };
    let mut h = v.constant(0.0);
    if s.value() > 0.0 {
        let (start, x, y) = if r.value() >= v.value() {
            (0.0, g, b)
        } else if g.value() >= v.value() {
            (2.0 / 6.0, b, r)
        } else {
            (4.0 / 6.0, r, g)
        };
        h = (x - y) / (chroma * 6.0) + start;
        if h.value() < 0.0 {
            h = h + 1.0;
        }
    }
    [h, s, v]
}

/// Hue, saturation, lightness to red, green, blue.
pub(super) fn hsl_to_rgb<N: Single>([h, s, l]: [N; 3]) -> [N; 3] {
    let v = if l.value() <= 0.5 { l * (s + 1.0) } else { l * s.subtracted_from(1.0) + s };
    if v.value() <= 0.0 {
        return [v.constant(0.0); 3];
    }
    let low = l * 2.0 - v;
    hsv_to_rgb([h, (v - low) / v, v])
}

/// Red, green, blue to hue, saturation, lightness.
pub(super) fn rgb_to_hsl<N: Single>(rgb: [N; 3]) -> [N; 3] {
    let low = smallest(rgb);
    let [h, _, high] = rgb_to_hsv(rgb);
    let l = (low + high) * 0.5;
    let chroma = high - low;
    let s = if low.value() == high.value() {
        l.constant(0.0)
    } else if l.value() <= 0.5 {
        chroma / (high + low)
    } else {
        chroma / (high.subtracted_from(2.0) - low)
    };
    [h, s, l]
}

/// A row of three times a matrix.
pub(super) fn row_times<N: Single>(v: [N; 3], m: &[[f32; 3]; 3]) -> [N; 3] {
    [0, 1, 2].map(|k| v[0] * m[0][k] + v[1] * m[1][k] + v[2] * m[2][k])
}

/// From YIQ's to red, green, blue, and back; for rows from the left.
pub(super) const RGB_FROM_YIQ: [[f32; 3]; 3] =
    [[1.0, 1.0, 1.0], [0.9557, -0.2716, -1.1082], [0.6199, -0.6469, 1.7051]];
pub(super) const YIQ_FROM_RGB: [[f32; 3]; 3] =
    [[0.299, 0.596, 0.212], [0.587, -0.275, -0.523], [0.114, -0.321, 0.311]];

/// XYZ to chromaticities and luminance.
#[expect(non_snake_case, reason = "xyY and XYZ differ by case")]
pub(super) fn XYZ_to_xyY<N: Single>([x, y, z]: [N; 3]) -> [N; 3] {
    let sum = x + y + z;
    let inverse = if sum.value() >= 1e-6 { sum.constant(1.0) / sum } else { sum.constant(0.0) };
    [x * inverse, y * inverse, y]
}

/// Chromaticities and luminance to XYZ.
#[expect(non_snake_case, reason = "xyY and XYZ differ by case")]
pub(super) fn xyY_to_XYZ<N: Single>([x, y, luminance]: [N; 3]) -> [N; 3] {
    let per_y = if y.value() > 1e-6 { luminance / y } else { y.constant(0.0) };
    [per_y * x, luminance, per_y * (x.subtracted_from(1.0) - y)]
}

/// x^exponent for x above 0, by the system's accurate function.
fn accurate_pow<N: Single>(x: N, exponent: f32) -> N {
    let value = x.value().max(0.0).powf(exponent).min(f32::MAX);
    x.chain(value, || div(exponent * value, x.value()))
}

/// sRGB's encoded numbers to linear ones.
pub(super) fn srgb_to_linear<N: Single>(rgb: [N; 3]) -> [N; 3] {
    rgb.map(|x| {
        if x.value() <= 0.04045 { x * (1.0 / 12.92) } else { accurate_pow((x + 0.055) * (1.0 / 1.055), 2.4) }
    })
}

/// Linear numbers to sRGB's encoded ones.
pub(super) fn linear_to_srgb<N: Single>(rgb: [N; 3]) -> [N; 3] {
    rgb.map(|x| if x.value() <= 0.003_130_8 { x * 12.92 } else { accurate_pow(x, 1.0 / 2.4) * 1.055 - 0.055 })
}
