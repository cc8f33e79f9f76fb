// SPDX-License-Identifier: GPL-3.0-or-later
//! Every rule for derivatives against central differences, and values that do not change by carrying derivatives.

use gnurt_sl_lib::math::*;
use gnurt_sl_lib::{Dual, noise};
use proptest::prelude::*;

type D = Dual<f32>;

/// A function of two numbers, with derivatives and without.
struct Case {
    name: &'static str,
    with: fn(D, D) -> D,
    without: fn(f32, f32) -> f32,
}

macro_rules! cases {
    ($($name:literal: $x:ident, $y:ident => $e:expr;)*) => {
        [$(Case { name: $name, with: |$x, $y| $e, without: |$x, $y| $e }),*]
    };
}

/// x and y are about 1 and 2, never further than 0.9 from that.
fn cases() -> [Case; 36] {
    cases! {
        "sin": x, _y => sin(x);
        "cos": x, _y => cos(x);
        "tan": x, _y => tan(x * 0.5);
        "asin": x, _y => asin(x * 0.45);
        "acos": x, _y => acos(x * 0.45);
        "atan": x, _y => atan(x);
        "atan2": x, y => atan2(x, y);
        "sinh": x, _y => sinh(x);
        "cosh": x, _y => cosh(x);
        "tanh": x, _y => tanh(x);
        "exp": x, _y => exp(x);
        "exp2": x, _y => exp2(x);
        "expm1": x, _y => expm1(x);
        "log": x, _y => log(x);
        "log2": x, _y => log2(x);
        "log10": x, _y => log10(x);
        "pow": x, y => pow(x, y);
        "sqrt": x, _y => sqrt(x);
        "inversesqrt": x, _y => inversesqrt(x);
        "cbrt": x, _y => cbrt(x);
        "hypot": x, y => hypot(x, y);
        "erf": x, _y => erf(x);
        "erfc": x, _y => erfc(x);
        "abs": x, y => abs(x - y);
        "div": x, y => div(x, y);
        "fmod": x, y => fmod(x, y * 4.0);
        "mod": x, y => modulo(x, y * 4.0);
        "min": x, y => min(x, y);
        "max": x, y => max(x * 3.0, y);
        "clamp": x, y => clamp(x, y * 0.6, y * 0.8);
        "mix": x, y => mix(x, y, x * y);
        "smoothstep": x, y => smoothstep(x * 0.01, y * 2.0, x);
        "linearstep": x, y => linearstep(x * 0.01, y * 2.0, x);
        "smooth_linearstep": x, y => smooth_linearstep(x * 0.01, y * 2.0, x, y * 0.1);
        "degrees": x, _y => degrees(x);
        "sincos": x, _y => { let (s, c) = sincos(x); s * c };
    }
}

proptest! {
    #[test]
    fn rules_agree_with_differences(x in 0.1_f32..1.9, y in 1.1_f32..2.9, dx in -1.0_f32..1.0, dy in -1.0_f32..1.0) {
        for Case { name, with, without } in cases() {
            let found = with(Dual::new(x, dx, 0.0), Dual::new(y, 0.0, dy));
            prop_assert_eq!(found.value.to_bits(), without(x, y).to_bits(), "{} changes by its derivatives", name);
            // Polynomials of few terms are no smoother than their rounding: steps are long, and corners excused.
            let h = 0.02;
            let slope = |dx: f32, dy: f32| {
                let at = |s: f32| f64::from(without(x + s * dx, y + s * dy));
                let (before, here, after) = (at(-h), at(0.0), at(h));
                ((after - before) / f64::from(2.0 * h), 2.0 * (after - 2.0 * here + before).abs() / f64::from(h))
            };
            for (expected, found, direction) in [(slope(dx, 0.0), found.dx, "x"), (slope(0.0, dy), found.dy, "y")] {
                let (expected, bend) = expected;
                let allowed = 4e-3 * (1.0 + expected.abs()) + bend;
                prop_assert!((f64::from(found) - expected).abs() < allowed,
                    "{}'s derivative in {} at ({}, {}) is {}, differences say {}", name, direction, x, y, found, expected);
            }
        }
    }

    #[test]
    fn noise_slopes_as_it_should(p in prop::array::uniform4(-20.0_f32..20.0), d in prop::array::uniform4(-1.0_f32..1.0)) {
        type Noise = fn([D; 4]) -> [D; 3];
        let kinds: [(&str, Noise); 10] = [
            ("snoise 1", |p| noise::snoise3([p[0]])),
            ("snoise 2", |p| noise::snoise3([p[0], p[1]])),
            ("snoise 3", |p| noise::snoise3([p[0], p[1], p[2]])),
            ("snoise 4", noise::snoise3),
            ("psnoise 3", |p| noise::psnoise3([p[0], p[1], p[2]], [3.0, 2.0, 4.0])),
            ("noise 2", |p| noise::noise3([p[0], p[1]])),
            ("simplex 1", |p| noise::simplex3([p[0]])),
            ("simplex 2", |p| noise::simplex3([p[0], p[1]])),
            ("simplex 3", |p| noise::simplex3([p[0], p[1], p[2]])),
            ("usimplex 4", noise::usimplex3),
        ];
        for (name, noise) in kinds {
            let at = |s: f32| noise(std::array::from_fn(|i| D::new(p[i] + s * d[i], d[i], -d[i])));
            let h = 0.01;
            for (i, (found, (before, after))) in at(0.0).into_iter().zip(at(-h).into_iter().zip(at(h))).enumerate() {
                let expected = (after.value - before.value) / (2.0 * h);
                prop_assert!((found.dx - expected).abs() < 0.06, "{} {}: {} instead of {}", name, i, found.dx, expected);
                prop_assert_eq!(found.dx, -found.dy, "{}", name);
            }
        }
    }
}

#[test]
fn triples_and_numbers_turn_into_each_other() {
    let triple = Dual::new([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]);
    assert_eq!(triple.components()[1], Dual::new(2.0, 5.0, 8.0));
    assert_eq!(Dual::from_components(triple.components()), triple);
    assert_eq!(Dual::from(2.0).dx, 0.0, "a constant");
}
