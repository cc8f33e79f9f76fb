// SPDX-License-Identifier: GPL-3.0-or-later
//! Normals from a texture, along the directions in which its coordinates grow.
//! Source: glTF 2.0 section 3.9.3; \[Tok05\] (slopes that are lost in the mean of normals). Space: world.
//! Tests: crates/render/tests/appearance.rs.

use glam::Vec3;

use crate::batch::SurfaceBatch;
use crate::sampling::Basis;
use crate::texture::TextureSampler;

/// Where a texture's own coordinates grow, from where the mesh's do: its transform undone. `None` if they are
/// constant.
pub(super) fn axes(texture: &TextureSampler, dp_du: Vec3, dp_dv: Vec3) -> Option<[Vec3; 2]> {
    let [a, b, c, d, ..] = texture.uv_from_mesh;
    let side = (a * d - b * c).signum();
    let (u, v) = ((dp_du * d - dp_dv * b) * side, (dp_dv * a - dp_du * c) * side);
    (u != Vec3::ZERO && a * d != b * c).then_some([u, v])
}

/// Normals from a texture.
#[derive(Clone, Debug)]
pub struct NormalMap {
    /// `2 texel - 1` along the texture's own u, v and the surface's normal.
    pub texture: TextureSampler,
    /// Multiplied to u and v.
    pub scale: f32,
}

impl NormalMap {
    /// The shading normal of a lane, unit, on the side of the mesh's own normal; and the mean square of the
    /// slopes that the map has around it within the footprint, from the length of the mean normal \[Tok05\].
    pub(super) fn at_hit(&self, hits: &SurfaceBatch, i: usize) -> (Vec3, f32) {
        let ns = hits.scattering_ns(i);
        let [x, y, z, _] = self.texture.at_hit(hits, i);
        let length = Vec3::new(2.0 * x - 1.0, 2.0 * y - 1.0, 2.0 * z - 1.0).length();
        let lost = (1.0 - ROUNDED - length).max(0.0) / length.max(1e-3);
        let slopes = if lost.is_finite() { lost * self.scale * self.scale } else { 0.0 };
        (self.bent(hits, i, [x, y, z]).unwrap_or(ns), slopes)
    }

    /// The normal of a texel, if it is valid.
    fn bent(&self, hits: &SurfaceBatch, i: usize, [x, y, z]: [f32; 3]) -> Option<Vec3> {
        let ns = hits.scattering_ns(i);
        let local = Vec3::new((2.0 * x - 1.0) * self.scale, (2.0 * y - 1.0) * self.scale, 2.0 * z - 1.0);
        let [tangent, bitangent] = axes(&self.texture, hits.dp_du.get(i), hits.dp_dv.get(i))?;
        let mut frame = Basis::along(ns, tangent);
        // Mirrored coordinates, and mirrored instances, make it left-handed.
        if frame.bitangent.dot(bitangent) < 0.0 {
            frame.bitangent = -frame.bitangent;
        }
        let bent = frame.to_world(local);
        bent.try_normalize().filter(|bent| bent.dot(ns) > 0.0)
    }
}

/// Possible rounding loss of a unit normal of three bytes.
const ROUNDED: f32 = 0.004;
