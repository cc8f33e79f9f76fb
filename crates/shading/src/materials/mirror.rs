// SPDX-License-Identifier: GPL-3.0-or-later
//! Perfect mirrors, on both sides.
//! Source: [Whi80]. Proof: `tests::reflections_stay_above`, crates/render/tests/mirrors.rs.

use glam::Vec3;

use crate::batch::{SurfaceBatch, Vec3s};
use crate::materials::color::TexturedColor;
use crate::shader::{RayRequest, SurfaceShader, Tracer};

/// A perfect mirror.
#[derive(Clone, Debug)]
pub struct Mirror {
    /// Share of light that is mirrored.
    pub reflectance: TexturedColor,
}

/// Numbers of the branches that leave a hit.
pub(crate) mod branch {
    pub(crate) const REFLECTED: u32 = 0;
    pub(crate) const REFRACTED: u32 = 1;
    pub(crate) const STRAIGHT: u32 = 2;
}

impl SurfaceShader for Mirror {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let (mut request, mut seen) = (RayRequest::default(), Vec3s::default());
        let weight: Vec<_> = (0..hits.len()).map(|i| self.reflectance.at_hit(hits, i)).collect();
        for i in (0..hits.len()).filter(|&i| weight[i] != Vec3::ZERO) {
            let dir = reflect_above(hits.ray_dir.get(i), hits.facing_ns(i), hits.facing_ng(i));
            request.rays.push(hits.spawn(i, dir, f32::INFINITY));
            request.parent.push(i as u32);
            request.key.push(hits.key[i].fork(branch::REFLECTED));
        }
        tracer.trace(hits.depth, &request, &mut seen);
        for (k, &parent) in request.parent.iter().enumerate() {
            out.add(parent as usize, weight[parent as usize] * seen.get(k));
        }
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, self.reflectance.at_hit(hits, i)));
    }
}

/// `dir` mirrored at the shading normal `ns`; at the geometric one `ng` if that would lead into the surface.
/// All unit, both normals facing the ray.
pub(crate) fn reflect_above(dir: Vec3, ns: Vec3, ng: Vec3) -> Vec3 {
    let mirrored = dir.reflect(ns);
    let above = if mirrored.dot(ng) > 0.0 { mirrored } else { dir.reflect(ng) };
    above.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflections_stay_above() {
        let down = Vec3::new(0.6, 0.0, -0.8);
        assert!(
            (reflect_above(down, Vec3::Z, Vec3::Z) - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6,
            "in = out"
        );
        let grazing = Vec3::new(0.995, 0.0, -0.1).normalize();
        let tilted = Vec3::new(0.5, 0.0, 1.0).normalize();
        assert!(reflect_above(grazing, tilted, Vec3::Z).z > 0.0, "never into the surface");
    }
}
