// SPDX-License-Identifier: GPL-3.0-or-later
//! `DiffuseShader`: a Lambertian surface without shadows.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | color | shader | 1 1 1 | share of light that is reflected |
//!
//! Shows the sum over lights of `E color max(0, n·l)`.
//! Source: name and parameter as OpenRT programs know them. Tests: `tests`.

use glam::Vec3;

use super::class::{Kind, Parameter, ShaderClass};
use super::lambert::{Shadows, direct_light, normals_given, shading_normals};
use super::shown::shown;
use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{RadianceShader, Tracer};

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "DiffuseShader",
    kind: Kind::Surface,
    parameters: &[Parameter::floats("color", &[1.0; 3])],
    make: |values| shown(Diffuse { color: values.vec3(0) }, vec![normals_given()]),
};

struct Diffuse {
    color: Vec3,
}

impl RadianceShader for Diffuse {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let normals = shading_normals(hits, 0);
        let light = direct_light(tracer, hits, &normals, Shadows::Ignored);
        (0..hits.len()).for_each(|i| out.set(i, self.color * light.get(i)));
    }
}

#[cfg(test)]
mod tests {
    use super::super::probe::{Probe, floor, shade};
    use super::super::shown::Shown;
    use super::*;

    fn diffuse() -> Shown<Diffuse> {
        Shown { shader: Diffuse { color: Vec3::new(0.5, 1.0, 0.0) }, attributes: vec![normals_given()] }
    }

    #[test]
    fn follows_the_cosine_and_ignores_shadows() {
        let mut probe = Probe::lit(Vec3::new(0.0, 3.0, 4.0).normalize(), Vec3::splat(2.0));
        probe.transmittance = Vec3::ZERO;
        let found = shade(&diffuse(), &mut probe, &floor());
        assert!((found - Vec3::new(0.6, 1.2, 0.0)).length() < 1e-6, "2 * cos 53 degrees: {found}");
    }

    #[test]
    fn given_normals_are_not_turned() {
        let mut probe = Probe::lit(Vec3::Y, Vec3::ONE);
        let mut hits = floor();
        hits.ng.set(0, Vec3::NEG_Y);
        hits.ns.set(0, Vec3::NEG_Y);
        assert_eq!(shade(&diffuse(), &mut probe, &hits).y, 1.0, "a geometric normal turns to the ray");
        hits.attributes = vec![vec![1.0]];
        assert_eq!(shade(&diffuse(), &mut probe, &hits), Vec3::ZERO, "a given one stays");
    }
}
