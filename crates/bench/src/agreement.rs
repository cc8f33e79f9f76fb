// SPDX-License-Identifier: GPL-3.0-or-later
//! Agreement of two engines on the same rays, and the engine at fault where they differ. Where answers
//! differ, both are compared with the exact values for their triangles (`exact.rs`): an answer is wrong if
//! its triangle is missed, if its `t` is off, or if the other's triangle is surely hit nearer. A ray that
//! passes an edge so closely that both of its triangles may count as hit or missed is undecided. If an answer
//! names no triangle, or if any would do, all are tested. More than a few wrong answers of our own end a
//! benchmark; those of a reference engine are reported.
//! Tests: `tests`.

use gnurt::accel::{INVALID_ID, Ray, Triangles};

use crate::exact::{Truth, truth};
use crate::ties::{BESIDE, is_tie, meet};
use crate::timing::{Answered, Rays};

/// Sums over the answers of an engine.
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

/// Relative error of a parameter that is right.
const ROUNDING: f64 = 1e-5;

/// Rays that are tested against all triangles: beyond these no fault is attributed.
const MOST_LOOKED_AT: u64 = 500;

/// Allowed wrong answers of a reference engine, as a fraction of the rays: hits and misses; all together. Its
/// usual test is not watertight, and near large triangles its `t` has the precision of floats; but an engine
/// that is called wrongly gives other answers to most rays.
const REFERENCES: [f64; 2] = [1e-2, 0.5];

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

/// The engine at fault for a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrong {
    First,
    Second,
    Both,
    /// It passes an edge.
    Nobody,
    /// Undecided.
    Somebody,
}

impl Wrong {
    fn of(first: bool, second: bool) -> Self {
        match (first, second) {
            (true, true) => Self::Both,
            (true, false) => Self::First,
            (false, true) => Self::Second,
            (false, false) => Self::Nobody,
        }
    }
}

/// An answer to one ray.
#[derive(Clone, Copy)]
struct Answer {
    t: f32,
    prim_id: u32,
}

/// Which of two hits is not one; where both are, which one is not the nearer.
fn judge(triangles: &Triangles, ray: &Ray, a: Answer, b: Answer) -> Wrong {
    let met = |answer: Answer| truth(triangles, ray, answer.prim_id).filter(|truth| truth.inside >= -BESIDE);
    let good = |answer: Answer, truth: Option<Truth>| {
        truth.is_some_and(|truth| (f64::from(answer.t) - truth.t).abs() <= ROUNDING * truth.t.abs())
    };
    let (true_a, true_b) = (met(a), met(b));
    match (true_a.filter(|_| good(a, true_a)), true_b.filter(|_| good(b, true_b))) {
        (Some(true_a), Some(true_b)) => {
            let apart = (true_a.t - true_b.t).abs() > ROUNDING * true_a.t.abs().min(true_b.t.abs());
            let nearer_is_met =
                |nearer: Truth, farther: Truth| apart && nearer.t < farther.t && nearer.inside > 0.0;
            Wrong::of(nearer_is_met(true_b, true_a), nearer_is_met(true_a, true_b))
        }
        (good_a, good_b) => Wrong::of(good_a.is_none(), good_b.is_none()),
    }
}

/// Which of a hit and a miss is wrong: of a hit on a known triangle, or, without one, of any.
fn judge_flip(triangles: &Triangles, ray: &Ray, hit: Answer, hit_is_first: bool) -> Wrong {
    let inside = if hit.prim_id == INVALID_ID {
        let count = triangles.indices.len() as u32;
        let met = (0..count).filter(|&prim_id| meet(triangles, ray, prim_id).is_some());
        let truths = met.filter_map(|prim_id| truth(triangles, ray, prim_id));
        let in_range = |truth: &Truth| truth.t >= f64::from(ray.t_near) && truth.t <= f64::from(ray.t_far);
        truths.filter(in_range).map(|truth| truth.inside).fold(f64::NEG_INFINITY, f64::max)
    } else {
        truth(triangles, ray, hit.prim_id).map_or(f64::NEG_INFINITY, |truth| truth.inside)
    };
    let (hit_is_wrong, miss_is_wrong) = (inside < -BESIDE, inside > 0.0);
    if hit_is_first { Wrong::of(hit_is_wrong, miss_is_wrong) } else { Wrong::of(miss_is_wrong, hit_is_wrong) }
}

/// A description of the differences, and the index of the ray whose `t` differs most, if there is any.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Difference {
    pub(crate) what: String,
    pub(crate) ray: usize,
}

/// The compared engines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Names<'a> {
    pub(crate) first: &'a str,
    pub(crate) second: &'a str,
}

/// Numbers of differing rays, by the engine at fault: flips, and all of them.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    flips: u64,
    all: u64,
}

impl Tally {
    fn count(&mut self, kind: Kind) {
        self.flips += u64::from(kind == Kind::Flipped);
        self.all += 1;
    }

    /// Whether it is more than these shares of this many rays, and one of few.
    fn is_above(self, rays: usize, [flips, all]: [f64; 2]) -> bool {
        let most = |share: f64| (rays as f64 * share).ceil() as u64;
        self.flips > most(flips) || self.all > most(all)
    }
}

/// Compares ray by ray. Reports nothing, something, or a failure. A failure is more than a fraction
/// `tolerance` of the rays with wrong hits or misses, or ten times as many with any fault, by the first
/// engine, by one of the same name, or undecided. Other engines have wider limits.
pub(crate) fn compare(
    first: &Answered,
    second: &Answered,
    names: Names,
    rays: &Rays,
    tolerance: f64,
) -> Result<Option<Difference>, Difference> {
    let count = first.t.len();
    if second.t.len() != count || second.prim_id.len() != count {
        let what = format!("{count} rays, {} answers", second.t.len());
        return Err(Difference { what, ray: 0 });
    }
    let triangles = &rays.triangles;
    let by = |i: usize| {
        let (a, b) = (f64::from(first.t[i]), f64::from(second.t[i]));
        (a - b).abs() / a.abs().max(b.abs()).max(f64::MIN_POSITIVE)
    };
    let kind = |i: usize, ray: &Ray| {
        let (a, b) = (first.t[i], second.t[i]);
        let (p, q) = (first.prim_id[i], second.prim_id[i]);
        if a.is_finite() != b.is_finite() {
            Some(Kind::Flipped)
        } else if a.is_finite() && by(i) > ROUNDING {
            Some(Kind::Moved)
        } else if p != q && p != INVALID_ID && q != INVALID_ID && !is_tie(triangles, ray, p, q) {
            Some(Kind::Other)
        } else {
            None
        }
    };
    let mut kinds = [0u64; 3];
    let [mut of_first, mut of_second, mut nobodys, mut somebodys] = [Tally::default(); 4];
    let (mut most, mut worst) = (0.0f64, None);
    let all = rays.chunks.iter().flat_map(|chunk| (0..chunk.len()).map(|lane| chunk.get(lane)));
    for (i, ray) in all.enumerate() {
        let Some(kind) = kind(i, &ray) else { continue };
        kinds[kind as usize] += 1;
        let [a, b] = [first, second].map(|all| Answer { t: all.t[i], prim_id: all.prim_id[i] });
        let hit_is_first = a.t.is_finite();
        let hit = if hit_is_first { a } else { b };
        let wrong = match kind {
            Kind::Flipped if kinds[0] > MOST_LOOKED_AT && hit.prim_id == INVALID_ID => Wrong::Somebody,
            Kind::Flipped => judge_flip(triangles, &ray, hit, hit_is_first),
            _ if a.prim_id == INVALID_ID || b.prim_id == INVALID_ID => Wrong::Somebody,
            _ => judge(triangles, &ray, a, b),
        };
        let tallies: &mut [&mut Tally] = match wrong {
            Wrong::First => &mut [&mut of_first],
            Wrong::Second => &mut [&mut of_second],
            Wrong::Both => &mut [&mut of_first, &mut of_second],
            Wrong::Nobody => &mut [&mut nobodys],
            Wrong::Somebody => &mut [&mut somebodys],
        };
        tallies.iter_mut().for_each(|tally| tally.count(kind));
        if kind != Kind::Flipped {
            most = most.max(by(i));
        }
        let by = if kind == Kind::Flipped { f64::MAX } else { by(i) };
        if worst.is_none_or(|(most, _)| by >= most) {
            worst = Some((by, i));
        }
    }
    let differing: u64 = kinds.iter().sum();
    if differing == 0 {
        return Ok(None);
    }
    let report = || {
        let [flips, moved, other] = kinds;
        let mut what = format!("{differing} of {count} answers differ: {flips} rays hit for one only");
        if !rays.any {
            what += &format!(
                ", {moved} hit elsewhere, by up to {most:.1e} of t, {other} another triangle that is not there"
            );
        }
        let Names { first, second } = names;
        what += &format!(
            "; by exact arithmetic {} of {second} are wrong, {} of {first}",
            of_second.all, of_first.all
        );
        if nobodys.all > 0 {
            what += &format!(", {} pass an edge", nobodys.all);
        }
        if somebodys.all > 0 {
            what += &format!(", {} are undecided", somebodys.all);
        }
        Difference { what, ray: worst.map_or(0, |(_, ray)| ray) }
    };
    let strict = [tolerance, 10.0 * tolerance];
    let of_reference = if names.first == names.second { strict } else { REFERENCES };
    let too_much = of_first.is_above(count, strict)
        || somebodys.is_above(count, strict)
        || of_second.is_above(count, of_reference)
        || nobodys.is_above(count, REFERENCES);
    if too_much { Err(report()) } else { Ok(Some(report())) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::accel::RayBatch;

    const OURS: Names = Names { first: "gnurt", second: "gnurt" };
    const REFERENCE: Names = Names { first: "gnurt", second: "reference" };

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
            compare(&answered(reference.clone()), &answered(answers), OURS, &rays, 1e-5)
        };
        assert_eq!(with(&[(0, 5.000_01)]), Ok(None), "rounding is not told");
        assert!(with(&[(0, 5.000_1)]).is_ok_and(|reported| reported.is_some()), "more than rounding is");
        assert!(
            with(&[(0, f32::INFINITY)])
                .is_ok_and(|reported| reported.is_some_and(|reported| reported.ray == 0)),
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
        assert!(
            compare(&answered(reference.clone()), &short, OURS, &rays, 1e-5).is_err(),
            "an answer is missing"
        );
    }

    #[test]
    fn triangles_are_compared() {
        let (rays, reference) = (rays(30, false), answered(vec![5.0; 30]));
        let with = |prim_id: u32, n: usize| {
            let mut answers = reference.clone();
            answers.prim_id[..n].fill(prim_id);
            compare(&reference, &answers, OURS, &rays, 1e-5)
        };
        assert_eq!(with(1, 30), Ok(None), "what lies on it is hit, too");
        assert!(with(2, 30).is_err(), "what is not met there is not");
        assert!(with(2, 1).is_ok_and(|reported| reported.is_some()), "one is told");
        assert_eq!(with(INVALID_ID, 30), Ok(None), "who does not say which is believed");
    }

    #[test]
    fn who_is_wrong_is_told() {
        let rays = rays(1000, false);
        let with = |a: f32, b: f32, n: usize| {
            let side = |t: f32| answered((0..1000).map(|i| if i < n { t } else { 5.0 }).collect());
            compare(&side(a), &side(b), REFERENCE, &rays, 1e-5)
        };
        let reported = |a, b, n| with(a, b, n).expect("it goes on").expect("it is told").what;
        let theirs = reported(5.0, 5.01, 90);
        assert!(
            theirs.contains("90 of 1000 answers differ") && theirs.contains("by up to 2.0e-3 of t"),
            "{theirs}"
        );
        assert!(theirs.contains("90 of reference are wrong, 0 of gnurt"), "{theirs}");
        let ours = with(5.01, 5.0, 90).expect_err("our own faults end it").what;
        assert!(ours.contains("0 of reference are wrong, 90 of gnurt"), "{ours}");
        assert!(with(5.0, 5.01, 501).is_err(), "who is wrong about a half is asked in a wrong way");
        let lost = reported(5.0, f32::INFINITY, 1);
        assert!(
            lost.contains("1 rays hit for one only") && lost.contains("1 of reference are wrong"),
            "{lost}"
        );
        assert!(with(f32::INFINITY, 5.0, 2).is_err(), "what we miss is there");
        let both = reported(5.01, 5.02, 1);
        assert!(both.contains("1 of reference are wrong, 1 of gnurt"), "{both}");
    }

    #[test]
    fn edges_are_nobodys_and_the_nearer_hit_is_right() {
        let count = 100;
        let of = |org: [f32; 3]| {
            let ray = Ray::new(org, [0.0, 0.0, -1.0]);
            Rays::new(vec![RayBatch::from_iter(vec![ray; count])], false, TRIANGLES)
        };
        let all = |t: f32, prim_id: u32| Answered { t: vec![t; count], prim_id: vec![prim_id; count] };
        // Triangle 2 is on the edge between corners 0 and 1: seen from above, edge on.
        let at_edge = of([1.0, 0.0, 5.0]);
        let what = compare(&all(5.0, 0), &all(f32::INFINITY, INVALID_ID), REFERENCE, &at_edge, 1e-5);
        let what = what.map_or_else(
            |too_much| too_much.what,
            |reported| reported.map_or(String::new(), |reported| reported.what),
        );
        assert!(what.contains("100 pass an edge") && what.contains("0 of reference"), "{what}");
        // From below its slope triangle 0 is met behind triangle 1, which lies on it: both are there.
        let inside = of([1.0, 1.0, 5.0]);
        assert_eq!(compare(&all(5.0, 0), &all(5.0, 1), REFERENCE, &inside, 1e-5), Ok(None), "both are right");
        let any = Rays { any: true, ..of([1.0, 1.0, 5.0]) };
        let missed = compare(&all(1.0, INVALID_ID), &all(f32::INFINITY, INVALID_ID), REFERENCE, &any, 1e-5);
        let missed = missed.expect_err("a hundred of a hundred").what;
        assert!(
            missed.contains("100 of reference are wrong, 0 of gnurt"),
            "all triangles are looked at: {missed}"
        );
    }
}
