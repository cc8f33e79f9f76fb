// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays. Space: that of the queried structure (world for a scene, object for an object's tree).
//! Tests: `tests::directions_of_any_length_are_made_regular`.

use std::borrow::Cow;

/// A ray `org + t * dir` for `t` in `[t_near, t_far]`.
///
/// `dir` need not be of unit length: `t` counts in multiples of it. A ray with a NaN, an infinite direction, an origin
/// beyond [`Ray::FARTHEST_ORIGIN`], a zero direction or an empty interval hits nothing. `t_far` may be infinite.
///
/// The fields have the layout of the first ones of Embree's `RTCRay`, so that a ray of a C program is read where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// Origin.
    pub org: [f32; 3],
    /// Smallest parameter that counts as a hit, inclusive. Designed for `>= 0`: below zero hits behind the
    /// origin are right, too, but nearer boxes are no longer visited first.
    pub t_near: f32,
    /// Direction, any length but zero. Of very short ones `t` may be beyond the greatest float, and then infinite.
    pub dir: [f32; 3],
    /// The time at which it sees moving geometry, from 0 to 1; values beyond are clamped, NaN is 0.
    pub time: f32,
    /// Largest parameter that counts as a hit, inclusive.
    pub t_far: f32,
    /// It sees an instance or a geometry where its mask and theirs have a bit in common.
    pub mask: u32,
}

impl Ray {
    /// The ray from `org` towards `dir` over `[0, inf]`, which sees everything at time 0.
    #[must_use]
    #[inline]
    pub fn new(org: [f32; 3], dir: [f32; 3]) -> Self {
        Self { org, t_near: 0.0, dir, t_far: f32::INFINITY, mask: u32::MAX, time: 0.0 }
    }

    /// The same ray, with a visibility mask.
    #[must_use]
    #[inline]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }

    /// The same ray at another time.
    #[must_use]
    #[inline]
    pub fn with_time(self, time: f32) -> Self {
        Self { time, ..self }
    }

    /// The same ray, seen only in `[t_near, t_far]`.
    #[must_use]
    #[inline]
    pub fn within(self, t_near: f32, t_far: f32) -> Self {
        Self { t_near, t_far, ..self }
    }

    /// The same ray from just behind a hit at `t` on: the query for the next hit, for shadows through glass.
    ///
    /// It starts at the next greater float, so a loop that follows a ray from hit to hit always ends: `t` grows in
    /// every round. The price: of several surfaces at exactly the same `t` only one is found.
    #[must_use]
    #[inline]
    pub fn beyond(self, t: f32) -> Self {
        Self { t_near: t.next_up(), ..self }
    }

    /// The point at parameter `t`.
    #[must_use]
    #[inline]
    pub fn at(&self, t: f32) -> [f32; 3] {
        [0, 1, 2].map(|k| self.org[k] + t * self.dir[k])
    }

    /// Greatest coordinate of an origin; kernels' products still fit a float.
    pub const FARTHEST_ORIGIN: f32 = 1e20;

    /// Directions whose longest component is in this range are traced as they are, others scaled first.
    pub const SHORTEST: f32 = 1.0 / Self::LONGEST;
    pub const LONGEST: f32 = (1 << 20) as f32;

    /// Whether it can hit anything.
    #[inline(always)]
    pub fn is_sound(&self) -> bool {
        let longest = size_bits(self.dir);
        let moves = longest != 0 && longest <= f32::MAX.to_bits();
        size_bits(self.org) <= Self::FARTHEST_ORIGIN.to_bits() && moves && self.t_near <= self.t_far
    }

    /// The axis along which it moves most; the first of equals.
    #[inline(always)]
    pub fn longest_axis(&self) -> usize {
        Self::longest_of([self.dir[0].abs(), self.dir[1].abs(), self.dir[2].abs()])
    }

    /// That of the greatest of these numbers; the first of equals.
    #[inline(always)]
    pub fn longest_of([x, y, z]: [f32; 3]) -> usize {
        if x >= y && x >= z { 0 } else { 2 - usize::from(y >= z) }
    }

    /// The same ray with a direction of regular length, and the factor from its parameters to this one's: a
    /// power of two, so that there is no rounding, unless `t` leaves the range of floats.
    #[cold]
    pub fn regular(&self) -> (Self, f64) {
        let mut dir = self.dir;
        let mut scale = 1.0f64;
        let longest = |dir: [f32; 3]| dir.iter().fold(0.0f32, |most, x| most.max(x.abs()));
        // The least of all floats is 2^-149.
        while longest(dir) < 1.0 && scale < 2f64.powi(150) {
            dir = dir.map(|x| x * 64.0);
            scale *= 64.0;
        }
        while longest(dir) > 64.0 {
            dir = dir.map(|x| x / 64.0);
            scale /= 64.0;
        }
        let scaled = |t: f32| (f64::from(t) / scale) as f32;
        (Self { dir, t_near: scaled(self.t_near), t_far: scaled(self.t_far), ..*self }, scale)
    }

    /// Whether the direction is of a length that kernels take as it is.
    #[inline(always)]
    pub fn is_regular(&self) -> bool {
        (Self::SHORTEST.to_bits()..=Self::LONGEST.to_bits()).contains(&size_bits(self.dir))
    }
}

/// Bits of the largest magnitude: they are in the order of magnitudes, and those of infinities and then NaNs come last.
#[inline(always)]
fn size_bits([x, y, z]: [f32; 3]) -> u32 {
    let bits = |x: f32| x.to_bits() & 0x7fff_ffff;
    bits(x).max(bits(y)).max(bits(z))
}

/// A ray whose origin is in double precision, for scenes far from the world's origin.
///
/// The instances of a [`SceneTree`](crate::SceneTree) have transforms in double precision, too: only the
/// difference of the two reaches an object, so no precision is lost where both are far away. Directions and
/// parameters are as for a [`Ray`]. A direct query of an object's tree rounds the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray64 {
    /// Origin.
    pub org: [f64; 3],
    /// Smallest parameter that counts as a hit, inclusive, `>= 0`.
    pub t_near: f32,
    /// Direction, any length but zero.
    pub dir: [f32; 3],
    /// Largest parameter that counts as a hit, inclusive.
    pub t_far: f32,
    /// See [`Ray::mask`].
    pub mask: u32,
    /// See [`Ray::time`].
    pub time: f32,
}

impl Ray64 {
    /// The ray from `org` towards `dir` over `[0, inf]`, which sees everything.
    #[must_use]
    pub fn new(org: [f64; 3], dir: [f32; 3]) -> Self {
        Self { org, t_near: 0.0, dir, t_far: f32::INFINITY, mask: u32::MAX, time: 0.0 }
    }

    /// The point at parameter `t`.
    #[must_use]
    #[inline]
    pub fn at(&self, t: f32) -> [f64; 3] {
        [0, 1, 2].map(|k| self.org[k] + f64::from(t) * f64::from(self.dir[k]))
    }
}

/// The argument of one-ray calls: a [`Ray`] or a [`Ray64`].
pub trait AnyRay {
    /// The ray in single precision.
    fn rounded(&self) -> Cow<'_, Ray>;
    /// Its origin, where that is known in double precision.
    fn origin64(&self) -> Option<[f64; 3]>;
}

impl AnyRay for Ray {
    #[inline(always)]
    fn rounded(&self) -> Cow<'_, Ray> {
        Cow::Borrowed(self)
    }

    #[inline(always)]
    fn origin64(&self) -> Option<[f64; 3]> {
        None
    }
}

impl AnyRay for Ray64 {
    fn rounded(&self) -> Cow<'_, Ray> {
        let Self { org, t_near, dir, t_far, mask, time } = *self;
        Cow::Owned(Ray { org: org.map(|x| x as f32), t_near, dir, t_far, mask, time })
    }

    fn origin64(&self) -> Option<[f64; 3]> {
        Some(self.org)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_of_any_length_are_made_regular() {
        for exponent in (-149..128).step_by(7) {
            let length = 2f64.powi(exponent) as f32;
            let ray = Ray::new([0.0; 3], [0.0, -length, 0.0]).within(0.0, 4.0);
            let (regular, scale) = ray.regular();
            assert!(regular.is_regular(), "{length:e} becomes {:?}", regular.dir);
            let same = f64::from(regular.dir[1]) == f64::from(ray.dir[1]) * scale;
            assert!(same, "{:?} is {:?} times {scale}", regular.dir, ray.dir);
        }
    }
}
