// SPDX-License-Identifier: GPL-3.0-or-later
//! Smaller copies of textures, so that a point that stands for many texels reads few.
//! Source: \[Wil83\] (pyramids, interpolation between levels); OpenGL 1.4 section 3.8.8 for filters and sizes (half, rounded
//! down). Each texel is the mean of the area that it covers, in linear light: odd sizes weigh the texels at its edges.
//! Invariant: every level has the mean of the picture. Memory: a third of the picture as floats, made when first asked for.
//! Proof: `tests`; the binding's tests/c/mipmaps.c.

use std::sync::{Arc, OnceLock};

use gnurt_image::Texels;

use crate::texels::{Wrap, fold, texel_of, wrap_index};

/// How a texture is read where a pixel stands for more than a texel.
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
        between_levels: bool,
    },
}

/// The smaller copies of a picture.
#[derive(Debug)]
pub struct MipMap {
    base: Arc<Texels>,
    /// From half the size down to one texel.
    levels: OnceLock<Vec<Level>>,
}

#[derive(Debug)]
struct Level {
    size: [usize; 2],
    texels: Vec<[f32; 4]>,
}

impl MipMap {
    /// Those of a picture; they are made when one is first asked for.
    #[must_use]
    pub fn new(base: Arc<Texels>) -> Self {
        Self { base, levels: OnceLock::new() }
    }

    fn levels(&self) -> &[Level] {
        self.levels.get_or_init(|| {
            let size = [self.base.width as usize, self.base.height as usize];
            let texels = (0..size[0] * size[1]).map(|i| texel_of(&self.base, i)).collect();
            let base = Level { size, texels };
            let smaller = |level: &Level| (level.size != [1, 1]).then(|| level.halved());
            std::iter::successors(smaller(&base), smaller).collect()
        })
    }

    /// The value at texture coordinates that are where they should be, for a `level` above 0, the picture itself.
    #[must_use]
    pub(crate) fn sample(
        &self,
        uv: [f32; 2],
        wrap: [Wrap; 2],
        level: f32,
        minify: Minify,
        base: [f32; 4],
    ) -> [f32; 4] {
        let Minify::Mipmap { linear, between_levels } = minify else { return base };
        let levels = self.levels();
        let at = |number: usize| match number.checked_sub(1).map(|i| &levels[i]) {
            Some(level) if linear => level.bilinear(uv, wrap),
            Some(level) => level.nearest(uv, wrap),
            None => base,
        };
        let level = level.clamp(0.0, levels.len() as f32);
        if !between_levels {
            return at((level + 0.5).floor().min(levels.len() as f32) as usize);
        }
        let (lower, share) = (level.floor() as usize, level.fract());
        let sharp = at(lower);
        if share == 0.0 {
            return sharp;
        }
        let blurred = at(lower + 1);
        std::array::from_fn(|k| sharp[k] + share * (blurred[k] - sharp[k]))
    }
}

impl Level {
    /// Half as large, at least one texel.
    fn halved(&self) -> Self {
        let [width, height] = self.size;
        let [w, h] = self.size.map(|n| (n / 2).max(1));
        let (columns, rows) = (overlaps(width, w), overlaps(height, h));
        let mut texels = Vec::with_capacity(w * h);
        for row in &rows {
            for column in &columns {
                let mut sum = [0.0_f64; 4];
                for (&(y, wy), &(x, wx)) in row.iter().flat_map(|y| column.iter().map(move |x| (y, x))) {
                    let texel = self.texels[y * width + x];
                    (0..4).for_each(|k| sum[k] += wx * wy * f64::from(texel[k]));
                }
                texels.push(sum.map(|s| s as f32));
            }
        }
        Self { size: [w, h], texels }
    }

    fn texel(&self, place: [i64; 2], wrap: [Wrap; 2]) -> [f32; 4] {
        let [column, row] = [0, 1].map(|k| wrap_index(place[k], self.size[k] as u32, wrap[k]));
        self.texels[row * self.size[0] + column]
    }

    /// From the upper left corner, in texels.
    fn place(&self, [u, v]: [f32; 2], wrap: [Wrap; 2]) -> [f32; 2] {
        [fold(u, wrap[0]) * self.size[0] as f32, (1.0 - fold(v, wrap[1])) * self.size[1] as f32]
    }

    fn nearest(&self, uv: [f32; 2], wrap: [Wrap; 2]) -> [f32; 4] {
        self.texel(self.place(uv, wrap).map(|x| x.floor() as i64), wrap)
    }

    fn bilinear(&self, uv: [f32; 2], wrap: [Wrap; 2]) -> [f32; 4] {
        let [x, y] = self.place(uv, wrap).map(|x| x - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let [column, row] = [x.floor() as i64, y.floor() as i64];
        let at = |dx: i64, dy: i64| self.texel([column + dx, row + dy], wrap);
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        std::array::from_fn(|k| {
            let (upper, lower) = (a[k] + fx * (b[k] - a[k]), c[k] + fx * (d[k] - c[k]));
            upper + fy * (lower - upper)
        })
    }
}

/// For each of `m` texels the `n` larger ones' parts that it covers, as numbers and shares that add up to 1.
fn overlaps(n: usize, m: usize) -> Vec<Vec<(usize, f64)>> {
    let size = n as f64 / m as f64;
    let covered = |i: usize| {
        let (from, to) = (i as f64 * size, (i + 1) as f64 * size);
        let share = |k: usize| ((k + 1) as f64).min(to) - (k as f64).max(from);
        let all = (from.floor() as usize..n.min(to.ceil() as usize)).map(|k| (k, share(k) / size));
        all.filter(|&(_, share)| share > 1e-12).collect()
    };
    (0..m).map(covered).collect()
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
    fn every_level_has_the_mean() {
        for (width, height) in [(8, 8), (7, 5), (1, 9), (13, 2), (3, 3)] {
            let grey = |i: usize| ((i * 37) % 11) as f32;
            let pyramid = picture(width, height, grey);
            let n = (width * height) as usize;
            let mean = (0..n).map(grey).sum::<f32>() / n as f32;
            for level in pyramid.levels() {
                let sum: f32 = level.texels.iter().map(|texel| texel[0]).sum();
                assert!(
                    (sum / level.texels.len() as f32 - mean).abs() < 1e-4,
                    "{width} x {height}, {:?}",
                    level.size
                );
            }
            assert_eq!(pyramid.levels().last().map(|level| level.size), Some([1, 1]), "down to one texel");
        }
        let three = picture(3, 1, |i| [3.0, 6.0, 12.0][i]);
        assert_eq!(three.levels()[0].texels[0][0], 7.0, "three in one");
        let five = picture(5, 1, |i| i as f32);
        // 0 and 1 whole, half of 2; half of 2, 3 and 4 whole.
        assert_eq!(
            five.levels()[0].texels.iter().map(|t| t[0]).collect::<Vec<_>>(),
            [0.8, 3.2],
            "shares at edges"
        );
    }

    #[test]
    fn filters_choose_levels() {
        let pyramid = picture(4, 4, |i| if (i / 4 + i) % 2 == 0 { 1.0 } else { 0.0 });
        let at = |level, linear, between_levels| {
            let minify = Minify::Mipmap { linear, between_levels };
            pyramid.sample([0.1, 0.1], [Wrap::Repeat; 2], level, minify, [9.0; 4])[0]
        };
        assert_eq!(at(0.4, true, false), 9.0, "nearer to the picture itself");
        assert_eq!(at(0.6, true, false), 0.5, "nearer to the mean of four");
        assert_eq!(at(0.5, false, true), 4.75, "half-way");
        assert_eq!(at(99.0, true, true), 0.5, "no smaller one is left");
        let minify = Minify::Linear;
        assert_eq!(
            pyramid.sample([0.1; 2], [Wrap::Repeat; 2], 3.0, minify, [9.0; 4])[0],
            9.0,
            "no levels asked for"
        );
    }
}
