// SPDX-License-Identifier: GPL-3.0-or-later
//! From linear light to the pixels of a screen of any size. Pixels are `0x00RRGGBB`, with the bytes that PNG
//! files get: see [`ToneCurve::screen_pixels`]. Tests: `tests`.

use std::ops::Range;

use gnurt::ThreadPool;
use gnurt::render::FilmBand;
use rayon::prelude::*;

use crate::exposure::Exposure;

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
    let gain = exposure.stops.exp2();
    let tone = |colors: &[[f32; 4]], out: &mut [u32]| exposure.tone.screen_pixels(gain, colors, out);
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
    use gnurt::image::{ToneCurve, screen_bytes};

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
