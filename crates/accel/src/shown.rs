// SPDX-License-Identifier: GPL-3.0-or-later
//! Primitives of a target, for queries that are decided outside of it.

use gnurt_accel_core::nearest::Nearest;
use gnurt_accel_core::region::Region;

use crate::surfaces::SurfaceInRegion;
use crate::target::Target;
use crate::{Aabb, Hit, PrimitiveId};

impl Target<'_> {
    /// Shows all primitives that may meet the region and have a bit of `mask`.
    pub(crate) fn show(self, region: &Region, mask: u32, visit: &mut dyn FnMut(&SurfaceInRegion)) {
        match self {
            Self::Object(object) => object.show_at(region, mask, 0, None, visit),
            Self::Scene(scene) => scene.show_at(region, mask, 0, None, visit),
        }
    }

    /// A box around everything.
    pub(crate) fn around(self) -> Aabb {
        match self {
            Self::Object(object) => object.bounds(),
            Self::Scene(scene) => scene.bounds(),
        }
    }

    /// Ids of a primitive.
    pub(crate) fn named(self, slot: u32, number: u32) -> PrimitiveId {
        self.hit(&Nearest { number, slot, ..Nearest::none(0.0) }).primitive()
    }

    /// The normal of a hit at a time, of any length; of spheres, if the hit point is given.
    pub(crate) fn raw_normal(self, hit: &Hit, at: Option<[f64; 3]>, time: f32) -> Option<[f64; 3]> {
        match self {
            Self::Object(object) => object.raw_normal(hit, at, time),
            Self::Scene(scene) => scene.raw_normal_at(hit, hit.leaf_id, at, time),
        }
    }
}
