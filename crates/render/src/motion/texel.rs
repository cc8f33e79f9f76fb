// SPDX-License-Identifier: GPL-3.0-or-later
//! Pixels of pictures of which one in four was traced, for the next picture, in half of a cache line. Reflectance and emitted radiance are kept with 11 bits, which is not
//! seen in the three frames until they are traced again. Space: world. Tests: `tests`.

use glam::{Vec3, Vec4};

use super::surface_key::{SurfaceKey, Tint};

/// A pixel.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(super) struct Texel {
    /// Position, and [the number](SurfaceKey::number) of the id.
    p: Vec4,
    /// Shares and plain radiance of the [`Tint`], and the luminance of the light.
    colors: [u16; 8],
}

/// The exponent of floats at which short ones begin: 2^-40; they reach to 2^24.
const LEAST_EXPONENT: u32 = 87;
/// Bits of the mantissa of floats that short ones lack.
const LOST_BITS: u32 = 13;

/// A float without sign in 16 bits: six of the exponent, ten of the mantissa. NaN and negative ones are 0.
#[inline(always)]
fn short(x: f32) -> u16 {
    // `max` answers the number where the other side is NaN.
    let bits = x.max(0.0).to_bits() + (1 << (LOST_BITS - 1));
    (bits.saturating_sub(LEAST_EXPONENT << 23) >> LOST_BITS).min(0xffff) as u16
}

#[inline(always)]
fn long(x: u16) -> f32 {
    f32::from_bits((u32::from(x) << LOST_BITS) + (LEAST_EXPONENT << 23))
}

/// The numbers of a pixel, or a weighted mean of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shown {
    /// As in [`Texel`].
    p: Vec4,
    colors: [f32; 8],
}

impl Shown {
    #[inline(always)]
    pub(super) fn traced(key: &SurfaceKey, tint: &Tint, light: Vec3) -> Self {
        let ([r, g, b], [x, y, z]) = (tint.share.to_array(), tint.plain.to_array());
        let grey = gnurt_image::srgb::luminance(light.into());
        Self { p: key.p.extend(key.number()), colors: [r, g, b, x, y, z, grey, 0.0] }
    }

    /// The mean of four pixels, with this number.
    #[inline(always)]
    pub(super) fn mean(texels: [&Texel; 4], weights: [f32; 4], number: f32) -> Self {
        let (mut p, mut colors) = (Vec4::ZERO, [0.0; 8]);
        for (texel, weight) in texels.into_iter().zip(weights) {
            p += texel.p * weight;
            for (sum, &x) in colors.iter_mut().zip(&texel.colors) {
                *sum += long(x) * weight;
            }
        }
        p.w = number;
        Self { p, colors }
    }

    #[inline(always)]
    pub(super) fn p(&self) -> Vec3 {
        self.p.truncate()
    }

    /// [The number](SurfaceKey::number) of the id.
    #[inline(always)]
    pub(super) fn number(&self) -> f32 {
        self.p.w
    }

    /// Light as it was, grey.
    pub(super) fn light(&self) -> Vec3 {
        Vec3::splat(self.colors[6])
    }

    /// Colour and opacity under a light.
    #[inline(always)]
    pub(super) fn color(&self, light: Vec3) -> [f32; 4] {
        let [r, g, b, x, y, z, ..] = self.colors;
        let opacity = if self.number() == 0.0 { 0.0 } else { 1.0 };
        [x + r * light.x, y + g * light.y, z + b * light.z, opacity]
    }

    #[inline(always)]
    pub(super) fn texel(&self) -> Texel {
        Texel { p: self.p, colors: self.colors.map(short) }
    }
}

impl Texel {
    #[inline(always)]
    pub(super) fn p(&self) -> Vec3 {
        self.p.truncate()
    }

    /// [The number](SurfaceKey::number) of the id.
    #[inline(always)]
    pub(super) fn number(&self) -> f32 {
        self.p.w
    }

    pub(super) fn shown(&self) -> Shown {
        Shown { p: self.p, colors: self.colors.map(long) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_floats_are_near_the_long_ones() {
        for x in [1.0, 0.04, 3.7e-5, 0.999_9, 8.1e6, 0.3, 1e-9] {
            let found = long(short(x));
            assert!((found - x).abs() <= x / 2048.0, "{x}: {found}");
        }
        assert!(long(short(0.0)) < 1e-12 && long(short(-1.0)) < 1e-12 && long(short(f32::NAN)) < 1e-12);
        assert!(long(short(f32::INFINITY)) > 1e7 && long(short(f32::MAX)).is_finite());
    }

    #[test]
    fn means_are_weighted() {
        assert_eq!(size_of::<Texel>(), 32);
        let key = |x: f32| SurfaceKey { p: Vec3::splat(x), ns: Vec3::Z, id: 5, width: 1.0 };
        let tint = |x: f32| Tint { share: Vec3::splat(x), ..Tint::default() };
        let [a, b] = [0.25, 0.5].map(|x| Shown::traced(&key(x), &tint(x), Vec3::ONE).texel());
        let mean = Shown::mean([&a, &a, &b, &b], [0.1, 0.2, 0.3, 0.4], key(0.0).number());
        let expected = 0.3 * 0.25 + 0.7 * 0.5;
        assert!((mean.p().x - expected).abs() < 1e-6 && mean.number() == key(0.0).number());
        let [r, _, _, opacity] = mean.color(Vec3::splat(2.0));
        assert!((r - 2.0 * expected).abs() < 1e-3 && opacity == 1.0, "{r}");
        assert!((mean.light().x - 1.0).abs() < 1e-3, "as it was");
        assert_eq!(Shown::default().color(Vec3::ONE)[3], 0.0, "nothing is there");
    }
}
