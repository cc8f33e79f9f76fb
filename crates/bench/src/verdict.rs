// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether two engines gave the same answers to the same rays. Source: original.
//! Engines round differently, so a ray may pass an edge for one and hit it for another: a few may differ, and are told.
//! Triangles are compared too: another one is a right answer only where both are met at the same `t`.
//! Proof: `tests::few_may_differ`, `tests::triangles_are_compared`.

use gnurt::accel::{INVALID_ID, Ray};

use crate::ties::is_tie;
use crate::timing::{Answered, Rays};

/// What the answers of an engine come to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sums {
    pub(crate) hits: u64,
    /// Of all hits; 0 where any hit would do, since there `t` is nobody's business.
    pub(crate) sum_t: f64,
}

impl Sums {
    pub(crate) fn of(answers: &Answered, any: bool) -> Self {
        let hits = answers.t.iter().filter(|t| t.is_finite());
        let sum_t = if any { 0.0 } else { hits.clone().map(|&t| f64::from(t)).sum() };
        Self { hits: hits.count() as u64, sum_t }
    }
}

/// How many rays may be answered differently: this share of them, and one of few.
fn allowance(rays: usize, tolerance: f64) -> u64 {
    (rays as f64 * tolerance).ceil() as u64
}

/// Relative difference of two parameters that are the same hit.
const ROUNDING: f32 = 1e-5;

/// How far apart parameters of one hit may be: a share of `t`, and what a few roundings of the origin's coordinates move a
/// surface by, without which no two engines agree on what is close to a ray's start.
fn slack(ray: &Ray, t: f32) -> f32 {
    let greatest = |v: [f32; 3]| v.iter().fold(0.0f32, |most, x| most.max(x.abs()));
    ROUNDING * t.abs() + 8.0 * f32::EPSILON * greatest(ray.org) / greatest(ray.dir)
}

/// How the answers to a ray differ.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A hit for one only.
    Flipped,
    /// At another `t`.
    Moved,
    /// At the same `t`, on a triangle that is not met there.
    Other,
}

/// What differs, and the place of a ray for which it does: the one whose `t` differs most, if there is any.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Difference {
    pub(crate) what: String,
    pub(crate) ray: usize,
}

/// Compares ray by ray. Nothing to tell, something to tell, or too much of it.
pub(crate) fn compare(
    reference: &Answered,
    answers: &Answered,
    rays: &Rays,
    tolerance: f64,
) -> Result<Option<Difference>, Difference> {
    let (expected, found) = (Sums::of(reference, rays.any), Sums::of(answers, rays.any));
    if reference.t.len() != answers.t.len() || answers.prim_id.len() != answers.t.len() {
        let what = format!("{} rays, {} answers", reference.t.len(), answers.t.len());
        return Err(Difference { what, ray: 0 });
    }
    let by = |i: usize| (reference.t[i] - answers.t[i]).abs();
    let kind = |i: usize, ray: &Ray| {
        let (a, b) = (reference.t[i], answers.t[i]);
        let (p, q) = (reference.prim_id[i], answers.prim_id[i]);
        if a.is_finite() != b.is_finite() {
            Some(Kind::Flipped)
        } else if a.is_finite() && by(i) > slack(ray, a) {
            Some(Kind::Moved)
        } else if p != q && p != INVALID_ID && q != INVALID_ID && !is_tie(&rays.triangles, ray, p, q) {
            Some(Kind::Other)
        } else {
            None
        }
    };
    let mut counts = [0; 3];
    let mut worst: Option<(f32, usize)> = None;
    let all = rays.chunks.iter().flat_map(|chunk| (0..chunk.len()).map(|lane| chunk.get(lane)));
    for (i, ray) in all.enumerate() {
        if let Some(kind) = kind(i, &ray) {
            counts[kind as usize] += 1u64;
            let by = if kind == Kind::Flipped { f32::MAX } else { by(i) };
            if worst.is_none_or(|(most, _)| by >= most) {
                worst = Some((by, i));
            }
        }
    }
    let [flips, moved, other] = counts;
    let allowance = allowance(reference.t.len(), tolerance);
    let tell = || {
        let Sums { hits, sum_t } = found;
        let mut text = format!("{hits} hits, {} expected, {flips} rays hit for one only", expected.hits);
        if !rays.any {
            text += &format!("; {moved} hit elsewhere, {other} another triangle that is not there");
            text += &format!("; sum of t {sum_t:.9e}, {:.9e} expected", expected.sum_t);
        }
        Difference { what: text, ray: worst.map_or(0, |(_, ray)| ray) }
    };
    // Rays that differ in opposite ways do not cancel: ten times as many of those are too many as well.
    if found.hits.abs_diff(expected.hits) > allowance || flips + moved + other > 10 * allowance {
        return Err(tell());
    }
    Ok((flips + moved + other > 0).then(tell))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::accel::{RayBatch, Triangles};

    /// Rays down to the triangles 0, 1 and 2: 1 lies on 0, and 2 is elsewhere.
    const POSITIONS: [[f32; 3]; 4] = [[0., 0., 0.], [9., 0., 0.], [0., 9., 0.], [0., 0., 9.]];
    const TRIANGLES: Triangles =
        Triangles { positions: &POSITIONS, indices: &[[0, 1, 2], [1, 2, 0], [0, 1, 3]] };

    fn rays(n: usize, any: bool) -> Rays<'static> {
        let ray = Ray::new([1.0, 1.0, 5.0], [0.0, 0.0, -1.0]);
        Rays::new(vec![RayBatch::from_iter(vec![ray; n])], any, TRIANGLES)
    }

    fn answered(t: Vec<f32>) -> Answered {
        let prim_id = t.iter().map(|t| if t.is_finite() { 0 } else { INVALID_ID }).collect();
        Answered { t, prim_id }
    }

    #[test]
    fn few_may_differ() {
        let rays = rays(200_000, false);
        let reference: Vec<f32> =
            (0..200_000).map(|i| if i % 2 == 0 { 5.0 } else { f32::INFINITY }).collect();
        let with = |changes: &[(usize, f32)]| {
            let mut answers = reference.clone();
            for &(i, t) in changes {
                answers[i] = t;
            }
            compare(&answered(reference.clone()), &answered(answers), &rays, 1e-5)
        };
        assert_eq!(with(&[(0, 5.000_01)]), Ok(None), "rounding is not told");
        assert!(with(&[(0, 5.000_1)]).is_ok_and(|told| told.is_some()), "more than rounding is");
        assert!(
            with(&[(0, f32::INFINITY)]).is_ok_and(|told| told.is_some_and(|told| told.ray == 0)),
            "a lost hit is told"
        );
        let lost = [(0, f32::INFINITY), (2, f32::INFINITY), (4, f32::INFINITY)];
        assert!(with(&lost).is_err(), "three lost hits are too many for 200,000 rays");
        let swapped: Vec<(usize, f32)> =
            (0..22).map(|i| (i, if i % 2 == 0 { f32::INFINITY } else { 5.0 })).collect();
        assert!(with(&swapped).is_err(), "lost and false hits do not cancel");
        let moved: Vec<(usize, f32)> = (0..22).map(|i| (2 * i, 5.001)).collect();
        assert!(with(&moved).is_err(), "nor do hits elsewhere count as hits");
        let short = Answered { t: reference[1..].to_vec(), prim_id: vec![0; 199_999] };
        assert!(compare(&answered(reference.clone()), &short, &rays, 1e-5).is_err(), "an answer is missing");
    }

    #[test]
    fn triangles_are_compared() {
        let (rays, reference) = (rays(30, false), answered(vec![5.0; 30]));
        let with = |prim_id: u32, n: usize| {
            let mut answers = reference.clone();
            answers.prim_id[..n].fill(prim_id);
            compare(&reference, &answers, &rays, 1e-5)
        };
        assert_eq!(with(1, 30), Ok(None), "what lies on it is hit, too");
        assert!(with(2, 30).is_err(), "what is not met there is not");
        assert!(with(2, 1).is_ok_and(|told| told.is_some()), "one is told");
        assert_eq!(with(INVALID_ID, 30), Ok(None), "who does not say which is believed");
    }
}
