// SPDX-License-Identifier: GPL-3.0-or-later
//! Tests of hair as a rough cylinder: energy, directions exchanged, and paths that are followed through the cylinder face by face.

use glam::{DVec2, Vec2, Vec3};

use super::anisotropy::Slopes;
use super::ggx::Ggx;
use super::rough_dielectric::{Glass, Plain};
use super::rough_fibre::RoughFibre;
use crate::real::Vector;
use crate::sampling::frame_around;

fn fibre(term: usize, alpha: f32, aspect: f32, tilt: f32) -> RoughFibre {
    let absorption = Vec3::new(0.0, 0.3, 1.0);
    RoughFibre { term, absorption, alpha, index: 1.55, tilt, aspect, major: Vec2::ZERO, random: 0.0 }
}

/// A view by its sine along the fibre and its offset from the middle.
fn view(sin: f32, offset: f32) -> Vec3 {
    let cos = (1.0 - sin * sin).sqrt();
    Vec3::new(sin, -offset * cos, (1.0 - offset * offset).sqrt() * cos)
}

fn step(i: u32, by: f64) -> f32 {
    (f64::from(i) * by).fract() as f32
}

/// Three numbers for each of many samples.
fn numbers(count: u32) -> impl Iterator<Item = [f32; 3]> {
    (1..=count).map(|i| [step(i, 0.819_172_513), step(i, 0.671_043_606_7), step(i, 0.549_700_478)])
}

/// The mean over ways and samples of a function of the direction, weighted by light.
fn mean(of: RoughFibre, wo: Vec3, count: u32, f: impl Fn(Vec3) -> f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (i, u) in (1..=count).zip(numbers(count)) {
        let here = RoughFibre { random: step(i, 0.754_877_666), ..of };
        let wi = here.sample(wo, u);
        if wi == Vec3::ZERO {
            continue;
        }
        let (value, pdf) = here.eval_pdf(wo, wi);
        assert!(pdf > 0.0 && value.is_finite(), "{here:?} {wo} {wi}: {value} {pdf}");
        let light = value / pdf;
        sum.iter_mut().zip(light.to_array()).for_each(|(sum, x)| *sum += f64::from(x) * f(wi));
    }
    sum.map(|x| x / f64::from(count))
}

#[test]
fn white_fibres_keep_their_light() {
    for (alpha, aspect, tilt) in [(0.02, 1.0, 0.0), (0.3, 1.0, 0.0), (0.3, 0.5, 0.04), (0.8, 0.8, 0.0)] {
        for wo in [view(0.0, 0.0), view(0.4, 0.6), view(-0.7, -0.8)] {
            let all: f64 =
                (0..4).map(|term| mean(fibre(term, alpha, aspect, tilt), wo, 20_000, |_| 1.0)[0]).sum();
            assert!(all > 0.96 && all < 1.02, "{alpha} {aspect} {tilt} from {wo}: {all} of 1");
            let said: f64 = (0..4)
                .flat_map(|term| (0..20_000).map(move |i| (term, step(i, 0.754_877_666))))
                .map(|(term, random)| {
                    let here = RoughFibre { random, ..fibre(term, alpha, aspect, tilt) };
                    f64::from(here.albedo(wo).x) / 20_000.0
                })
                .sum();
            assert!((said - all).abs() < 0.03, "{alpha} {aspect} {tilt} from {wo}: {all}, albedo {said}");
        }
    }
}

/// A path through the cylinder: at each face rough glass chooses one of its two events. The direction, the number of faces within,
/// and the light that is left.
fn path(of: &RoughFibre, wo: Vec3, random: &mut impl FnMut() -> f32) -> Option<(Vec3, u32, Vec3)> {
    let a = f64::from(of.aspect);
    let offset = f64::from(-wo.y / wo.y.hypot(wo.z));
    // The section's major axis is across the view: axes are the fibre's x, that one, and towards the view.
    let (sin, cos) = (wo.x, (1.0 - wo.x * wo.x).sqrt());
    let [side, up] = [Vec2::new(wo.z, -wo.y).normalize(), Vec2::new(wo.y, wo.z).normalize()];
    let mut at = DVec2::new(offset, a * (1.0 - offset * offset).sqrt());
    let normal = |at: DVec2| {
        let across = DVec2::new(at.x, at.y / (a * a)).normalize().as_vec2();
        let (sin, cos) = of.tilt.sin_cos();
        Vec3::new(sin, cos * across.x, cos * across.y)
    };
    let glass = |eta| Glass {
        slopes: Slopes { ggx: Ggx::from_alpha(of.alpha), anisotropy: None },
        eta,
        film: None,
        rise: Plain,
        tints: [Vector::grey(1.0); 2],
        losses: Vector::grey(0.0),
        thin: false,
    };
    let (mut w, mut within, mut weight) = (Vec3::new(sin, 0.0, cos), false, Vec3::ONE);
    for face in 0..66 {
        let n = if within { -normal(at) } else { normal(at) };
        let [x, y]: [Vec3; 2] = frame_around::<f32>(n.into()).map(Into::into);
        let local = Vec3::new(x.dot(w), y.dot(w), n.dot(w));
        if local.z <= 0.0 {
            return None;
        }
        let glass = glass(if within { of.index } else { 1.0 / of.index });
        let prepared = glass.prepared(local.into(), local.z);
        // Single scattering; its losses are added to the rest.
        weight /= 1.0 - prepared.lost;
        let prepared = super::rough_dielectric::PreparedGlass { lost: 0.0, ..prepared };
        let (wi, some) = glass.sample(prepared, local.into(), [random(), random(), random()], Vec3::Z.into());
        let wi = Vec3::from(wi);
        if !some {
            return None;
        }
        let (value, pdf) =
            glass.eval_pdf(prepared, Vec3::Z.into(), [local.into(), wi.into()], [local.z, wi.z]);
        weight *= Vec3::from(value) / pdf;
        let to = x * wi.x + y * wi.y + n * wi.z;
        within = (wi.z < 0.0) != within;
        if !within {
            let across = side * to.y + up * to.z;
            return Some((Vec3::new(to.x, across.x, across.y), face, weight));
        }
        // The way to the next face, by bisection.
        let inside = |t: f64| {
            let p = at + DVec2::new(f64::from(to.y), f64::from(to.z)) * t;
            p.x * p.x + p.y * p.y / (a * a) < 1.0
        };
        let (mut low, mut high) = (1e-4, 1e3);
        if !inside(low) {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if inside(middle) { low = middle } else { high = middle }
        }
        at += DVec2::new(f64::from(to.y), f64::from(to.z)) * low;
        weight *= (-of.absorption * low as f32).exp();
        w = -to;
    }
    None
}

#[test]
fn terms_are_those_of_paths_through_the_cylinder() {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / 16_777_216.0
    };
    let tests: [fn(Vec3) -> f64; 3] = [
        |_| 1.0,
        |w| f64::from(w.x * w.x + 0.5 * w.y + 0.3 * w.z * w.x),
        |w| f64::from(0.4 * w.x + w.z * w.z + 0.6 * w.z * w.y),
    ];
    for (alpha, aspect, tilt) in [(0.05, 1.0, 0.0), (0.2, 1.0, 0.03), (0.2, 0.6, 0.0)] {
        for wo in [view(0.0, 0.2), view(0.5, -0.6)] {
            let count = 60_000;
            let mut expected = [[[0.0; 3]; 3]; 4];
            for _ in 0..count {
                let of = fibre(0, alpha, aspect, tilt);
                let Some((wi, faces, light)) = path(&of, wo, &mut random) else { continue };
                for (sums, f) in expected[(faces as usize).min(3)].iter_mut().zip(tests) {
                    for (sum, x) in sums.iter_mut().zip(light.to_array()) {
                        *sum += f64::from(x) * f(wi) / f64::from(count);
                    }
                }
            }
            for (term, expected) in expected.iter().enumerate() {
                let expected_all = expected;
                for (f, expected) in tests.iter().zip(expected) {
                    let found = mean(fibre(term, alpha, aspect, tilt), wo, count, f);
                    for (found, expected) in found.iter().zip(expected) {
                        let off = (found - expected).abs();
                        // Few paths have many reflections.
                        let noise = if term == 3 { 0.02 } else { 0.006 };
                        assert!(
                            off < noise + 0.01 * expected.abs(),
                            "term {term} {alpha} {aspect} {tilt} {wo}: {:?}, {expected_all:?}",
                            tests.map(|f| mean(fibre(term, alpha, aspect, tilt), wo, count, f))
                        );
                    }
                }
            }
        }
    }
}

/// Light from one direction to another, over all offsets, is the same with both exchanged.
#[test]
fn directions_may_be_exchanged() {
    let aspect = 0.6;
    let major = Vec2::new(0.28, 0.96);
    let wide = |w: Vec3| {
        // Half of the width that is seen, and the cosine along.
        let side = Vec2::new(w.z, -w.y).normalize();
        let (a, b) = (side.dot(major), side.dot(Vec2::new(-major.y, major.x)));
        (a * a + aspect * aspect * b * b).sqrt() * (1.0 - w.x * w.x).sqrt()
    };
    let between = |term, wo: Vec3, wi: Vec3| {
        let count = 200_000;
        let mut sum = 0.0;
        for i in 0..count {
            let offset = 2.0 * step(i, 0.819_172_513) - 1.0;
            // The hit's normal is z, so axes turn with the offset.
            let turned = offset.asin();
            let at = |w: Vec2, by: f32| Vec2::from_angle(by).rotate(w);
            let around = Vec2::new(wo.y, wo.z).to_angle();
            // The view to the angle of -offset from z.
            let by = std::f32::consts::FRAC_PI_2 + turned - around;
            let place = |w: Vec3| {
                let across = at(Vec2::new(w.y, w.z), by);
                Vec3::new(w.x, across.x, across.y)
            };
            let mut here = fibre(term, 0.1, aspect, 0.05);
            (here.major, here.random) = (at(major, by), step(i, 0.754_877_666));
            sum += f64::from(here.eval_pdf(place(wo), place(wi)).0.y);
        }
        sum / f64::from(count) * f64::from(wide(wo))
    };
    let mut compared = 0;
    for (wo, wi) in [
        (Vec3::new(0.0, 0.3, 0.9), Vec3::new(0.1, -0.5, 0.7)),
        (Vec3::new(0.3, 0.1, 0.8), Vec3::new(-0.28, 0.1, -0.8)),
    ] {
        let (wo, wi) = (wo.normalize(), wi.normalize());
        for term in 0..4 {
            let (there, back) = (between(term, wo, wi), between(term, wi, wo));
            // Light that grazes the surface is scaled for the view only.
            let grazes = term == 0 && wo.dot(wi) < -0.5;
            if there.max(back) < 1e-3 || grazes {
                continue;
            }
            compared += 1;
            assert!((there / back - 1.0).abs() < 0.05, "term {term} {wo} {wi}: {there}, {back}");
        }
    }
    assert!(compared >= 3, "{compared} terms have light");
}
