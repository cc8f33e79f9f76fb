// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays, one by one and in batches.
//! Source: [SSM*05]; hot fields as structure of arrays after the paper's Figure 4.
//! Space: that of the structure that is asked (world for a scene, object for an object's tree).
//! Invariant: all vectors of a batch have the same length, but for the masks, which may be missing altogether.
//! Proof: `tests::push_and_get`.

use std::borrow::Cow;

use crate::kd::most;

/// A ray `org + t * dir` for `t` in `[t_near, t_far]`.
///
/// `dir` need not be of unit length: `t` counts in multiples of it. A ray with a NaN, an infinite direction, an origin
/// beyond [`Ray::FARTHEST_ORIGIN`], a zero direction or an empty interval hits nothing. `t_far` may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin.
    pub org: [f32; 3],
    /// Smallest parameter that counts as a hit, inclusive, `>= 0`.
    pub t_near: f32,
    /// Direction, any length but zero.
    pub dir: [f32; 3],
    /// Largest parameter that counts as a hit, inclusive.
    pub t_far: f32,
    /// It sees an instance or a geometry where its mask and theirs have a bit in common.
    pub mask: u32,
}

impl Ray {
    /// The ray from `org` towards `dir` over `[0, inf]`, which sees everything.
    #[must_use]
    #[inline]
    pub fn new(org: [f32; 3], dir: [f32; 3]) -> Self {
        Self { org, t_near: 0.0, dir, t_far: f32::INFINITY, mask: u32::MAX }
    }

    /// The same ray, with a mask that says what it sees.
    #[must_use]
    #[inline]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }

    /// The same ray, seen only in `[t_near, t_far]`.
    #[must_use]
    pub fn within(self, t_near: f32, t_far: f32) -> Self {
        Self { t_near, t_far, ..self }
    }

    /// The same ray from just behind a hit at `t` on: what asks for the next hit, for shadows through glass.
    ///
    /// It starts at the next greater float, so a loop that follows a ray from hit to hit always ends: `t` grows in
    /// every round. The price: of several surfaces at exactly the same `t` only one is seen.
    #[must_use]
    pub fn beyond(self, t: f32) -> Self {
        Self { t_near: t.next_up(), ..self }
    }

    /// The point at parameter `t`.
    #[must_use]
    pub fn at(&self, t: f32) -> [f32; 3] {
        [0, 1, 2].map(|k| self.org[k] + t * self.dir[k])
    }

    /// Greatest coordinate of an origin; kernels' products still fit a float.
    pub const FARTHEST_ORIGIN: f32 = 1e20;

    /// Directions whose longest component is in this range are traced as they are, others scaled first.
    pub(crate) const SHORTEST: f32 = 1.0 / Self::LONGEST;
    pub(crate) const LONGEST: f32 = (1 << 20) as f32;

    /// Whether it can hit anything. Every comparison is false for a NaN.
    #[inline(always)]
    pub(crate) fn is_sound(&self) -> bool {
        let limit = Self::FARTHEST_ORIGIN;
        let ([x, y, z], [dx, dy, dz]) = (self.org, self.dir);
        let near = x.abs() <= limit && y.abs() <= limit && z.abs() <= limit;
        let finite = dx.abs() <= f32::MAX && dy.abs() <= f32::MAX && dz.abs() <= f32::MAX;
        near && finite && self.longest() > 0.0 && self.t_near <= self.t_far
    }

    /// The largest component of the direction, without its sign.
    #[inline(always)]
    pub(crate) fn longest(&self) -> f32 {
        // Written out: `map` over an array may be a call, and `f32::max` minds NaNs, which sound rays have none of.
        let [x, y, z] = [self.dir[0].abs(), self.dir[1].abs(), self.dir[2].abs()];
        most(most(x, y), z)
    }

    /// The axis along which it moves most; the first of equals.
    #[inline(always)]
    pub(crate) fn longest_axis(&self) -> usize {
        let [x, y, z] = [self.dir[0].abs(), self.dir[1].abs(), self.dir[2].abs()];
        if x >= y && x >= z { 0 } else { 2 - usize::from(y >= z) }
    }

    /// The same ray with a direction of regular length, and what its parameters have to be multiplied with to be
    /// this one's. Powers of two: nothing is rounded, unless `t` leaves the range of floats.
    #[cold]
    pub(crate) fn regular(&self) -> (Self, f32) {
        let mut dir = self.dir;
        let mut scale = 1.0f32;
        let longest = |dir: [f32; 3]| dir.iter().fold(0.0f32, |most, x| most.max(x.abs()));
        while longest(dir) < 1.0 && scale < 2f32.powi(120) {
            dir = dir.map(|x| x * 64.0);
            scale *= 64.0;
        }
        while longest(dir) > 64.0 {
            dir = dir.map(|x| x / 64.0);
            scale /= 64.0;
        }
        (Self { dir, t_near: self.t_near / scale, t_far: self.t_far / scale, ..*self }, scale)
    }
}

/// A ray whose origin is in double precision, for scenes far from the world's origin.
///
/// The instances of a [`SceneTree`](crate::SceneTree) have their places in double precision, too: what reaches an
/// object is the difference of the two, so nothing is lost where both are far away. Directions and parameters are as
/// for a [`Ray`]. An object's tree that is asked directly rounds the origin.
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
}

impl Ray64 {
    /// The ray from `org` towards `dir` over `[0, inf]`, which sees everything.
    #[must_use]
    pub fn new(org: [f64; 3], dir: [f32; 3]) -> Self {
        Self { org, t_near: 0.0, dir, t_far: f32::INFINITY, mask: u32::MAX }
    }

    /// The point at parameter `t`.
    #[must_use]
    pub fn at(&self, t: f32) -> [f64; 3] {
        [0, 1, 2].map(|k| self.org[k] + f64::from(t) * f64::from(self.dir[k]))
    }
}

/// What one-ray calls take: a [`Ray`] or a [`Ray64`].
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
        let Self { org, t_near, dir, t_far, mask } = *self;
        Cow::Owned(Ray { org: org.map(|x| x as f32), t_near, dir, t_far, mask })
    }

    fn origin64(&self) -> Option<[f64; 3]> {
        Some(self.org)
    }
}

/// Many rays, one array per component: what a tile's queue holds and what kernels read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RayBatch {
    /// Origins: x, y and z arrays, `len()` values each.
    pub org: [Vec<f32>; 3],
    /// Directions, likewise.
    pub dir: [Vec<f32>; 3],
    /// Near ends.
    pub t_near: Vec<f32>,
    /// Far ends.
    pub t_far: Vec<f32>,
    /// Masks; empty as long as all rays see everything.
    pub mask: Vec<u32>,
}

impl RayBatch {
    /// An empty batch with room for `n` rays.
    #[must_use]
    pub fn with_capacity(n: usize) -> Self {
        let array = || Vec::with_capacity(n);
        Self {
            org: [array(), array(), array()],
            dir: [array(), array(), array()],
            t_near: array(),
            t_far: array(),
            mask: Vec::new(),
        }
    }

    /// Number of rays.
    #[must_use]
    pub fn len(&self) -> usize {
        self.t_near.len()
    }

    /// Whether no ray is in.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.t_near.is_empty()
    }

    /// Appends a ray.
    pub fn push(&mut self, ray: Ray) {
        for k in 0..3 {
            self.org[k].push(ray.org[k]);
            self.dir[k].push(ray.dir[k]);
        }
        self.t_near.push(ray.t_near);
        self.t_far.push(ray.t_far);
        if ray.mask != u32::MAX || !self.mask.is_empty() {
            self.mask.resize(self.t_near.len() - 1, u32::MAX);
            self.mask.push(ray.mask);
        }
    }

    /// Ray `i`. Panics if `i >= len()`.
    #[inline]
    #[must_use]
    pub fn get(&self, i: usize) -> Ray {
        // Written out: `map` over an array may be a call.
        let [x, y, z] = &self.org;
        let [dx, dy, dz] = &self.dir;
        let (org, dir) = ([x[i], y[i], z[i]], [dx[i], dy[i], dz[i]]);
        let mask = self.mask.get(i).copied().unwrap_or(u32::MAX);
        Ray { org, t_near: self.t_near[i], dir, t_far: self.t_far[i], mask }
    }

    /// Removes all rays and keeps the memory.
    pub fn clear(&mut self) {
        for k in 0..3 {
            self.org[k].clear();
            self.dir[k].clear();
        }
        self.t_near.clear();
        self.t_far.clear();
        self.mask.clear();
    }
}

impl Extend<Ray> for RayBatch {
    fn extend<I: IntoIterator<Item = Ray>>(&mut self, rays: I) {
        rays.into_iter().for_each(|ray| self.push(ray));
    }
}

impl FromIterator<Ray> for RayBatch {
    fn from_iter<I: IntoIterator<Item = Ray>>(rays: I) -> Self {
        let mut batch = Self::default();
        batch.extend(rays);
        batch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn push_and_get() {
        let rays = [
            Ray::new([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]),
            Ray::new([4.0, 5.0, 6.0], [1.0, 0.0, 0.0]).within(0.5, 2.0),
            Ray::new([7.0, 8.0, 9.0], [1.0, 0.0, 0.0]).with_mask(5),
        ];
        let mut batch: RayBatch = rays.into_iter().collect();
        assert_eq!(batch.len(), 3, "three rays went in");
        assert_eq!([0, 1, 2].map(|i| batch.get(i)), rays, "what goes in comes out");
        assert_eq!(batch.mask, [u32::MAX, u32::MAX, 5], "masks are kept from the first that matters");
        assert_eq!(rays[1].at(2.0), [6.0, 5.0, 6.0], "a point on the ray");
        batch.clear();
        assert!(batch.is_empty() && batch.mask.is_empty(), "nothing is left");
        batch.push(rays[0]);
        assert!(batch.mask.is_empty(), "rays that see everything need no masks");
    }
}
