// SPDX-License-Identifier: GPL-3.0-or-later
//! Structural similarity: means, variances and covariance in a sliding Gaussian window.
//! Source: [Wang2004], eq. 13, with its window of 11 x 11 of deviation 1.5, K1 = 0.01, K2 = 0.03. Differs: windows at the
//! border are cut and their weights made to sum to 1 again, so that small pictures have a value too.
//! In: linear light; taken of luma, the weighted sum of sRGB-encoded values clamped to 0..1 (NaN as 0), so
//! that it follows perception. Out: the mean over all pixels, -1..=1. Tests: `tests::matches_the_definition`.

use crate::{Picture, srgb};

const RADIUS: usize = 5;
const DEVIATION: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity of two pictures of one size.
pub(crate) fn ssim(a: &Picture, b: &Picture) -> f64 {
    let (width, height) = (a.width as usize, a.height as usize);
    let [x, y] = [luma(a), luma(b)];
    let product = |p: &[f64], q: &[f64]| -> Vec<f64> { p.iter().zip(q).map(|(p, q)| p * q).collect() };
    let mean = |values: &[f64]| blur(values, width, height);
    let [mean_x, mean_y] = [mean(&x), mean(&y)];
    let [mean_xx, mean_yy, mean_xy] =
        [mean(&product(&x, &x)), mean(&product(&y, &y)), mean(&product(&x, &y))];
    let similarity = |i: usize| {
        let (mx, my) = (mean_x[i], mean_y[i]);
        let variances = (mean_xx[i] - mx * mx) + (mean_yy[i] - my * my);
        let covariance = mean_xy[i] - mx * my;
        ((2.0 * mx * my + C1) * (2.0 * covariance + C2)) / ((mx * mx + my * my + C1) * (variances + C2))
    };
    (0..x.len()).map(similarity).sum::<f64>() / x.len() as f64
}

fn luma(picture: &Picture) -> Vec<f64> {
    // `clamp` keeps a NaN; `max` returns the other number.
    let encoded = |value: f32| srgb::encode(value.clamp(0.0, 1.0).max(0.0));
    picture
        .color
        .iter()
        .map(|&[r, g, b, _]| f64::from(srgb::luminance([encoded(r), encoded(g), encoded(b)])))
        .collect()
}

/// Weighted means, first along rows, then along columns.
fn blur(values: &[f64], width: usize, height: usize) -> Vec<f64> {
    let along_rows: Vec<f64> = (0..height)
        .flat_map(|y| {
            let row = &values[y * width..(y + 1) * width];
            (0..width).map(move |x| weighted_mean(x, width, |x| row[x]))
        })
        .collect();
    let pixel = |y: usize, x: usize| weighted_mean(y, height, |y| along_rows[y * width + x]);
    (0..height).flat_map(|y| (0..width).map(move |x| (y, x))).map(|(y, x)| pixel(y, x)).collect()
}

fn weighted_mean(center: usize, length: usize, value: impl Fn(usize) -> f64) -> f64 {
    let window = center.saturating_sub(RADIUS)..(center + RADIUS + 1).min(length);
    let [sum, weights] = window.fold([0.0; 2], |[sum, weights], at| {
        let weight = WEIGHTS[at.abs_diff(center)];
        [sum + weight * value(at), weights + weight]
    });
    sum / weights
}

static WEIGHTS: std::sync::LazyLock<[f64; RADIUS + 1]> = std::sync::LazyLock::new(|| {
    std::array::from_fn(|d| (-((d * d) as f64) / (2.0 * DEVIATION * DEVIATION)).exp())
});

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(width: u32, height: u32, step: u32) -> Picture {
        let mut picture = Picture::new(width, height);
        for (i, pixel) in picture.color.iter_mut().enumerate() {
            let hash = (i as u32).wrapping_mul(2_654_435_761).wrapping_add(step.wrapping_mul(40_503)) >> 16;
            *pixel = [hash as f32 / 65536.0, (hash % 256) as f32 / 256.0, 0.3, 1.0];
        }
        picture
    }

    /// The definition, one window of two dimensions at a time.
    fn naive(a: &Picture, b: &Picture) -> f64 {
        let (width, height) = (a.width as i64, a.height as i64);
        let [p, q] = [luma(a), luma(b)];
        let mut sum = 0.0;
        for cy in 0..height {
            for cx in 0..width {
                let mut window = Vec::new();
                for y in (cy - 5).max(0)..(cy + 6).min(height) {
                    for x in (cx - 5).max(0)..(cx + 6).min(width) {
                        let distance = ((x - cx).pow(2) + (y - cy).pow(2)) as f64;
                        window.push(((-distance / 4.5).exp(), (y * width + x) as usize));
                    }
                }
                let total: f64 = window.iter().map(|(w, _)| w).sum();
                let mean =
                    |f: &dyn Fn(usize) -> f64| window.iter().map(|&(w, i)| w * f(i)).sum::<f64>() / total;
                let (mp, mq) = (mean(&|i| p[i]), mean(&|i| q[i]));
                let vp = mean(&|i| (p[i] - mp).powi(2));
                let vq = mean(&|i| (q[i] - mq).powi(2));
                let cov = mean(&|i| (p[i] - mp) * (q[i] - mq));
                sum += (2.0 * mp * mq + 1e-4) * (2.0 * cov + 9e-4)
                    / ((mp * mp + mq * mq + 1e-4) * (vp + vq + 9e-4));
            }
        }
        sum / (width * height) as f64
    }

    #[test]
    fn matches_the_definition() {
        for (width, height) in [(1, 1), (3, 17), (24, 13)] {
            let [a, b] = [pattern(width, height, 1), pattern(width, height, 2)];
            let (fast, slow) = (ssim(&a, &b), naive(&a, &b));
            assert!((fast - slow).abs() < 1e-9, "{width} x {height}: {fast} instead of {slow}");
        }
    }

    #[test]
    fn identical_pictures_have_one() {
        let picture = pattern(20, 20, 1);
        assert!((ssim(&picture, &picture) - 1.0).abs() < 1e-12, "SSIM of a picture with itself");
    }

    #[test]
    fn flat_pictures_have_a_closed_form() {
        let mut white = Picture::new(16, 16);
        white.color.fill([1.0; 4]);
        let expected = 1e-4 / (1.0 + 1e-4);
        let found = ssim(&white, &Picture::new(16, 16));
        assert!((found - expected).abs() < 1e-9, "white and black: {found} instead of {expected}");
    }
}
