// SPDX-License-Identifier: GPL-3.0-or-later
//! `MirrorShader`: a perfect mirror.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | attenuation | shader | 1 | share of light that is reflected |
//!
//! Source: [Whi80]; name and parameter as OpenRT programs know them. Tests: `tests::reflects`.

use glam::Vec3;

use super::class::{Kind, Parameter, ShaderClass};
use super::lambert::{normals_given, shading_normals};
use super::shown::shown;
use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{RadianceShader, RayRequest, Tracer};

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "MirrorShader",
    kind: Kind::Surface,
    parameters: &[Parameter::floats("attenuation", &[1.0])],
    make: |values| shown(Mirror { attenuation: values.float(0) }, vec![normals_given()]),
};

struct Mirror {
    attenuation: f32,
}

impl RadianceShader for Mirror {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let mut request = RayRequest::default();
        for (i, normal) in shading_normals(hits, 0).into_iter().enumerate() {
            let dir = reflection(hits, i, normal);
            request.push(hits.spawn(i, dir, f32::INFINITY), i, hits.key[i].fork(0));
            request.width.push(hits.footprint.get(i).copied().unwrap_or(0.0));
        }
        tracer.trace(hits.depth, &request, out);
        (0..hits.len()).for_each(|i| out.set(i, self.attenuation * out.get(i)));
    }
}

/// Direction of the mirrored ray of lane `i`. Where an interpolated normal would send it through the surface,
/// the geometric one is used.
pub(super) fn reflection(hits: &SurfaceBatch, i: usize, normal: Vec3) -> Vec3 {
    let (ray, facing) = (hits.ray_dir.get(i), hits.facing_ng(i));
    let mirrored = ray.reflect(normal);
    let outside = mirrored.dot(facing) > 0.0;
    if outside { mirrored.normalize_or(facing) } else { ray.reflect(facing).normalize_or(facing) }
}

#[cfg(test)]
mod tests {
    use super::super::probe::{Probe, floor, shade};
    use super::super::shown::Shown;
    use super::*;

    #[test]
    fn reflects() {
        let mut hits = floor();
        hits.ray_dir.set(0, Vec3::new(0.6, -0.8, 0.0));
        let mut probe = Probe::dark();
        probe.found = Vec3::new(1.0, 2.0, 4.0);
        let shader = Shown { shader: Mirror { attenuation: 0.5 }, attributes: vec![normals_given()] };
        assert_eq!(shade(&shader, &mut probe, &hits), Vec3::new(0.5, 1.0, 2.0), "half of what the ray sees");
        let [ray] = probe.traced[..] else { panic!("one ray per point: {:?}", probe.traced) };
        let off = Vec3::from(ray.dir) - Vec3::new(0.6, 0.8, 0.0);
        assert!(off.length() < 1e-6, "angle in = angle out: {:?}", ray.dir);
    }
}
