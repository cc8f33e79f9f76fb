// SPDX-License-Identifier: GPL-3.0-or-later
//! Areas of an object's meshes where it is put: for shaders that share a lamp's power out over its surface.
//! Areas are summed once for each mesh and each stretch by a transform: rotation and translation change
//! nothing. Space: that of the transform. Tests: crates/render/tests/appearance.rs.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use glam::{Mat3, Vec3};
use gnurt_scene::Mesh;

/// The largest number of cached sums; others are computed again.
const MOST: usize = 4096;

/// A mesh, and the squares of a transform's stretch.
type Key = (u32, [u32; 6]);

/// Cached areas of an object. Clones start empty, because they may have other meshes.
#[derive(Default)]
pub(crate) struct Areas {
    known: Mutex<HashMap<Key, f32>>,
}

impl Clone for Areas {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Areas {
    /// The area of mesh `geom_id` of `meshes`, transformed by this.
    pub(crate) fn of(&self, meshes: &[Arc<Mesh>], geom_id: u32, linear: &Mat3) -> f32 {
        let Some(mesh) = meshes.get(geom_id as usize) else { return 0.0 };
        let Mat3 { x_axis: x, y_axis: y, z_axis: z } = *linear;
        // Transforms that only rotate the mesh differ in the last bits.
        let squares = [x.dot(x), y.dot(y), z.dot(z), x.dot(y), y.dot(z), z.dot(x)];
        let scale = squares[0].max(squares[1]).max(squares[2]);
        let key = squares.map(|s| {
            let rounded = (s / scale * 65536.0).round();
            (if rounded == 0.0 { 0.0 } else { rounded }).to_bits()
        });
        let key = (geom_id, key);
        let known = self.known.lock().ok().and_then(|known| known.get(&key).copied());
        let unit = known.unwrap_or_else(|| {
            let area = sum(mesh, linear) / scale;
            if let Ok(mut known) = self.known.lock()
                && known.len() < MOST
            {
                known.insert(key, area);
            }
            area
        });
        unit * scale
    }
}

fn sum(mesh: &Mesh, linear: &Mat3) -> f32 {
    let area = |&[a, b, c]: &[u32; 3]| {
        let at = |i: u32| mesh.positions.get(i as usize).copied().map_or(Vec3::ZERO, Vec3::from);
        let (p, q, r) = (at(a), at(b), at(c));
        let doubled = f64::from((*linear * (q - p)).cross(*linear * (r - p)).length());
        // A degenerate triangle has no area.
        if doubled.is_finite() { 0.5 * doubled } else { 0.0 }
    };
    mesh.indices.iter().map(area).sum::<f64>() as f32
}
