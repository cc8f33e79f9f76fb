// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays, one by one and in batches.
//! Source: [SSM*05]; hot fields as structure of arrays after the paper's Figure 4.
//! Space: that of the structure that is asked (world for a scene, object for an object's tree).
//! Invariant: all vectors of a batch have the same length. Proof: `tests::push_and_get`.

/// A ray `org + t * dir` for `t` in `[t_near, t_far]`.
///
/// `dir` need not be of unit length: `t` counts in multiples of it. A ray with a NaN, an infinite origin or
/// direction, a zero direction or an empty interval hits nothing. `t_far` may be infinite.
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
}

impl Ray {
    /// The ray from `org` towards `dir` over `[0, inf]`.
    #[must_use]
    pub fn new(org: [f32; 3], dir: [f32; 3]) -> Self {
        Self { org, t_near: 0.0, dir, t_far: f32::INFINITY }
    }

    /// The same ray, seen only in `[t_near, t_far]`.
    #[must_use]
    pub fn within(self, t_near: f32, t_far: f32) -> Self {
        Self { t_near, t_far, ..self }
    }

    /// The point at parameter `t`.
    #[must_use]
    pub fn at(&self, t: f32) -> [f32; 3] {
        [0, 1, 2].map(|k| self.org[k] + t * self.dir[k])
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
    }

    /// Ray `i`. Panics if `i >= len()`.
    #[must_use]
    pub fn get(&self, i: usize) -> Ray {
        Ray {
            org: [0, 1, 2].map(|k| self.org[k][i]),
            t_near: self.t_near[i],
            dir: [0, 1, 2].map(|k| self.dir[k][i]),
            t_far: self.t_far[i],
        }
    }

    /// Removes all rays and keeps the memory.
    pub fn clear(&mut self) {
        for k in 0..3 {
            self.org[k].clear();
            self.dir[k].clear();
        }
        self.t_near.clear();
        self.t_far.clear();
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
        ];
        let mut batch: RayBatch = rays.into_iter().collect();
        assert_eq!(batch.len(), 2, "two rays went in");
        assert_eq!([batch.get(0), batch.get(1)], rays, "what goes in comes out");
        assert_eq!(rays[1].at(2.0), [6.0, 5.0, 6.0], "a point on the ray");
        batch.clear();
        assert!(batch.is_empty(), "nothing is left");
    }
}
