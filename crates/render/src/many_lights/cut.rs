// SPDX-License-Identifier: GPL-3.0-or-later
//! A sample of the virtual lights for some points, in proportion to their possible contribution there.
//! Source: in the spirit of [WFA*05] (light cuts), but random with known probability, so that the mean does
//! not change.
//! Space: world. The estimate ignores visibility: it uses power, the cosine at the light, and the distance to
//! the points.
//! Invariant: the probability of a light with power is above 0; a function of the points and of one random
//! number.
//! Tests: `tests::samples_keep_the_sum`, crates/render/tests/many_lights.rs.

use glam::Vec3;

use super::eye::EyePoint;
use super::lanes::Source;

/// Virtual lights that neighbouring points gather from, at most.
pub(super) const MOST: usize = 2048;
/// The number of points that represent all.
const WITNESSES: usize = 4;

/// The lights for `points`, weighted; `None` if they may use all of them. `u` in [0, 1).
pub(super) fn cut(points: &[&EyePoint], sources: &[Source], most: usize, u: f32) -> Option<Vec<Source>> {
    if sources.len() <= most || points.is_empty() {
        return None;
    }
    let chosen = cut_of(points, sources, most, u);
    Some(chosen.into_iter().map(|(i, weight)| sources[i].scaled(weight)).collect())
}

/// The same as positions in the list and weights, for one point or more.
pub(super) fn cut_of(points: &[&EyePoint], sources: &[Source], most: usize, u: f32) -> Vec<(usize, f32)> {
    let step = points.len().div_ceil(WITNESSES);
    let witnesses: Vec<Vec3> = points.iter().step_by(step).map(|point| point.point.p).collect();
    let far = |p: Vec3| witnesses.iter().map(|w| w.distance_squared(p)).fold(0.0, f32::max);
    let extent = far(witnesses[0]).max(f32::MIN_POSITIVE);
    let contribution = |source: &Source| {
        let vpl = &source.vpl;
        let to = |w: &Vec3| {
            let offset = *w - vpl.point.p;
            let cos = vpl.point.ng.dot(offset.normalize_or_zero()).max(0.0);
            (0.05 + cos) / (offset.length_squared() + extent)
        };
        f64::from(vpl.strength() * witnesses.iter().map(to).sum::<f32>())
    };
    resample(sources.iter().map(contribution), most, u)
}

/// Chooses `count` times among weights, evenly spaced along their sum: returns positions, and the number of
/// choices of each over its expected number.
pub(super) fn resample(weights: impl Iterator<Item = f64>, count: usize, u: f32) -> Vec<(usize, f32)> {
    let weights: Vec<f64> = weights.map(|w| if w > 0.0 && w.is_finite() { w } else { 0.0 }).collect();
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let count = count as f64;
    let (mut sum, mut chosen) = (0.0, 0.0);
    let mut out = Vec::new();
    for (i, &weight) in weights.iter().enumerate() {
        sum += weight;
        let until = (sum / total * count - f64::from(u)).ceil().clamp(chosen, count);
        let times = until - chosen;
        chosen = until;
        if times > 0.0 {
            out.push((i, (times * total / (count * weight)) as f32));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_keep_the_sum() {
        let weights = [0.1, 3.0, 0.0, 0.7, 1.2, 5.0, 0.01];
        let values = [1.0, 2.0, 99.0, 3.0, -1.0, 0.5, 40.0_f64];
        let requested: f64 = values.iter().zip(&weights).filter(|(_, w)| **w > 0.0).map(|(v, _)| v).sum();
        const N: usize = 20_000;
        let mean: f64 = (0..N)
            .map(|i| {
                let chosen = resample(weights.into_iter(), 3, (i as f32 + 0.5) / N as f32);
                chosen.iter().map(|&(i, weight)| values[i] * f64::from(weight)).sum::<f64>() / N as f64
            })
            .sum();
        assert!((mean - requested).abs() < 0.05 * requested, "{mean} instead of {requested}");
        assert!(resample([0.0; 3].into_iter(), 2, 0.5).is_empty(), "nothing to choose");
    }
}
