// SPDX-License-Identifier: GPL-3.0-or-later
//! A compiled shader and its parameters.

use std::sync::Arc;

use gnurt_sl::ir::{self, Shader as Intermediate, SymbolKind};
use gnurt_sl::types::Type;

/// A compiled shader. Copies share it.
#[derive(Clone, Debug)]
pub struct Shader {
    pub(crate) shader: Arc<Intermediate>,
    /// Warnings of the compiler, each with its place, and folders of `include` that do not exist.
    pub warnings: Arc<[String]>,
}

/// A parameter of a shader.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name; members of structs are named `struct.member`.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Whether it is an output.
    pub is_output: bool,
}

impl Shader {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.shader.name
    }

    /// Its kind: `surface`, `displacement`, `volume` or `shader`; or one of GNU RT's own, `light`, `camera`, `environment` and
    /// `pixel`.
    #[must_use]
    pub fn kind(&self) -> &str {
        &self.shader.kind
    }

    /// Its parameters, in the order of the text.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let all = self.shader.params().filter(|(_, symbol)| !symbol.ty.is_struct());
        all.map(|(_, symbol)| Parameter {
            name: symbol.name.to_string(),
            ty: symbol.ty,
            is_output: symbol.kind == SymbolKind::OutputParam,
        })
        .collect()
    }

    /// The text of its compiled form, which [`ShadingSystem::read_oso`](crate::ShadingSystem::read_oso) reads.
    #[must_use]
    pub fn oso(&self) -> String {
        ir::write(&self.shader, "")
    }
}
