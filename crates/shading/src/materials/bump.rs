// SPDX-License-Identifier: GPL-3.0-or-later
//! Bump maps: heights that bend normals and leave the surface unchanged.
//! Source: \[Mik10\] (the surface's gradient of the height, from any two changes of the point), \[Bli78\] (bumps).
//! Heights are filtered over the ray's footprint, and their differences over the same width, at least a
//! texel, so that bumps fade where they are too fine to resolve.
//! Space: world. Invariant: bent normals see their ray from the front, so that no rim is black.
//! Tests: `tests`; crates/render/tests/bumps.rs.

use glam::Vec3;
use gnurt_image::srgb::luminance;

use crate::batch::SurfaceBatch;
use crate::texture::TextureSampler;

/// Heights from a texture.
#[derive(Clone, Debug)]
pub struct BumpMap {
    /// Heights, by their luminance.
    pub texture: TextureSampler,
    /// How far white lies above black, in widths of a texel.
    pub height: f32,
}

/// Least cosine of bent normals to their rays.
const LEAST_COS: f32 = 0.02;

impl BumpMap {
    /// Normals of all lanes, unit, on the side of the mesh's own.
    #[must_use]
    pub fn bent(&self, hits: &SurfaceBatch) -> crate::batch::Vec3s {
        let mut out = crate::batch::Vec3s::with_capacity(hits.len());
        (0..hits.len()).for_each(|i| out.push(self.normal(hits, i)));
        out
    }

    fn normal(&self, hits: &SurfaceBatch, i: usize) -> Vec3 {
        let ns = hits.ns.get(i);
        let bent = self.bent_at(hits, i).unwrap_or(ns);
        // Towards the ray until it is seen.
        let side = if hits.facing_ns(i) == ns { 1.0 } else { -1.0 };
        let (facing, wo) = (bent * side, -hits.ray_dir.get(i));
        let cos = facing.dot(wo);
        if cos >= LEAST_COS {
            return bent;
        }
        (facing + wo * (LEAST_COS - cos)).try_normalize().map_or(ns, |facing_normal| facing_normal * side)
    }

    /// `None` if texture coordinates or heights are constant.
    fn bent_at(&self, hits: &SurfaceBatch, i: usize) -> Option<Vec3> {
        if hits.dp_du.is_empty() {
            return None;
        }
        let (ns, dp_du, dp_dv) = (hits.ns.get(i), hits.dp_du.get(i), hits.dp_dv.get(i));
        let (across_u, across_v) = (dp_dv.cross(ns), ns.cross(dp_du));
        let area = dp_du.dot(across_u);
        let [a, b, c, d, ..] = self.texture.uv_from_mesh;
        let [width, height] = [self.texture.texels.width, self.texture.texels.height].map(|n| n as f32);
        // Texels that the mesh's coordinates cross from 0 to 1, along each and as an area.
        let texels = [(a * width).hypot(b * height), (c * width).hypot(d * height)];
        let all = (a * d - b * c).abs() * width * height;
        if !(area.abs() > 0.0 && all > 0.0 && texels[0] > 0.0 && texels[1] > 0.0) {
            return None;
        }
        let axes = hits.texture_axes(i);
        let [[ux, vx], [uy, vy]] = axes;
        let stands_for = (ux * vy - uy * vx).abs().sqrt();
        let [u, v] = hits.uv(i);
        let at = |u: f32, v: f32| {
            let [r, g, b, _] = self.texture.sample_over([u, v], axes);
            luminance([r, g, b])
        };
        let [du, dv] = texels.map(|n| (1.0 / n).max(stands_for));
        let by_u = (at(u + 0.5 * du, v) - at(u - 0.5 * du, v)) / du;
        let by_v = (at(u, v + 0.5 * dv) - at(u, v - 0.5 * dv)) / dv;
        if by_u == 0.0 && by_v == 0.0 {
            return None;
        }
        let texel = (area.abs() / all).sqrt();
        let gradient = (across_u * by_u + across_v * by_v) * (self.height * texel * area.signum());
        (ns * area.abs() - gradient).try_normalize()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use gnurt_image::{TexelData, Texels};

    use super::*;
    use crate::batch::Vec3s;

    /// A point of the plane z = 0 at coordinates `uv`, whose u runs along `dp_du`, seen along `ray`.
    fn point(uv: [f32; 2], dp_du: Vec3, dp_dv: Vec3, ray: Vec3) -> SurfaceBatch {
        let one = |v: Vec3| Vec3s::splat(1, v);
        let up = one(Vec3::Z);
        SurfaceBatch {
            t: vec![1.0],
            texcoord: uv.map(|x| vec![x]),
            ng: up.clone(),
            ns: up,
            ray_dir: one(ray.normalize()),
            dp_du: one(dp_du),
            dp_dv: one(dp_dv),
            ..SurfaceBatch::default()
        }
    }

    /// Grows by 0.1 from column to column.
    fn ramp() -> TextureSampler {
        let data = TexelData::Float((0..64).map(|i| [(i % 8) as f32 * 0.1; 4]).collect());
        TextureSampler::new(Arc::new(Texels { width: 8, height: 8, data }))
    }

    #[test]
    fn normals_lean_down_the_slope() {
        let map = BumpMap { texture: ramp(), height: 5.0 };
        let down = -Vec3::Z;
        // Texels are half a unit wide: 0.1 times 5 of them up for each.
        let slope = |dp_du, dp_dv, ray| map.normal(&point([0.45, 0.5], dp_du, dp_dv, ray), 0);
        let expected = Vec3::new(-0.5, 0.0, 1.0).normalize();
        let found = slope(Vec3::X * 4.0, Vec3::Y * 4.0, down);
        assert!(found.distance(expected) < 1e-4, "a ramp of one half: {found}");
        let mirrored = slope(Vec3::X * -4.0, Vec3::Y * 4.0, down);
        assert!(mirrored.distance(expected * Vec3::new(-1.0, 1.0, 1.0)) < 1e-4, "mirrored: {mirrored}");
        // Twice as long along u: half as steep in texels that are longer.
        let stretched = slope(Vec3::X * 8.0, Vec3::Y * 2.0, down);
        let expected = Vec3::new(-0.25, 0.0, 1.0).normalize();
        assert!(stretched.distance(expected) < 1e-4, "stretched: {stretched}");
        let grazing = slope(Vec3::X * 4.0, Vec3::Y * 4.0, Vec3::new(-1.0, 0.0, -0.1));
        assert!(grazing.dot(Vec3::new(1.0, 0.0, 0.1).normalize()) > 0.0, "seen from behind: {grazing}");
        let below = slope(Vec3::X * 4.0, Vec3::Y * 4.0, Vec3::Z);
        assert!(below.z > 0.0, "on the mesh's side, from whichever side it is seen: {below}");
        let flat = slope(Vec3::ZERO, Vec3::ZERO, down);
        assert_eq!(flat, Vec3::Z, "no coordinates");
    }
}
