// SPDX-License-Identifier: GPL-3.0-or-later
//! The primitives of a scene that may meet a region. Space: that of the scene until an instance is entered.
//! Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/overlaps.rs`.

use gnurt_accel_core::exact::InstancePath;
use gnurt_accel_core::region::{Map, Region};

use super::types::{SceneTree, Shape};
use crate::surfaces::SurfaceInRegion;

impl SceneTree {
    /// Shows them; the scene is at `index`, and its first object has this slot.
    pub(crate) fn show_at(
        &self,
        region: &Region,
        mask: u32,
        first_leaf: u32,
        outer: Option<&InstancePath>,
        visit: &mut dyn FnMut(&SurfaceInRegion),
    ) {
        self.top.filter_region(region, &mut |index| {
            self.enter_shown(index, region, mask, first_leaf, outer, visit)
        });
    }

    /// Into one instance.
    fn enter_shown(
        &self,
        index: usize,
        region: &Region,
        mask: u32,
        first_leaf: u32,
        outer: Option<&InstancePath>,
        visit: &mut dyn FnMut(&SurfaceInRegion),
    ) {
        let Some(placed) = self.placed(index).filter(|placed| placed.mask & mask != 0) else {
            return;
        };
        let leaf = first_leaf + self.leaves.first(index);
        let Some(exact) = placed.exact(0.0) else { return };
        let here = InstancePath { columns: &exact.columns, outer };
        let map = Map { columns: &exact.columns, rows: &exact.rows };
        let (region, index) = match placed.is_identity() {
            true => (*region, outer),
            false => (region.inside(&map), Some(&here)),
        };
        match &placed.shape {
            Shape::Object(object) => object.show_at(&region, mask, leaf, index, visit),
            Shape::Scene(scene) => scene.show_at(&region, mask, leaf, index, visit),
        }
    }
}
