// SPDX-License-Identifier: GPL-3.0-or-later
//! The primitives of a scene that may meet a region. Space: that of the scene until an instance is entered.
//! Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/overlaps.rs`.

use gnurt_accel_core::exact::Place;
use gnurt_accel_core::region::{Map, Region};

use super::types::{SceneTree, Shape};
use crate::surfaces::Seen;

impl SceneTree {
    /// Shows them; the scene is at `place`, and its first object has this slot.
    pub(crate) fn show_at(
        &self,
        region: &Region,
        mask: u32,
        first_leaf: u32,
        outer: Option<&Place>,
        visit: &mut dyn FnMut(&Seen),
    ) {
        self.top.sift(region, &mut |place| self.enter_shown(place, region, mask, first_leaf, outer, visit));
    }

    /// Into one instance.
    fn enter_shown(
        &self,
        place: usize,
        region: &Region,
        mask: u32,
        first_leaf: u32,
        outer: Option<&Place>,
        visit: &mut dyn FnMut(&Seen),
    ) {
        let Some(placed) = self.placed(place).filter(|placed| placed.mask & mask != 0) else {
            return;
        };
        let leaf = first_leaf + self.leaves.first(place);
        let Some(exact) = placed.exact(0.0) else { return };
        let here = Place { columns: &exact.columns, outer };
        let map = Map { columns: &exact.columns, rows: &exact.rows };
        let (region, place) = match placed.is_in_place() {
            true => (*region, outer),
            false => (region.inside(&map), Some(&here)),
        };
        match &placed.shape {
            Shape::Object(object) => object.show_at(&region, mask, leaf, place, visit),
            Shape::Scene(scene) => scene.show_at(&region, mask, leaf, place, visit),
        }
    }
}
