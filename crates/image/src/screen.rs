// SPDX-License-Identifier: GPL-3.0-or-later
//! From linear light to the pixels of a screen, fast: the bytes that PNG files get, exactly, without a power function.
//! A table over the float's exponent and upper mantissa bits gives the byte at the bottom of each bin;
//! bins are narrower than bytes are apart, so that one comparison with the next byte's threshold makes it exact.
//! Invariant: equals [`screen_bytes`](crate::screen_bytes). Tests: `tests`.

use std::sync::LazyLock;

use crate::srgb::encode_u8;
use crate::tone::ToneCurve;

/// Mantissa bits that a bin is chosen by.
const BITS: u32 = 8;
/// Below this value all bytes are 0.
const LEAST: f32 = 1.0 / 8192.0;
const FIRST: u32 = LEAST.to_bits() >> (23 - BITS);

/// As many bins as there are, and some more: a power of two.
const BINS: usize = 4096;

struct Table {
    /// The byte at the lower end of each bin, from `LEAST` on.
    bins: [u8; BINS],
    /// The smallest value that becomes each byte; NaN beyond 255.
    thresholds: [f32; 257],
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let threshold = |byte: usize| {
        // Positive floats are ordered as their bits are.
        let (mut below, mut above) = (0, 1.0_f32.to_bits());
        while above - below > 1 {
            let middle = below.midpoint(above);
            let reaches = usize::from(encode_u8(f32::from_bits(middle))) >= byte;
            *(if reaches { &mut above } else { &mut below }) = middle;
        }
        f32::from_bits(above)
    };
    let thresholds = std::array::from_fn(|byte| match byte {
        0 => f32::NEG_INFINITY,
        // Nothing reaches it, infinity neither.
        256 => f32::NAN,
        byte => threshold(byte),
    });
    let bins = std::array::from_fn(|bin| {
        let lower_end = f32::from_bits((FIRST + bin as u32) << (23 - BITS));
        encode_u8(lower_end.min(1.0))
    });
    Table { bins, thresholds }
});

/// Pixels that are converted together.
const PIECE: usize = 8;

impl Table {
    /// Bytes of values in 0..=1 from the film; NaN is 0.
    #[inline(always)]
    fn piece(&self, curve: impl Fn(f32) -> f32, gain: f32, colors: &[[f32; 4]; PIECE]) -> [u32; PIECE] {
        // First the arithmetic common to all pixels, then the table lookups: the former is vectorised.
        let (mut values, mut bins) = ([0.0; 4 * PIECE], [0; 4 * PIECE]);
        for (value, &light) in values.iter_mut().zip(colors.as_flattened()) {
            *value = curve(light * gain);
        }
        for (bin, &value) in bins.iter_mut().zip(&values) {
            // Compared in this order NaN is the least.
            let lit = if value > LEAST { value } else { LEAST };
            let lit = if lit < 1.0 { lit } else { 1.0 };
            *bin = (lit.to_bits() >> (23 - BITS)) - FIRST;
        }
        let byte = |i: usize| {
            let byte = self.bins[bins[i] as usize % BINS];
            u32::from(byte) + u32::from(values[i] >= self.thresholds[usize::from(byte) + 1])
        };
        std::array::from_fn(|i| byte(4 * i) << 16 | byte(4 * i + 1) << 8 | byte(4 * i + 2))
    }

    #[inline(always)]
    fn row(&self, curve: impl Fn(f32) -> f32, gain: f32, colors: &[[f32; 4]], out: &mut [u32]) {
        let (pieces, rest) = colors.as_chunks::<PIECE>();
        let (out_pieces, out_rest) = out[..colors.len()].as_chunks_mut::<PIECE>();
        for (out, colors) in out_pieces.iter_mut().zip(pieces) {
            *out = self.piece(&curve, gain, colors);
        }
        if !rest.is_empty() {
            let mut colors = [[0.0; 4]; PIECE];
            colors[..rest.len()].copy_from_slice(rest);
            out_rest.copy_from_slice(&self.piece(&curve, gain, &colors)[..rest.len()]);
        }
    }
}

impl ToneCurve {
    /// Writes the pixels `0x00RRGGBB` of linear colours times `gain`, without their opacity, to the first ones
    /// of `out`.
    ///
    /// # Panics
    /// If `out` is shorter than `colors`.
    pub fn screen_pixels(self, gain: f32, colors: &[[f32; 4]], out: &mut [u32]) {
        let table = &*TABLE;
        match self {
            Self::Clamp => table.row(|x| x, gain, colors, out),
            Self::Reinhard => table.row(|x| Self::Reinhard.apply(x), gain, colors, out),
            Self::Filmic => table.row(|x| Self::Filmic.apply(x), gain, colors, out),
            Self::Agx | Self::Neutral => {
                let mut shown = [[0.0; 4]; 8 * PIECE];
                for (colors, out) in colors.chunks(shown.len()).zip(out.chunks_mut(shown.len())) {
                    for (to, &[r, g, b, a]) in shown.iter_mut().zip(colors) {
                        let [r, g, b] = self.apply_rgb([r * gain, g * gain, b * gain]);
                        *to = [r, g, b, a];
                    }
                    table.row(|x| x, 1.0, &shown[..colors.len()], out);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tone::screen_bytes;

    #[test]
    fn bytes_are_those_of_files() {
        let bits = (0..=1.5_f32.to_bits()).step_by(997).chain(
            // Both sides of each threshold.
            TABLE.thresholds[1..256].iter().flat_map(|t| [t.to_bits() - 1, t.to_bits(), t.to_bits() + 1]),
        );
        let mut values: Vec<f32> = bits.map(f32::from_bits).collect();
        values.extend([-1.0, -0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 300.0]);
        let colors: Vec<[f32; 4]> = values.iter().map(|&x| [x, 0.5 * x, 2.0 * x, 1.0]).collect();
        for (tone, stops) in ToneCurve::ALL.into_iter().flat_map(|tone| [(tone, 0.0_f32), (tone, -2.5)]) {
            let mut out = vec![0; colors.len()];
            tone.screen_pixels(stops.exp2(), &colors, &mut out);
            for (&color, &found) in colors.iter().zip(&out) {
                let [r, g, b, _] = screen_bytes(color, tone, stops).map(u32::from);
                assert_eq!(found, r << 16 | g << 8 | b, "{tone} {stops} of {color:?}");
            }
        }
    }
}
