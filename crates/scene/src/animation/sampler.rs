// SPDX-License-Identifier: GPL-3.0-or-later
//! Values over time: keys and their interpolation.
//! Source: glTF 2.0 section 3.11 and appendix C (step, linear, spherical linear, cubic spline). Double precision.
//! Times outside of the keys are clamped. Of keys of equal times the last one counts from that time on.
//! Invariant: there is at least one time; times do not descend; each has its values; all numbers in use are
//! finite.
//! Tests: `tests`, `tests/animation.rs`.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::local::{slerp, unit};

/// How values go from key to key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interpolation {
    /// They stay until the next key.
    Step,
    /// Linear; rotations with constant speed on the shorter arc.
    Linear,
    /// By Hermite's cubic: a tangent, a value, a tangent for each key.
    CubicSpline,
}

impl Interpolation {
    /// How many sets of values a key has.
    #[must_use]
    pub fn sets(self) -> usize {
        if self == Self::CubicSpline { 3 } else { 1 }
    }
}

/// Reasons to reject keys; `Display` gives the message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SamplerError {
    /// There are no keys.
    #[error("keys missing")]
    Empty,
    /// A time is NaN or infinite.
    #[error("the time of key {0} is not a finite number")]
    NotFinite(usize),
    /// A value, or a tangent, of a key is NaN or infinite.
    #[error("a value of key {0} is not a finite number")]
    NotFiniteValue(usize),
    /// A time is less than its predecessor.
    #[error("the time of key {0} is before that of the key before it")]
    Unordered(usize),
    /// The number of values does not go with that of the keys.
    #[error("{values} values for {keys} keys; expected {expected}")]
    Count {
        /// Values that there are.
        values: usize,
        /// Keys that there are.
        keys: usize,
        /// Values that these need.
        expected: usize,
    },
}

/// Keys of a value of `width` numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sampler {
    times: Arc<[f32]>,
    values: Vec<f32>,
    width: usize,
    interpolation: Interpolation,
}

impl Sampler {
    /// Keys at `times`; `values` has `width` numbers for each, or for splines three times as many: the tangent that comes in, the
    /// value, the tangent that goes out.
    ///
    /// # Errors
    /// [`SamplerError`] if the times do not ascend (equal ones may follow each other), a number is not finite or the counts do not fit.
    pub fn new(
        times: Arc<[f32]>,
        values: Vec<f32>,
        width: usize,
        interpolation: Interpolation,
    ) -> Result<Self, SamplerError> {
        let keys = times.len();
        if keys == 0 {
            return Err(SamplerError::Empty);
        }
        if let Some(k) = times.iter().position(|t| !t.is_finite()) {
            return Err(SamplerError::NotFinite(k));
        }
        if let Some(k) = times.windows(2).position(|t| t[1] < t[0]) {
            return Err(SamplerError::Unordered(k + 1));
        }
        let expected = keys.saturating_mul(width).saturating_mul(interpolation.sets());
        if values.len() != expected {
            return Err(SamplerError::Count { values: values.len(), keys, expected });
        }
        let of_key = width.saturating_mul(interpolation.sets()).max(1);
        // The tangent into the first key and the tangent out of the last key are unused.
        let ends = if interpolation == Interpolation::CubicSpline { width } else { 0 };
        let used = &values[ends..values.len() - ends];
        if let Some(i) = used.iter().position(|value| !value.is_finite()) {
            return Err(SamplerError::NotFiniteValue((ends + i) / of_key));
        }
        Ok(Self { times, values, width, interpolation })
    }

    /// Numbers of a value.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Times of the keys.
    #[must_use]
    pub fn times(&self) -> &[f32] {
        &self.times
    }

    /// The values of all keys, with tangents.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// How values go from key to key.
    #[must_use]
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// The times of the first and of the last key.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        [self.times[0], self.times[self.times.len() - 1]].map(f64::from)
    }

    /// The values of all keys, without tangents.
    pub fn keys(&self) -> impl Iterator<Item = &[f32]> {
        (0..self.times.len()).map(|k| self.key(k))
    }

    /// Whether two keys share a time.
    #[must_use]
    pub fn has_equal_times(&self) -> bool {
        self.times.windows(2).any(|t| t[0] == t[1])
    }

    fn set(&self, key: usize, set: usize) -> &[f32] {
        let start = (key * self.interpolation.sets() + set) * self.width;
        &self.values[start..start + self.width]
    }

    fn key(&self, key: usize) -> &[f32] {
        self.set(key, self.interpolation.sets() / 2)
    }

    /// The key at or before `seconds`, and how far it is to the next one in `[0, 1)`; before the first key that one.
    fn find(&self, seconds: f64) -> (usize, f64) {
        // NaN is before everything.
        let after = self.times.partition_point(|&t| f64::from(t) <= seconds);
        let Some(key) = after.checked_sub(1) else { return (0, 0.0) };
        let Some(&next) = self.times.get(after) else { return (key, 0.0) };
        let (from, to) = (f64::from(self.times[key]), f64::from(next));
        (key, (seconds - from) / (to - from))
    }

    /// The value of the last key, for any interpolation.
    pub fn step(&self, seconds: f64) -> &[f32] {
        self.key(self.find(seconds).0)
    }

    /// Writes the value at a time to `to`, which has space for `width` numbers.
    pub fn sample(&self, seconds: f64, to: &mut [f64]) {
        let (key, t) = self.find(seconds);
        if t == 0.0 || self.interpolation == Interpolation::Step {
            to.iter_mut().zip(self.key(key)).for_each(|(to, &value)| *to = value.into());
            return;
        }
        let (from, next) = (self.key(key), self.key(key + 1));
        if self.interpolation == Interpolation::Linear {
            for ((to, &a), &b) in to.iter_mut().zip(from).zip(next) {
                *to = (1.0 - t) * f64::from(a) + t * f64::from(b);
            }
            return;
        }
        let length = f64::from(self.times[key + 1]) - f64::from(self.times[key]);
        let (t2, t3) = (t * t, t * t * t);
        let (out, into) = (self.set(key, 2), self.set(key + 1, 0));
        for (k, to) in to.iter_mut().enumerate().take(self.width) {
            let [a, b, c, d] = [from[k], out[k], next[k], into[k]].map(f64::from);
            *to = (2.0 * t3 - 3.0 * t2 + 1.0) * a
                + length * (t3 - 2.0 * t2 + t) * b
                + (3.0 * t2 - 2.0 * t3) * c
                + length * (t3 - t2) * d;
        }
    }

    /// The quaternion at a time; `width` is 4.
    #[must_use]
    pub fn rotation(&self, seconds: f64) -> [f64; 4] {
        let (key, t) = self.find(seconds);
        let quaternion = |values: &[f32]| -> [f64; 4] { std::array::from_fn(|k| values[k].into()) };
        if t > 0.0 && self.interpolation == Interpolation::Linear {
            return slerp(quaternion(self.key(key)), quaternion(self.key(key + 1)), t);
        }
        let mut value = [0.0; 4];
        self.sample(seconds, &mut value);
        unit(value).unwrap_or(value)
    }

    /// Bytes that it holds; times may be shared with others.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.times[..]) + size_of_val(&self.values[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampler(times: &[f32], values: &[f32], how: Interpolation) -> Result<Sampler, SamplerError> {
        Sampler::new(times.into(), values.to_vec(), 1, how)
    }

    fn at(sampler: &Sampler, seconds: f64) -> f64 {
        let mut value = [f64::NAN];
        sampler.sample(seconds, &mut value);
        value[0]
    }

    #[test]
    fn each_interpolation_meets_its_keys_and_is_clamped() {
        let times = [1.0, 2.0, 4.0];
        let step = sampler(&times, &[10.0, 20.0, 40.0], Interpolation::Step).expect("good");
        let linear = sampler(&times, &[10.0, 20.0, 40.0], Interpolation::Linear).expect("good");
        // x^2 and its derivative 2 x: a cubic is met exactly.
        let square = [2.0, 1.0, 2.0, 4.0, 4.0, 4.0, 8.0, 16.0, 8.0];
        let cubic = sampler(&times, &square, Interpolation::CubicSpline).expect("good");
        for (seconds, a, b, c) in [
            (-5.0, 10.0, 10.0, 1.0),
            (f64::NAN, 10.0, 10.0, 1.0),
            (1.0, 10.0, 10.0, 1.0),
            (1.5, 10.0, 15.0, 2.25),
            (2.0, 20.0, 20.0, 4.0),
            (3.5, 20.0, 35.0, 12.25),
            (4.0, 40.0, 40.0, 16.0),
            (99.0, 40.0, 40.0, 16.0),
        ] {
            assert_eq!(at(&step, seconds), a, "step at {seconds}");
            assert_eq!(at(&linear, seconds), b, "linear at {seconds}");
            assert!((at(&cubic, seconds) - c).abs() < 1e-12, "cubic at {seconds}: {}", at(&cubic, seconds));
        }
    }

    #[test]
    fn equal_times_are_a_jump() {
        let jump = sampler(&[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 5.0, 6.0], Interpolation::Linear);
        let jump = jump.expect("equal times may follow each other");
        assert!(jump.has_equal_times(), "it knows");
        let found = [0.5, 0.999, 1.0, 1.5].map(|t| at(&jump, t));
        assert_eq!(found, [0.5, 0.999, 5.0, 5.5], "up to the first, from the last");
    }

    #[test]
    fn refuses_what_is_no_curve() {
        let error = |times: &[f32], values: &[f32]| {
            sampler(times, values, Interpolation::Linear).expect_err("no curve").to_string()
        };
        assert_eq!(error(&[], &[]), "keys missing");
        assert_eq!(error(&[0.0, f32::NAN], &[0.0; 2]), "the time of key 1 is not a finite number");
        assert_eq!(error(&[0.0, 1.0], &[0.0, f32::NAN]), "a value of key 1 is not a finite number");
        let ends = [f32::NAN, 1.0, 2.0, 3.0, 4.0, f32::INFINITY];
        sampler(&[0.0, 1.0], &ends, Interpolation::CubicSpline).expect("nobody looks at the outer tangents");
        let inner = [0.0, 1.0, 2.0, f32::NAN, 4.0, 0.0];
        let error_of_spline =
            sampler(&[0.0, 1.0], &inner, Interpolation::CubicSpline).expect_err("one inside");
        assert_eq!(error_of_spline, SamplerError::NotFiniteValue(1));
        assert!(error(&[0.0, 2.0, 1.0], &[0.0; 3]).starts_with("the time of key 2 is before"), "order");
        assert_eq!(error(&[0.0, 1.0], &[0.0; 3]), "3 values for 2 keys; expected 2");
        let spline = sampler(&[0.0, 1.0], &[0.0; 2], Interpolation::CubicSpline).expect_err("too few");
        assert_eq!(spline.to_string(), "2 values for 2 keys; expected 6");
    }
}
