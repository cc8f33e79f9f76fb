// SPDX-License-Identifier: GPL-3.0-or-later
//! The library's hot functions for sixteen points at once, as tables of functions for each CPU level: what compiled shaders
//! call.
//! Source: original. A [`Row`] is one number of sixteen points; a number with derivatives is three rows: values, dx, dy.
//! Invariant: each lane has the bits that the function gives alone, at every level. Levels whose registers are narrow run lane
//! by lane: sixteen lanes that are arrays take minutes to compile and gain nothing.
//! Proof: `tests/lanes.rs`.

use std::marker::PhantomData;

use gnurt_simd::{Level, Simd, Token, by_level, f32x16, prelude::*};

use crate::dual::Dual;
use crate::number::{Number, Real};
use crate::number_lanes::LANES;
use crate::spline::{Basis, Knots, spline};
use crate::{math, noise};

/// One number of each of sixteen points.
pub type Row = [f32; LANES];

/// A wide function: the arguments' rows, one after the other, and the results'.
///
/// # Panics
/// If there are fewer rows than [`Function::arguments`] and [`Function::results`] say, three for each with derivatives, or if
/// the token is of another level than the function was got for.
pub type WideFn = fn(Token, &[Row], &mut [Row]);

/// A wide spline: knots that all points share, then as above.
pub type WideSpline = fn(Token, Basis, &[f32], &[Row], &mut [Row]);

/// A function of I numbers with O results, written once.
trait Entry<const I: usize, const O: usize> {
    fn apply<N: Number>(x: [N; I]) -> [N; O];
}

macro_rules! functions {
    ($($(#[doc = $doc:literal])* $name:ident, $inputs:literal => $outputs:literal, |$x:pat_param| $body:expr;)*) => {
        /// Functions that have wide forms.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Function {
            $($(#[doc = $doc])* $name,)*
        }

        impl Function {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// How many numbers it takes; coordinates of noise one by one, periods after them.
            #[must_use]
            pub const fn arguments(self) -> usize {
                match self { $(Self::$name => $inputs,)* }
            }

            /// How many numbers it gives.
            #[must_use]
            pub const fn results(self) -> usize {
                match self { $(Self::$name => $outputs,)* }
            }
        }

        $(
            struct $name;

            impl Entry<$inputs, $outputs> for $name {
                #[inline(always)]
                fn apply<N: Number>($x: [N; $inputs]) -> [N; $outputs] {
                    $body
                }
            }
        )*

        struct For<S>(PhantomData<S>);

        impl<S: Simd> For<S> {
            const PLAIN: &'static [WideFn] = &[$(
                if is_wide::<S>() { wide::<S, $name, $inputs, $outputs> } else { narrow::<$name, $inputs, $outputs> },
            )*];
            const DUAL: &'static [WideFn] = &[$(
                if is_wide::<S>() {
                    wide_dual::<S, $name, $inputs, $outputs>
                } else {
                    narrow_dual::<$name, $inputs, $outputs>
                },
            )*];
            const SPLINES: [WideSpline; 2] =
                if is_wide::<S>() { [wide_spline::<S>, wide_spline_dual::<S>] } else { [narrow_spline, narrow_spline_dual] };
        }
    };
}

functions! {
    /// Sine.
    Sin, 1 => 1, |[x]| [math::sin(x)];
    /// Cosine.
    Cos, 1 => 1, |[x]| [math::cos(x)];
    /// Tangent.
    Tan, 1 => 1, |[x]| [math::tan(x)];
    /// Arc sine.
    Asin, 1 => 1, |[x]| [math::asin(x)];
    /// Arc cosine.
    Acos, 1 => 1, |[x]| [math::acos(x)];
    /// Arc tangent.
    Atan, 1 => 1, |[x]| [math::atan(x)];
    /// The angle of a direction: y, then x.
    Atan2, 2 => 1, |[y, x]| [math::atan2(y, x)];
    /// e^x.
    Exp, 1 => 1, |[x]| [math::exp(x)];
    /// 2^x.
    Exp2, 1 => 1, |[x]| [math::exp2(x)];
    /// Natural logarithm.
    Log, 1 => 1, |[x]| [math::log(x)];
    /// Logarithm to base 2.
    Log2, 1 => 1, |[x]| [math::log2(x)];
    /// Logarithm to base 10.
    Log10, 1 => 1, |[x]| [math::log10(x)];
    /// x^y.
    Pow, 2 => 1, |[x, y]| [math::pow(x, y)];
    /// The cube root.
    Cbrt, 1 => 1, |[x]| [math::cbrt(x)];
    /// The remainder.
    Fmod, 2 => 1, |[a, b]| [math::fmod(a, b)];
    /// The smooth step: the edges, then the place.
    Smoothstep, 3 => 1, |[low, high, x]| [math::smoothstep(low, high, x)];
    /// Signed Perlin noise; unsigned noise is (x + 1) / 2 of it.
    Snoise1, 1 => 1, |p| [noise::snoise(p)];
    /// Signed Perlin noise.
    Snoise2, 2 => 1, |p| [noise::snoise(p)];
    /// Signed Perlin noise.
    Snoise3, 3 => 1, |p| [noise::snoise(p)];
    /// Signed Perlin noise.
    Snoise4, 4 => 1, |p| [noise::snoise(p)];
    /// Three signed Perlin noises.
    Vsnoise1, 1 => 3, |p| noise::snoise3(p);
    /// Three signed Perlin noises.
    Vsnoise2, 2 => 3, |p| noise::snoise3(p);
    /// Three signed Perlin noises.
    Vsnoise3, 3 => 3, |p| noise::snoise3(p);
    /// Three signed Perlin noises.
    Vsnoise4, 4 => 3, |p| noise::snoise3(p);
    /// Signed Perlin noise that repeats.
    Psnoise1, 2 => 1, |[x, px]| [noise::psnoise([x], [px.value()])];
    /// Signed Perlin noise that repeats.
    Psnoise2, 4 => 1, |[x, y, px, py]| [noise::psnoise([x, y], [px.value(), py.value()])];
    /// Signed Perlin noise that repeats.
    Psnoise3, 6 => 1, |[x, y, z, px, py, pz]| [noise::psnoise([x, y, z], [px.value(), py.value(), pz.value()])];
    /// Signed simplex noise; unsigned noise is (x + 1) / 2 of it.
    Simplex1, 1 => 1, |p| [noise::simplex(p)];
    /// Signed simplex noise.
    Simplex2, 2 => 1, |p| [noise::simplex(p)];
    /// Signed simplex noise.
    Simplex3, 3 => 1, |p| [noise::simplex(p)];
    /// Signed simplex noise.
    Simplex4, 4 => 1, |p| [noise::simplex(p)];
    /// Noise of cells.
    Cell1, 1 => 1, |[x]| [N::lift(noise::cellnoise([x.value()]))];
    /// Noise of cells.
    Cell2, 2 => 1, |[x, y]| [N::lift(noise::cellnoise([x.value(), y.value()]))];
    /// Noise of cells.
    Cell3, 3 => 1, |[x, y, z]| [N::lift(noise::cellnoise([x.value(), y.value(), z.value()]))];
    /// Noise of cells.
    Cell4, 4 => 1, |[x, y, z, t]| [N::lift(noise::cellnoise([x.value(), y.value(), z.value(), t.value()]))];
    /// Three noises of cells.
    Vcell3, 3 => 3, |[x, y, z]| lifted(noise::cellnoise3([x.value(), y.value(), z.value()]));
    /// The hash of one word; rows hold words as the bits of floats, here and below.
    Hash1, 1 => 1, |[x]| [hashed::<N, 1>([x.value()])];
    /// The hash of two words.
    Hash2, 2 => 1, |[x, y]| [hashed::<N, 2>([x.value(), y.value()])];
    /// The hash of three words.
    Hash3, 3 => 1, |[x, y, z]| [hashed::<N, 3>([x.value(), y.value(), z.value()])];
    /// The hash of four words.
    Hash4, 4 => 1, |[x, y, z, t]| [hashed::<N, 4>([x.value(), y.value(), z.value(), t.value()])];
}

#[inline(always)]
fn lifted<N: Number>([a, b, c]: [N::Real; 3]) -> [N; 3] {
    [N::lift(a), N::lift(b), N::lift(c)]
}

#[inline(always)]
fn hashed<N: Number, const D: usize>(x: [N::Real; D]) -> N {
    let mut words = [x[0].bits(); D];
    for (word, x) in words.iter_mut().zip(x) {
        *word = x.bits();
    }
    N::lift(N::Real::from_bits(noise::hash_words(words)))
}

const fn is_wide<S: Simd>() -> bool {
    S::LANES >= 8 || cfg!(target_arch = "aarch64") && S::LANES > 1
}

#[inline(always)]
fn load<S: Simd>(simd: S, row: &Row) -> f32x16<S> {
    f32x16::from_slice(simd, row)
}

#[inline(always)]
fn store<S: Simd>(x: f32x16<S>, row: &mut Row) {
    x.store_slice(row);
}

fn wide<S: Simd, E: Entry<I, O>, const I: usize, const O: usize>(
    token: Token,
    input: &[Row],
    output: &mut [Row],
) {
    let simd = S::from_token(token);
    let input: &[Row; I] = input[..I].try_into().expect("as many rows as arguments");
    simd.vectorize(
        #[inline(always)]
        || {
            let mut x = [load(simd, &input[0]); I];
            for (x, row) in x.iter_mut().zip(input) {
                *x = load(simd, row);
            }
            for (y, row) in E::apply(x).into_iter().zip(&mut output[..O]) {
                store(y, row);
            }
        },
    );
}

fn wide_dual<S: Simd, E: Entry<I, O>, const I: usize, const O: usize>(
    token: Token,
    input: &[Row],
    output: &mut [Row],
) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || {
            let mut x = [Dual::lift(load(simd, &input[0])); I];
            for (x, rows) in x.iter_mut().zip(input[..3 * I].chunks_exact(3)) {
                *x = Dual::new(load(simd, &rows[0]), load(simd, &rows[1]), load(simd, &rows[2]));
            }
            for (y, rows) in E::apply(x).into_iter().zip(output[..3 * O].chunks_exact_mut(3)) {
                store(y.value, &mut rows[0]);
                store(y.dx, &mut rows[1]);
                store(y.dy, &mut rows[2]);
            }
        },
    );
}

fn narrow<E: Entry<I, O>, const I: usize, const O: usize>(_: Token, input: &[Row], output: &mut [Row]) {
    for lane in 0..LANES {
        let x: [f32; I] = std::array::from_fn(|i| input[i][lane]);
        for (y, row) in E::apply(x).into_iter().zip(&mut output[..O]) {
            row[lane] = y;
        }
    }
}

/// One lane of three rows.
fn dual_at(rows: &[Row], lane: usize) -> Dual<f32> {
    Dual::new(rows[0][lane], rows[1][lane], rows[2][lane])
}

fn put_dual(x: Dual<f32>, rows: &mut [Row], lane: usize) {
    (rows[0][lane], rows[1][lane], rows[2][lane]) = (x.value, x.dx, x.dy);
}

fn narrow_dual<E: Entry<I, O>, const I: usize, const O: usize>(_: Token, input: &[Row], output: &mut [Row]) {
    for lane in 0..LANES {
        let x: [Dual<f32>; I] = std::array::from_fn(|i| dual_at(&input[3 * i..], lane));
        for (y, rows) in E::apply(x).into_iter().zip(output[..3 * O].chunks_exact_mut(3)) {
            put_dual(y, rows, lane);
        }
    }
}

/// Knots that all lanes share.
#[derive(Clone, Copy)]
struct Shared<'a>(&'a [f32]);

impl<S: Simd> Knots<f32x16<S>> for Shared<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn at(&self, places: <f32x16<S> as Real>::Words) -> f32x16<S> {
        let mut row = [0.0; LANES];
        for (lane, x) in row.iter_mut().enumerate() {
            *x = self.0[places[lane] as usize];
        }
        f32x16::from_slice(places.token(), &row)
    }
}

impl<S: Simd> Knots<Dual<f32x16<S>>> for Shared<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn at(&self, places: <f32x16<S> as Real>::Words) -> Dual<f32x16<S>> {
        Dual::lift(Knots::<f32x16<S>>::at(self, places))
    }
}

fn wide_spline<S: Simd>(token: Token, basis: Basis, knots: &[f32], input: &[Row], output: &mut [Row]) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || store(spline(basis, load(simd, &input[0]), Shared(knots)), &mut output[0]),
    );
}

fn wide_spline_dual<S: Simd>(token: Token, basis: Basis, knots: &[f32], input: &[Row], output: &mut [Row]) {
    let simd = S::from_token(token);
    simd.vectorize(
        #[inline(always)]
        || {
            let x = Dual::new(load(simd, &input[0]), load(simd, &input[1]), load(simd, &input[2]));
            let y = spline(basis, x, Shared(knots));
            store(y.value, &mut output[0]);
            store(y.dx, &mut output[1]);
            store(y.dy, &mut output[2]);
        },
    );
}

fn narrow_spline(_: Token, basis: Basis, knots: &[f32], input: &[Row], output: &mut [Row]) {
    for lane in 0..LANES {
        output[0][lane] = spline(basis, input[0][lane], knots);
    }
}

fn narrow_spline_dual(_: Token, basis: Basis, knots: &[f32], input: &[Row], output: &mut [Row]) {
    for lane in 0..LANES {
        put_dual(spline(basis, dual_at(input, lane), knots), output, lane);
    }
}

/// The wide functions of one level.
#[derive(Clone, Copy)]
pub struct Wide {
    token: Token,
    plain: &'static [WideFn],
    dual: &'static [WideFn],
    splines: [WideSpline; 2],
}

impl Wide {
    /// Those of a level, or of the best one below it that the CPU has.
    #[must_use]
    pub fn new(level: Level) -> Self {
        let token = level.token();
        by_level!(token, S => Self {
            token,
            plain: For::<S>::PLAIN,
            dual: For::<S>::DUAL,
            splines: For::<S>::SPLINES,
        })
    }

    /// What the functions want as their first argument.
    #[must_use]
    pub fn token(&self) -> Token {
        self.token
    }

    /// A function, with derivatives or without.
    #[must_use]
    pub fn function(&self, function: Function, derivatives: bool) -> WideFn {
        if derivatives { self.dual[function as usize] } else { self.plain[function as usize] }
    }

    /// Splines, with derivatives or without.
    #[must_use]
    pub fn spline(&self, derivatives: bool) -> WideSpline {
        self.splines[usize::from(derivatives)]
    }
}
