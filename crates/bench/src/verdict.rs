// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether two engines gave the same answers to the same rays. Source: original.
//! Engines round differently, so a ray may pass an edge for one and hit it for another: a few may differ, and are told.
//! Proof: `tests::few_may_differ`.

/// What the answers of an engine come to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sums {
    pub(crate) hits: u64,
    /// Of all hits; 0 where any hit would do, since there `t` is nobody's business.
    pub(crate) sum_t: f64,
}

impl Sums {
    pub(crate) fn of(answers: &[f32], any: bool) -> Self {
        let hits = answers.iter().filter(|t| t.is_finite());
        let sum_t = if any { 0.0 } else { hits.clone().map(|&t| f64::from(t)).sum() };
        Self { hits: hits.count() as u64, sum_t }
    }
}

/// How many rays may be answered differently: this share of them, and one of few.
fn allowance(rays: usize, tolerance: f64) -> u64 {
    (rays as f64 * tolerance).ceil() as u64
}

/// Relative difference of two parameters that are the same hit.
const ROUNDING: f32 = 1e-3;

/// What differs, and the place of a ray for which it does: the one whose `t` differs most, if there is any.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Difference {
    pub(crate) what: String,
    pub(crate) ray: usize,
}

/// Compares ray by ray. Nothing to tell, something to tell, or too much of it.
pub(crate) fn compare(
    reference: &[f32],
    answers: &[f32],
    any: bool,
    tolerance: f64,
) -> Result<Option<Difference>, Difference> {
    let (expected, found) = (Sums::of(reference, any), Sums::of(answers, any));
    if reference.len() != answers.len() {
        let what = format!("{} rays, {} answers", reference.len(), answers.len());
        return Err(Difference { what, ray: 0 });
    }
    let pairs = || reference.iter().zip(answers);
    let is_flipped = |a: f32, b: f32| a.is_finite() != b.is_finite();
    let flips = pairs().filter(|&(&a, &b)| is_flipped(a, b)).count() as u64;
    let is_moved = |a: f32, b: f32| a.is_finite() && b.is_finite() && (a - b).abs() > ROUNDING * a.abs();
    let moved = pairs().filter(|&(&a, &b)| is_moved(a, b)).count() as u64;
    let allowance = allowance(reference.len(), tolerance);
    let tell = || {
        let Sums { hits, sum_t } = found;
        let mut text = format!("{hits} hits, {} expected, {flips} rays hit for one only", expected.hits);
        if !any {
            text +=
                &format!("; {moved} hit elsewhere; sum of t {sum_t:.9e}, {:.9e} expected", expected.sum_t);
        }
        let by = |i: usize| {
            if is_flipped(reference[i], answers[i]) { f32::MAX } else { (reference[i] - answers[i]).abs() }
        };
        let differing = (0..answers.len())
            .filter(|&i| is_flipped(reference[i], answers[i]) || is_moved(reference[i], answers[i]));
        let ray = differing.max_by(|&i, &j| by(i).total_cmp(&by(j))).unwrap_or(0);
        Difference { what: text, ray }
    };
    // Rays that differ in opposite ways do not cancel: ten times as many of those are too many as well.
    if found.hits.abs_diff(expected.hits) > allowance || flips + moved > 10 * allowance {
        return Err(tell());
    }
    Ok((flips + moved > 0).then(tell))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_may_differ() {
        let reference: Vec<f32> =
            (0..200_000).map(|i| if i % 2 == 0 { 5.0 } else { f32::INFINITY }).collect();
        let with = |changes: &[(usize, f32)]| {
            let mut answers = reference.clone();
            for &(i, t) in changes {
                answers[i] = t;
            }
            compare(&reference, &answers, false, 1e-5)
        };
        assert_eq!(with(&[(0, 5.000_01)]), Ok(None), "rounding is not told");
        assert!(
            with(&[(0, f32::INFINITY)]).is_ok_and(|told| told.is_some_and(|told| told.ray == 0)),
            "a lost hit is told"
        );
        let lost = [(0, f32::INFINITY), (2, f32::INFINITY), (4, f32::INFINITY)];
        assert!(with(&lost).is_err(), "three lost hits are too many for 200,000 rays");
        let swapped: Vec<(usize, f32)> =
            (0..22).map(|i| (i, if i % 2 == 0 { f32::INFINITY } else { 5.0 })).collect();
        assert!(with(&swapped).is_err(), "lost and false hits do not cancel");
        let moved: Vec<(usize, f32)> = (0..22).map(|i| (2 * i, 6.0)).collect();
        assert!(with(&moved).is_err(), "nor do hits elsewhere count as hits");
        assert!(compare(&reference, &reference[1..], true, 1e-5).is_err(), "an answer is missing");
    }
}
