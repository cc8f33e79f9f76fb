// SPDX-License-Identifier: GPL-3.0-or-later
//! From a point to the nearest surface of a scene.
//! Source: original. Space: world until an instance is entered. Proof: `tests/closest_point.rs`.

use gnurt_simd::{Simd, prelude::*};

use super::SceneTree;
use super::instance::Shape;
use crate::bvh::{Around, square_of};
use crate::point::{NearestPoint, Probe};

impl SceneTree {
    /// Improves `nearest`. A function of its own, since scenes may hold scenes.
    #[inline(never)]
    pub(crate) fn nearest<S: Simd>(
        &self,
        simd: S,
        probe: &Probe,
        first_leaf: u32,
        nearest: &mut NearestPoint,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                if self.placed.is_empty() {
                    return;
                }
                let top = &self.top;
                let point = [0, 1, 2].map(|k| probe.point[k] - f64::from(top.origin[k]));
                let around = Around::new(simd, &point);
                let reach = probe.reach(nearest.distance);
                top.tree.near(simd, &point, reach, |range| {
                    for block in &top.blocks[range] {
                        let squares = around.squares(simd, block).to_array();
                        for (lane, square) in squares.into_iter().enumerate() {
                            let near = square <= square_of(probe.reach(nearest.distance));
                            if near && !block.bounds(lane).is_empty() {
                                let place = block.child(lane).index();
                                self.enter_nearest(simd, place, probe, first_leaf, nearest);
                            }
                        }
                    }
                    probe.reach(nearest.distance)
                });
            },
        );
    }

    /// Into one instance.
    fn enter_nearest<S: Simd>(
        &self,
        simd: S,
        place: usize,
        probe: &Probe,
        first_leaf: u32,
        nearest: &mut NearestPoint,
    ) {
        let (placed, exact) = (&self.placed[place], &self.exact[place]);
        if placed.mask & probe.mask == 0 {
            return;
        }
        let leaf = first_leaf + placed.first_leaf;
        let [axes @ .., _] = exact.columns;
        let inside = match placed.object_from_world {
            None => *probe,
            Some(_) => probe.inside(exact.point(probe.point), &axes),
        };
        match &placed.shape {
            Shape::Object(object) => object.nearest(simd, &inside, leaf, nearest),
            Shape::Scene(scene) => scene.nearest(simd, &inside, leaf, nearest),
        }
    }
}
