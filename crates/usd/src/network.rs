// SPDX-License-Identifier: GPL-3.0-or-later
//! Networks of shaders: the value of an input, or the shader whose output it is connected to.
//! Source: UsdShade (connections, node graphs, interfaces). Tests: `tests/materials.rs`.

use openusd::sdf::{Path, Value};

use crate::reader::Reader;
use crate::value;

/// Connections that may follow on one another.
const LONGEST: usize = 64;

/// Where an input has its value from.
pub(crate) enum Source {
    /// From here.
    Value(Value),
    /// From an output of a shader.
    Shader { prim: Path, output: String },
}

impl Reader {
    /// What an input or an output of a prim of a network has, through all interfaces.
    pub(crate) fn source(&self, prim: &Path, name: &str) -> Option<Source> {
        let (mut prim, mut name) = (prim.clone(), name.to_owned());
        for _ in 0..LONGEST {
            let Some(target) = self.connection(&prim, &name) else {
                return self.value(&prim, &name).map(Source::Value);
            };
            let (owner, property) = target.split_property()?;
            if let Some(output) = property.strip_prefix("outputs:")
                && self.kind(&owner) == "Shader"
            {
                let output = output.to_owned();
                return Some(Source::Shader { prim: owner, output });
            }
            let property = property.to_owned();
            (prim, name) = (owner, property);
        }
        None
    }

    /// A number of an input that is not connected to a shader.
    pub(crate) fn input_number(&self, shader: &Path, name: &str) -> Option<f64> {
        match self.source(shader, &format!("inputs:{name}"))? {
            Source::Value(found) => value::number(&found).filter(|x| x.is_finite()),
            Source::Shader { .. } => None,
        }
    }

    /// A word of an input that is not connected to a shader.
    pub(crate) fn input_word(&self, shader: &Path, name: &str) -> Option<String> {
        match self.source(shader, &format!("inputs:{name}"))? {
            Source::Value(found) => value::word(&found),
            Source::Shader { .. } => None,
        }
    }

    /// A vector of an input that is not connected to a shader.
    pub(crate) fn input_vector<const N: usize>(&self, shader: &Path, name: &str) -> Option<[f32; N]> {
        match self.source(shader, &format!("inputs:{name}"))? {
            Source::Value(found) => value::vector(&found).map(|v: [f64; N]| v.map(|x| x as f32)),
            Source::Shader { .. } => None,
        }
    }

    /// The identifier of a shader.
    pub(crate) fn shader_id(&self, shader: &Path) -> String {
        self.uniform(shader, "info:id").as_ref().and_then(value::word).unwrap_or_default()
    }
}
