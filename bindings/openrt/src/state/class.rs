// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the code of a shader class is: in the renderer, in a plugin, in a script, or among the rendering objects.
//! Tests: tests/c/scene.c, tests/plugins.rs.

use std::sync::Arc;

use gnurt::shading::classes::{self, ShaderClass};
use gnurt_plugins::host::{Kind, Parameter, PluginClass};

use super::rendering_object::RenderingClass;
use super::script::ScriptClass;

/// Where the code of a class is.
#[derive(Clone)]
pub(crate) enum ClassCode {
    /// In the renderer.
    BuiltIn(&'static ShaderClass),
    /// In a shared library.
    Plugin(Arc<PluginClass>),
    /// In the shading language.
    Script(Arc<ScriptClass>),
    /// It chooses among the renderer's integrators.
    Rendering(&'static RenderingClass),
}

impl ClassCode {
    /// The built-in class of this name.
    #[must_use]
    pub(crate) fn built_in(name: &str) -> Option<Self> {
        let rendering = || RenderingClass::find(name).map(Self::Rendering);
        classes::find(name).map(Self::BuiltIn).or_else(rendering)
    }

    /// Names of all built-in classes.
    #[must_use]
    pub(crate) fn built_in_names() -> Vec<&'static str> {
        classes::ALL.iter().map(|class| class.name).chain(RenderingClass::names()).collect()
    }

    /// Its name.
    #[must_use]
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::BuiltIn(class) => class.name,
            Self::Plugin(class) => &class.name,
            Self::Script(class) => &class.name,
            Self::Rendering(class) => class.name,
        }
    }

    /// The purpose of its shaders.
    #[must_use]
    pub(crate) fn kind(&self) -> Kind {
        match self {
            Self::BuiltIn(class) => class.kind.into(),
            Self::Plugin(class) => class.kind,
            Self::Script(class) => class.kind,
            Self::Rendering(_) => Kind::RenderingObject,
        }
    }

    /// Its parameters.
    #[must_use]
    pub(crate) fn parameters(&self) -> Vec<Parameter> {
        match self {
            Self::BuiltIn(class) => Parameter::of_built_in(class),
            Self::Plugin(class) => class.parameters.iter().map(|p| p.description.clone()).collect(),
            Self::Script(class) => class.parameters.clone(),
            Self::Rendering(_) => RenderingClass::parameters(),
        }
    }
}
