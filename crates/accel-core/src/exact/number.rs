// SPDX-License-Identifier: GPL-3.0-or-later
//! Arithmetic that is exact or reports that it is not: doubles until a result is rounded, then [`Dyadic`]
//! numbers.
//! Source: [Dek71] for the rounding errors of a sum and a product. Meshes on a grid, where lines do pass
//! through vertices, need no more than doubles. Tests: `tests::doubles_say_when_they_round`.

use super::dyadic::Dyadic;

/// A number whose operations are exact, or `None`.
pub(super) trait Number: Sized + Clone {
    fn new(x: f64) -> Self;
    fn plus(&self, other: &Self) -> Option<Self>;
    fn minus(&self, other: &Self) -> Option<Self>;
    fn times(&self, other: &Self) -> Option<Self>;
    fn sign(&self) -> i8;
}

/// Outside of these, the rounding error is not a double itself.
const LEAST: f64 = 1e-140;
const GREATEST: f64 = 1e140;

impl Number for f64 {
    fn new(x: f64) -> Self {
        x
    }

    fn plus(&self, other: &Self) -> Option<Self> {
        let (a, b) = (*self, *other);
        let sum = a + b;
        let part = sum - a;
        let error = (a - (sum - part)) + (b - part);
        (error == 0.0).then_some(sum)
    }

    fn minus(&self, other: &Self) -> Option<Self> {
        self.plus(&-other)
    }

    fn times(&self, other: &Self) -> Option<Self> {
        let (a, b) = (*self, *other);
        if a == 0.0 || b == 0.0 {
            return Some(0.0);
        }
        let product = a * b;
        let is_plain = |x: f64| x.abs() > LEAST && x.abs() < GREATEST;
        if !(is_plain(product) && is_plain(a) && is_plain(b)) {
            return None;
        }
        let halves = |x: f64| {
            let upper = x * 134_217_729.0;
            let high = upper - (upper - x);
            (high, x - high)
        };
        let ((ah, al), (bh, bl)) = (halves(a), halves(b));
        let error = al * bl - (((product - ah * bh) - al * bh) - ah * bl);
        (error == 0.0).then_some(product)
    }

    fn sign(&self) -> i8 {
        i8::from(*self > 0.0) - i8::from(*self < 0.0)
    }
}

impl Number for Dyadic {
    fn new(x: f64) -> Self {
        Self::new(x)
    }

    fn plus(&self, other: &Self) -> Option<Self> {
        Some(self.plus(other))
    }

    fn minus(&self, other: &Self) -> Option<Self> {
        Some(self.minus(other))
    }

    fn times(&self, other: &Self) -> Option<Self> {
        Some(self.times(other))
    }

    fn sign(&self) -> i8 {
        self.sign()
    }
}

/// A value that is written down once, for any kind of number.
pub(super) trait Formula {
    fn value<N: Number>(&self) -> Option<N>;
}

/// The sign of a value, exactly: -1, 0 or 1.
pub(super) fn sign(formula: &impl Formula) -> i8 {
    match formula.value::<f64>() {
        Some(value) => value.sign(),
        None => formula.value::<Dyadic>().map_or(0, |value| value.sign()),
    }
}

pub(super) type V3<N> = [N; 3];

pub(super) fn of<N: Number>(v: [f64; 3]) -> V3<N> {
    v.map(N::new)
}

pub(super) fn minus<N: Number>([a, b, c]: &V3<N>, [x, y, z]: &V3<N>) -> Option<V3<N>> {
    Some([a.minus(x)?, b.minus(y)?, c.minus(z)?])
}

/// `a * d - b * c`.
pub(super) fn minor<N: Number>(a: &N, b: &N, c: &N, d: &N) -> Option<N> {
    a.times(d)?.minus(&b.times(c)?)
}

pub(super) fn cross<N: Number>([a, b, c]: &V3<N>, [x, y, z]: &V3<N>) -> Option<V3<N>> {
    Some([minor(b, c, y, z)?, minor(c, a, z, x)?, minor(a, b, x, y)?])
}

pub(super) fn dot<N: Number>([a, b, c]: &V3<N>, [x, y, z]: &V3<N>) -> Option<N> {
    a.times(x)?.plus(&b.times(y)?)?.plus(&c.times(z)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_say_when_they_round() {
        let third = 1.0 / 3.0;
        assert_eq!(Number::plus(&1.5, &2.25), Some(3.75), "a sum that is a double");
        assert_eq!(Number::plus(&1.0, &1e-30), None, "one that is not");
        assert_eq!(Number::times(&1.5, &2.5), Some(3.75), "a product that is a double");
        assert_eq!(Number::times(&third, &third), None, "one that is not");
        assert_eq!(Number::times(&1e-100, &1e-100), None, "too small to tell");
        assert_eq!(Number::times(&0.0, &1e300), Some(0.0), "nothing times anything");
        assert_eq!(Number::minus(&f64::INFINITY, &1.0), None, "infinity is no number");
    }
}
