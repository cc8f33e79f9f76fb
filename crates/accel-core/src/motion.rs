// SPDX-License-Identifier: GPL-3.0-or-later
//! Times between keys that are evenly spaced over an open shutter. Straight lines between keys are Embree's
//! and glTF's (LINEAR).
//! Invariant: interpolation is two products and a sum, each rounded, which never reverses an order: two
//! numbers in one order at both keys are in that order between them. So an interpolated box encloses the
//! interpolation of everything that the boxes at its keys enclose.
//! Tests: `tests`, `tests/surfaces/motion.rs` of `gnurt-accel`.

/// The keys around a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyInterval {
    /// The key before it.
    pub key: usize,
    /// The key behind it.
    pub next: usize,
    /// How much these two count; the sum is 1 up to rounding.
    pub weights: [f32; 2],
}

impl KeyInterval {
    /// Where `time` in [0, 1] lies among `keys`, one or more. Other times are clamped, NaN is 0.
    #[must_use]
    #[inline(always)]
    pub fn of(time: f32, keys: usize) -> Self {
        let pieces = keys.saturating_sub(1);
        if pieces == 0 {
            return Self { key: 0, next: 0, weights: [1.0, 0.0] };
        }
        // NaN is not above zero.
        let at = if time > 0.0 { time.min(1.0) } else { 0.0 } * pieces as f32;
        let key = (at as usize).min(pieces - 1);
        let behind = at - key as f32;
        Self { key, next: key + 1, weights: [1.0 - behind, behind] }
    }

    /// The interpolated number, `from` at the key before and `to` at the one behind.
    #[must_use]
    #[inline(always)]
    pub fn mix(&self, from: f32, to: f32) -> f32 {
        self.weights[0] * from + self.weights[1] * to
    }

    /// The same for a point or a direction.
    #[must_use]
    #[inline(always)]
    pub fn mix3(&self, from: [f32; 3], to: [f32; 3]) -> [f32; 3] {
        [self.mix(from[0], to[0]), self.mix(from[1], to[1]), self.mix(from[2], to[2])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_lie_between_their_keys() {
        let at = |time, keys| KeyInterval::of(time, keys);
        assert_eq!(at(0.5, 1), KeyInterval { key: 0, next: 0, weights: [1.0, 0.0] }, "one key stands still");
        assert_eq!(
            at(0.25, 2),
            KeyInterval { key: 0, next: 1, weights: [0.75, 0.25] },
            "a quarter of the way"
        );
        assert_eq!(
            at(0.625, 5),
            KeyInterval { key: 2, next: 3, weights: [0.5, 0.5] },
            "in the third of four pieces"
        );
        assert_eq!(at(1.0, 4), KeyInterval { key: 2, next: 3, weights: [0.0, 1.0] }, "the last key");
        assert_eq!((at(-3.0, 3), at(7.0, 3)), (at(0.0, 3), at(1.0, 3)), "times beyond are clamped");
        assert_eq!(at(f32::NAN, 3), at(0.0, 3), "no number is the first key");
        assert_eq!(
            (at(0.0, 2).mix(3.3, 9.1), at(1.0, 2).mix(3.3, 9.1)),
            (3.3, 9.1),
            "keys are kept as they are"
        );
    }

    #[test]
    fn mixing_keeps_the_order() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        for _ in 0..100_000 {
            let interval = KeyInterval::of(random(), 3);
            let (low, high) = ([random() - 0.5, random() - 0.5], [random(), random()]);
            let more = [low[0] + 1e-7 * high[0], low[1] + 1e-7 * high[1]];
            assert!(
                interval.mix(low[0], low[1]) <= interval.mix(more[0], more[1]),
                "{low:?} and {more:?}, {interval:?}"
            );
        }
    }
}
