// SPDX-License-Identifier: GPL-3.0-or-later
//! Shader classes with names and named parameters, available to OpenRT programs without a plugin.
//! Source: \[DWBS03\] for classes, shaders and rates; class and parameter names as OpenRT programs know them.
//! Space: world; colours linear. One class per file; to add one, write its file and a line in [`ALL`].
//! Tests: `tests` here and in each file; the C programs of the OpenRT binding draw with each class.

mod class;
mod constant;
mod constant_environment;
mod diffuse;
mod emissive;
mod glass;
mod infinite_light;
mod lambert;
mod matte;
mod metallic_roughness;
mod mirror;
mod phong;
mod pinhole_camera;
mod projection_camera;
mod projective_cameras;
mod sample;
mod shown;
mod spot_light;
mod texture;
mod textured_diffuse;

#[cfg(test)]
mod probe;

pub use class::{Kind, Parameter, ParameterRate, ParameterType, Shader, ShaderClass, Value, Values};
pub use lambert::NORMALS_GIVEN;
pub use projection_camera::ProjectionCamera;

/// Every class, in the order in which messages list them.
pub static ALL: &[&ShaderClass] = &[
    &constant::CLASS,
    &diffuse::CLASS,
    &textured_diffuse::CLASS,
    &texture::CLASS,
    &mirror::CLASS,
    &phong::CLASS,
    &matte::CLASS,
    &metallic_roughness::CLASS,
    &glass::CLASS,
    &emissive::CLASS,
    &sample::CLASS,
    &spot_light::CLASS,
    &infinite_light::CLASS,
    &pinhole_camera::CLASS,
    &projective_cameras::THIN_LENS,
    &projective_cameras::ORTHOGRAPHIC,
    &projective_cameras::FISHEYE,
    &projective_cameras::PANORAMIC,
    &constant_environment::CLASS,
];

/// The class called `name`.
#[must_use]
pub fn find(name: &str) -> Option<&'static ShaderClass> {
    ALL.iter().copied().find(|class| class.name == name)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::probe::{Probe, floor, shade};
    use super::*;
    use crate::batch::Vec3s;

    /// The physical materials by name, under a light from above, at their defaults: the closed forms.
    #[test]
    fn materials_by_name() {
        let found = |name: &str, edit: &[(usize, Value)], probe: &mut Probe| {
            let class = find(name).expect("a class");
            let mut values = class.defaults();
            edit.iter().for_each(|(index, value)| values.0[*index] = value.clone());
            let Shader::Surface(surface) = class.make(&values) else { panic!("{name} is of surfaces") };
            let mut hits = floor();
            hits.color = Vec3s::splat(1, Vec3::ONE);
            shade(&*surface, probe, &hits)
        };
        let pi = std::f32::consts::PI;
        let matte = found("MatteShader", &[], &mut Probe::lit(Vec3::Y, Vec3::ONE));
        assert!((matte - Vec3::splat(0.8 / pi)).length() < 1e-6, "E color / pi: {matte}");
        let light = found("EmissiveShader", &[], &mut Probe::dark());
        assert_eq!(light, Vec3::ONE, "its radiance");
        let mut around = Probe { found: Vec3::splat(2.0), ..Probe::dark() };
        let glass = found("GlassShader", &[], &mut around);
        assert!((glass - Vec3::splat(2.0)).length() < 1e-5, "all of what is around: {glass}");
        assert_eq!(around.traced.len(), 2, "mirrored and refracted");
        let black = (0, Value::Floats(vec![0.0; 3]));
        let plastic = found("MetallicRoughnessShader", &[black], &mut Probe::lit(Vec3::Y, Vec3::ONE));
        assert!(plastic.x > 0.0 && plastic.x < 0.2, "only the coat's highlight: {plastic}");
    }

    #[test]
    fn descriptions_are_consistent() {
        for class in ALL {
            assert!(std::ptr::eq(find(class.name).expect("listed"), *class), "{} is found", class.name);
            for parameter in class.parameters {
                let name = parameter.name;
                assert_eq!(parameter.default.len(), parameter.components as usize, "default of {name}");
                let varying = parameter.rate != ParameterRate::Shader;
                assert!(!varying || class.kind == Kind::Surface, "only surfaces vary: {name}");
            }
            let same_kind = matches!(
                (class.kind, class.make(&class.defaults())),
                (Kind::Surface, Shader::Surface(_))
                    | (Kind::Light, Shader::Light(_))
                    | (Kind::Camera, Shader::Camera(_))
                    | (Kind::Environment, Shader::Environment(_))
            );
            assert!(same_kind, "{} makes what it says", class.name);
        }
        assert!(find("NoSuchShader").is_none(), "an unknown name is not found");
    }
}
