// SPDX-License-Identifier: GPL-3.0-or-later
//! Smaller copies of a texture (mip levels): half as large, each texel the mean of the area that it covers.
//! Source: \[Wil83\]; OpenGL 1.4 section 3.8.8 for sizes (half, rounded down). In linear light; odd sizes weigh the texels at
//! edges by their shares. Colours of pictures with transparent parts count by their opacity, so that hidden
//! colours do not show at the rims. Copies of a picture in tiles are in tiles of the same cache.
//! Invariant: every level has the mean of the picture. Tests: `tests`.

use crate::texels::{TakeRow, to_floats, to_numbers};
use crate::{Error, TexelData, Texels};

/// The weights of the texels of an area.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Weigh {
    /// All alike.
    #[default]
    Alike,
    /// Colours by their opacity, opacities alike.
    ByOpacity,
    /// All alike, and red, green, blue are directions from 0 = -1 to 1: each counts as a unit one, so that
    /// the length of a mean measures how far they differ.
    Directions,
}

/// Added to opacities, so that fully transparent areas have their texels' mean.
const HOLE: f64 = 1e-6;

/// The texels that one covers, along one side, and their shares, which add up to 1.
type Covered = [(usize, f64); 3];

impl Texels {
    /// The picture half as large, at least one texel: bytes become numbers of 16 bits.
    #[must_use]
    pub fn halved(&self, weigh: Weigh) -> Self {
        self.smaller(
            weigh == Weigh::ByOpacity,
            |texel| if weigh == Weigh::Directions { unit(texel) } else { texel },
        )
    }

    fn smaller(&self, by_opacity: bool, of: impl Fn([f32; 4]) -> [f32; 4]) -> Self {
        let size @ [width, height] = self.half_size();
        let is_even = self.width.is_multiple_of(2) && self.height.is_multiple_of(2);
        let each_row = |take: TakeRow| {
            if is_even && !by_opacity {
                self.means_of_four(&of, take)
            } else {
                self.means(by_opacity, &of, take)
            }
        };
        if let TexelData::Tiled(tiled) = &self.data
            && let Ok(smaller) = tiled.cache().keep_rows(size, self.is_float(), each_row)
        {
            return smaller;
        }
        // Also where the disk is full.
        let count = width as usize * height as usize;
        let data = if self.is_float() {
            TexelData::Float(collect(count, to_floats, each_row))
        } else {
            TexelData::Linear16(collect(count, to_numbers, each_row))
        };
        Self { width, height, data }
    }

    fn half_size(&self) -> [u32; 2] {
        [self.width, self.height].map(|n| (n / 2).max(1))
    }

    /// Makes the rows of the picture half as large, the upper one first.
    fn means(&self, by_opacity: bool, of: impl Fn([f32; 4]) -> [f32; 4], take: TakeRow) -> Result<(), Error> {
        let [width, height] = self.half_size();
        let columns = overlaps(self.width as usize, width as usize);
        let mut line = vec![[0.0; 4]; self.width as usize];
        let mut sums = vec![[0.0_f64; 5]; columns.len()];
        let mut texels = Vec::with_capacity(columns.len());
        for row in overlaps(self.height as usize, height as usize) {
            sums.fill([0.0; 5]);
            for &(y, share) in row.iter().filter(|(_, share)| *share > 0.0) {
                self.read_row(y, &mut line);
                line.iter_mut().for_each(|texel| *texel = of(*texel));
                for (sum, column) in sums.iter_mut().zip(&columns) {
                    for &(x, part) in column {
                        let [r, g, b, a] = line[x].map(f64::from);
                        let opacity = if by_opacity { a + HOLE } else { 1.0 };
                        let weight = share * part * opacity;
                        let more = [r * weight, g * weight, b * weight, a * share * part, weight];
                        (0..5).for_each(|k| sum[k] += more[k]);
                    }
                }
            }
            texels.clear();
            texels.extend(sums.iter().map(|[r, g, b, a, weight]| [r / weight, g / weight, b / weight, *a]));
            take(&texels)?;
        }
        Ok(())
    }

    /// The same, with the same bits, where both sizes are even and texels count alike: most pictures.
    fn means_of_four(&self, of: impl Fn([f32; 4]) -> [f32; 4], take: TakeRow) -> Result<(), Error> {
        let (width, height) = (self.width as usize, self.height as usize);
        let (mut upper, mut lower) = (vec![[0.0; 4]; width], vec![[0.0; 4]; width]);
        let mut texels = vec![[0.0; 4]; width / 2];
        for y in (0..height).step_by(2) {
            self.read_row(y, &mut upper);
            self.read_row(y + 1, &mut lower);
            let fours = upper.chunks_exact(2).zip(lower.chunks_exact(2));
            for (mean, (up, low)) in texels.iter_mut().zip(fours) {
                let [a, b, c, d] = [of(up[0]), of(up[1]), of(low[0]), of(low[1])];
                for k in 0..4 {
                    mean[k] = (f64::from(a[k]) + f64::from(b[k]) + f64::from(c[k]) + f64::from(d[k])) * 0.25;
                }
            }
            take(&texels)?;
        }
        Ok(())
    }

    /// The smaller copies, from half the size down to one texel.
    #[must_use]
    pub fn pyramid(&self, weigh: Weigh) -> Vec<Self> {
        let smaller =
            |texels: &Self, weigh| ([texels.width, texels.height] != [1, 1]).then(|| texels.halved(weigh));
        // Means of directions are shorter, and stay so.
        let then = if weigh == Weigh::Directions { Weigh::Alike } else { weigh };
        std::iter::successors(smaller(self, weigh), |texels| smaller(texels, then)).collect()
    }
}

/// All `count` texels of the rows that `each_row` makes.
fn collect<T>(
    count: usize,
    texel: impl Fn([f64; 4]) -> T,
    each_row: impl FnOnce(TakeRow) -> Result<(), Error>,
) -> Vec<T> {
    let mut texels = Vec::with_capacity(count);
    let done = each_row(&mut |row| {
        texels.extend(row.iter().map(|&mean| texel(mean)));
        Ok(())
    });
    debug_assert!(done.is_ok(), "memory takes all rows");
    texels
}

/// A direction of any length, as a unit one.
fn unit([x, y, z, a]: [f32; 4]) -> [f32; 4] {
    let direction = [x, y, z].map(|x| 2.0 * x - 1.0);
    let length = direction.iter().map(|x| x * x).sum::<f32>().sqrt();
    let [x, y, z] = if length > 0.0 { direction.map(|x| 0.5 + 0.5 * x / length) } else { [0.5, 0.5, 1.0] };
    [x, y, z, a]
}

/// For each of `m` texels its share of the `n` larger ones; `m` is `n / 2`, or 1.
fn overlaps(n: usize, m: usize) -> Vec<Covered> {
    let size = n as f64 / m as f64;
    let covered = |i: usize| {
        let (from, to) = (i as f64 * size, (i + 1) as f64 * size);
        let first = from.floor() as usize;
        std::array::from_fn(|k| {
            let at = first + k;
            let share = ((at + 1) as f64).min(to) - (at as f64).max(from);
            (at.min(n - 1), if at < n && share > 1e-9 { share / size } else { 0.0 })
        })
    };
    (0..m).map(covered).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32, grey: impl Fn(usize) -> f32) -> Texels {
        let data =
            TexelData::Float((0..(width * height) as usize).map(|i| [grey(i), 0.0, 0.0, 1.0]).collect());
        Texels { width, height, data }
    }

    fn first_channel(texels: &Texels) -> Vec<f32> {
        let [width, height] = [texels.width, texels.height].map(|n| n as usize);
        (0..width * height).map(|i| texels.texel(i % width, i / width)[0]).collect()
    }

    #[test]
    fn every_level_has_the_mean() {
        for (width, height) in [(8, 8), (7, 5), (1, 9), (13, 2), (3, 3)] {
            let grey = |i: usize| ((i * 37) % 11) as f32;
            let all = picture(width, height, grey);
            let mean = first_channel(&all).iter().sum::<f32>() / (width * height) as f32;
            let levels = all.pyramid(Weigh::Alike);
            for level in &levels {
                let found = first_channel(level);
                let sum: f32 = found.iter().sum();
                assert!((sum / found.len() as f32 - mean).abs() < 1e-4, "{width} x {height}: {level:?}");
            }
            let last = levels.last().map(|level| [level.width, level.height]);
            assert_eq!(last, Some([1, 1]), "down to one texel");
        }
        let three = picture(3, 1, |i| [3.0, 6.0, 12.0][i]).halved(Weigh::Alike);
        assert_eq!(three.texel(0, 0)[0], 7.0, "three in one");
        // 0 and 1 whole, half of 2; half of 2, 3 and 4 whole.
        let five = picture(5, 1, |i| i as f32).halved(Weigh::Alike);
        assert_eq!(first_channel(&five), [0.8, 3.2], "shares at edges");
    }

    #[test]
    fn means_of_four_have_the_bits_of_all() {
        for form in 0..2 {
            let [width, height] = [6, 4];
            let bytes = |i: u32| i.wrapping_mul(0x9e37_79b9).to_le_bytes();
            let all = 0..width * height;
            let data = match form {
                0 => TexelData::Srgb8(all.map(bytes).collect()),
                _ => TexelData::Float(all.map(|i| bytes(i).map(|x| 1.1 * f32::from(x))).collect()),
            };
            let texels = Texels { width, height, data };
            let four = collect(6, |mean| mean, |take| texels.means_of_four(unit, take));
            let all = collect(6, |mean| mean, |take| texels.means(false, unit, take));
            assert_eq!(four, all, "form {form}");
        }
    }

    #[test]
    fn means_are_of_light_and_of_what_is_there() {
        let data = TexelData::Srgb8(vec![[255, 0, 0, 0], [255, 255, 255, 255]]);
        let texels = Texels { width: 2, height: 1, data };
        let [r, g, _, a] = texels.halved(Weigh::Alike).texel(0, 0);
        assert!((r - 1.0).abs() < 1e-4 && (g - 0.5).abs() < 1e-4, "half of white's light: {g}");
        assert!((a - 0.5).abs() < 1e-4, "half of it is there: {a}");
        let [_, g, _, a] = texels.halved(Weigh::ByOpacity).texel(0, 0);
        assert!((g - 1.0).abs() < 1e-4 && (a - 0.5).abs() < 1e-4, "red hides in a hole: {g}, {a}");
        let holes = Texels { data: TexelData::Srgb8(vec![[0; 4], [255, 255, 255, 0]]), ..texels };
        assert!((holes.halved(Weigh::ByOpacity).texel(0, 0)[1] - 0.5).abs() < 1e-4, "all hole: the mean");
    }

    #[test]
    fn directions_count_as_unit_ones() {
        let data = TexelData::Float(vec![[1.0, 0.5, 0.5, 1.0], [0.5, 0.5, 0.75, 1.0]]);
        let texels = Texels { width: 2, height: 1, data };
        assert_eq!(texels.pyramid(Weigh::Directions)[0].texel(0, 0), [0.75, 0.5, 0.75, 1.0], "x and z alike");
    }
}
