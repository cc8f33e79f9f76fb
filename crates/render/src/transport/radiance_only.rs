// SPDX-License-Identifier: GPL-3.0-or-later
//! Estimated scattering of radiance-only shaders: they are evaluated without light, and under a few
//! unoccluded lights, and count as Lambertian surfaces of the same albedo. Light models of [DWBS03]. Space:
//! world.
//! Invariant: exact for diffuse shaders; for others exact towards the light path.
//! Tests: `tests`, bindings/openrt/tests/plugins.rs.

use std::f32::consts::PI;

use glam::Vec3;
use gnurt_shading::bsdf::{ClosureBatch, Lobe};
use gnurt_shading::sampling::Basis;
use gnurt_shading::{LightBatch, RadianceShader, RayRequest, SampleKey, SurfaceBatch, Tracer, Vec3s};

/// Cosines and azimuths (in full rotations) of the lights: centres of parts of the hemisphere of equal
/// weight.
const LIGHTS: [[f32; 2]; 4] = [[0.935, 0.0], [0.79, 0.25], [0.61, 0.5], [0.35, 0.75]];

/// A renderer with only a few lights; rays see black.
struct Probe {
    lights: usize,
    /// Radiance of each, times its cosine.
    strength: f32,
}

impl Tracer for Probe {
    fn light_count(&self) -> usize {
        self.lights
    }

    fn illuminate(&mut self, light: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        out.reset(hits.len());
        let Some([cos, turns]) = LIGHTS.get(light).copied().filter(|_| light < self.lights) else { return };
        let (sin, azimuth) = ((1.0 - cos * cos).sqrt(), turns * 2.0 * PI);
        let local = Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
        for i in 0..hits.len() {
            out.dir.set(i, Basis::around(hits.facing_ns(i)).to_world(local).normalize());
            out.radiance.set(i, Vec3::splat(self.strength / cos));
        }
    }

    fn occluded(&mut self, request: &RayRequest, transmittance: &mut Vec3s) {
        transmittance.reset(request.rays.len(), Vec3::ONE);
    }

    fn trace(&mut self, _depth: u32, request: &RayRequest, radiance: &mut Vec3s) {
        radiance.reset(request.rays.len(), Vec3::ZERO);
    }

    fn random(&self, _key: SampleKey, _depth: u32, _purpose: u32) -> [f32; 2] {
        [0.5; 2]
    }
}

/// Writes the closure of each point, and returns its radiance without light; `white` is the radiance of a
/// white diffuse surface under light 1.
pub(crate) fn probe(
    shader: &dyn RadianceShader,
    points: &SurfaceBatch,
    white: f32,
    out: &mut ClosureBatch,
) -> Vec3s {
    let [mut dark, mut lit] = [(); 2].map(|()| Vec3s::splat(points.len(), Vec3::ZERO));
    shader.shade(&mut Probe { lights: 0, strength: 0.0 }, points, &mut dark);
    let strength = 1.0 / (white * LIGHTS.len() as f32);
    shader.shade(&mut Probe { lights: LIGHTS.len(), strength }, points, &mut lit);
    for i in 0..points.len() {
        let albedo = (lit.get(i) - dark.get(i)).clamp(Vec3::ZERO, Vec3::ONE);
        let albedo = if albedo.is_finite() { albedo } else { Vec3::ZERO };
        out.set(i, points.facing_ns(i), &[Lobe::lambert(albedo)]);
    }
    dark
}

#[cfg(test)]
mod tests {
    use gnurt_shading::SurfaceShader;

    use super::*;

    /// Returns an emission plus `color` times cosine-weighted light.
    struct Diffuse(Vec3);

    impl RadianceShader for Diffuse {
        fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
            let mut light = LightBatch::default();
            for i in 0..hits.len() {
                out.set(i, Vec3::new(0.0, 0.0, 2.0));
            }
            for number in 0..tracer.light_count() {
                tracer.illuminate(number, hits, &mut light);
                for i in 0..hits.len() {
                    let cos = hits.facing_ns(i).dot(light.dir.get(i)).max(0.0);
                    out.add(i, self.0 * light.radiance.get(i) * cos);
                }
            }
        }
    }

    impl SurfaceShader for Diffuse {
        fn radiance(&self) -> Option<&dyn RadianceShader> {
            Some(self)
        }
    }

    #[test]
    fn diffuse_shaders_are_understood() {
        let mut points = SurfaceBatch::default();
        points.resize(3, gnurt_shading::Detail::Full);
        for i in 0..3 {
            let normal = Vec3::new(0.3 * i as f32, 0.5, 1.0).normalize();
            points.ng.set(i, normal);
            points.ns.set(i, normal);
            points.ray_dir.set(i, if i == 1 { normal } else { -normal });
        }
        for (white, albedo) in [(1.0, 1.0), (1.0 / PI, PI)] {
            let color = Vec3::new(0.1, 0.2, 0.3);
            let mut found = ClosureBatch::default();
            found.reset(points.len());
            let dark = probe(&Diffuse(color), &points, white, &mut found);
            for i in 0..points.len() {
                let point = found.point(i);
                let visible = point.bsdf.lambertian().expect("it is Lambertian");
                assert!((visible - color * albedo).length() < 1e-5, "point {i}: {visible}");
                assert_eq!(dark.get(i), Vec3::new(0.0, 0.0, 2.0), "point {i} glows");
            }
        }
    }
}
