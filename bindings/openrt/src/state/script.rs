// SPDX-License-Identifier: GPL-3.0-or-later
//! Shader classes in the shading language: `rtGenNewShaderClass("wood", "wood.osl")`.
//! Parameters of floats and ints have the calls of their numbers, texts have rtParameterString; one that is
//! marked `interpolated` belongs to vertices, or to triangles with `rate = "triangle"`. A parameter without a
//! call in C keeps its default.
//! Tests: tests/c/script.c.

use std::path::Path;

use gnurt::osl::{Access, CameraFrame, Kind as ScriptKind, ParameterValue as ScriptValue, Script};
use gnurt::shading::classes::{ParameterRate, Shader as RenderShader};
use gnurt_plugins::host::{DataType, Kind, LoadError, Parameter};

use super::value::ParameterValue;

/// Numbers of one parameter that a call can bring.
const MOST: usize = 16;

/// A class whose code is a script.
pub(crate) struct ScriptClass {
    /// The shader's name.
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) parameters: Vec<Parameter>,
    script: Script,
}

impl ScriptClass {
    /// The shader `name` of a file.
    pub(crate) fn load(name: &str, file: &str) -> Result<Self, LoadError> {
        let script = Script::open(Path::new(file), &Access::default()).map_err(LoadError::Unfit)?;
        if script.shader_name() != name {
            let found = script.shader_name();
            return Err(LoadError::Missing(format!(
                "unknown shader \"{name}\" in {file}; it holds \"{found}\""
            )));
        }
        let kind = match script.kind() {
            ScriptKind::Surface => Kind::Surface,
            ScriptKind::Displacement => {
                return Err(LoadError::Unfit(format!(
                    "{file}: displacement shaders are unsupported in OpenRT"
                )));
            }
            ScriptKind::Light => Kind::Light,
            ScriptKind::Camera => Kind::Camera,
            ScriptKind::Environment => Kind::Environment,
            ScriptKind::Pixel => Kind::RenderingObject,
        };
        let parameters = script.parameters().iter().filter_map(described).collect();
        Ok(Self { name: name.to_owned(), kind, parameters, script })
    }

    /// The shader with these values, one for each parameter.
    pub(crate) fn make(&self, values: &[ParameterValue]) -> Result<RenderShader, String> {
        let mut script = self.script.clone();
        for (parameter, value) in self.parameters.iter().zip(values) {
            let given = match value {
                ParameterValue::Floats(list) => ScriptValue::Floats(list.clone()),
                ParameterValue::Integer(value) => ScriptValue::Ints(vec![*value]),
                ParameterValue::Text(Some(text)) => ScriptValue::Texts(vec![text.clone()]),
                ParameterValue::Text(None) => continue,
            };
            if parameter.rate == ParameterRate::Shader {
                script.set(&parameter.name, &given)?;
            }
        }
        Ok(match self.kind {
            Kind::Light => RenderShader::Light(script.light()?),
            Kind::Environment => RenderShader::Environment(script.environment()?),
            Kind::Camera => {
                let [right, up, back] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                let parameter_index = CameraFrame { eye: [0.0; 3], right, up, back, pixels: [1; 2] };
                RenderShader::Camera(script.camera(parameter_index)?)
            }
            Kind::RenderingObject => RenderShader::Pixel(script.pixel()?),
            Kind::Surface => RenderShader::Surface(script.surface()?),
        })
    }
}

/// A parameter in C's terms, if C has a call for it.
fn described(from: &gnurt::osl::Parameter) -> Option<Parameter> {
    let rate = match (from.is_of_mesh, &from.rate[..]) {
        (false, _) => ParameterRate::Shader,
        (true, "triangle") => ParameterRate::Triangle,
        (true, _) => ParameterRate::Vertex,
    };
    let (kind, default) = match &from.default {
        ScriptValue::Floats(list) => (DataType::F32, list.clone()),
        ScriptValue::Ints(list) => (DataType::I32, list.iter().map(|&x| x as f32).collect()),
        ScriptValue::Texts(list) => (DataType::Text, vec![0.0; list.len()]),
    };
    let fits = match kind {
        DataType::F32 => (1..=MOST).contains(&default.len()),
        _ => default.len() == 1 && rate == ParameterRate::Shader,
    };
    let count = default.len();
    fits.then(|| Parameter { name: from.name.clone(), rate, kind, count, default })
}
