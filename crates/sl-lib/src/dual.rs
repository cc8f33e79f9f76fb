// SPDX-License-Identifier: GPL-3.0-or-later
//! Dual numbers: a value with its derivatives along the two directions of the screen.
//! The rules are those of every forward-mode differentiation.
//! Invariant: a value does not depend on whether derivatives are carried along, to the bit. In OSL it does,
//! by a rounding, in `pow`, `smoothstep` and four-dimensional noise; here a request for derivatives cannot
//! change a picture.
//! Tests: `tests/derivatives.rs`, against finite differences.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::number::{Number, Real};

/// A value and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dual<T> {
    /// The value.
    pub value: T,
    /// Its change from this pixel to the next one in x.
    pub dx: T,
    /// Its change from this pixel to the next one in y.
    pub dy: T,
}

impl<T> Dual<T> {
    /// From its parts.
    #[inline(always)]
    pub const fn new(value: T, dx: T, dy: T) -> Self {
        Self { value, dx, dy }
    }

    /// A function applied to each part: right for functions that are linear.
    #[inline(always)]
    pub fn map<U>(self, mut function: impl FnMut(T) -> U) -> Dual<U> {
        Dual { value: function(self.value), dx: function(self.dx), dy: function(self.dy) }
    }
}

impl<T: Copy> Dual<[T; 3]> {
    /// A triple with derivatives as a triple of numbers with derivatives, the form that functions take.
    #[inline(always)]
    pub fn components(self) -> [Dual<T>; 3] {
        let [v, dx, dy] = [self.value, self.dx, self.dy];
        [Dual::new(v[0], dx[0], dy[0]), Dual::new(v[1], dx[1], dy[1]), Dual::new(v[2], dx[2], dy[2])]
    }

    /// The inverse of [`components`](Self::components).
    #[inline(always)]
    pub fn from_components([a, b, c]: [Dual<T>; 3]) -> Self {
        Self { value: [a.value, b.value, c.value], dx: [a.dx, b.dx, c.dx], dy: [a.dy, b.dy, c.dy] }
    }
}

impl From<f32> for Dual<f32> {
    /// A constant.
    fn from(value: f32) -> Self {
        Self { value, dx: 0.0, dy: 0.0 }
    }
}

impl From<[f32; 3]> for Dual<[f32; 3]> {
    /// A constant.
    fn from(value: [f32; 3]) -> Self {
        Self { value, dx: [0.0; 3], dy: [0.0; 3] }
    }
}

impl<R: Real> Neg for Dual<R> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value, dx: -self.dx, dy: -self.dy }
    }
}

impl<R: Real> Add for Dual<R> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, dx: self.dx + other.dx, dy: self.dy + other.dy }
    }
}

impl<R: Real> Sub for Dual<R> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, dx: self.dx - other.dx, dy: self.dy - other.dy }
    }
}

impl<R: Real> Mul for Dual<R> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            dx: self.value * other.dx + self.dx * other.value,
            dy: self.value * other.dy + self.dy * other.value,
        }
    }
}

impl<R: Real> Div for Dual<R> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = other.value.of(1.0) / other.value;
        let value = self.value / other.value;
        Self { value, dx: inverse * (self.dx - value * other.dx), dy: inverse * (self.dy - value * other.dy) }
    }
}

impl<R: Real> Add<f32> for Dual<R> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f32) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<R: Real> Sub<f32> for Dual<R> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: f32) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<R: Real> Mul<f32> for Dual<R> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f32) -> Self {
        Self { value: self.value * other, dx: self.dx * other, dy: self.dy * other }
    }
}

impl<R: Real> Number for Dual<R> {
    type Real = R;
    type Mask = R::Mask;

    #[inline(always)]
    fn value(self) -> R {
        self.value
    }

    #[inline(always)]
    fn lift(value: R) -> Self {
        let zero = value.of(0.0);
        Self { value, dx: zero, dy: zero }
    }

    #[inline(always)]
    fn chain(self, value: R, slope: impl FnOnce() -> R) -> Self {
        let slope = slope();
        Self { value, dx: slope * self.dx, dy: slope * self.dy }
    }

    #[inline(always)]
    fn chain2(self, other: Self, value: R, slopes: impl FnOnce() -> (R, R)) -> Self {
        let (a, b) = slopes();
        Self { value, dx: a * self.dx + b * other.dx, dy: a * self.dy + b * other.dy }
    }

    #[inline(always)]
    fn pick(mask: R::Mask, a: Self, b: Self) -> Self {
        Self {
            value: R::choose(mask, a.value, b.value),
            dx: R::choose(mask, a.dx, b.dx),
            dy: R::choose(mask, a.dy, b.dy),
        }
    }

    #[inline(always)]
    fn negated_where(self, bit: R::UInts) -> Self {
        Self {
            value: self.value.negated_where(bit),
            dx: self.dx.negated_where(bit),
            dy: self.dy.negated_where(bit),
        }
    }

    #[inline(always)]
    fn with_value(self, value: R) -> Self {
        Self { value, ..self }
    }

    #[inline(always)]
    fn slopes(self) -> Option<[R; 2]> {
        Some([self.dx, self.dy])
    }

    #[inline(always)]
    fn from_parts(value: R, slopes: impl FnOnce() -> [R; 2]) -> Self {
        let [dx, dy] = slopes();
        Self { value, dx, dy }
    }

    #[inline(always)]
    fn scaled(self, by: R) -> Self {
        Self { value: self.value * by, dx: self.dx * by, dy: self.dy * by }
    }
}
