// SPDX-License-Identifier: GPL-3.0-or-later
//! Which geometries of an object share a tree: those of one kind, one mask and one range of times.

use gnurt_accel_bvh::BlockSort;
use gnurt_accel_core::geometry::GeometryKind;

use crate::Geometry;

/// The kinds of trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Surfaces,
    /// Moving meshes, with this many keys.
    Moving(u32),
    /// User geometry with this many keys.
    MovingUser(u32),
    /// All that is not a triangle.
    Blocks(BlockSort),
}

/// A kind, a mask, and the times of keys.
pub(super) type Group = (Kind, u32, Times);

/// From the first key to the last; those of most geometries, and of all that stand still, are from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times([f32; 2]);

impl PartialEq for Times {
    fn eq(&self, other: &Self) -> bool {
        self.0.map(f32::to_bits) == other.0.map(f32::to_bits)
    }
}

impl Eq for Times {}

impl Times {
    pub(super) const SHUTTER: Self = Self([0.0, 1.0]);

    /// Whether they are other ones.
    #[inline(always)]
    pub(super) fn differ(&self) -> bool {
        *self != Self::SHUTTER
    }

    /// How far a time is from the first key to the last; `None` before and after them.
    pub(super) fn local(&self, time: f32) -> Option<f32> {
        let [from, to] = self.0;
        if *self == Self::SHUTTER {
            return Some(time);
        }
        let share = if to > from { (time - from) / (to - from) } else { 0.0 };
        (time >= from && time <= to).then_some(share)
    }
}

/// The group of a geometry.
pub(super) fn group_of(geometry: &Geometry) -> Group {
    let keys = geometry.keys();
    let kind = match (&geometry.kind, BlockSort::of(&geometry.kind)) {
        (GeometryKind::Moving(_) | GeometryKind::MovingQuads(_), _) => Kind::Moving(keys),
        (GeometryKind::User(_), _) if keys > 1 => Kind::MovingUser(keys),
        (_, Some(sort)) => Kind::Blocks(sort),
        (_, None) => Kind::Surfaces,
    };
    let moves = matches!(kind, Kind::Moving(_) | Kind::MovingUser(_)) && keys > 1;
    (kind, geometry.mask, if moves { Times(geometry.times) } else { Times::SHUTTER })
}
