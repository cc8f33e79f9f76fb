// SPDX-License-Identifier: GPL-3.0-or-later
//! Many rays, one array per component.
//! Source: [SSM*05]; fields as structure of arrays after the paper's Figure 4.
//! Space: that of the queried structure.
//! Invariant: all vectors of a batch have the same length, except for masks and times, which may be empty.
//! Tests: `tests::push_and_get`.

use crate::ray::Ray;

/// Many rays, one array per component: the contents of a tile's queue, and the input of kernels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RayBatch {
    /// Origins: x, y and z arrays, `len()` values each.
    pub org: [Vec<f32>; 3],
    /// Directions, component by component.
    pub dir: [Vec<f32>; 3],
    /// Near ends.
    pub t_near: Vec<f32>,
    /// Far ends.
    pub t_far: Vec<f32>,
    /// Masks; empty as long as all rays see everything.
    pub mask: Vec<u32>,
    /// Times; empty if all rays are of time 0.
    pub time: Vec<f32>,
}

impl RayBatch {
    /// An empty batch with memory for `n` rays.
    #[must_use]
    pub fn with_capacity(n: usize) -> Self {
        let array = || Vec::with_capacity(n);
        Self {
            org: [array(), array(), array()],
            dir: [array(), array(), array()],
            t_near: array(),
            t_far: array(),
            mask: Vec::new(),
            time: Vec::new(),
        }
    }

    /// Number of rays: that of near ends, if arrays have different lengths.
    #[must_use]
    #[inline]
    pub fn len(&self) -> usize {
        self.t_near.len()
    }

    /// Whether no ray is in.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.t_near.is_empty()
    }

    /// Checks that the public arrays have the same length.
    ///
    /// # Panics
    /// If they have not; the message names the one of another length.
    pub fn check(&self) {
        let n = self.t_near.len();
        let arrays = [
            ("org[0]", self.org[0].len()),
            ("org[1]", self.org[1].len()),
            ("org[2]", self.org[2].len()),
            ("dir[0]", self.dir[0].len()),
            ("dir[1]", self.dir[1].len()),
            ("dir[2]", self.dir[2].len()),
            ("t_far", self.t_far.len()),
        ];
        for (name, len) in arrays {
            assert!(len == n, "a batch of {n} rays (t_near) has {len} values in {name}");
        }
        let (masks, times) = (self.mask.len(), self.time.len());
        assert!(masks == 0 || masks == n, "a batch of {n} rays has {masks} masks: none, or one each");
        assert!(times == 0 || times == n, "a batch of {n} rays has {times} times: none, or one each");
    }

    /// Appends a ray.
    #[inline]
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
        if ray.time != 0.0 || !self.time.is_empty() {
            self.time.resize(self.t_near.len() - 1, 0.0);
            self.time.push(ray.time);
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
        let time = self.time.get(i).copied().unwrap_or(0.0);
        Ray { org, t_near: self.t_near[i], dir, t_far: self.t_far[i], mask, time }
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
        self.time.clear();
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
            Ray::new([7.0, 8.0, 9.0], [1.0, 0.0, 0.0]).with_mask(5).with_time(0.25),
        ];
        let mut batch: RayBatch = rays.into_iter().collect();
        assert_eq!(batch.len(), 3, "three rays went in");
        assert_eq!([0, 1, 2].map(|i| batch.get(i)), rays, "what goes in comes out");
        assert_eq!(batch.mask, [u32::MAX, u32::MAX, 5], "masks are kept from the first that matters");
        assert_eq!(batch.time, [0.0, 0.0, 0.25], "so are moments");
        assert_eq!(rays[1].at(2.0), [6.0, 5.0, 6.0], "a point on the ray");
        batch.clear();
        assert!(batch.is_empty() && batch.mask.is_empty() && batch.time.is_empty(), "nothing is left");
        batch.push(rays[0]);
        assert!(
            batch.mask.is_empty() && batch.time.is_empty(),
            "rays that see everything need no masks, those of moment 0 no moments"
        );
    }

    #[test]
    fn arrays_that_do_not_go_together_are_named() {
        let batch: RayBatch = [Ray::new([0.0; 3], [1.0; 3]); 3].into_iter().collect();
        batch.check();
        type Spoil = fn(&mut RayBatch);
        let spoiled: [(&str, Spoil); 5] = [
            ("org[1]", |batch| batch.org[1].truncate(2)),
            ("dir[2]", |batch| batch.dir[2].push(0.0)),
            ("t_far", |batch| batch.t_far.clear()),
            ("masks", |batch| batch.mask.push(1)),
            ("times", |batch| batch.time.push(1.0)),
        ];
        for (name, spoil) in spoiled {
            let mut batch = batch.clone();
            spoil(&mut batch);
            let panic = std::panic::catch_unwind(|| batch.check()).expect_err("they do not go together");
            let message = panic.downcast_ref::<String>().expect("an assertion's text");
            assert!(message.contains(name) && message.contains("3 rays"), "'{message}' names {name}");
        }
    }
}
