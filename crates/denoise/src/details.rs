// SPDX-License-Identifier: GPL-3.0-or-later
//! What a filter took away that was no noise: lines too thin to have neighbours that look alike.
//! Source: original; shrinkage by the ratio of signal to noise, as Wiener's filter. A pixel that stands out alone is noise
//! whose variance was found too small: it needs company. Proof: `tests`.

use crate::noisy::Triple;

/// What differs from the noisy picture by fewer standard deviations is noise.
const STANDS_OUT: f32 = 1.5;

/// Brings details back to `clean` from the noisy `color`, whose variance and smoothed variance these are.
pub(crate) fn bring_back(
    width: usize,
    color: &[Triple],
    variance: &[Triple],
    smooth: &[Triple],
    clean: &mut [Triple],
) {
    let height = color.len() / width;
    // How much of the difference is signal; its sign says whether the noisy pixel is brighter.
    let share = |p: usize, clean: &Triple| {
        [0, 1, 2].map(|k| {
            let apart = color[p][k] - clean[k];
            let noise = STANDS_OUT * STANDS_OUT * smooth[p][k].max(variance[p][k]);
            (1.0 - noise / (apart * apart).max(f32::MIN_POSITIVE)).max(0.0).copysign(apart)
        })
    };
    let shares: Vec<Triple> = clean.iter().enumerate().map(|(p, clean)| share(p, clean)).collect();
    for (p, clean) in clean.iter_mut().enumerate() {
        if shares[p] == [0.0; 3] {
            continue;
        }
        let (x, y) = (p % width, p / width);
        let mut company = [0.0f32; 3];
        for row in y.saturating_sub(1)..(y + 2).min(height) {
            for column in x.saturating_sub(1)..(x + 2).min(width) {
                if [column, row] != [x, y] {
                    let beside = &shares[row * width + column];
                    (0..3).for_each(|k| {
                        company[k] = company[k].max(beside[k] * shares[p][k].signum());
                    });
                }
            }
        }
        for k in 0..3 {
            clean[k] += (color[p][k] - clean[k]) * shares[p][k].abs().min(company[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_back_and_single_pixels_do_not() {
        let (width, height) = (12, 10);
        let mut color = vec![[1.0; 3]; width * height];
        (0..width).for_each(|x| color[3 * width + x] = [3.0; 3]);
        color[7 * width + 5] = [3.0; 3];
        let variance = vec![[0.04; 3]; width * height];
        let mut clean = vec![[1.0; 3]; width * height];
        bring_back(width, &color, &variance, &variance, &mut clean);
        assert!((0..width).all(|x| clean[3 * width + x][1] > 2.9), "the line is there again");
        assert_eq!(clean[7 * width + 5], [1.0; 3], "the pixel is not");
        let noise = vec![[2.0; 3]; width * height];
        let mut clean = vec![[1.0; 3]; width * height];
        bring_back(width, &color, &noise, &noise, &mut clean);
        assert!(clean.iter().all(|c| *c == [1.0; 3]), "within the noise nothing is");
    }
}
