// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures at rest without flicker: the displayed colours approach the known ones by steps too small to
//! notice, block by block. A block is 8 x 8 pixels. Its mean brightness changes by no more than `STEP` of
//! itself from picture to picture, or of `DARK` of the whole picture's if it is darker. Its pixels change by
//! no more than `NOISE_STEP` times the root of the samples, so that noise of few samples fades in. If the
//! steps suffice, the known colours are displayed, bit for bit. At the end all are. Linear light. Tests:
//! `tests`.

use gnurt::image::srgb::luminance;

/// Sides of blocks, in pixels.
const BLOCK: usize = 8;
/// Most that a block's mean changes.
const STEP: f32 = 0.018;
/// Most that its pixels change, root of the mean square, where one sample of each is known.
const NOISE_STEP: f32 = 0.06;
/// Share of the whole picture's brightness, below which blocks count as so bright.
const DARK: f32 = 0.05;

/// The displayed colours of a picture at rest.
#[derive(Default)]
pub(crate) struct TemporalFilter {
    /// Columns; 0 = nothing was shown.
    width: usize,
    shown: Vec<[f32; 4]>,
    is_there: bool,
}

impl TemporalFilter {
    /// Starts over: nothing of the next picture was displayed.
    pub(crate) fn forget(&mut self) {
        (self.width, self.is_there) = (0, false);
    }

    /// These colours are shown already.
    pub(crate) fn begin(&mut self, width: usize, colors: &[[f32; 4]]) {
        (self.width, self.is_there) = (width, false);
        self.shown.clear();
        self.shown.extend_from_slice(colors);
    }

    /// Approaches the known colours, which have this number of samples per pixel.
    pub(crate) fn follow(&mut self, width: usize, known: &[[f32; 4]], samples: u32) {
        if self.width != width || self.shown.len() != known.len() {
            self.begin(width, known);
            self.is_there = true;
            return;
        }
        self.is_there = true;
        // The display may be darker everywhere than the known colours.
        let dark = DARK * mean(known.iter()).min(mean(self.shown.iter()));
        let noise_step = NOISE_STEP * (samples.max(1) as f32).sqrt();
        for top in (0..known.len() / width.max(1)).step_by(BLOCK) {
            for left in (0..width).step_by(BLOCK) {
                let change = Change::of(width, &self.shown, known, [left, top]);
                let bright = change.before.max(dark);
                let share = (STEP * bright / change.size).min(noise_step * bright / change.noise_step);
                // No number where nothing changes, or where something is none.
                if share >= 1.0 || share.is_nan() {
                    rows(width, known.len(), [left, top])
                        .for_each(|row| self.shown[row.clone()].copy_from_slice(&known[row]));
                    continue;
                }
                self.is_there = false;
                for i in rows(width, known.len(), [left, top]).flatten() {
                    let (shown, known) = (&mut self.shown[i], &known[i]);
                    (0..4).for_each(|k| shown[k] += (known[k] - shown[k]) * share);
                }
            }
        }
    }

    /// The displayed colours, row by row.
    pub(crate) fn shown(&self) -> &[[f32; 4]] {
        &self.shown
    }

    /// Whether they are the known ones.
    pub(crate) fn is_there(&self) -> bool {
        self.is_there
    }
}

/// How a block changes.
struct Change {
    /// Its mean brightness before.
    before: f32,
    /// How much that changes, in either direction.
    size: f32,
    /// How much the brightness of its pixels does: root of the mean square.
    noise_step: f32,
}

impl Change {
    fn of(width: usize, from: &[[f32; 4]], to: &[[f32; 4]], corner: [usize; 2]) -> Self {
        let [before, after] =
            [from, to].map(|colors| mean(rows(width, colors.len(), corner).flat_map(|row| &colors[row])));
        let pixels = || rows(width, from.len(), corner).flatten();
        let light = |[r, g, b, _]: [f32; 4]| luminance([r, g, b]);
        let squares: f32 = pixels().map(|i| (light(to[i]) - light(from[i])).powi(2)).sum();
        let noise_step = (squares / pixels().count().max(1) as f32).sqrt();
        Self { before, size: (after - before).abs(), noise_step }
    }
}

/// The pixels of a block, row by row.
fn rows(
    width: usize,
    pixels: usize,
    [left, top]: [usize; 2],
) -> impl Iterator<Item = std::ops::Range<usize>> {
    let height = pixels / width;
    let right = (left + BLOCK).min(width);
    (top..(top + BLOCK).min(height)).map(move |y| y * width + left..y * width + right)
}

/// Mean brightness.
fn mean<'a>(colors: impl Iterator<Item = &'a [f32; 4]>) -> f32 {
    let (sum, count) =
        colors.fold((0.0, 0.0), |(sum, n), &[r, g, b, _]| (sum + f64::from(luminance([r, g, b])), n + 1.0));
    (sum / f64::max(count, 1.0)) as f32
}

/// By which share of its brightness the block changes most that changes most, and the mean block, from one picture to the next.
pub(crate) fn flicker(width: usize, from: &[[f32; 4]], to: &[[f32; 4]]) -> [f32; 2] {
    let dark = DARK * mean(to.iter());
    let (mut most, mut sum, mut count) = (0.0_f32, 0.0, 0.0_f32);
    for top in (0..to.len() / width.max(1)).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            let change = Change::of(width, from, to, [left, top]);
            let share = if change.size > 0.0 { change.size / change.before.max(dark) } else { 0.0 };
            (most, sum, count) = (most.max(share), sum + share, count + 1.0);
        }
    }
    [most, sum / count.max(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(value: impl Fn(usize, usize) -> f32) -> Vec<[f32; 4]> {
        (0..21 * 19).map(|i| [value(i % 21, i / 21); 4]).collect()
    }

    #[test]
    fn what_is_shown_gets_there_by_small_steps() {
        let from = picture(|x, y| 1.0 + 0.1 * ((x * 7 + y * 13) % 5) as f32);
        let to = picture(|x, y| if x < 9 { 3.0 } else { 1.0 + 0.1 * ((x * 3 + y * 11) % 5) as f32 });
        let mut temporal_filter = TemporalFilter::default();
        temporal_filter.follow(21, &from, 1);
        assert!(
            temporal_filter.is_there() && temporal_filter.shown() == from,
            "the first one is shown as it is"
        );
        let (mut before, mut steps) = (from, 0);
        while steps == 0 || !temporal_filter.is_there() {
            temporal_filter.follow(21, &to, 1);
            let [most, _] = flicker(21, &before, temporal_filter.shown());
            assert!(most < 0.02, "step {steps}: {most}");
            before = temporal_filter.shown().to_vec();
            steps += 1;
            assert!(steps < 200, "it gets there");
        }
        assert!(temporal_filter.shown() == to && steps > 20, "at last all of it, bit for bit: {steps} steps");
        temporal_filter.forget();
        temporal_filter.follow(21, &picture(|_, _| 9.0), 1);
        assert!(temporal_filter.is_there(), "another picture is shown at once");
    }

    /// Pixels that change while the mean of their block stays.
    #[test]
    fn noise_comes_in_little_by_little() {
        let blocks = |value: fn(usize) -> f32| (0..256).map(|i| [value(i); 4]).collect::<Vec<_>>();
        let (smooth, noisy) = (blocks(|_| 1.0), blocks(|i| 2.0 * (i % 2) as f32));
        let noise_step = |shown: &[[f32; 4]]| {
            let squares: f32 = shown[..8].iter().map(|pixel| (pixel[0] - 1.0).powi(2)).sum();
            (squares / 8.0).sqrt()
        };
        for samples in [1, 16, 1024] {
            let mut temporal_filter = TemporalFilter::default();
            temporal_filter.begin(16, &smooth);
            temporal_filter.follow(16, &noisy, samples);
            let allowed = (NOISE_STEP * (samples as f32).sqrt()).min(1.0);
            let found = noise_step(temporal_filter.shown());
            assert!((found - allowed).abs() < 1e-3, "{samples} samples: {found}, not {allowed}");
            assert_eq!(temporal_filter.is_there(), samples == 1024, "{samples} samples");
        }
    }

    #[test]
    fn flicker_is_told() {
        let still = picture(|_, _| 2.0);
        assert_eq!(flicker(21, &still, &still), [0.0; 2], "none");
        let [most, mean] = flicker(21, &still, &picture(|x, _| if x < 8 { 3.0 } else { 2.0 }));
        assert!(
            (most - 0.5).abs() < 1e-6 && (mean - 0.5 / 3.0).abs() < 1e-6,
            "a third of the blocks: {most} {mean}"
        );
    }
}
