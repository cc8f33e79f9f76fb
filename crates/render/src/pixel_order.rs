// SPDX-License-Identifier: GPL-3.0-or-later
//! The random numbers of each pixel's samples: a sequence of its own, or its part of one sequence for many pixels.
//! Source: [AW20]: pixels in the order of nested squares take their samples one after the other from one sequence, so
//! errors of pixels side by side have opposite signs more often than not. Differs: halves instead of quarters are
//! shuffled, which the scrambled order of `sampling` does anyway.
//! Invariant: different samples of a picture have different keys. Tests: `tests` here, crates/render/tests/noise_color.rs.

use gnurt_shading::SampleKey;

use crate::options::RenderOptions;
use crate::pixel_noise::PixelNoise;

/// Keys of samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelOrder {
    /// Columns of the picture.
    width: u32,
    /// How pixels share sequences, if they do.
    shared: Option<Shared>,
}

/// One sequence for each square of pixels.
#[derive(Clone, Copy, Debug)]
struct Shared {
    /// Numbers for each pixel: a power of two, as parts of a sequence are evenly spread in such blocks only.
    samples: u32,
    /// Binary logarithm of the square's width.
    log: u32,
    /// Squares in a row of the picture.
    columns: u32,
    /// Those of the picture or more; a power of two.
    squares: u32,
}

impl PixelOrder {
    pub(crate) fn new(options: &RenderOptions) -> Self {
        let is_shared = options.pixel_noise == PixelNoise::Blue && !options.integrator.has_virtual_lights();
        let size = [options.width, options.height];
        Self { width: options.width, shared: is_shared.then(|| Shared::new(size, options.spp)) }
    }

    /// The key of a pixel's sample.
    pub(crate) fn key(&self, [x, y]: [u32; 2], sample: u32) -> SampleKey {
        let Some(Shared { samples, log, columns, squares }) = self.shared else {
            return SampleKey { pixel: y * self.width + x, sample, branch: 0 };
        };
        let square = (y >> log) * columns + (x >> log);
        let inside = (1 << log) - 1;
        let place = spread(x & inside) | spread(y & inside) << 1;
        // Samples beyond the number that was asked for have sequences of their own.
        let pixel = square.wrapping_add(squares.wrapping_mul(sample / samples));
        SampleKey { pixel, sample: place * samples + sample % samples, branch: 0 }
    }

    /// The number of the sample within its pixel.
    pub(crate) fn sample(&self, key: SampleKey) -> u32 {
        self.shared.map_or(key.sample, |Shared { samples, squares, .. }| {
            (key.pixel / squares).wrapping_mul(samples).wrapping_add(key.sample % samples)
        })
    }

    /// The pixel of a sample.
    pub(crate) fn pixel(&self, key: SampleKey) -> [u32; 2] {
        let Some(Shared { samples, log, columns, squares }) = self.shared else {
            return [key.pixel % self.width, key.pixel / self.width];
        };
        let (square, place) = (key.pixel % squares, key.sample / samples);
        [(square % columns) << log | gather(place), (square / columns) << log | gather(place >> 1)]
    }
}

impl Shared {
    fn new([width, height]: [u32; 2], samples: u32) -> Self {
        let log_of = |n: u32| n.max(1).checked_next_power_of_two().unwrap_or(1 << 31).trailing_zeros();
        let samples = 1 << log_of(samples);
        // A sequence has 2^32 numbers.
        let log = log_of(width.max(height)).min((32 - log_of(samples)) / 2);
        let squares = |n: u32| n.div_ceil(1 << log);
        let columns = squares(width);
        Self { samples, log, columns, squares: (columns * squares(height)).next_power_of_two() }
    }
}

/// The lower 16 bits, each with a zero above it.
fn spread(n: u32) -> u32 {
    let n = (n | n << 8) & 0x00ff_00ff;
    let n = (n | n << 4) & 0x0f0f_0f0f;
    let n = (n | n << 2) & 0x3333_3333;
    (n | n << 1) & 0x5555_5555
}

/// Every other bit, from the lowest on: the inverse of [`spread`].
fn gather(n: u32) -> u32 {
    let n = n & 0x5555_5555;
    let n = (n | n >> 1) & 0x3333_3333;
    let n = (n | n >> 2) & 0x0f0f_0f0f;
    let n = (n | n >> 4) & 0x00ff_00ff;
    (n | n >> 8) & 0xffff
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// Pictures of one square and of several, samples within the number and beyond: no two keys are equal, and each
    /// gives its pixel and sample back.
    #[test]
    fn keys_are_different_and_known() {
        for (width, height, spp) in
            [(7, 5, 3), (1, 1, 1), (33, 2, 1 << 24), (300, 200, 1 << 20), (5, 9, u32::MAX)]
        {
            for pixel_noise in [PixelNoise::White, PixelNoise::Blue] {
                let options = RenderOptions { width, height, spp, pixel_noise, ..RenderOptions::default() };
                let order = PixelOrder::new(&options);
                let mut keys = HashSet::new();
                for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    for sample in [0, 1, 2, 5, spp - 1] {
                        let key = order.key([x, y], sample);
                        keys.insert((key.pixel, key.sample));
                        assert_eq!((order.pixel(key), order.sample(key)), ([x, y], sample), "{options:?}");
                    }
                }
                let samples: HashSet<u32> = [0, 1, 2, 5, spp - 1].into();
                assert_eq!(keys.len(), (width * height) as usize * samples.len(), "{options:?}");
            }
        }
    }
}
