// SPDX-License-Identifier: GPL-3.0-or-later
//! Shader classes: loading, binding, parameter handles (rtGenNewShaderClass, rtBindShaderClass, rtParameterHandle).
//! Source: \[DWBS03\]; the paper's Figure 1. Invariant: ids and handles are positions plus 1 and never become invalid.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::ffi::{CStr, CString};
use std::sync::Arc;

use gnurt::shading::classes::ParameterRate;

use crate::class::{Code, Kind, Parameter};
use crate::context::Context;
use crate::error::{Error, Result, not_null};
use crate::plugin_load::{LoadError, load, suggestion};

/// A class with the places of its varying parameters.
pub struct LoadedClass {
    /// Name of the library it came from; empty for built-in classes.
    file: String,
    /// Where its code is.
    pub code: Code,
    /// What its shaders are for.
    pub kind: Kind,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// Parameters that vary per triangle.
    pub triangle: Block,
    /// Parameters that vary per vertex.
    pub vertex: Block,
}

/// The parameters of one varying rate, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Block {
    /// Each parameter's number in the class, and where its floats begin.
    pub slots: Vec<Slot>,
    /// The values that a bind starts with; as long as the block.
    pub defaults: Vec<f32>,
}

/// Where a varying parameter lies in its block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Number of the parameter in the class.
    pub parameter: usize,
    /// First float.
    pub offset: usize,
    /// Floats.
    pub components: usize,
}

impl Block {
    fn of(parameters: &[Parameter], rate: ParameterRate) -> Self {
        let mut block = Self::default();
        for (parameter, description) in parameters.iter().enumerate() {
            if description.rate == rate {
                let components = description.default.len();
                block.slots.push(Slot { parameter, offset: block.defaults.len(), components });
                block.defaults.extend_from_slice(&description.default);
            }
        }
        block
    }

    /// The place of parameter number `parameter`, if it is of this rate.
    #[must_use]
    pub fn slot(&self, parameter: usize) -> Option<Slot> {
        self.slots.iter().copied().find(|slot| slot.parameter == parameter)
    }
}

impl LoadedClass {
    fn new(code: Code, file: &str) -> Self {
        let (kind, parameters) = (code.kind(), code.parameters());
        let block = |rate| Block::of(&parameters, rate);
        let (triangle, vertex) = (block(ParameterRate::Triangle), block(ParameterRate::Vertex));
        Self { file: file.to_owned(), code, kind, parameters, triangle, vertex }
    }
}

/// A parameter of a class, as handles name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Handle {
    /// The class' id.
    pub class: u32,
    /// Number of the parameter in it.
    pub parameter: usize,
}

/// All classes and handles.
#[derive(Default)]
pub struct Classes {
    loaded: Vec<Arc<LoadedClass>>,
    handles: Vec<Handle>,
    /// Why the last load failed, or what was wrong with plugins in a frame since; empty if nothing was.
    info_log: CString,
}

impl Classes {
    /// The class of this id.
    #[must_use]
    pub fn get(&self, id: u32) -> Option<&Arc<LoadedClass>> {
        self.loaded.get((id as usize).checked_sub(1)?)
    }

    /// What handle `id` names; [`Error::InvalidValue`] if nothing.
    pub fn handle(&self, id: u32) -> Result<Handle> {
        let place = (id as usize).checked_sub(1);
        place.and_then(|i| self.handles.get(i)).copied().ok_or(Error::InvalidValue)
    }

    /// Finds or loads a class and returns its id, or says why it cannot.
    fn load(&mut self, name: &str, file: &str) -> std::result::Result<u32, LoadError> {
        let known = self.loaded.iter().position(|class| class.code.name() == name && class.file == file);
        if let Some(known) = known {
            return Ok(known as u32 + 1);
        }
        let code = if file.is_empty() {
            Code::built_in(name).ok_or_else(|| {
                let names = Code::built_in_names();
                let (list, hint) = (names.join(", "), suggestion(name, &names));
                LoadError::missing(format!("no built-in shader class \"{name}\"; there are {list}{hint}"))
            })?
        } else {
            Code::Plugin(Arc::new(load(name, file)?))
        };
        self.loaded.push(Arc::new(LoadedClass::new(code, file)));
        Ok(self.loaded.len() as u32)
    }

    /// Lets [`Context::shader_class_info_log`] say something.
    pub fn set_info_log(&mut self, text: &str) {
        // A C string ends at its first zero byte: texts of plugins hold none, nor do those that came from C.
        self.info_log = CString::new(text).unwrap_or_default();
    }

    /// The handle of a parameter, made if it is new.
    fn handle_of(&mut self, wanted: Handle) -> u32 {
        let known = self.handles.iter().position(|&handle| handle == wanted);
        let place = known.unwrap_or_else(|| {
            self.handles.push(wanted);
            self.handles.len() - 1
        });
        place as u32 + 1
    }
}

impl Context {
    /// rtGenNewShaderClass.
    pub fn gen_new_shader_class(&mut self, name: Option<&CStr>, file: Option<&CStr>) -> Result<u32> {
        self.outside_block()?;
        let text = |s: &CStr| s.to_string_lossy().into_owned();
        let outcome = match name {
            None => Err(LoadError::missing("no shader class name: the name is NULL".to_owned())),
            Some(name) => self.classes.load(&text(name), &file.map(text).unwrap_or_default()),
        };
        self.classes.set_info_log(outcome.as_ref().err().map_or("", |failure| &failure.text));
        let id = outcome.map_err(|failure| failure.code)?;
        self.bind_class(id);
        Ok(id)
    }

    /// rtBindShaderClass.
    pub fn bind_shader_class(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        self.classes.get(id).ok_or(Error::InvalidOperation)?;
        self.bind_class(id);
        Ok(())
    }

    /// rtParameterHandle.
    pub fn parameter_handle(&mut self, name: Option<&CStr>) -> Result<u32> {
        self.outside_block()?;
        let name = not_null(name)?;
        let class = self.bound.class_id().ok_or(Error::InvalidOperation)?;
        let loaded = self.classes.get(class).ok_or(Error::InvalidOperation)?;
        let mut parameters = loaded.parameters.iter();
        let parameter = parameters.position(|p| p.name.as_bytes() == name.to_bytes());
        let parameter = parameter.ok_or(Error::InvalidValue)?;
        Ok(self.classes.handle_of(Handle { class, parameter }))
    }

    /// rtGetShaderClassInfoLog.
    pub fn shader_class_info_log(&self) -> Result<&CStr> {
        self.outside_block()?;
        Ok(&self.classes.info_log)
    }
}
