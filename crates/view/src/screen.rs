// SPDX-License-Identifier: GPL-3.0-or-later
//! From linear light to the pixels of a screen, fast: the bytes that PNG files get, exactly, without a power function.
//! A table over the float's exponent and upper mantissa bits gives the byte at the bottom of each bin;
//! bins are narrower than bytes are apart, so that one comparison with the next byte's threshold makes it exact.
//! Pixels are `0x00RRGGBB`. Invariant: equals `gnurt::image::screen_bytes`. Tests: `tests`.

use std::ops::Range;
use std::sync::LazyLock;

use gnurt::ThreadPool;
use gnurt::image::ToneCurve;
use gnurt::image::srgb::encode_u8;
use gnurt::render::FilmBand;
use rayon::prelude::*;

use crate::exposure::Exposure;

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
    #[inline]
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

    #[inline]
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

/// Some rows of a picture, from the upper ones to the lower ones.
pub(crate) enum Part<'a> {
    /// These are there.
    Colors { rows: Range<u32>, colors: &'a [[f32; 4]] },
    /// These come from the film, and are not stored.
    Passing(FilmBand<'a>),
}

impl<'a> Part<'a> {
    /// A picture of that many columns in parts that are worth a thread's while.
    pub(crate) fn all_of(colors: &'a [[f32; 4]], [columns, rows]: [u32; 2]) -> Vec<Self> {
        let part = |first: u32| {
            let rows = first..(first + 16).min(rows);
            let [begin, end] = [rows.start, rows.end].map(|row| row as usize * columns as usize);
            colors.get(begin..end).map(|colors| Self::Colors { rows, colors })
        };
        (0..rows).step_by(16).map_while(part).collect()
    }

    fn rows(&self) -> Range<u32> {
        match self {
            Self::Colors { rows, .. } => rows.clone(),
            Self::Passing(band) => band.rows(),
        }
    }
}

/// Writes the pixels of a `from[0]` x `from[1]` picture into a screen of `to[0]` x `to[1]` pixels, each
/// repeated as needed. On the threads of `pool`, if there is one. Pixels outside of all parts are black.
pub(crate) fn develop(
    exposure: Exposure,
    parts: Vec<Part>,
    from: [u32; 2],
    to: [u32; 2],
    out: &mut Vec<u32>,
    pool: Option<&ThreadPool>,
) {
    let [columns, rows] = to.map(|x| x as usize);
    let [from_columns, from_rows] = from.map(|x| x as usize);
    out.resize(columns * rows, 0);
    if out.is_empty() || from_columns == 0 || from_rows == 0 {
        return;
    }
    let table = &*TABLE;
    let gain = exposure.stops.exp2();
    let tone = |colors: &[[f32; 4]], out: &mut [u32]| match exposure.tone {
        ToneCurve::Clamp => table.row(|x| x, gain, colors, out),
        ToneCurve::Reinhard => table.row(|x| ToneCurve::Reinhard.apply(x), gain, colors, out),
        ToneCurve::Filmic => table.row(|x| ToneCurve::Filmic.apply(x), gain, colors, out),
        curve @ (ToneCurve::Agx | ToneCurve::Neutral) => {
            let mut shown = [[0.0; 4]; 8 * PIECE];
            for (colors, out) in colors.chunks(shown.len()).zip(out.chunks_mut(shown.len())) {
                for (to, &[r, g, b, a]) in shown.iter_mut().zip(colors) {
                    let [r, g, b] = curve.apply_rgb([r * gain, g * gain, b * gain]);
                    *to = [r, g, b, a];
                }
                table.row(|x| x, 1.0, &shown[..colors.len()], out);
            }
        }
    };
    // The first row of the screen that shows this row of the picture or one below it.
    let shown_from = |source: usize| (source * rows).div_ceil(from_rows);
    let stretch = |line: &[u32], out: &mut [u32]| {
        for (x, out) in out.iter_mut().enumerate() {
            *out = line[x * from_columns / columns];
        }
    };
    let write = |(part, out): (Part, &mut [u32])| {
        let Range { start, end } = part.rows();
        // Few pixels fill several rows of the screen; of many some rows are not seen.
        let first = shown_from(start as usize);
        let mut fill = |source: usize, row: &mut dyn FnMut(&mut [u32])| {
            let [begin, end] = [source, source + 1].map(|row| (shown_from(row) - first) * columns);
            if let Some((top, others)) = out[begin..end].split_at_mut_checked(columns) {
                row(top);
                others.chunks_exact_mut(columns).for_each(|row| row.copy_from_slice(top));
            }
        };
        let colors = match part {
            Part::Colors { colors, .. } => colors,
            Part::Passing(band) if from == to => {
                return band.pieces(|[x, y], colors| {
                    tone(colors, &mut out[(y - start) as usize * columns + x as usize..]);
                });
            }
            Part::Passing(band) => {
                let mut lines = vec![0; (end - start) as usize * from_columns];
                band.pieces(|[x, y], colors| {
                    tone(colors, &mut lines[(y - start) as usize * from_columns + x as usize..]);
                });
                for (source, line) in (start as usize..).zip(lines.chunks_exact(from_columns)) {
                    fill(source, &mut |out| stretch(line, out));
                }
                return;
            }
        };
        let mut line = vec![0; if from_columns == columns { 0 } else { from_columns }];
        for (source, colors) in (start as usize..end as usize).zip(colors.chunks_exact(from_columns)) {
            fill(source, &mut |out| {
                if line.is_empty() {
                    return tone(colors, out);
                }
                tone(colors, &mut line);
                stretch(&line, out);
            });
        }
    };
    let (mut rest, mut next, mut shares) = (&mut out[..], 0, Vec::with_capacity(parts.len()));
    for part in parts {
        let [begin, end] = [part.rows().start, part.rows().end].map(|row| shown_from(row as usize) * columns);
        let (skipped, below) = std::mem::take(&mut rest).split_at_mut(begin - next);
        skipped.fill(0);
        let (share, below) = below.split_at_mut(end - begin);
        shares.push((part, share));
        (rest, next) = (below, end);
    }
    rest.fill(0);
    match pool {
        Some(pool) => pool.install(|| shares.into_par_iter().for_each(write)),
        None => shares.into_iter().for_each(write),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::image::screen_bytes;

    #[test]
    fn bytes_are_those_of_files() {
        let bits = (0..=1.5_f32.to_bits()).step_by(997).chain(
            // Both sides of each threshold.
            TABLE.thresholds[1..256].iter().flat_map(|t| [t.to_bits() - 1, t.to_bits(), t.to_bits() + 1]),
        );
        let mut values: Vec<f32> = bits.map(f32::from_bits).collect();
        values.extend([-1.0, -0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 300.0]);
        let colors: Vec<[f32; 4]> = values.iter().map(|&x| [x, 0.5 * x, 2.0 * x, 1.0]).collect();
        let size = [colors.len() as u32, 1];
        let pool = gnurt::thread_pool(2).expect("two threads");
        for (tone, stops) in ToneCurve::ALL.into_iter().flat_map(|tone| [(tone, 0.0), (tone, -2.5)]) {
            let mut out = Vec::new();
            develop(Exposure { stops, tone }, Part::all_of(&colors, size), size, size, &mut out, Some(&pool));
            for (&color, &found) in colors.iter().zip(&out) {
                let [r, g, b, _] = screen_bytes(color, tone, stops).map(u32::from);
                assert_eq!(found, r << 16 | g << 8 | b, "{tone} {stops} of {color:?}");
            }
        }
    }

    #[test]
    fn few_pixels_fill_any_screen() {
        let colors: Vec<[f32; 4]> = (0..6).map(|i| [i as f32 / 5.0; 4]).collect();
        for to in [[3, 2], [7, 5], [2, 1], [1, 9], [600, 4]] {
            let mut out = vec![7; 3];
            develop(Exposure::default(), Part::all_of(&colors, [3, 2]), [3, 2], to, &mut out, None);
            assert_eq!(out.len() as u32, to[0] * to[1], "the whole screen");
            for (x, y) in [(0, 0), (to[0] - 1, 0), (to[0] / 2, to[1] - 1)] {
                let from = colors[((y * 2 / to[1]) * 3 + x * 3 / to[0]) as usize];
                let [r, g, b, _] = screen_bytes(from, ToneCurve::Clamp, 0.0).map(u32::from);
                let found = out[(y * to[0] + x) as usize];
                assert_eq!(found, r << 16 | g << 8 | b, "{to:?}: pixel {x},{y}");
            }
        }
        let mut out = vec![1; 4];
        develop(Exposure::default(), Vec::new(), [0, 0], [2, 2], &mut out, None);
        develop(Exposure::default(), Vec::new(), [3, 2], [0, 0], &mut out, None);
        assert!(out.is_empty(), "no screen at all");
    }
}
