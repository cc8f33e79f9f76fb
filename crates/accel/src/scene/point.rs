// SPDX-License-Identifier: GPL-3.0-or-later
//! From a point to the nearest surface of a scene.
//! Space: world until an instance is entered. Tests: `tests/closest_point.rs`.

use gnurt_accel_core::point::{NearestPoint, Probe};

use super::types::{SceneTree, Shape};
use crate::engine::Engine;

impl SceneTree {
    /// Improves the nearest point.
    pub(crate) fn nearest(&self, engine: &Engine, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        if self.top.count() == 0 {
            return;
        }
        let from = self.top.origin();
        let point = [0, 1, 2].map(|k| probe.point[k] - f64::from(from[k]));
        let radius = probe.radius_for(nearest.distance());
        engine.bvh.boxes_point(&self.top, &point, radius, &mut |index| {
            self.enter_nearest(engine, index, probe, slot, nearest);
            probe.radius_for(nearest.distance())
        });
    }

    /// Into one instance.
    fn enter_nearest(
        &self,
        engine: &Engine,
        index: usize,
        probe: &Probe,
        slot: u32,
        nearest: &mut dyn NearestPoint,
    ) {
        let Some(placed) = self.placed(index).filter(|placed| placed.mask & probe.mask != 0) else {
            return;
        };
        let slot = slot + self.leaves.first(index);
        let Some(exact) = placed.exact(0.0) else { return };
        let [axes @ .., _] = exact.columns;
        let inside = match placed.is_identity() {
            true => *probe,
            false => probe.inside(exact.stand().point(probe.point), &axes),
        };
        match &placed.shape {
            Shape::Object(object) => object.nearest(engine, &inside, slot, nearest),
            Shape::Scene(scene) => scene.nearest(engine, &inside, slot, nearest),
        }
    }
}
