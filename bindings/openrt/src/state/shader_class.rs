// SPDX-License-Identifier: GPL-3.0-or-later
//! Shader classes that were loaded, where their varying parameters lie, and the handles of their parameters.
//! Source: \[DWBS03\]; the paper's Figure 1. Invariant: ids and handles are positions plus 1 and never become invalid.
//! Tests: tests/c/scene.c, tests/c/errors.c.

use std::ffi::CString;
use std::sync::Arc;

use gnurt::shading::classes::ParameterRate;
use gnurt_plugins::host::{Kind, LoadError, Parameter, load, suggestion};
use gnurt_plugins::is_script;

use super::class::ClassCode;
use super::error::{Error, Result};
use super::script::ScriptClass;

/// A class with the slots of its varying parameters.
pub(crate) struct LoadedClass {
    /// Name of the library it came from; empty for built-in classes.
    file: String,
    /// Where its code is.
    pub(crate) code: ClassCode,
    /// The purpose of its shaders.
    pub(crate) kind: Kind,
    /// Its parameters.
    pub(crate) parameters: Vec<Parameter>,
    /// Parameters that vary per triangle.
    pub(crate) triangle: Layout,
    /// Parameters that vary per vertex.
    pub(crate) vertex: Layout,
}

/// The parameters of one varying rate, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Layout {
    /// Each parameter's number in the class, and where its floats begin.
    pub(crate) slots: Vec<Slot>,
    /// The values that a bind starts with; as long as all of them together.
    pub(crate) defaults: Vec<f32>,
}

/// Where a varying parameter lies among those of its rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    /// Number of the parameter in the class.
    pub(crate) parameter: usize,
    /// First float.
    pub(crate) offset: usize,
    /// Floats.
    pub(crate) components: usize,
}

impl Layout {
    fn of(parameters: &[Parameter], rate: ParameterRate) -> Self {
        let mut layout = Self::default();
        for (parameter, description) in parameters.iter().enumerate() {
            if description.rate == rate {
                let components = description.default.len();
                layout.slots.push(Slot { parameter, offset: layout.defaults.len(), components });
                layout.defaults.extend_from_slice(&description.default);
            }
        }
        layout
    }

    /// The slot of parameter number `parameter`, if it is of this rate.
    #[must_use]
    pub(crate) fn slot(&self, parameter: usize) -> Option<Slot> {
        self.slots.iter().copied().find(|slot| slot.parameter == parameter)
    }
}

impl LoadedClass {
    fn new(code: ClassCode, file: &str) -> Self {
        let (kind, parameters) = (code.kind(), code.parameters());
        let layout = |rate| Layout::of(&parameters, rate);
        let (triangle, vertex) = (layout(ParameterRate::Triangle), layout(ParameterRate::Vertex));
        Self { file: file.to_owned(), code, kind, parameters, triangle, vertex }
    }
}

/// A parameter of a class, as handles name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Handle {
    /// The class' id.
    pub(crate) class: u32,
    /// Number of the parameter in it.
    pub(crate) parameter: usize,
}

/// All classes and handles.
#[derive(Default)]
pub(crate) struct Classes {
    loaded: Vec<Arc<LoadedClass>>,
    handles: Vec<Handle>,
    /// The failure of the last load, or faults of plugins in a frame since; empty if there were none.
    pub(crate) info_log: CString,
}

impl Classes {
    /// The class of this id.
    #[must_use]
    pub(crate) fn get(&self, id: u32) -> Option<&Arc<LoadedClass>> {
        self.loaded.get((id as usize).checked_sub(1)?)
    }

    /// The handle `id`; [`Error::InvalidValue`] if there is none.
    pub(crate) fn handle(&self, id: u32) -> Result<Handle> {
        let parameter_index = (id as usize).checked_sub(1);
        parameter_index.and_then(|i| self.handles.get(i)).copied().ok_or(Error::InvalidValue)
    }

    /// Finds or loads a class and returns its id, or the reason why it cannot.
    pub(crate) fn load(&mut self, name: &str, file: &str) -> std::result::Result<u32, LoadError> {
        let known = self.loaded.iter().position(|class| class.code.name() == name && class.file == file);
        if let Some(known) = known {
            return Ok(known as u32 + 1);
        }
        let code = if file.is_empty() {
            ClassCode::built_in(name).ok_or_else(|| {
                let names = ClassCode::built_in_names();
                let (list, hint) = (names.join(", "), suggestion(name, &names));
                LoadError::Missing(format!(
                    "unknown built-in shader class \"{name}\"; valid are: {list}{hint}"
                ))
            })?
        } else if is_script(file) {
            ClassCode::Script(Arc::new(ScriptClass::load(name, file)?))
        } else {
            ClassCode::Plugin(Arc::new(load(name, file)?))
        };
        self.loaded.push(Arc::new(LoadedClass::new(code, file)));
        Ok(self.loaded.len() as u32)
    }

    /// Sets the result of rtGetShaderClassInfoLog.
    pub(crate) fn set_info_log(&mut self, text: &str) {
        // A C string ends at its first zero byte: texts of plugins hold none, nor do those that came from C.
        self.info_log = CString::new(text).unwrap_or_default();
    }

    /// The handle of a parameter, made if it is new.
    pub(crate) fn handle_of(&mut self, expected: Handle) -> u32 {
        let known = self.handles.iter().position(|&handle| handle == expected);
        let parameter_index = known.unwrap_or_else(|| {
            self.handles.push(expected);
            self.handles.len() - 1
        });
        parameter_index as u32 + 1
    }
}
