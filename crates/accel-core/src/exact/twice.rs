// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of twice the precision of doubles: a double and the part of it that was lost.
//! Source: [Dek71]. The relative error of an operation is below 2^-100, except for sums that cancel.
//! Invariant: `low` is at most half a unit in the last place of `high`. Tests: `tests::beyond_doubles`.

use super::number::Number;

/// `high + low`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twice {
    high: f64,
    low: f64,
}

/// A rounded sum, and its rounding error.
fn sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// A rounded product, and its rounding error.
fn product(a: f64, b: f64) -> (f64, f64) {
    let halves = |x: f64| {
        let upper = x * 134_217_729.0;
        let high = upper - (upper - x);
        (high, x - high)
    };
    let product = a * b;
    let ((ah, al), (bh, bl)) = (halves(a), halves(b));
    (product, al * bl - (((product - ah * bh) - al * bh) - ah * bl))
}

impl Twice {
    fn settled(high: f64, low: f64) -> Self {
        let (high, low) = sum(high, low);
        Self { high, low }
    }

    /// Rounded.
    pub(super) fn rounded(self) -> f64 {
        self.high
    }

    /// The quotient as a double.
    pub(super) fn over(self, other: Self) -> f64 {
        let first = self.high / other.high;
        let (back, lost) = product(first, other.high);
        let rest = ((self.high - back) - lost + self.low) - first * other.low;
        first + rest / other.high
    }
}

/// No operation reports that it rounds: callers bound the error.
impl Number for Twice {
    fn new(x: f64) -> Self {
        Self { high: x, low: 0.0 }
    }

    fn plus(&self, other: &Self) -> Option<Self> {
        let (high, lost) = sum(self.high, other.high);
        let (low, least) = sum(self.low, other.low);
        let Self { high, low } = Self::settled(high, lost + low);
        Some(Self::settled(high, low + least))
    }

    fn minus(&self, other: &Self) -> Option<Self> {
        self.plus(&Self { high: -other.high, low: -other.low })
    }

    fn times(&self, other: &Self) -> Option<Self> {
        let (high, lost) = product(self.high, other.high);
        Some(Self::settled(high, lost + (self.high * other.low + self.low * other.high)))
    }

    fn sign(&self) -> i8 {
        i8::from(self.high > 0.0) - i8::from(self.high < 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_doubles() {
        let (one, little) = (Twice::new(1.0), Twice::new(1e-25));
        let rest = one.plus(&little).and_then(|sum| sum.minus(&one)).map(Twice::rounded);
        assert_eq!(rest, Some(1e-25), "a sum keeps the lesser part");
        let third = 1.0 / 3.0;
        let square = Twice::new(third).times(&Twice::new(third));
        let rest = square.and_then(|square| square.minus(&Twice::new(third * third))).map(Twice::rounded);
        assert_eq!(rest, Some(f64::mul_add(third, third, -(third * third))), "a product its rounding error");
        assert_eq!(Twice::new(1.0).over(Twice::new(3.0)), third, "a quotient");
    }
}
