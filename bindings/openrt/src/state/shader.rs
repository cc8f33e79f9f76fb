// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders: instances of classes with their values, and the bound ones.
//! Source: \[DWBS03\]; the paper's Figure 1. Invariant: the number of `Bound`'s values is that of its class.
//! Tests: tests/c/scene.c, tests/c/errors.c.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use gnurt::shading::classes::{self, ParameterType, Shader as RenderShader, Value, Values};
use gnurt_plugins::host::{DataType, Kind, Parameter, PluginBlock, PluginFrame};

use super::block::CurrentValues;
use super::class::ClassCode;
use super::error::{Error, Result};
use super::ids::RT_INVALID;
use super::shader_class::LoadedClass;
use super::texture::Textures;
use super::value::ParameterValue;

/// A shader.
#[derive(Clone)]
pub(crate) struct Shader {
    /// Its class' id.
    pub(crate) class_id: u32,
    /// Its class.
    pub(crate) class: Arc<LoadedClass>,
    /// One value per parameter of the class; none if it is a plugin's.
    pub(crate) values: Vec<ParameterValue>,
    /// The parameter block of a plugin's shader.
    pub(crate) block: Option<Arc<PluginBlock>>,
    /// Its id is gone; it lives on while something uses it.
    pub(crate) deleted: bool,
    /// As the renderer took it last, and the values that it had then: the same shader as long as they are the same.
    made: Option<(Vec<Value>, RenderShader)>,
    /// The same of a script.
    made_script: Option<(Vec<ParameterValue>, RenderShader)>,
}

impl Shader {
    /// A shader with its class' defaults; a line for people if a plugin cannot make one.
    pub(crate) fn new(class_id: u32, class: Arc<LoadedClass>) -> std::result::Result<Self, String> {
        let value = |p: &Parameter| match p.kind {
            DataType::F32 => ParameterValue::Floats(p.default.clone()),
            DataType::Text => ParameterValue::Text(None),
            _ => ParameterValue::Integer(p.default.first().map_or(0, |&x| x as i32)),
        };
        let (values, block) = match &class.code {
            ClassCode::Plugin(plugin) => (Vec::new(), Some(PluginBlock::new(plugin)?)),
            _ => (class.parameters.iter().map(value).collect(), None),
        };
        Ok(Self { class_id, class, values, block, deleted: false, made: None, made_script: None })
    }

    /// Its purpose.
    #[must_use]
    pub(crate) fn kind(&self) -> Kind {
        self.class.kind
    }

    /// The shader as the renderer takes it, with its present values: the same one as before while these are. `None` if it
    /// shades nothing: a rendering object, or a plugin that cannot take part in the frame. Plugins' are prepared for each frame.
    #[must_use]
    pub(crate) fn make(
        &mut self,
        id: u32,
        textures: &Textures,
        plugins: &PluginFrame,
    ) -> Option<RenderShader> {
        let value = |(value, parameter): (&ParameterValue, &classes::Parameter)| match value {
            ParameterValue::Floats(floats) => Value::Floats(floats.clone()),
            ParameterValue::Integer(value) if parameter.kind == ParameterType::Int => Value::Int(*value),
            ParameterValue::Integer(id) => Value::Texture(textures.sampler(*id)),
            ParameterValue::Text(_) => Value::Texture(None),
        };
        match &self.class.code {
            ClassCode::BuiltIn(class) => {
                let values: Vec<Value> = self.values.iter().zip(class.parameters).map(value).collect();
                if let Some((_, same)) = self.made.as_ref().filter(|(before, _)| *before == values) {
                    return Some(same.clone());
                }
                let made = class.make(&Values(values.clone()));
                self.made = Some((values, made.clone()));
                Some(made)
            }
            ClassCode::Script(class) => {
                if let Some((_, same)) =
                    self.made_script.as_ref().filter(|(before, _)| *before == self.values)
                {
                    return Some(same.clone());
                }
                let made = class.make(&self.values).ok()?;
                self.made_script = Some((self.values.clone(), made.clone()));
                Some(made)
            }
            ClassCode::Plugin(_) => plugins.made(id),
            ClassCode::Rendering(_) => None,
        }
    }
}

/// All shaders.
#[derive(Default)]
pub(crate) struct Shaders {
    last_id: u32,
    all: BTreeMap<u32, Shader>,
    /// Blocks of deleted plugin shaders that a frame may still hold. They end here, so that `fini` runs on a
    /// thread in a call of the program, as `init` and `prepare` do, and never at the same time as one of
    /// these.
    ending: Vec<Arc<PluginBlock>>,
}

impl Shaders {
    /// Adds one and returns its id.
    pub(crate) fn add(&mut self, shader: Shader) -> Result<u32> {
        if self.all.len() >= (RT_INVALID - 1) as usize {
            return Err(Error::OutOfMemory);
        }
        let after = |id: u32| if id + 1 < RT_INVALID { id + 1 } else { 1 };
        let mut id = after(self.last_id);
        // As with instances: ids go round, and those in use are passed over once a round.
        while self.all.contains_key(&id) {
            id = after(id);
        }
        self.last_id = id;
        self.all.insert(id, shader);
        Ok(id)
    }

    /// The shader of a valid id.
    #[must_use]
    pub(crate) fn get(&self, id: u32) -> Option<&Shader> {
        self.all.get(&id).filter(|shader| !shader.deleted)
    }

    /// The shader of a valid id, to be changed.
    pub(crate) fn get_mut(&mut self, id: u32) -> Option<&mut Shader> {
        self.all.get_mut(&id).filter(|shader| !shader.deleted)
    }

    /// The shader of an id that geometry, camera or lights hold: it may have been deleted.
    #[must_use]
    pub(crate) fn in_use(&self, id: u32) -> Option<&Shader> {
        self.all.get(&id)
    }

    /// The same, to be made ready for a frame.
    pub(crate) fn in_use_mut(&mut self, id: u32) -> Option<&mut Shader> {
        self.all.get_mut(&id)
    }

    /// Whether a deleted one may still be in use.
    pub(crate) fn has_deleted(&self) -> bool {
        self.all.values().any(|shader| shader.deleted)
    }

    /// All that live, with their ids.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, &Shader)> {
        self.all.iter().map(|(&id, shader)| (id, shader))
    }

    /// Frees deleted shaders that are not in `used`.
    pub(crate) fn prune(&mut self, used: &BTreeSet<u32>) {
        let ending = &mut self.ending;
        self.all.retain(|id, shader| {
            let stays = !shader.deleted || used.contains(id);
            if !stays {
                ending.extend(shader.block.take());
            }
            stays
        });
    }

    /// Ends the blocks that no frame holds any more.
    pub(crate) fn end_blocks(&mut self) {
        // No frame takes a block from here, so an unshared block stays unshared.
        self.ending.retain(|block| Arc::strong_count(block) > 1);
    }
}

/// The bound class and shader, and the current values of the parameters that vary.
#[derive(Default)]
pub(crate) struct Bound {
    class: Option<(u32, Arc<LoadedClass>)>,
    shader: Option<u32>,
    /// Values of the next triangle and the next vertex.
    pub(crate) values: CurrentValues,
}

impl Bound {
    /// The bound class.
    #[must_use]
    pub(crate) fn class(&self) -> Option<&Arc<LoadedClass>> {
        self.class.as_ref().map(|(_, class)| class)
    }

    /// The bound class' id.
    #[must_use]
    pub(crate) fn class_id(&self) -> Option<u32> {
        self.class.as_ref().map(|(id, _)| *id)
    }

    /// The bound shader's id.
    #[must_use]
    pub(crate) fn shader(&self) -> Option<u32> {
        self.shader
    }

    /// Binds a class, and a shader of it or none.
    pub(crate) fn bind(&mut self, class_id: u32, class: Arc<LoadedClass>, shader: Option<u32>) {
        (self.class, self.shader) = (Some((class_id, class)), shader);
        self.restart_values();
    }

    /// Unbinds a shader if it is bound.
    pub(crate) fn unbind(&mut self, shader: u32) {
        self.shader = self.shader.filter(|&bound| bound != shader);
    }

    /// The current values of parameters that vary become the class' defaults.
    pub(crate) fn restart_values(&mut self) {
        let defaults = |layout: fn(&LoadedClass) -> &Vec<f32>| {
            self.class.as_ref().map(|(_, class)| layout(class).clone()).unwrap_or_default()
        };
        let (triangle, vertex) = (defaults(|c| &c.triangle.defaults), defaults(|c| &c.vertex.defaults));
        self.values = CurrentValues { triangle, vertex };
    }
}
