// SPDX-License-Identifier: GPL-3.0-or-later
//! Mip maps: smaller copies of textures, so that a footprint of many texels reads few.
//! Source: \[Wil83\] (pyramids, interpolation between levels); OpenGL 1.4 section 3.8.8 (filters); \[MPFJ99\] (several probes along
//! the longer axis of an ellipse). Memory: two thirds of a picture of bytes, one third of one of floats, made
//! at first use.
//! Tests: `tests`; the binding's tests/c/mipmaps.c; crates/render/tests/filtering.rs.

use std::sync::{Arc, OnceLock};

use gnurt_image::{Texels, Weigh};

use crate::texels::{Wrap, bilinear, nearest};

/// The filter of a texture for footprints of more than a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Minify {
    /// The nearest texel.
    Nearest,
    /// Between four texels.
    Linear,
    /// From the nearest level, or between two.
    Mipmap {
        /// Between four texels of a level, not the nearest one.
        linear: bool,
        /// Between two levels, not the nearest one.
        interpolate_levels: bool,
    },
    /// The ellipse of texels of the footprint: from two levels at up to sixteen positions along its longer
    /// axis, as wide as its shorter one.
    Ellipse,
}

/// The smaller copies of a picture.
#[derive(Debug)]
pub struct MipMap {
    base: Arc<Texels>,
    weigh: Weigh,
    /// From half the size down to one texel.
    levels: OnceLock<Vec<Texels>>,
}

/// Largest number of positions along the longer axis of an ellipse; a longer one is treated as wider.
const MOST_TAPS: f32 = 16.0;

impl MipMap {
    /// Those of a picture whose texels have equal weights; they are made at first use.
    #[must_use]
    pub fn new(base: Arc<Texels>) -> Self {
        Self::weighed(base, Weigh::Alike)
    }

    /// The same where texels may count by their opacity.
    #[must_use]
    pub fn weighed(base: Arc<Texels>, weigh: Weigh) -> Self {
        Self { base, weigh, levels: OnceLock::new() }
    }

    fn levels(&self) -> &[Texels] {
        self.levels.get_or_init(|| self.base.pyramid(self.weigh))
    }

    /// The picture itself, or a smaller copy, which must exist.
    fn level(&self, number: usize) -> &Texels {
        number.checked_sub(1).map_or(&*self.base, |i| &self.levels()[i])
    }

    /// The value at texture coordinates that are where they should be, for a `level` above 0, the picture itself.
    #[must_use]
    pub(crate) fn sample(&self, uv: [f32; 2], wrap: [Wrap; 2], level: f32, minify: Minify) -> [f32; 4] {
        let (linear, interpolate_levels) = match minify {
            Minify::Nearest => return nearest(&self.base, uv, wrap),
            Minify::Linear => return bilinear(&self.base, uv, wrap),
            Minify::Mipmap { linear, interpolate_levels } => (linear, interpolate_levels),
            Minify::Ellipse => (true, true),
        };
        let read = if linear { bilinear } else { nearest };
        if interpolate_levels {
            return self.interpolate_levels(uv, wrap, level, read);
        }
        let last = self.levels().len() as f32;
        read(self.level((level + 0.5).floor().clamp(0.0, last) as usize), uv, wrap)
    }

    /// Approximate mean over this number of texels around wrapped coordinates: from the one level of the
    /// nearest texel size. `None` where that is the picture itself.
    #[must_use]
    pub(crate) fn about(&self, uv: [f32; 2], texels: f32, wrap: [Wrap; 2]) -> Option<[f32; 4]> {
        // A texel of level n covers 4^n of them: n is half the exponent, rounded.
        if texels.is_nan() || texels < 2.0 {
            return None;
        }
        let exponent = (texels.to_bits() >> 23) as usize - 127;
        let level = exponent.div_ceil(2).min(self.levels().len());
        Some(bilinear(self.level(level), uv, wrap))
    }

    /// The mean over an ellipse around wrapped coordinates. `axes` are two diameters that cross in its
    /// middle, in texels, x to the right and y upwards: the images of two perpendicular diameters of a
    /// circle. `None` if it is no wider than a texel: the picture itself is read there.
    #[must_use]
    pub(crate) fn over(&self, uv: [f32; 2], axes: [[f32; 2]; 2], wrap: [Wrap; 2]) -> Option<[f32; 4]> {
        let [[ax, ay], [bx, by]] = axes;
        // The larger root of the ellipse's matrix is the square of its longer axis.
        let (xx, xy, yy) = (ax * ax + bx * bx, ax * ay + bx * by, ay * ay + by * by);
        let (half, area) = (0.5 * (xx + yy), (ax * by - ay * bx).abs());
        let long2 = half + (half * half - area * area).max(0.0).sqrt();
        if !(long2 > 1.0 && long2.is_finite()) {
            return None;
        }
        let long = long2.sqrt();
        let short = (area / long).max(long / MOST_TAPS).max(1.0).min(long);
        // More than one position only if it is longer than wide.
        let taps = (long / short - 0.05).ceil().clamp(1.0, MOST_TAPS) as usize;
        let level = short.log2();
        if taps == 1 {
            return Some(self.interpolate_levels(uv, wrap, level, bilinear));
        }
        let along = if xx > yy { [long2 - yy, xy] } else { [xy, long2 - xx] };
        let scale = long / along[0].hypot(along[1]).max(f32::MIN_POSITIVE);
        let step = [along[0] * scale / self.base.width as f32, along[1] * scale / self.base.height as f32];
        let mut sum = [0.0; 4];
        for i in 0..taps {
            let at = (i as f32 + 0.5) / taps as f32 - 0.5;
            let texcoord = [uv[0] + step[0] * at, uv[1] + step[1] * at];
            let found = self.interpolate_levels(texcoord, wrap, level, bilinear);
            (0..4).for_each(|k| sum[k] += found[k]);
        }
        Some(sum.map(|x| x / taps as f32))
    }

    /// From two levels, 0 being the picture itself.
    #[inline]
    fn interpolate_levels(
        &self,
        uv: [f32; 2],
        wrap: [Wrap; 2],
        level: f32,
        read: impl Fn(&Texels, [f32; 2], [Wrap; 2]) -> [f32; 4],
    ) -> [f32; 4] {
        let level = level.clamp(0.0, self.levels().len() as f32);
        let lower = level as usize;
        let share = level - lower as f32;
        let sharp = read(self.level(lower), uv, wrap);
        if share == 0.0 {
            return sharp;
        }
        let blurred = read(self.level(lower + 1), uv, wrap);
        std::array::from_fn(|k| sharp[k] + share * (blurred[k] - sharp[k]))
    }
}

#[cfg(test)]
mod tests {
    use gnurt_image::TexelData;

    use super::*;

    fn picture(width: u32, height: u32, grey: impl Fn(usize) -> f32) -> MipMap {
        let data =
            TexelData::Float((0..(width * height) as usize).map(|i| [grey(i), 0.0, 0.0, 1.0]).collect());
        MipMap::new(Arc::new(Texels { width, height, data }))
    }

    #[test]
    fn filters_choose_levels() {
        let pyramid = picture(4, 4, |i| if (i / 4 + i) % 2 == 0 { 1.0 } else { 0.0 });
        let read = |level, minify| pyramid.sample([0.375, 0.125], [Wrap::Repeat; 2], level, minify)[0];
        let at =
            |level, linear, interpolate_levels| read(level, Minify::Mipmap { linear, interpolate_levels });
        assert_eq!(at(0.4, true, false), 1.0, "nearer to the picture itself");
        assert_eq!(at(0.6, true, false), 0.5, "nearer to the mean of four");
        assert_eq!(at(0.5, false, true), 0.75, "half-way");
        assert_eq!(at(99.0, true, true), 0.5, "no smaller one is left");
        assert_eq!(read(3.0, Minify::Linear), 1.0, "no levels asked for");
    }

    #[test]
    fn areas_choose_the_level_that_is_nearest() {
        // Every texel of level n is n.
        let mut pyramid = picture(16, 16, |_| 0.0);
        let levels = (1..=4).map(|n| {
            let size = 16 >> n;
            let data = TexelData::Float(vec![[n as f32; 4]; (size * size) as usize]);
            Texels { width: size, height: size, data }
        });
        pyramid.levels = OnceLock::from(levels.collect::<Vec<_>>());
        let about = |texels| pyramid.about([0.3, 0.6], texels, [Wrap::Repeat; 2]).map(|t| t[0]);
        for level in 1..=4 {
            let texels = 4.0_f32.powi(level);
            let all = [0.51, 1.0, 1.99].map(|times| about(texels * times));
            assert_eq!(all, [Some(level as f32); 3], "level {level}");
        }
        assert_eq!([0.0, 1.9, f32::NAN, -1.0].map(about), [None; 4], "the picture itself");
        assert_eq!([1e9, f32::INFINITY].map(about), [Some(4.0); 2], "all of it");
    }

    #[test]
    fn ellipses_are_read_along_their_longer_axis() {
        // Stripes along y: each column has one value.
        let stripes = picture(64, 64, |i| ((i % 64) / 4 % 2) as f32);
        let over = |axes: [[f32; 2]; 2]| stripes.over([0.53, 0.5], axes, [Wrap::Repeat; 2]).map(|t| t[0]);
        assert_eq!(over([[0.5, 0.0], [0.0, 0.9]]), None, "no wider than a texel");
        let middle = stripes.over([34.0 / 64.0, 0.5], [[0.0, 12.0], [1.0, 0.0]], [Wrap::Repeat; 2]);
        assert_eq!(middle.map(|t| t[0]), Some(0.0), "long along the stripes: as sharp as ever");
        let across = over([[16.0, 0.0], [0.0, 1.0]]).expect("wide");
        assert!((across - 0.5).abs() < 0.02, "long across them: their mean {across}");
        // The same ellipse by another pair of lengths, and rotated.
        let [c, s] = [0.8_f32, 0.6];
        let turned = over([[16.0 * c, -s], [16.0 * s, c]]).expect("wide");
        assert!((turned - across).abs() < 1e-4, "whatever lines say it: {turned}");
        let all = over([[1e6, 0.0], [0.0, 1e6]]).expect("wide");
        assert!((all - 0.5).abs() < 1e-6, "all of it: {all}");
        assert_eq!(over([[f32::NAN, 0.0], [0.0, 2.0]]), None, "no number");
    }
}
