// SPDX-License-Identifier: GPL-3.0-or-later
//! Mathematics against `f64`, within the errors that the modules state, and the language's definitions of
//! undefined results.

use gnurt_sl_lib::math::*;
use proptest::prelude::*;

fn near(name: &str, x: f32, found: f32, expected: f64, absolute: f64, relative: f64) {
    let error = (f64::from(found) - expected).abs();
    let allowed = absolute + relative * expected.abs();
    assert!(error <= allowed, "{name}({x}) is {found}, wanted {expected}: off by {error}, {allowed} allowed");
}

proptest! {
    #[test]
    fn trigonometry_is_within_its_errors(x in -1000.0_f32..1000.0, y in -10.0_f32..10.0) {
        let (wide, exact) = (f64::from(x), f64::from(y));
        near("sin", x, sin(x), wide.sin(), 5e-7, 0.0);
        near("cos", x, cos(x), wide.cos(), 5e-7, 0.0);
        prop_assert_eq!(sincos(x), (sin(x), cos(x)));
        near("tan", y, tan(y), exact.tan(), 2e-6, 2e-6 * (1.0 + exact.tan().abs()));
        let unit = exact.clamp(-1.0, 1.0);
        near("asin", y, asin(y), unit.asin(), 5e-5, 0.0);
        near("acos", y, acos(y), unit.acos(), 5e-5, 0.0);
        near("atan", x, atan(x), wide.atan(), 1e-5, 0.0);
        near("atan2", y, atan2(y, x), exact.atan2(wide), 1e-5, 0.0);
        near("sinh", y, sinh(y), exact.sinh(), 2e-7, 3e-5);
        near("cosh", y, cosh(y), exact.cosh(), 2e-7, 3e-5);
        near("tanh", y, tanh(y), exact.tanh(), 4e-6, 0.0);
    }

    #[test]
    fn powers_are_within_their_errors(x in 1e-6_f32..1e6, y in -20.0_f32..20.0, small in -0.1_f32..0.1) {
        let (wide, exact) = (f64::from(x), f64::from(y));
        near("log", x, log(x), wide.ln(), 8e-6, 1e-6);
        near("log2", x, log2(x), wide.log2(), 8e-6, 1e-6);
        near("log10", x, log10(x), wide.log10(), 8e-6, 1e-6);
        near("exp", y, exp(y), exact.exp(), 0.0, 3e-5);
        near("exp2", y, exp2(y), exact.exp2(), 0.0, 3e-5);
        near("expm1", small, expm1(small), f64::from(small).exp_m1(), 3e-6, 4e-4);
        near("pow", x, pow(x, y / 8.0), wide.powf(exact / 8.0), 0.0, 6e-5);
        near("cbrt", x, cbrt(x), wide.cbrt(), 0.0, 2e-6);
        near("cbrt", -x, cbrt(-x), -wide.cbrt(), 0.0, 2e-6);
        near("inversesqrt", x, inversesqrt(x), wide.sqrt().recip(), 0.0, 2e-7);
        // Simpson's rule for the integral that the error function is.
        let (steps, end) = (200, exact / 5.0);
        let at = |i: i32| { let t = end * f64::from(i) / f64::from(steps); (-t * t).exp() };
        let sum: f64 = (0..steps).step_by(2).map(|i| at(i) + 4.0 * at(i + 1) + at(i + 2)).sum();
        let expected = sum * end / f64::from(steps) / 3.0 * std::f64::consts::FRAC_2_SQRT_PI;
        near("erf", y / 5.0, erf(y / 5.0), expected, 2e-6, 0.0);
        near("erfc", y / 5.0, erfc(y / 5.0), 1.0 - expected, 2e-6, 0.0);
    }

    #[test]
    fn remainders_and_rounding_are_exact(a in -1e6_f32..1e6, b in -1e3_f32..1e3) {
        prop_assert_eq!(round(a), a.round());
        let expected = f64::from(a) % f64::from(b);
        let error = (f64::from(fmod(a, b)) - expected).abs();
        prop_assert!(error < 0.1 || (error - f64::from(b.abs())).abs() < 0.1, "fmod({a}, {b})");
        let rest = modulo(a, b);
        prop_assert!(rest * b.signum() > -0.2 && rest.abs() <= b.abs() * 1.001 + 0.2, "mod({a}, {b}) = {rest}");
        prop_assert_eq!(div_int(a as i32, b as i32), (a as i32).checked_div(b as i32).unwrap_or(0));
        prop_assert_eq!(rem_int(a as i32, b as i32), (a as i32).checked_rem(b as i32).unwrap_or(0));
    }

    #[test]
    fn numbers_never_give_nan(x in any::<f32>(), y in any::<f32>()) {
        prop_assume!(x.is_finite() && y.is_finite());
        type Unary = fn(f32) -> f32;
        let unary: [(&str, Unary); 21] = [
            ("sin", sin), ("cos", cos), ("asin", asin), ("acos", acos), ("atan", atan), ("sinh", sinh),
            ("cosh", cosh), ("tanh", tanh), ("exp", exp), ("exp2", exp2), ("expm1", expm1), ("log", log),
            ("log2", log2), ("log10", log10), ("logb", logb), ("sqrt", sqrt), ("inversesqrt", inversesqrt),
            ("cbrt", cbrt), ("round", round), ("erf", erf), ("erfc", erfc),
        ];
        for (name, function) in unary {
            prop_assert!(function(x).is_finite(), "{name}({x}) = {}", function(x));
        }
        type Binary = fn(f32, f32) -> f32;
        let binary: [(&str, Binary); 4] = [("atan2", atan2), ("pow", pow), ("div", div), ("fmod", fmod)];
        for (name, function) in binary {
            prop_assert!(function(x, y).is_finite(), "{name}({x}, {y}) = {}", function(x, y));
        }
    }
}

#[test]
fn what_has_no_result_has_the_languages_one() {
    assert_eq!([div(1.0, 0.0), div(0.0, 0.0), div(1.0, 1e-40)], [0.0; 3], "division");
    assert_eq!([div_int(1, 0), rem_int(1, 0), div_int(i32::MIN, -1)], [0, 0, i32::MIN], "whole numbers");
    assert_eq!([sqrt(-1.0), inversesqrt(0.0), inversesqrt(-4.0)], [0.0; 3], "roots");
    assert_eq!([pow(-2.0, 1.5), pow(0.0, -3.0), pow(0.0, 0.0), pow(-2.0, 0.0)], [0.0, 0.0, 1.0, 1.0], "pow");
    assert_eq!([pow(-2.0, 3.0), pow(-2.2, 2.0), pow(1e20, 2.0)], [-8.0, 4.84, f32::MAX], "pow");
    assert_eq!([asin(2.0), acos(-2.0)], [std::f32::consts::FRAC_PI_2, std::f32::consts::PI], "arcs");
    assert_eq!([fmod(-16.0, 7.0), modulo(-16.0, 7.0), fmod(1.0, 0.0)], [-2.0, 5.0, 0.0], "remainders");
    assert_eq!(abs_int(i32::MIN), i32::MIN, "no panic");
    assert_eq!([max(f32::NAN, 1.0), max(1.0, 2.0), min(1.0, 2.0)], [1.0, 2.0, 1.0], "larger and smaller");
}

#[test]
fn steps_climb_from_0_to_1() {
    assert_eq!([step(0.5, 0.4), step(0.5, 0.5)], [0.0, 1.0]);
    for i in 0..=100 {
        let x = i as f32 / 25.0 - 1.0;
        let t = f64::from(x).clamp(0.0, 2.0) / 2.0;
        near("smoothstep", x, smoothstep(0.0, 2.0, x), t * t * (3.0 - 2.0 * t), 1e-6, 0.0);
        near("linearstep", x, linearstep(0.0, 2.0, x), t, 1e-6, 0.0);
        let rounded = smooth_linearstep(0.0, 2.0, x, 0.2);
        assert!((rounded - linearstep(0.0, 2.0, x)).abs() <= 0.0251, "{x}: {rounded}");
        near("aastep", x, aastep(0.5, x, 0.0, 0.5), (f64::from(x) * 2.0 - 0.5).clamp(0.0, 1.0), 1e-6, 0.0);
        assert_eq!([smoothstep(1.0, 1.0, x), linearstep(1.0, 1.0, x)], [step(1.0, x); 2], "edges that meet");
    }
    assert_eq!([select(1.0, 2.0, 0.0), select(1.0, 2.0, -3.0)], [1.0, 2.0]);
    assert_eq!(mix(1.0, 3.0, 0.25), 1.5);
}

#[test]
fn nobody_looks_at_the_sign_of_what_is_no_number() {
    // Which sign an operation gives to it differs from machine to machine, and from code to code.
    let (plus, minus) = (f32::NAN.copysign(1.0), f32::NAN.copysign(-1.0));
    for x in [0.0, -0.0, 1.0, -2.0] {
        let [a, b] = [plus, minus].map(|nan| [atan2(x, nan), atan2(nan, x), log(nan), exp(nan), pow(nan, x)]);
        for (k, (a, b)) in a.into_iter().zip(b).enumerate() {
            assert!(a == b || a.is_nan() && b.is_nan(), "function {k} of {x}: {a} or {b}");
        }
        let [a, b] = [plus, minus].map(|nan| gnurt_sl_lib::noise::hash_floats([nan, x]));
        assert_eq!(a, b, "a hash with {x}");
    }
}
