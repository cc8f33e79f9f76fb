// SPDX-License-Identifier: GPL-3.0-or-later
//! The primitives of an object that may meet a region. Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/overlaps.rs`.

use gnurt_accel_core::exact::InstancePath;
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::Region;

use super::{Index, ObjectTree, Part};
use crate::surfaces::SurfaceInRegion;

impl ObjectTree {
    /// Shows them; the object is at `path` and has this slot.
    pub(crate) fn show_at(
        &self,
        region: &Region,
        mask: u32,
        slot: u32,
        path: Option<&InstancePath>,
        visit: &mut dyn FnMut(&SurfaceInRegion),
    ) {
        let is_met = |part: &&Part| part.mask & mask != 0 && part.times.local(0.0).is_some();
        for part in self.parts.iter().filter(is_met) {
            let region_filter = region.region_filter(part.index.bounds().greatest());
            let visit = &mut |number: u32, primitive: Primitive| {
                visit(&SurfaceInRegion { slot, number, primitive, path, region });
            };
            match &part.index {
                Index::Research(index) => index.filter_region(&region_filter, visit),
                Index::Bvh(index) => index.filter_region(&region_filter, visit),
                Index::Moving(index) => index.first().filter_region(&region_filter, visit),
                Index::MovingUser(index) => index.filter_region(&region_filter, visit),
                Index::Blocks(index) => index.filter_region(&region_filter, visit),
            }
        }
    }
}
