// SPDX-License-Identifier: GPL-3.0-or-later
//! Splines against de Casteljau's and Cox and de Boor's rules, and their inverse against the output of OSL.

use gnurt_sl_lib::Dual;
use gnurt_sl_lib::spline::*;
use proptest::prelude::*;

fn plain(basis: Basis, x: f32, knots: &[f32]) -> f64 {
    spline(basis, x, knots).into()
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// A segment's value by repeated interpolation.
fn expected(basis: Basis, k: [f64; 4], t: f64) -> f64 {
    match basis {
        Basis::Bezier => {
            let (a, b, c) = (lerp(k[0], k[1], t), lerp(k[1], k[2], t), lerp(k[2], k[3], t));
            lerp(lerp(a, b, t), lerp(b, c, t), t)
        }
        // Cox and de Boor with knots at whole numbers.
        Basis::BSpline => {
            let step = |a: f64, b: f64, at: f64, over: f64| lerp(a, b, (t + at) / over);
            let (a, b, c) =
                (step(k[0], k[1], 2.0, 3.0), step(k[1], k[2], 1.0, 3.0), step(k[2], k[3], 0.0, 3.0));
            let (a, b) = (step(a, b, 1.0, 2.0), step(b, c, 0.0, 2.0));
            step(a, b, 0.0, 1.0)
        }
        // As a Bezier segment with a third of the slope at each end.
        Basis::CatmullRom => {
            let slopes = ((k[2] - k[0]) / 2.0, (k[3] - k[1]) / 2.0);
            expected(Basis::Bezier, [k[1], k[1] + slopes.0 / 3.0, k[2] - slopes.1 / 3.0, k[2]], t)
        }
        Basis::Hermite => expected(Basis::Bezier, [k[0], k[0] + k[1] / 3.0, k[2] - k[3] / 3.0, k[2]], t),
        Basis::Linear => lerp(k[1], k[2], t),
        Basis::Constant => k[1],
    }
}

const ALL: [Basis; 6] =
    [Basis::CatmullRom, Basis::Bezier, Basis::BSpline, Basis::Hermite, Basis::Linear, Basis::Constant];

proptest! {
    #[test]
    fn segments_are_what_repeated_interpolation_gives(
        knots in prop::collection::vec(-4.0_f32..4.0, 4..14), x in -0.2_f32..1.2, dx in -1.0_f32..1.0
    ) {
        for basis in ALL {
            let segments = basis.segments(knots.len());
            let at = f64::from(x.clamp(0.0, 1.0)) * segments as f64;
            let segment = (at as usize).min(segments - 1);
            let four = std::array::from_fn(|i| f64::from(knots[segment * basis.step() + i]));
            let rest = at - segment as f64;
            // Where a segment ends the constant basis may go either way.
            prop_assume!((1e-5..1.0 - 1e-5).contains(&rest) || basis != Basis::Constant);
            let found = plain(basis, x, &knots);
            prop_assert!((found - expected(basis, four, rest)).abs() < 2e-4, "{basis:?} at {x}: {found}");

            let dual = spline(basis, Dual::new(x, dx, 0.0), &knots[..]);
            prop_assert_eq!(dual.value.to_bits(), spline(basis, x, &knots[..]).to_bits());
            let h = 1e-6 * segments as f64;
            let slope = (expected(basis, four, rest + h) - expected(basis, four, rest - h)) / (2.0 * h);
            let inside = x > 0.0 && x < 1.0 && basis != Basis::Constant;
            let expected = if inside { slope * segments as f64 * f64::from(dx) } else { 0.0 };
            prop_assert!((f64::from(dual.dx) - expected).abs() < 1e-2 * (1.0 + expected.abs()), "{basis:?}: {} not {expected}", dual.dx);

            // Knots hand on derivatives by the same weights; triples are three splines.
            let changing: Vec<Dual<f32>> = knots.iter().map(|k| Dual::new(*k, 2.0 * k, 0.0)).collect();
            let by_knots = spline(basis, Dual::from(x), &changing[..]);
            let expected = if basis == Basis::Constant { 0.0 } else { 2.0 * by_knots.value };
            prop_assert!((by_knots.dx - expected).abs() < 1e-4);
            let triples: Vec<[f32; 3]> = knots.iter().map(|k| [0.0, *k, 1.0]).collect();
            let second: f32 = spline(basis, x, Component { triples: &triples[..], index: 1 });
            prop_assert_eq!(second.to_bits(), spline(basis, x, &knots[..]).to_bits());
        }
    }

    #[test]
    fn the_inverse_leads_back(mut knots in prop::collection::vec(0.0_f32..1.0, 4..9), y in 0.0_f32..1.0, falling: bool) {
        knots.sort_by(f32::total_cmp);
        if falling { knots.reverse(); }
        for basis in [Basis::Linear, Basis::CatmullRom, Basis::BSpline] {
            let ends = [plain(basis, 0.0, &knots), plain(basis, 1.0, &knots)];
            let y = lerp(ends[0], ends[1], f64::from(y)) as f32;
            let x = splineinverse(basis, y, &knots);
            prop_assert!((0.0..=1.0).contains(&x));
            // A curve that does not rise all the way has no inverse to speak of.
            let outer = [knots[1], knots[knots.len() - 2]];
            let inside = (y - outer[0]) * (y - outer[1]) < 0.0;
            prop_assert!(!inside || (plain(basis, x, &knots) - f64::from(y)).abs() < 1e-3, "{basis:?}: {y} at {x}");
        }
    }
}

#[test]
fn inverses_are_osls() {
    let knots = [0.0, 0.0, 0.05, 0.1, 0.3, 1.0, 1.0];
    // u, and for linear, Catmull-Rom and B-splines the place and its derivative, as OSL's test suite prints them.
    let known = [
        (1.0 / 6.0, [(0.583_333, 0.416_667), (0.636_126, 0.485_242), (0.569_314, 0.462_879)]),
        (0.5, [(0.821_429, 0.119_048), (0.826_469, 0.103_961), (0.808_612, 0.155_984)]),
        (5.0 / 6.0, [(0.940_476, 0.119_048), (0.927_532, 0.111_185), (0.968_067, 0.193_972)]),
    ];
    for (u, expected) in known {
        let names = ["linear", "catmull-rom", "bspline"];
        for (name, (x, dx)) in names.into_iter().zip(expected) {
            let found = splineinverse(Basis::named(name), Dual::new(u, 1.0 / 3.0, 0.0), &knots);
            assert!(
                (found.value - x).abs() < 1e-6 && (found.dx - dx).abs() < 2e-6,
                "{name} at {u}: {found:?}, not {x} {dx}"
            );
        }
    }
}

#[test]
fn names_and_short_lists() {
    let names = ["catmull-rom", "bezier", "bspline", "hermite", "linear", "constant"];
    assert_eq!(names.map(Basis::named), ALL);
    assert_eq!(Basis::named("unheard of"), Basis::Linear);
    assert_eq!(Basis::Bezier.segments(7), 2);
    assert_eq!(spline(Basis::Linear, 0.5, &[1.0, 2.0, 3.0][..]), 0.0, "three knots are no spline");
    assert_eq!(splineinverse(Basis::Linear, 0.5, &[]), 0.0);
    assert_eq!(spline(Basis::Linear, f32::NAN, &[1.0, 2.0, 3.0, 4.0][..]), 2.0, "NaN is the start");
}
