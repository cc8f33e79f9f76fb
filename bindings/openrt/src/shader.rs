// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders: instances of classes with their values, and what is bound (rtGenNewShader, rtBindShader, rtDeleteShader).
//! Source: \[DWBS03\]; the paper's Figure 1. Invariant: `Bound`'s blocks are as long as its class says.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use gnurt::shading::classes::{self, ParameterType, Shader as Made, Value, Values};

use crate::class::{Code, DataType, Kind, Parameter};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::ffi_plugin_block::PluginBlock;
use crate::plugin_frame::PluginFrame;
use crate::shader_class::LoadedClass;
use crate::texture::Textures;

/// The per-shader value of a parameter; parameters of other rates keep their default here.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    /// Numbers.
    Floats(Vec<f32>),
    /// An integer; as a texture, 0, a negative or an unknown one is white.
    Integer(i32),
}

/// A shader.
#[derive(Clone)]
pub struct Shader {
    /// Its class' id.
    pub class_id: u32,
    /// Its class.
    pub class: Arc<LoadedClass>,
    /// One value per parameter of the class; none if it is a plugin's.
    pub values: Vec<ParameterValue>,
    /// What a plugin keeps its parameters in.
    pub block: Option<Arc<PluginBlock>>,
    /// Its id is gone; it lives on while something uses it.
    deleted: bool,
}

impl Shader {
    fn new(class_id: u32, class: Arc<LoadedClass>) -> Self {
        let value = |p: &Parameter| match p.kind {
            DataType::F32 => ParameterValue::Floats(p.default.clone()),
            _ => ParameterValue::Integer(p.default.first().map_or(0, |&x| x as i32)),
        };
        let (values, block) = match &class.code {
            Code::Plugin(plugin) => (Vec::new(), Some(PluginBlock::new(plugin))),
            _ => (class.parameters.iter().map(value).collect(), None),
        };
        Self { class_id, class, values, block, deleted: false }
    }

    /// What it is for.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.class.kind
    }

    /// The shader as the renderer takes it, with its present values; `None` if it shades nothing: a rendering object, or
    /// a plugin that cannot take part in the frame.
    #[must_use]
    pub fn make(&self, id: u32, textures: &Textures, plugins: &PluginFrame) -> Option<Made> {
        let value = |(value, parameter): (&ParameterValue, &classes::Parameter)| match value {
            ParameterValue::Floats(floats) => Value::Floats(floats.clone()),
            ParameterValue::Integer(value) if parameter.kind == ParameterType::Int => Value::Int(*value),
            ParameterValue::Integer(id) => Value::Texture(textures.sampler(*id)),
        };
        match &self.class.code {
            Code::BuiltIn(class) => {
                let values = self.values.iter().zip(class.parameters).map(value).collect();
                Some(class.make(&Values(values)))
            }
            Code::Plugin(_) => plugins.made(id),
            Code::Rendering(_) => None,
        }
    }
}

/// All shaders.
#[derive(Default)]
pub struct Shaders {
    last_id: u32,
    all: BTreeMap<u32, Shader>,
}

impl Shaders {
    fn add(&mut self, shader: Shader) -> Result<u32> {
        let id = self.last_id.checked_add(1).filter(|&id| id < u32::MAX).ok_or(Error::OutOfMemory)?;
        self.last_id = id;
        self.all.insert(id, shader);
        Ok(id)
    }

    /// The shader of a valid id.
    #[must_use]
    pub fn get(&self, id: u32) -> Option<&Shader> {
        self.all.get(&id).filter(|shader| !shader.deleted)
    }

    /// The shader of a valid id, to be changed.
    pub fn get_mut(&mut self, id: u32) -> Option<&mut Shader> {
        self.all.get_mut(&id).filter(|shader| !shader.deleted)
    }

    /// The shader of an id that geometry, camera or lights hold: it may have been deleted.
    #[must_use]
    pub fn in_use(&self, id: u32) -> Option<&Shader> {
        self.all.get(&id)
    }

    /// All that live, with their ids.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &Shader)> {
        self.all.iter().map(|(&id, shader)| (id, shader))
    }

    /// Frees deleted shaders that are not in `used`.
    pub fn prune(&mut self, used: &BTreeSet<u32>) {
        self.all.retain(|id, shader| !shader.deleted || used.contains(id));
    }
}

/// The bound class and shader, and the current values of the parameters that vary.
#[derive(Default)]
pub struct Bound {
    class: Option<(u32, Arc<LoadedClass>)>,
    shader: Option<u32>,
    /// What the next triangle takes.
    pub triangle: Vec<f32>,
    /// What the next vertex takes.
    pub vertex: Vec<f32>,
}

impl Bound {
    /// The bound class.
    #[must_use]
    pub fn class(&self) -> Option<&Arc<LoadedClass>> {
        self.class.as_ref().map(|(_, class)| class)
    }

    /// The bound class' id.
    #[must_use]
    pub fn class_id(&self) -> Option<u32> {
        self.class.as_ref().map(|(id, _)| *id)
    }

    /// The bound shader's id.
    #[must_use]
    pub fn shader(&self) -> Option<u32> {
        self.shader
    }

    /// The current values of parameters that vary become the class' defaults.
    pub fn restart_values(&mut self) {
        let defaults = |block: fn(&LoadedClass) -> &Vec<f32>| {
            self.class.as_ref().map(|(_, class)| block(class).clone()).unwrap_or_default()
        };
        let (triangle, vertex) = (defaults(|c| &c.triangle.defaults), defaults(|c| &c.vertex.defaults));
        (self.triangle, self.vertex) = (triangle, vertex);
    }
}

impl Context {
    /// Binds a class that exists, and no shader.
    pub(crate) fn bind_class(&mut self, id: u32) {
        self.bound.class = self.classes.get(id).map(|class| (id, class.clone()));
        self.bound.shader = None;
        self.bound.restart_values();
    }

    /// rtGenNewShader.
    pub fn gen_new_shader(&mut self) -> Result<u32> {
        self.outside_block()?;
        let (class_id, class) = self.bound.class.clone().ok_or(Error::InvalidOperation)?;
        let id = self.shaders.add(Shader::new(class_id, class))?;
        self.bound.shader = Some(id);
        self.bound.restart_values();
        Ok(id)
    }

    /// rtBindShader.
    pub fn bind_shader(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        let shader = self.shaders.get(id).ok_or(Error::InvalidOperation)?;
        self.bound.class = Some((shader.class_id, shader.class.clone()));
        self.bound.shader = Some(id);
        self.bound.restart_values();
        Ok(())
    }

    /// rtDeleteShader.
    pub fn delete_shader(&mut self, id: u32) -> Result<()> {
        self.outside_block()?;
        self.shaders.get_mut(id).ok_or(Error::InvalidValue)?.deleted = true;
        if self.bound.shader == Some(id) {
            self.bound.shader = None;
        }
        Ok(())
    }

    /// rtIsShader.
    pub fn is_shader(&self, id: u32) -> Result<bool> {
        self.outside_block()?;
        Ok(self.shaders.get(id).is_some())
    }
}
