// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers that are an integer times a power of two, of any size: sums, differences and products are exact.
//! Schoolbook multiplication. Cost: about a hundred nanoseconds an operation, so this is for cases that
//! doubles cannot decide. Invariant: no leading zero words; zero has no word and sign 0. Tests: `tests`.

/// `sign * limbs * 2^exponent`, lowest word first.
#[derive(Clone, Debug)]
pub(super) struct Dyadic {
    sign: i8,
    limbs: Vec<u64>,
    exponent: i32,
}

impl Dyadic {
    /// Of a finite double.
    pub(super) fn new(x: f64) -> Self {
        let bits = x.to_bits();
        let (exponent, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
        let (limb, exponent) = match exponent {
            0 => (fraction, -1074),
            _ => (fraction | 1 << 52, exponent - 1075),
        };
        // Short words make short products.
        let zeros = if limb == 0 { 0 } else { limb.trailing_zeros() };
        let sign = if x < 0.0 { -1 } else { 1 };
        Self { sign, limbs: vec![limb >> zeros], exponent: exponent + zeros as i32 }.trimmed()
    }

    pub(super) fn sign(&self) -> i8 {
        self.sign
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        if self.sign == 0 || other.sign == 0 {
            return if self.sign == 0 { other.clone() } else { self.clone() };
        }
        let exponent = self.exponent.min(other.exponent);
        let a = shifted(&self.limbs, (self.exponent - exponent) as usize);
        let b = shifted(&other.limbs, (other.exponent - exponent) as usize);
        let (sign, limbs) = if self.sign == other.sign {
            (self.sign, sum(a, &b))
        } else if is_less(&a, &b) {
            (other.sign, difference(b, &a))
        } else {
            (self.sign, difference(a, &b))
        };
        Self { sign, limbs, exponent }.trimmed()
    }

    pub(super) fn minus(&self, other: &Self) -> Self {
        self.plus(&Self { sign: -other.sign, ..other.clone() })
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut limbs = vec![0; self.limbs.len() + other.limbs.len()];
        for (i, &a) in self.limbs.iter().enumerate() {
            let mut carry = 0;
            for (j, &b) in other.limbs.iter().enumerate() {
                // The greatest product and two greatest words fit.
                let value = u128::from(a) * u128::from(b) + u128::from(limbs[i + j]) + carry;
                limbs[i + j] = value as u64;
                carry = value >> 64;
            }
            limbs[i + other.limbs.len()] = carry as u64;
        }
        let exponent = self.exponent + other.exponent;
        Self { sign: self.sign * other.sign, limbs, exponent }.trimmed()
    }

    /// The quotient as a double: two roundings and that of the division. `other` is not zero.
    pub(super) fn over(&self, other: &Self) -> f64 {
        let ((a, up), (b, down)) = (self.leading(), other.leading());
        a / b * 2f64.powi(up - down)
    }

    /// The first two words, and the power of two that they are to be multiplied by.
    fn leading(&self) -> (f64, i32) {
        let two = 2f64.powi(64);
        let (value, below) = match self.limbs[..] {
            [] => (0.0, 0),
            [only] => (only as f64, 0),
            [.., low, high] => (high as f64 * two + low as f64, self.limbs.len() as i32 - 2),
        };
        (f64::from(self.sign) * value, self.exponent + 64 * below)
    }

    fn trimmed(mut self) -> Self {
        while self.limbs.last() == Some(&0) {
            self.limbs.pop();
        }
        if self.limbs.is_empty() {
            (self.sign, self.exponent) = (0, 0);
        }
        self
    }
}

fn shifted(limbs: &[u64], by: usize) -> Vec<u64> {
    let (whole, bits) = (by / 64, by % 64);
    let mut result = vec![0; whole];
    result.reserve(limbs.len() + 1);
    let mut low = 0;
    for &limb in limbs {
        result.push(limb << bits | low);
        low = if bits == 0 { 0 } else { limb >> (64 - bits) };
    }
    result.push(low);
    result
}

fn is_less(a: &[u64], b: &[u64]) -> bool {
    let at = |limbs: &[u64], i: usize| limbs.get(i).copied().unwrap_or(0);
    let differing = (0..a.len().max(b.len())).rev().find(|&i| at(a, i) != at(b, i));
    differing.is_some_and(|i| at(a, i) < at(b, i))
}

fn sum(mut a: Vec<u64>, b: &[u64]) -> Vec<u64> {
    a.resize(a.len().max(b.len()) + 1, 0);
    let mut carry = false;
    for (i, limb) in a.iter_mut().enumerate() {
        let (once, first) = limb.overflowing_add(b.get(i).copied().unwrap_or(0));
        let (twice, second) = once.overflowing_add(u64::from(carry));
        (*limb, carry) = (twice, first || second);
    }
    a
}

/// `a` is not the lesser.
fn difference(mut a: Vec<u64>, b: &[u64]) -> Vec<u64> {
    let mut borrow = false;
    for (i, limb) in a.iter_mut().enumerate() {
        let (once, first) = limb.overflowing_sub(b.get(i).copied().unwrap_or(0));
        let (twice, second) = once.overflowing_sub(u64::from(borrow));
        (*limb, borrow) = (twice, first || second);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    #[test]
    fn small_integers_are_right() {
        let mut random = Random::new(1);
        for _ in 0..20_000 {
            // Integers of up to 40 bits, times powers of two that go along.
            let mut pick = || (random.bits() as i64 >> (24 + random.below(39)), random.below(60) as i32 - 30);
            let ((a, e), (b, f), (c, _)) = (pick(), pick(), pick());
            let of = |x: i64, e: i32| Dyadic::new(x as f64 * 2f64.powi(e));
            let product = of(a, e).times(&of(b, f));
            assert_eq!(product.sign(), (i128::from(a) * i128::from(b)).signum() as i8, "{a} times {b}");
            let exact = i128::from(a) * i128::from(b) - i128::from(c);
            let value = product.minus(&of(c, 0).times(&of(1, e + f)));
            assert_eq!(value.sign(), exact.signum() as i8, "{a} * {b} - {c}");
            let zero = value.plus(&of(c, e).times(&of(1, f))).minus(&product);
            assert_eq!(zero.sign(), 0, "what is added and taken away leaves nothing");
        }
    }

    #[test]
    fn the_least_counts_beside_the_greatest() {
        let (large, small) = (Dyadic::new(f64::MAX), Dyadic::new(5e-324));
        assert_eq!(large.plus(&small).minus(&large).minus(&small).sign(), 0, "nothing is lost");
        let square = large.times(&large);
        assert_eq!(square.minus(&small.times(&small)).minus(&square).sign(), -1, "squares neither");
        assert_eq!(Dyadic::new(-0.0).sign(), 0, "zero has no sign");
        assert_eq!(Dyadic::new(-2.5).sign(), -1, "others do");
    }
}
