// SPDX-License-Identifier: GPL-3.0-or-later
//! The library's functions by name, over any numbers: a shader's call is recorded by calling the function.
//! The names are those of `gnurt_sl::exec`'s table.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_sl_lib::noise::{self, NoiseKind};
use gnurt_sl_lib::{Number, UInts, math};

use crate::term::{Bits, Term, Which};

/// How many arguments a function takes that is done component by component.
pub(crate) fn arguments(name: &str) -> Option<usize> {
    Some(match name {
        "neg" | "sin" | "cos" | "tan" | "asin" | "acos" | "atan" | "sinh" | "cosh" | "tanh" | "exp"
        | "exp2" | "expm1" | "log" | "log2" | "log10" | "logb" | "sqrt" | "inversesqrt" | "cbrt" | "erf"
        | "erfc" | "abs" | "fabs" | "sign" | "floor" | "ceil" | "round" | "trunc" => 1,
        "add" | "sub" | "mul" | "div" | "atan2" | "pow" | "fmod" | "mod" | "min" | "max" | "step" => 2,
        "mix" | "select" | "smoothstep" | "clamp" => 3,
        _ => return None,
    })
}

/// Such a function of its arguments.
pub(crate) fn apply<N: Number<Real = Term, Mask = Which>>(name: &str, x: [N; 3]) -> N {
    let [a, b, c] = x;
    let flat = |y: Term| N::lift(y);
    let v = a.value();
    match name {
        "add" => a + b,
        "sub" => a - b,
        "mul" => a * b,
        "div" => math::div(a, b),
        "neg" => -a,
        "sin" => math::sin(a),
        "cos" => math::cos(a),
        "tan" => math::tan(a),
        "asin" => math::asin(a),
        "acos" => math::acos(a),
        "atan" => math::atan(a),
        "atan2" => math::atan2(a, b),
        "sinh" => math::sinh(a),
        "cosh" => math::cosh(a),
        "tanh" => math::tanh(a),
        "exp" => math::exp(a),
        "exp2" => math::exp2(a),
        "expm1" => math::expm1(a),
        "log" => math::log(a),
        "log2" => math::log2(a),
        "log10" => math::log10(a),
        "logb" => flat(math::logb(v)),
        "pow" => math::pow(a, b),
        "sqrt" => math::sqrt(a),
        "inversesqrt" => math::inversesqrt(a),
        "cbrt" => math::cbrt(a),
        "erf" => math::erf(a),
        "erfc" => math::erfc(a),
        "abs" | "fabs" => math::abs(a),
        "sign" => flat(math::sign(v)),
        "floor" => flat(math::floor(v)),
        "ceil" => flat(math::ceil(v)),
        "round" => flat(math::round(v)),
        "trunc" => flat(math::trunc(v)),
        "fmod" | "mod" => math::fmod(a, b),
        "min" => math::min(a, b),
        "max" => math::max(a, b),
        "step" => flat(math::step(v, b.value())),
        "mix" => math::mix(a, b, c),
        "select" => math::select(a, b, c.value()),
        "smoothstep" => math::smoothstep(a, b, c),
        "clamp" => math::clamp(a, b, c),
        _ => unreachable!("'{name}' has no arguments"),
    }
}

/// How many arguments an operation on ints takes.
pub(crate) fn int_arguments(name: &str) -> Option<usize> {
    Some(match name {
        "add" | "sub" | "mul" | "div" | "mod" | "fmod" | "bitand" | "bitor" | "xor" | "shl" | "shr"
        | "min" | "max" | "and" | "or" => 2,
        "neg" | "compl" | "abs" | "fabs" => 1,
        _ => return None,
    })
}

fn fixed<const D: usize>(list: &[Term]) -> [Term; D] {
    std::array::from_fn(|i| list.get(i).copied().unwrap_or(Term::constant(1.0)))
}

/// Noise of one kind at a position, one number or three.
pub(crate) fn noise<N: Number<Real = Term, Mask = Which>>(
    kind: NoiseKind,
    point: &[N],
    period: Option<&[Term]>,
    three: bool,
) -> [N; 3] {
    match *point {
        [x] => of(kind, [x], period.map(fixed), three),
        [x, y] => of(kind, [x, y], period.map(fixed), three),
        [x, y, z] => of(kind, [x, y, z], period.map(fixed), three),
        [x, y, z, t, ..] => of(kind, [x, y, z, t], period.map(fixed), three),
        [] => unreachable!("noise has a place"),
    }
}

fn of<N: Number<Real = Term, Mask = Which>, const D: usize>(
    kind: NoiseKind,
    p: [N; D],
    period: Option<[Term; D]>,
    three: bool,
) -> [N; 3] {
    let v = p.map(N::value);
    let all = |x: N| [x; 3];
    match (kind, period, three) {
        (NoiseKind::UPerlin, None, false) => all(noise::noise(p)),
        (NoiseKind::UPerlin, None, true) => noise::noise3(p),
        (NoiseKind::UPerlin, Some(q), false) => all(noise::pnoise(p, q)),
        (NoiseKind::UPerlin, Some(q), true) => noise::pnoise3(p, q),
        (NoiseKind::Perlin, None, false) => all(noise::snoise(p)),
        (NoiseKind::Perlin, None, true) => noise::snoise3(p),
        (NoiseKind::Perlin, Some(q), false) => all(noise::psnoise(p, q)),
        (NoiseKind::Perlin, Some(q), true) => noise::psnoise3(p, q),
        (NoiseKind::Simplex, _, false) => all(noise::simplex(p)),
        (NoiseKind::Simplex, _, true) => noise::simplex3(p),
        (NoiseKind::USimplex, _, false) => all(noise::usimplex(p)),
        (NoiseKind::USimplex, _, true) => noise::usimplex3(p),
        (NoiseKind::Cell, None, false) => all(N::lift(noise::cellnoise(v))),
        (NoiseKind::Cell, None, true) => noise::cellnoise3(v).map(N::lift),
        (NoiseKind::Cell, Some(q), false) => all(N::lift(noise::pcellnoise(v, q))),
        (NoiseKind::Cell, Some(q), true) => noise::pcellnoise3(v, q).map(N::lift),
        (NoiseKind::Hash, None, false) => all(N::lift(noise::hashnoise(v))),
        (NoiseKind::Hash, None, true) => noise::hashnoise3(v).map(N::lift),
        (NoiseKind::Hash, Some(q), false) => all(N::lift(noise::phashnoise(v, q))),
        (NoiseKind::Hash, Some(q), true) => noise::phashnoise3(v, q).map(N::lift),
        (NoiseKind::Null, ..) => all(N::lift(Term::constant(0.0))),
        (NoiseKind::UNull, ..) => all(N::lift(Term::constant(0.5))),
        (NoiseKind::Gabor, ..) => unreachable!("the interpreter does it"),
    }
}

/// The hash of one to four floats, or of an int.
pub(crate) fn hash(x: &[Bits]) -> Bits {
    match *x {
        [a] => noise::hash_uints([a]),
        [a, b] => noise::hash_uints([a, b]),
        [a, b, c] => noise::hash_uints([a, b, c]),
        [a, b, c, d, ..] => noise::hash_uints([a, b, c, d]),
        [] => unreachable!("a hash of something"),
    }
}

/// Whole numbers moved, by the lowest five bits of others.
pub(crate) fn five_bits(x: Bits) -> Bits {
    x & 31
}

/// Without the sign.
pub(crate) fn int_abs(x: Bits) -> Bits {
    let zero = UInts::constant(x, 0);
    x.signed_max(zero - x).or_least(x)
}

impl Bits {
    /// The smallest whole number stays unchanged.
    fn or_least(self, x: Self) -> Self {
        Self::pick(x.equal(1 << 31), x, self)
    }
}
