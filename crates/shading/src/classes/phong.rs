// SPDX-License-Identifier: GPL-3.0-or-later
//! `Phong`: the surface of VRML and X3D, with mirrors and see-through, under the parameter names of RTfact.
//!
//! | parameter | type, default | meaning |
//! |---|---|---|
//! | diffuseColor | 0.8 0.8 0.8 | share of light that is scattered |
//! | specularColor | 0 0 0 | share of light in the highlights |
//! | emissiveColor | 0 0 0 | emitted radiance |
//! | reflective | 0 | share of the mirror reflection that is added |
//! | ambientIntensity | 0.2 | white light from everywhere, scattered by the diffuse colour |
//! | shininess | 0.2 | 0 to 1: highlights from wide to small; the exponent is 128 times it |
//! | transparency | 0 | share of the radiance straight behind, instead of all the rest |
//! | diffuseTexture | texture 0 | multiplied to the diffuse colour |
//! | maxDepth | int -1 | mirrors and see-through end at this depth of rays; negative: at that of the API |
//! | useVertexColor | int 0 | if not 0, the colours of the vertices replace the diffuse colour |
//!
//! Source: ISO/IEC 14772 (VRML97) section 4.14 for the model, with the half vector of [Bli77] and shadow rays; names of
//! RTfact. Lights as in `lambert.rs`: no division by pi. Tests: `tests`.

use std::sync::Arc;

use glam::Vec3;

use super::class::{Kind, Parameter, Shader, ShaderClass, Values};
use super::lambert::{normals_given, shading_normals};
use super::mirror::reflection;
use super::texture::texel_colors;
use crate::batch::{SurfaceBatch, Vec3s};
use crate::shader::{AttributeRequest, LightBatch, RadianceShader, RayRequest, SurfaceShader, Tracer};
use crate::texture::TextureSampler;

/// Factor from shininess to the exponent.
const EXPONENT: f32 = 128.0;

/// Numbers of the branches.
const REFLECTED: u32 = 0;
const STRAIGHT: u32 = 2;

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "Phong",
    kind: Kind::Surface,
    parameters: &[
        Parameter::floats("diffuseColor", &[0.8; 3]),
        Parameter::floats("specularColor", &[0.0; 3]),
        Parameter::floats("emissiveColor", &[0.0; 3]),
        Parameter::floats("reflective", &[0.0]),
        Parameter::floats("ambientIntensity", &[0.2]),
        Parameter::floats("shininess", &[0.2]),
        Parameter::floats("transparency", &[0.0]),
        Parameter::texture("diffuseTexture"),
        Parameter::int("maxDepth", &[-1.0]),
        Parameter::int("useVertexColor", &[0.0]),
    ],
    make: |values| Shader::Surface(Arc::new(Phong::new(values))),
};

struct Phong {
    diffuse: Vec3,
    specular: Vec3,
    emissive: Vec3,
    reflective: f32,
    ambient: f32,
    exponent: f32,
    transparency: f32,
    texture: Option<Arc<TextureSampler>>,
    max_depth: u32,
    use_vertex_color: bool,
    attributes: [AttributeRequest; 1],
}

impl Phong {
    fn new(values: &Values) -> Self {
        Self {
            diffuse: values.vec3(0),
            specular: values.vec3(1),
            emissive: values.vec3(2),
            reflective: values.float(3),
            ambient: values.float(4),
            exponent: values.float(5).clamp(0.0, 1.0) * EXPONENT,
            transparency: values.float(6).clamp(0.0, 1.0),
            texture: values.texture(7),
            // Without an own limit the renderer's holds.
            max_depth: u32::try_from(values.int(8)).unwrap_or(u32::MAX),
            use_vertex_color: values.int(9) != 0,
            attributes: [normals_given()],
        }
    }

    /// Diffuse colours of all lanes.
    fn colors(&self, hits: &SurfaceBatch) -> Vec3s {
        let mut colors = Vec3s::splat(hits.len(), Vec3::ONE);
        texel_colors(self.texture.as_deref(), hits, &mut colors);
        for i in 0..hits.len() {
            let own = if self.use_vertex_color { hits.color.get(i) } else { self.diffuse };
            colors.set(i, colors.get(i) * own);
        }
        colors
    }

    fn add_lights(
        &self,
        tracer: &mut dyn Tracer,
        hits: &SurfaceBatch,
        normals: &[Vec3],
        colors: &Vec3s,
        out: &mut Vec3s,
    ) {
        let (mut light, mut through) = (LightBatch::default(), Vec3s::default());
        for number in 0..tracer.light_count() {
            tracer.illuminate(number, hits, &mut light);
            let (mut request, mut scattered) = (RayRequest::default(), Vec::new());
            for (i, &normal) in normals.iter().enumerate() {
                let dir = light.dir.get(i);
                let cos = normal.dot(dir);
                if cos <= 0.0 || light.radiance.get(i) == Vec3::ZERO {
                    continue;
                }
                let half = (dir - hits.ray_dir.get(i)).normalize_or_zero();
                let highlight = self.specular * normal.dot(half).max(0.0).powf(self.exponent);
                scattered.push(light.radiance.get(i) * (colors.get(i) * cos + highlight));
                request.push(hits.spawn_to(i, dir, light.dist[i]), i, hits.key[i]);
            }
            tracer.occluded(&request, &mut through);
            for (k, &i) in request.parent.iter().enumerate() {
                out.add(i as usize, scattered[k] * through.get(k));
            }
        }
    }

    /// Adds `weight` times the radiance of rays in these directions.
    fn add_radiance(
        tracer: &mut dyn Tracer,
        hits: &SurfaceBatch,
        dirs: impl Iterator<Item = Vec3>,
        (branch, weight): (u32, f32),
        out: &mut Vec3s,
    ) {
        let (mut request, mut found) = (RayRequest::default(), Vec3s::default());
        for (i, dir) in dirs.enumerate() {
            request.push(hits.spawn(i, dir, f32::INFINITY), i, hits.key[i].fork(branch));
            request.width.push(hits.footprint.get(i).copied().unwrap_or(0.0));
        }
        tracer.trace(hits.depth, &request, &mut found);
        (0..hits.len()).for_each(|i| out.add(i, weight * found.get(i)));
    }
}

impl RadianceShader for Phong {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let (normals, colors) = (shading_normals(hits, 0), self.colors(hits));
        (0..hits.len()).for_each(|i| out.set(i, self.emissive + self.ambient * colors.get(i)));
        self.add_lights(tracer, hits, &normals, &colors, out);
        let goes_on = hits.depth < self.max_depth;
        if goes_on && self.reflective > 0.0 {
            let dirs = normals.iter().enumerate().map(|(i, &normal)| reflection(hits, i, normal));
            Self::add_radiance(tracer, hits, dirs, (REFLECTED, self.reflective), out);
        }
        if self.transparency > 0.0 {
            (0..hits.len()).for_each(|i| out.set(i, (1.0 - self.transparency) * out.get(i)));
            if goes_on {
                let dirs = (0..hits.len()).map(|i| hits.ray_dir.get(i));
                Self::add_radiance(tracer, hits, dirs, (STRAIGHT, self.transparency), out);
            }
        }
    }
}

impl SurfaceShader for Phong {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }

    fn transmit(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        out.reset(hits.len(), Vec3::splat(self.transparency));
    }

    fn is_opaque(&self) -> bool {
        self.transparency <= 0.0
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        *out = self.colors(hits);
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.attributes
    }
}

#[cfg(test)]
mod tests {
    use gnurt_image::{TexelData, Texels};

    use super::super::class::Value;
    use super::super::probe::{Probe, floor, shade};
    use super::*;

    /// The defaults, with one parameter changed.
    fn with(name: &str, value: Value) -> Phong {
        let mut values = CLASS.defaults();
        let index = CLASS.parameters.iter().position(|p| p.name == name).expect("a parameter");
        values.0[index] = value;
        Phong::new(&values)
    }

    fn floats(name: &str, value: &[f32]) -> Phong {
        with(name, Value::Floats(value.to_vec()))
    }

    fn near(a: Vec3, b: Vec3) {
        assert!((a - b).length() < 1e-5, "{a} is not {b}");
    }

    #[test]
    fn sums_its_parts() {
        let mut lit_probe = Probe::lit(Vec3::Y, Vec3::splat(2.0));
        near(shade(&floats("reflective", &[0.0]), &mut lit_probe, &floor()), Vec3::splat(0.8 * (0.2 + 2.0)));
        near(shade(&floats("ambientIntensity", &[1.0]), &mut Probe::dark(), &floor()), Vec3::splat(0.8));
        near(
            shade(&floats("emissiveColor", &[1.0, 0.0, 0.5]), &mut Probe::dark(), &floor()),
            Vec3::new(1.16, 0.16, 0.66),
        );
        // The light is in the mirror direction: the half vector is the normal, the highlight at its greatest.
        let mut mirrored = Probe::lit(Vec3::new(0.0, 1.0, -1.0).normalize(), Vec3::ONE);
        let cos = 0.5_f32.sqrt();
        near(
            shade(&floats("specularColor", &[0.5; 3]), &mut mirrored, &floor()),
            Vec3::splat(0.16 + 0.8 * cos + 0.5),
        );
        // Off by 45 degrees from the eye, 22.5 between half vector and normal: the exponent is 0.2 * 128.
        let found = shade(&floats("specularColor", &[1.0; 3]), &mut lit_probe, &floor());
        let highlight = 22.5_f32.to_radians().cos().powf(25.6);
        near(found, Vec3::splat(0.16 + 2.0 * (0.8 + highlight)));
        lit_probe.transmittance = Vec3::ZERO;
        near(shade(&floats("specularColor", &[1.0; 3]), &mut lit_probe, &floor()), Vec3::splat(0.16));
    }

    #[test]
    fn mirrors_and_is_seen_through_to_its_depth() {
        let mut probe = Probe { found: Vec3::new(1.0, 2.0, 3.0), ..Probe::dark() };
        near(shade(&floats("reflective", &[0.5]), &mut probe, &floor()), Vec3::new(0.66, 1.16, 1.66));
        assert_eq!(probe.traced.len(), 1, "one ray");
        let half = floats("transparency", &[0.5]);
        near(shade(&half, &mut probe, &floor()), Vec3::new(0.58, 1.08, 1.58));
        assert_eq!(Vec3::from(probe.traced[1].dir), floor().ray_dir.get(0), "straight on");
        assert!(!half.is_opaque(), "shadow rays go on");
        let ended = Phong { max_depth: 0, reflective: 1.0, ..floats("transparency", &[0.5]) };
        near(shade(&ended, &mut probe, &floor()), Vec3::splat(0.08));
        assert_eq!(probe.traced.len(), 2, "no more rays");
    }

    #[test]
    fn vertices_and_textures_may_give_the_color() {
        let mut hits = floor();
        hits.color = Vec3s::splat(1, Vec3::new(0.0, 1.0, 0.5));
        let shader = with("useVertexColor", Value::Int(1));
        near(shade(&shader, &mut Probe::dark(), &hits), Vec3::new(0.0, 0.2, 0.1));
        let data = TexelData::Float(vec![[0.5, 1.0, 2.0, 1.0]]);
        let texture = TextureSampler::new(Arc::new(Texels { width: 1, height: 1, data }));
        let shader = with("diffuseTexture", Value::Texture(Some(Arc::new(texture))));
        near(shade(&shader, &mut Probe::dark(), &hits), Vec3::new(0.08, 0.16, 0.32));
    }
}
