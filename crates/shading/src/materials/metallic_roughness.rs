// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF's metal and plastic: a diffuse body under a rough coat, or a rough metal, or a mix.
//! Source: glTF 2.0 appendix B.3 (mix of dielectric and metal, Schlick's Fresnel); facets as in `ggx.rs`.
//! Light is counted once: a lane is *smooth* if its roughness is below [`SMOOTH`]. Smooth lanes follow one mirrored ray,
//! drawn from the facets, and their coat ignores light samples of lights that such a ray can meet; rough lanes send no
//! ray and weigh all light samples with coat and body. Lights without extent reach the coat by samples either way.
//! What rough coats would mirror of other surfaces is left out: that is light scattered twice.
//! Proof: `tests::energy_is_not_made`, crates/render/tests/appearance.rs.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::materials::color::TexturedColor;
use crate::materials::direct::direct_light;
use crate::materials::ggx::Ggx;
use crate::materials::mirror::branch;
use crate::sampling::{Basis, purpose};
use crate::shader::{RayRequest, SurfaceShader, Tracer};
use crate::texture::TextureSampler;

/// Perceptual roughness below which reflections are traced. Just above 0.5, which many glTF files have: there, at grazing
/// views, rays drawn from the facets leave a tenth to a quarter of the error that light samples leave.
pub const SMOOTH: f32 = 0.55;

/// glTF's metal and plastic.
#[derive(Clone, Debug)]
pub struct MetallicRoughness {
    /// Albedo of the body, normal reflectance of the metal.
    pub base_color: TexturedColor,
    /// 0 = plastic, 1 = metal.
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Green times roughness, blue times metallic.
    pub metallic_roughness_texture: Option<TextureSampler>,
    /// Index of refraction of the coat.
    pub ior: f32,
    /// Normals.
    pub normal_map: Option<NormalMap>,
}

/// Normals from a texture.
#[derive(Clone, Debug)]
pub struct NormalMap {
    /// `2 texel - 1` along the texture's u, v and the surface's normal.
    pub texture: TextureSampler,
    /// Multiplied to u and v.
    pub scale: f32,
}

impl NormalMap {
    /// The shading normal of a lane, unit, on the side of the mesh's own.
    fn at_hit(&self, hits: &SurfaceBatch, i: usize) -> Vec3 {
        let ns = hits.ns.get(i);
        let [x, y, z, _] = self.texture.sample([hits.texcoord[0][i], hits.texcoord[1][i]]);
        let local = Vec3::new((2.0 * x - 1.0) * self.scale, (2.0 * y - 1.0) * self.scale, 2.0 * z - 1.0);
        let dp_du = hits.dp_du.get(i);
        if dp_du == Vec3::ZERO {
            return ns;
        }
        let bent = Basis::along(ns, dp_du).to_world(local);
        bent.try_normalize().filter(|bent| bent.dot(ns) > 0.0).unwrap_or(ns)
    }
}

/// All that light needs to know of one lane.
struct Point {
    basis: Basis,
    /// Towards the viewer, in the basis; z > 0.
    wo: Vec3,
    base: Vec3,
    metallic: f32,
    ggx: Ggx,
    smooth: bool,
    /// Normal reflectance of the coat.
    f0: f32,
}

impl Point {
    /// Fresnel's share of what the facet mirrors, mixed of coat and metal; and the coat's share alone.
    fn fresnel(&self, cos: f32) -> (Vec3, f32) {
        let rise = (1.0 - cos.clamp(0.0, 1.0)).powi(5);
        let coat = self.f0 + (1.0 - self.f0) * rise;
        let metal = self.base + (Vec3::ONE - self.base) * rise;
        (Vec3::splat(coat * (1.0 - self.metallic)) + metal * self.metallic, coat)
    }

    /// BSDF times cosine for light from the world direction `dir`.
    fn bsdf_cos(&self, dir: Vec3, with_coat: bool) -> Vec3 {
        let wi = self.basis.to_local(dir);
        if wi.z <= 0.0 {
            return Vec3::ZERO;
        }
        let h = (self.wo + wi).normalize();
        let (mirrored, coat) = self.fresnel(self.wo.dot(h));
        let body = self.base * ((1.0 - self.metallic) * (1.0 - coat) * FRAC_1_PI * wi.z);
        if with_coat { body + mirrored * self.ggx.lobe_cos(self.wo, wi, h) } else { body }
    }
}

impl MetallicRoughness {
    fn point(&self, hits: &SurfaceBatch, i: usize) -> Point {
        let texel = self
            .metallic_roughness_texture
            .as_ref()
            .map_or([1.0; 4], |texture| texture.sample([hits.texcoord[0][i], hits.texcoord[1][i]]));
        let roughness = (self.roughness * texel[1]).clamp(0.0, 1.0);
        let basis = Basis::around(self.normal(hits, i));
        let wo = {
            let wo = basis.to_local(-hits.ray_dir.get(i));
            // Interpolated normals may turn away from the viewer at silhouettes.
            Vec3::new(wo.x, wo.y, wo.z.max(1e-3)).normalize()
        };
        let f0 = ((self.ior - 1.0) / (self.ior + 1.0)).powi(2);
        Point {
            basis,
            wo,
            base: self.base_color.at_hit(hits, i),
            metallic: (self.metallic * texel[2]).clamp(0.0, 1.0),
            ggx: Ggx::new(roughness),
            smooth: roughness < SMOOTH,
            f0: if f0.is_finite() { f0 } else { 1.0 },
        }
    }

    /// Shading normal on the side that the ray came from.
    fn normal(&self, hits: &SurfaceBatch, i: usize) -> Vec3 {
        let ns = self.normal_map.as_ref().map_or_else(|| hits.ns.get(i), |map| map.at_hit(hits, i));
        if ns.dot(hits.facing_ng(i)) < 0.0 { -ns } else { ns }
    }

    fn add_reflections(
        &self,
        tracer: &mut dyn Tracer,
        hits: &SurfaceBatch,
        points: &[Point],
        out: &mut Vec3s,
    ) {
        let (mut request, mut weights) = (RayRequest::default(), Vec::new());
        for (i, point) in points.iter().enumerate().filter(|(_, point)| point.smooth) {
            let u = tracer.random(hits.key[i], hits.depth, purpose::DIRECTION);
            let h = point.ggx.sample_visible(point.wo, u);
            let wi = (-point.wo).reflect(h);
            let dir = point.basis.to_world(wi).normalize();
            let weight = point.fresnel(point.wo.dot(h)).0 * point.ggx.sample_weight(point.wo, wi);
            if hits.facing_ng(i).dot(dir) > 0.0 && weight != Vec3::ZERO {
                request.rays.push(hits.spawn(i, dir, f32::INFINITY));
                request.parent.push(i as u32);
                request.key.push(hits.key[i].fork(branch::REFLECTED));
                weights.push(weight);
            }
        }
        if weights.is_empty() {
            return;
        }
        let mut seen = Vec3s::default();
        tracer.trace(hits.depth, &request, &mut seen);
        for (k, (&parent, &weight)) in request.parent.iter().zip(&weights).enumerate() {
            out.add(parent as usize, weight * seen.get(k));
        }
    }
}

impl SurfaceShader for MetallicRoughness {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let points: Vec<_> = (0..hits.len()).map(|i| self.point(hits, i)).collect();
        let bsdf_cos = |i: usize, dir: Vec3, light_is_visible: bool| {
            let point: &Point = &points[i];
            point.bsdf_cos(dir, !(point.smooth && light_is_visible))
        };
        direct_light(tracer, hits, &bsdf_cos, out);
        self.add_reflections(tracer, hits, &points, out);
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.base_color.at_hit(hits, i)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(metallic: f32, roughness: f32, angle: f32) -> Point {
        Point {
            basis: Basis::around(Vec3::Z),
            wo: Vec3::new(angle.sin(), 0.0, angle.cos()),
            base: Vec3::ONE,
            metallic,
            ggx: Ggx::new(roughness),
            smooth: false,
            f0: 0.04,
        }
    }

    #[test]
    fn energy_is_not_made() {
        for (metallic, roughness) in [(0.0, 0.3), (0.0, 1.0), (1.0, 0.3), (1.0, 1.0), (0.5, 0.6)] {
            for step in 0..5 {
                let point =
                    point(metallic, roughness, std::f32::consts::FRAC_PI_2 * (0.05 + 0.18 * step as f32));
                let (rings, sectors) = (400, 200);
                let mut sum = 0.0;
                for (ring, sector) in (0..rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
                    let z = (ring as f32 + 0.5) / rings as f32;
                    let azimuth = std::f32::consts::TAU * (sector as f32 + 0.5) / sectors as f32;
                    let radius = (1.0 - z * z).sqrt();
                    let dir = Vec3::new(radius * azimuth.cos(), radius * azimuth.sin(), z);
                    sum += point.bsdf_cos(dir, true).x;
                }
                let albedo = sum * std::f32::consts::TAU / (rings * sectors) as f32;
                // glTF takes Fresnel's share at the half vector for the body too: white plastic gains at grazing views.
                assert!(
                    albedo < if metallic < 1.0 { 1.1 } else { 1.0 },
                    "metallic {metallic}, roughness {roughness}: albedo {albedo}"
                );
                // Light that leaves a facet once: at roughness 1, seen from above, 1 - ln 2 of it comes back.
                assert!(albedo > 0.3, "and no more is lost than by one bounce alone: {albedo}");
            }
        }
    }
}
