// SPDX-License-Identifier: GPL-3.0-or-later
//! `sample`: the class of the paper's Figure 1, a parameter at each of the three rates.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | shader_color | shader | 1 1 1 | colour of all |
//! | triangle_color | triangle | 1 1 1 | colour of a triangle |
//! | vertex_color | vertex | 1 1 1 | colour at a vertex, interpolated between them |
//!
//! The surface's colour is the mean of the three, so that each of them shows for any values of the others. It
//! is lit as a `DiffuseShader`; in a scene without lights by one in the eye, `color |n·d|`, since Figure 1
//! has no light.
//! Source: the paper's Figure 1; the look is original. Tests: `tests`.

use glam::Vec3;

use super::class::{Kind, Parameter, ParameterRate, ShaderClass};
use super::lambert::{Shadows, direct_light, normals_given, shading_normals};
use super::shown::shown;
use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{AttributeRequest, RadianceShader, Tracer};

const PARAMETERS: [Parameter; 3] = [
    Parameter::floats("shader_color", &[1.0; 3]),
    Parameter::floats("triangle_color", &[1.0; 3]).at(ParameterRate::Triangle),
    Parameter::floats("vertex_color", &[1.0; 3]).at(ParameterRate::Vertex),
];

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "sample",
    kind: Kind::Surface,
    parameters: &PARAMETERS,
    make: |values| shown(Sample { shader_color: values.vec3(0) }, attributes()),
};

struct Sample {
    shader_color: Vec3,
}

fn attributes() -> Vec<AttributeRequest> {
    let [_, triangle_color, vertex_color] = PARAMETERS;
    vec![triangle_color.request(), vertex_color.request(), normals_given()]
}

impl Sample {
    fn color(&self, hits: &SurfaceBatch, i: usize) -> Vec3 {
        let value = |attribute: usize| {
            let (data, n) = (&hits.attributes[attribute], hits.len());
            Vec3::new(data[i], data[n + i], data[2 * n + i])
        };
        (self.shader_color + value(0) + value(1)) / 3.0
    }
}

impl RadianceShader for Sample {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let normals = shading_normals(hits, 2);
        let light = if tracer.light_count() == 0 {
            let eyelight = |i: usize| Vec3::splat(normals[i].dot(hits.ray_dir.get(i)).abs());
            let mut light = Vec3s::default();
            (0..hits.len()).for_each(|i| light.push(eyelight(i)));
            light
        } else {
            direct_light(tracer, hits, &normals, Shadows::Ignored)
        };
        (0..hits.len()).for_each(|i| out.set(i, self.color(hits, i) * light.get(i)));
    }
}

#[cfg(test)]
mod tests {
    use super::super::probe::{Probe, floor, shade};
    use super::super::shown::Shown;
    use super::*;

    #[test]
    fn shows_each_rate_and_needs_no_light() {
        let mut hits = floor();
        hits.ray_dir.set(0, Vec3::NEG_Y);
        hits.attributes = vec![vec![0.0, 0.9, 0.0], vec![0.0, 0.0, 0.9], vec![0.0]];
        let shader = Sample { shader_color: Vec3::new(0.9, 0.0, 0.0) };
        let shader = Shown { shader, attributes: attributes() };
        let found = shade(&shader, &mut Probe::dark(), &hits);
        assert!((found - Vec3::splat(0.3)).length() < 1e-6, "the mean, seen head-on: {found}");
        let mut lit_probe = Probe::lit(Vec3::Y, Vec3::splat(2.0));
        let found = shade(&shader, &mut lit_probe, &hits);
        assert!((found - Vec3::splat(0.6)).length() < 1e-6, "lit where there is a light: {found}");
    }
}
