// SPDX-License-Identifier: GPL-3.0-or-later
//! Shader classes that are made by name with named parameters: what OpenRT programs find without a plugin.
//! Source: \[DWBS03\] for classes, shaders and rates; class and parameter names as OpenRT programs know them.
//! Space: world; colours linear. One class per file; to add one, write its file and a line in [`ALL`].
//! Proof: `tests` here and in each file; the C programs of the OpenRT binding draw with each class.

mod class;
mod constant;
mod constant_environment;
mod diffuse;
mod infinite_light;
mod lambert;
mod mirror;
mod pinhole_camera;
mod projection_camera;
mod sample;
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
    &sample::CLASS,
    &spot_light::CLASS,
    &infinite_light::CLASS,
    &pinhole_camera::CLASS,
    &constant_environment::CLASS,
];

/// The class called `name`.
#[must_use]
pub fn find(name: &str) -> Option<&'static ShaderClass> {
    ALL.iter().copied().find(|class| class.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

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
