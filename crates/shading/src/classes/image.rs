// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures of shader classes: texels, wrapping and filter.
//! Source: original; wrapping and texel centres as OpenGL defines them; bilinear after decoding, no mip levels.
//! Space: texture coordinates (s, t); the first row of texels lies at t = 0, texel centres at (i + 0.5) / size.
//! Proof: `tests::{linear_meets_texel_centres, wraps}`.

use std::sync::Arc;

use gnurt_image::{TexelData, Texels};

/// What happens outside [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImageWrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// The image repeats, every other time mirrored.
    MirroredRepeat,
    /// The edge goes on.
    Clamp,
}

/// How points between texel centres are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImageFilter {
    /// The nearest texel.
    Nearest,
    /// Bilinear interpolation.
    #[default]
    Linear,
}

/// A texture.
#[derive(Clone, Debug)]
pub struct Image {
    /// Its texels; the first row is at t = 0.
    pub texels: Arc<Texels>,
    /// Wrapping along s and t.
    pub wrap: [ImageWrap; 2],
    /// Its filter.
    pub filter: ImageFilter,
}

impl Image {
    /// Linear red, green, blue and opacity at (s, t). Coordinates that are not finite count as 0.
    #[must_use]
    pub fn sample(&self, st: [f32; 2]) -> [f32; 4] {
        let size = [self.texels.width, self.texels.height];
        let at = [0, 1].map(|k| {
            let x = if st[k].is_finite() { f64::from(st[k]) } else { 0.0 };
            x * f64::from(size[k])
        });
        let texel = |column: f64, row: f64| {
            let [i, j] = [(column, 0), (row, 1)].map(|(x, k)| self.wrap[k].index(x, size[k]));
            decode(&self.texels.data, j as usize * size[0] as usize + i as usize)
        };
        match self.filter {
            ImageFilter::Nearest => texel(at[0].floor(), at[1].floor()),
            ImageFilter::Linear => {
                let base = at.map(|x| (x - 0.5).floor());
                let weight = [0, 1].map(|k| (at[k] - 0.5 - base[k]) as f32);
                let row = |j: f64| mix(texel(base[0], j), texel(base[0] + 1.0, j), weight[0]);
                mix(row(base[1]), row(base[1] + 1.0), weight[1])
            }
        }
    }
}

impl ImageWrap {
    /// The texel that column or row `x`, an integer of any size, shows.
    fn index(self, x: f64, size: u32) -> u32 {
        let n = f64::from(size);
        let inside = match self {
            Self::Repeat => x.rem_euclid(n),
            Self::MirroredRepeat => {
                let x = x.rem_euclid(2.0 * n);
                if x < n { x } else { 2.0 * n - 1.0 - x }
            }
            Self::Clamp => x,
        };
        inside.clamp(0.0, n - 1.0) as u32
    }
}

fn mix(a: [f32; 4], b: [f32; 4], weight: f32) -> [f32; 4] {
    [0, 1, 2, 3].map(|k| a[k] + (b[k] - a[k]) * weight)
}

/// Texel `i` as linear numbers.
fn decode(data: &TexelData, i: usize) -> [f32; 4] {
    let linear = |byte: u8| f32::from(byte) / 255.0;
    let from_srgb = |byte: u8| {
        let x = linear(byte);
        if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    match data {
        TexelData::Srgb8(v) => {
            let [r, g, b, a] = v[i];
            [from_srgb(r), from_srgb(g), from_srgb(b), linear(a)]
        }
        TexelData::Linear8(v) => v[i].map(linear),
        TexelData::Float(v) => v[i],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two columns, two rows: red is the column, green the row.
    fn checker(wrap: ImageWrap, filter: ImageFilter) -> Image {
        let texels = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[r, g]| [r, g, 0.0, 1.0]);
        let texels = Texels { width: 2, height: 2, data: TexelData::Float(texels.to_vec()) };
        Image { texels: Arc::new(texels), wrap: [wrap; 2], filter }
    }

    #[test]
    fn linear_meets_texel_centres() {
        let image = checker(ImageWrap::Clamp, ImageFilter::Linear);
        assert_eq!(image.sample([0.25, 0.25]), [0.0, 0.0, 0.0, 1.0], "first texel");
        assert_eq!(image.sample([0.75, 0.25]), [1.0, 0.0, 0.0, 1.0], "second column");
        assert_eq!(image.sample([0.25, 0.75]), [0.0, 1.0, 0.0, 1.0], "the second row is at the larger t");
        assert_eq!(image.sample([0.5, 0.5]), [0.5, 0.5, 0.0, 1.0], "middle");
    }

    #[test]
    fn wraps() {
        let red = |wrap, s| checker(wrap, ImageFilter::Nearest).sample([s, 0.0])[0];
        assert_eq!(red(ImageWrap::Repeat, 1.1), 0.0, "starts again");
        assert_eq!(red(ImageWrap::Repeat, -0.1), 1.0, "also to the left");
        assert_eq!(red(ImageWrap::MirroredRepeat, 1.1), 1.0, "comes back");
        assert_eq!(red(ImageWrap::MirroredRepeat, -0.1), 0.0, "also to the left");
        assert_eq!(red(ImageWrap::Clamp, 9.0), 1.0, "the edge goes on");
        assert_eq!(red(ImageWrap::Repeat, f32::NAN), 0.0, "NaN counts as 0");
        assert!(red(ImageWrap::Repeat, 1e30).is_finite(), "far away is no panic");
    }
}
