// SPDX-License-Identifier: GPL-3.0-or-later
//! Fireflies: a pixel's excess over its neighbourhood is removed, and distributed to its surroundings in
//! proportion to their light. A rank among neighbours as in \[DeCoro2010\]'s rejection of outliers, but
//! energy is preserved as far as `MOST` allows. Invariant: pictures times a factor give that factor. Tests:
//! `tests`.

use rayon::prelude::*;

use crate::light::mean;
use crate::noisy::Triple;

/// Pixels to each side that are compared.
const REACH: usize = 3;
/// Pixels to each side among which many bright ones are no outliers, and how many are many.
const WIDER: usize = 7;
const MANY: f32 = 3.0;
/// A highlight has this many pixels beside each other that differ by less than this share.
const COMPANY: usize = 3;
const ALIKE: f32 = 0.4;
/// Light is in rare samples where half of the pixels have less than this share of its mean.
const RARE: f32 = 0.2;
/// Columns and rows of the cells in which light is summed up that was taken.
const CELL: usize = 16;
/// Cells to each side among which it is shared.
const SHARED: usize = 4;
/// Few outliers give little information on how much light is missing: this many are weighted by half.
const BELIEVED: f32 = 8.0;
/// Pixels become brighter by less than this factor.
const MOST: f32 = 30.0;

/// Light that was taken from pixels.
pub(crate) struct Outliers {
    /// Which, and how much.
    taken: Vec<(usize, Triple)>,
    /// By pixel: whether light is in rare samples there.
    pub(crate) rare: Vec<bool>,
}

impl Outliers {
    /// Takes what makes pixels brighter than `brighter` times the neighbour that only an eighth of them is brighter than, or
    /// their mean. Call within a pool of threads.
    pub(crate) fn take(
        width: usize,
        normal: &[Triple],
        brighter: f32,
        (color, variance): (&mut [Triple], &mut [Triple]),
    ) -> Self {
        let light: Vec<f32> = color.iter().map(mean).collect();
        let height = light.len() / width;
        let of_row = |near: &mut Vec<f32>, y: usize| -> Vec<(usize, f32, bool)> {
            let find = |x: usize| {
                let p = y * width + x;
                let (bright, is_rare) = most(&light, normal, [width, height], [x, y], near)?;
                let most = brighter * bright;
                let most = if light[p] <= most {
                    most
                } else if is_rare {
                    most.max(common(&light, normal, [width, height], [x, y]))
                } else if has_company(&light, [width, height], [x, y]) {
                    f32::INFINITY
                } else {
                    most
                };
                (is_rare || light[p] > most).then(|| (p, most / light[p], is_rare))
            };
            (0..width).filter_map(find).collect()
        };
        let found: Vec<Vec<(usize, f32, bool)>> =
            (0..height).into_par_iter().map_init(Vec::new, of_row).collect();
        let mut rare = vec![false; light.len()];
        let take = |(p, retained, is_rare): (usize, f32, bool)| {
            rare[p] = is_rare;
            if retained.is_nan() || retained >= 1.0 {
                return None;
            }
            let before = color[p];
            color[p] = before.map(|x| x * retained);
            variance[p] = variance[p].map(|x| x * retained * retained);
            Some((p, [0, 1, 2].map(|k| before[k] - color[p][k])))
        };
        let taken = found.into_iter().flatten().filter_map(take).collect();
        Self { taken, rare }
    }

    /// Distributes it; `divisor` is the divisor of light.
    pub(crate) fn give_back(&self, width: usize, divisor: &[Triple], color: &mut [Triple]) {
        if self.taken.is_empty() {
            return;
        }
        let (columns, rows) = (width.div_ceil(CELL), (color.len() / width).div_ceil(CELL));
        let cell = |p: usize| p / width / CELL * columns + p % width / CELL;
        // Taken, left, how many.
        let mut cells = vec![([0.0f32; 3], [0.0f32; 3], 0.0f32); columns * rows];
        for (p, light) in &self.taken {
            let (taken, _, count) = &mut cells[cell(*p)];
            (0..3).for_each(|k| taken[k] += light[k] * divisor[*p][k]);
            *count += 1.0;
        }
        for (p, light) in color.iter().enumerate() {
            let (_, left, _) = &mut cells[cell(p)];
            (0..3).for_each(|k| left[k] += light[k] * divisor[p][k]);
        }
        let gain = |at: usize| {
            let (x, y) = (at % columns, at / columns);
            let (mut taken, mut left, mut count) = ([0.0; 3], [0.0; 3], 0.0);
            for row in y.saturating_sub(SHARED)..(y + SHARED + 1).min(rows) {
                for column in x.saturating_sub(SHARED)..(x + SHARED + 1).min(columns) {
                    let (dx, dy) = (column.abs_diff(x), row.abs_diff(y));
                    let weight = 1.0 / (1.0 + 2.0 * (dx * dx + dy * dy) as f32 / (SHARED * SHARED) as f32);
                    let of = &cells[row * columns + column];
                    (0..3).for_each(|k| taken[k] += weight * of.0[k]);
                    (0..3).for_each(|k| left[k] += weight * of.1[k]);
                    count += weight * of.2;
                }
            }
            let believed = count / (count + BELIEVED);
            [0, 1, 2].map(|k| {
                let gain = if left[k] > 0.0 { taken[k] / left[k] * believed } else { 0.0 };
                // Towards MOST without ever reaching it.
                if gain.is_finite() { gain / (1.0 + gain / MOST) } else { MOST }
            })
        };
        let gains: Vec<Triple> = (0..cells.len()).map(gain).collect();
        for (p, light) in color.iter_mut().enumerate() {
            let place = |at: usize, cells: usize| {
                let at = ((at as f32 + 0.5) / CELL as f32 - 0.5).clamp(0.0, (cells - 1) as f32);
                (at as usize, (at as usize + 1).min(cells - 1), at.fract())
            };
            let ((x0, x1, fx), (y0, y1, fy)) = (place(p % width, columns), place(p / width, rows));
            for (k, light) in light.iter_mut().enumerate() {
                let along =
                    |y: usize| gains[y * columns + x0][k] * (1.0 - fx) + gains[y * columns + x1][k] * fx;
                *light *= 1.0 + along(y0) * (1.0 - fy) + along(y1) * fy;
            }
        }
    }
}

/// Whether a bright pixel belongs to a highlight: others beside it are about as bright.
fn has_company(light: &[f32], [width, height]: [usize; 2], [x, y]: [usize; 2]) -> bool {
    let own = light[y * width + x];
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    let bright = rows.flat_map(|row| columns.clone().map(move |column| light[row * width + column]));
    // It is among them.
    bright.filter(|&other| other > ALIKE * own).count() > COMPANY
}

/// How bright pixels are that bring the light around, if there are many; else 0. Where light is in rare samples, most
/// pixels are dark, and those that are not are no outliers.
fn common(light: &[f32], normal: &[Triple], [width, height]: [usize; 2], [x, y]: [usize; 2]) -> f32 {
    let n = normal[y * width + x];
    let is_nothing = n == [0.0; 3];
    let (mut sum, mut squares) = (0.0, 0.0);
    for row in y.saturating_sub(WIDER)..(y + WIDER + 1).min(height) {
        for column in x.saturating_sub(WIDER)..(x + WIDER + 1).min(width) {
            let q = row * width + column;
            let m = normal[q];
            if [column, row] != [x, y] && (is_nothing || n[0] * m[0] + n[1] * m[1] + n[2] * m[2] > 0.5) {
                sum += light[q];
                squares += light[q] * light[q];
            }
        }
    }
    if sum * sum >= MANY * squares && sum > 0.0 { squares / sum } else { 0.0 }
}

/// How bright a pixel's neighbours of about its orientation are, and whether light is in rare samples; `None` if there are too few.
fn most(
    light: &[f32],
    normal: &[Triple],
    [width, height]: [usize; 2],
    [x, y]: [usize; 2],
    near: &mut Vec<f32>,
) -> Option<(f32, bool)> {
    near.clear();
    let n = normal[y * width + x];
    let is_nothing = n == [0.0; 3];
    for row in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
        for column in x.saturating_sub(REACH)..(x + REACH + 1).min(width) {
            let q = row * width + column;
            let m = normal[q];
            if [column, row] != [x, y] && (is_nothing || n[0] * m[0] + n[1] * m[1] + n[2] * m[2] > 0.5) {
                near.push(light[q]);
            }
        }
    }
    if near.len() < 8 {
        return None;
    }
    let rank = near.len() - 1 - near.len() / 8;
    let (_, &mut bright, _) = near.select_nth_unstable_by(rank, f32::total_cmp);
    // In the dark, where few pixels have light at all, those few are all that is known of it.
    let mean = (near.iter().sum::<f32>() + light[y * width + x]) / (near.len() + 1) as f32;
    let half = near.len() / 2;
    let (_, &mut middle, _) = near.select_nth_unstable_by(half, f32::total_cmp);
    Some((bright.max(mean), middle < RARE * mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grey wall with a few pixels that are far too bright.
    fn surface(width: usize, height: usize, light: f32) -> Vec<Triple> {
        let mut color = vec![[light; 3]; width * height];
        for p in (17..color.len()).step_by(331) {
            color[p] = [40.0 * light; 3];
        }
        color
    }

    fn sum(color: &[Triple]) -> f64 {
        color.iter().map(|c| f64::from(c[0])).sum()
    }

    #[test]
    fn light_is_taken_from_single_pixels_and_given_to_all() {
        let (width, height) = (96, 80);
        for light in [1.0, 1e-6] {
            let (normal, before) = (vec![[0.0, 0.0, 1.0]; width * height], surface(width, height, light));
            let (mut color, mut variance) = (before.clone(), vec![[light * light; 3]; width * height]);
            let outliers = Outliers::take(width, &normal, 1.5, (&mut color, &mut variance));
            let brightest = color.iter().map(|c| c[0] / light).fold(0.0, f32::max);
            // One of 28 neighbours or more, at the picture's edge of 15, is forty times as bright.
            assert!(brightest < 0.15 * 40.0, "{brightest} times the light is left");
            assert!(variance.iter().all(|v| v[0] <= light * light), "variances shrink with the light");
            assert!(sum(&color) < 0.95 * sum(&before), "there was something to take");
            outliers.give_back(width, &vec![[1.0; 3]; width * height], &mut color);
            let retained = sum(&color) / sum(&before);
            assert!((retained - 1.0).abs() < 0.05, "of all light there is {retained}");
            let brightest = color.iter().map(|c| c[0] / light).fold(0.0, f32::max);
            assert!(brightest < 0.15 * 40.0, "nobody gets it all: {brightest}");
        }
    }

    #[test]
    fn highlights_and_rare_light_are_no_outliers() {
        let (width, height) = (40, 40);
        let taken = |light: &dyn Fn(usize, usize) -> f32| {
            let at = |p: usize| light(p % width, p / width);
            let mut color: Vec<Triple> = (0..width * height).map(|p| [at(p); 3]).collect();
            let normal = vec![[0.0, 0.0, 1.0]; width * height];
            let mut variance = vec![[0.0; 3]; width * height];
            Outliers::take(width, &normal, 1.5, (&mut color, &mut variance)).taken.len()
        };
        let square = |x: usize, y: usize| (20..22).contains(&x) && (20..22).contains(&y);
        assert_eq!(taken(&|x, y| if square(x, y) { 30.0 } else { 1.0 }), 0, "four pixels together stay");
        assert_eq!(taken(&|x, y| if (x, y) == (20, 20) { 30.0 } else { 1.0 }), 1, "a single one does not");
        // One pixel in nine has all the light.
        let lit = |x: usize, y: usize| x.is_multiple_of(3) && y.is_multiple_of(3);
        assert_eq!(
            taken(&|x, y| if lit(x, y) { 1.0 } else { 0.0 }),
            0,
            "the light is where samples found it"
        );
    }

    #[test]
    fn edges_and_corners_are_no_outliers() {
        let (width, height) = (40, 40);
        let step = |p: usize| if p % width < 20 || p / width < 20 { 1.0 } else { 30.0 };
        let before: Vec<Triple> = (0..width * height).map(|p| [step(p); 3]).collect();
        let (mut color, mut variance) = (before.clone(), vec![[0.0; 3]; width * height]);
        let normal = vec![[0.0, 0.0, 1.0]; width * height];
        let outliers = Outliers::take(width, &normal, 1.5, (&mut color, &mut variance));
        assert!(outliers.taken.is_empty(), "{:?}", outliers.taken);
        assert_eq!(color, before, "nothing was taken");
    }
}
