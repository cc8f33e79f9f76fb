// SPDX-License-Identifier: GPL-3.0-or-later
//! The input of a wide BVH: boxes by number, some of which may be split. Source: [SFD09] for the splits.

use gnurt_accel_core::Aabb;

/// The primitives of a tree: boxes, by numbers from 0 on.
pub(crate) trait Primitives: Sync {
    /// How many there are.
    fn count(&self) -> usize;
    /// The box of one.
    fn bounds(&self, number: usize) -> Aabb;
    /// Boxes of the parts of `number` within `cell` on both sides of a plane; `None` where it has no part.
    /// The default, `None` for the whole, is for primitives that cannot be split.
    fn split(&self, _number: usize, _cell: &Aabb, _axis: usize, _at: f32) -> Option<[Option<Aabb>; 2]> {
        None
    }
}

/// Boxes of primitives that cannot be split.
impl Primitives for &[Aabb] {
    fn count(&self) -> usize {
        self.len()
    }

    fn bounds(&self, number: usize) -> Aabb {
        self[number]
    }
}
