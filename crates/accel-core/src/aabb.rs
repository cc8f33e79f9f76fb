// SPDX-License-Identifier: GPL-3.0-or-later
//! Axis-aligned boxes.
//! Space: that of the caller's points.
//! Invariant: `min[k] <= max[k]`, or the box is [`Aabb::EMPTY`]. Tests: `tests::boxes_grow_and_measure`.

/// The points `p` with `min[k] <= p[k] <= max[k]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least coordinates.
    pub min: [f32; 3],
    /// Greatest coordinates.
    pub max: [f32; 3],
}

impl Aabb {
    /// The empty box, the start of growing.
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The smallest box around some points.
    #[must_use]
    #[inline]
    pub fn around(points: &[[f32; 3]]) -> Self {
        points.iter().fold(Self::EMPTY, |all, &p| all.union(&Self { min: p, max: p }))
    }

    /// Whether no point is in.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        (0..3).any(|k| self.min[k] > self.max[k])
    }

    /// The smallest box around both.
    #[must_use]
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: [0, 1, 2].map(|k| self.min[k].min(other.min[k])),
            max: [0, 1, 2].map(|k| self.max[k].max(other.max[k])),
        }
    }

    /// Lengths of the sides; zero for an empty box.
    #[must_use]
    #[inline]
    pub fn extent(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| (f64::from(self.max[k]) - f64::from(self.min[k])).max(0.0))
    }

    /// Half of the surface, in double precision: huge boxes overflow a float.
    #[must_use]
    #[inline]
    pub fn half_area(&self) -> f64 {
        let [x, y, z] = self.extent();
        x * y + y * z + z * x
    }

    /// How far a point is from it; 0 inside.
    #[must_use]
    pub fn distance(&self, point: &[f64; 3]) -> f64 {
        let outside =
            |k: usize| (f64::from(self.min[k]) - point[k]).max(point[k] - f64::from(self.max[k])).max(0.0);
        let [x, y, z] = [outside(0), outside(1), outside(2)];
        (x * x + y * y + z * z).sqrt()
    }

    /// The two parts on either side of the plane `p[axis] == at`.
    #[must_use]
    #[inline]
    pub fn split(&self, axis: usize, at: f32) -> [Self; 2] {
        let (mut left, mut right) = (*self, *self);
        left.max[axis] = at;
        right.min[axis] = at;
        [left, right]
    }

    /// Greatest absolute coordinate; 0 for an empty box.
    #[inline]
    pub fn greatest(&self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        self.min.iter().chain(&self.max).fold(0.0, |most, x| most.max(x.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_grow_and_measure() {
        let unit = Aabb::around(&[[0.0, 1.0, 0.0], [1.0, 0.0, 2.0]]);
        assert_eq!(unit.half_area(), 5.0, "1 x 1 x 2 has 1 + 2 + 2");
        assert!(Aabb::EMPTY.is_empty() && !unit.is_empty(), "only the empty box is empty");
        assert_eq!(Aabb::EMPTY.half_area(), 0.0, "nothing has no surface");
        assert_eq!(Aabb::EMPTY.union(&unit), unit, "growing starts from the empty box");
        let [left, right] = unit.split(2, 0.5);
        assert_eq!((left.max[2], right.min[2]), (0.5, 0.5), "the parts meet at the plane");
        assert_eq!(unit.greatest(), 2.0, "the greatest coordinate");
    }
}
