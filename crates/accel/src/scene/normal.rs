// SPDX-License-Identifier: GPL-3.0-or-later
//! Normals of hits in a scene, transformed outward through all instances.
//! Space: that of the scene. Tests: `tests/surfaces/normals.rs`.

use super::types::{SceneTree, Shape};
use crate::Hit;

impl SceneTree {
    /// As that of an object, in the scene's space: by the transposed inverse of each instance's map, so that
    /// a normal stays on its side, mirrored or not.
    pub(crate) fn raw_normal_at(
        &self,
        hit: &Hit,
        leaf: u32,
        at: Option<[f64; 3]>,
        time: f32,
    ) -> Option<[f64; 3]> {
        let (index, placed) = self.located_instance(leaf)?;
        let (stands, exact) = (placed.is_identity(), placed.exact(time)?);
        let at = at.map(|at| if stands { at } else { exact.stand().point(at) });
        let inside = match &placed.shape {
            Shape::Object(object) => object.raw_normal(hit, at, time),
            Shape::Scene(scene) => scene.raw_normal_at(hit, leaf - self.leaves.first(index), at, time),
        }?;
        if stands {
            return Some(inside);
        }
        let [x, y, z] = exact.rows;
        Some([0, 1, 2].map(|k| inside[0] * x[k] + inside[1] * y[k] + inside[2] * z[k]))
    }
}
