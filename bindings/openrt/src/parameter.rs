// SPDX-License-Identifier: GPL-3.0-or-later
//! Setting and reading shader parameters at their three rates (rtParameter*, rtGetParameterfv).
//! Source: \[DWBS03\]; the paper's Figure 1 (one family of calls for all rates).
//! Proof: tests/c/scene.c, tests/c/errors.c.

use gnurt::shading::classes::{ParameterRate, ParameterType};

use crate::context::Context;
use crate::error::{Error, Result, Writer, not_null};
use crate::shader::ParameterValue;
use crate::shader_class::{Block, Handle};

/// What a call brings.
#[derive(Clone, Copy, Debug)]
pub enum Given<'a> {
    /// rtParameter*f, rtParameter*fv.
    Floats(&'a [f32]),
    /// rtParameter*i, rtParameter*iv.
    Ints(&'a [i32]),
    /// rtParameter1d.
    Double,
    /// rtParameterRaw.
    Bytes(&'a [u8]),
    /// rtParameterString.
    String,
}

/// Numbers per parameter at most.
const MAX_COMPONENTS: usize = 16;

impl Given<'_> {
    /// The floats of a parameter with `components` of them, in the front of the result.
    fn floats(self, components: usize) -> Result<[f32; MAX_COMPONENTS]> {
        let mut floats = [0.0; MAX_COMPONENTS];
        match self {
            Given::Floats(v) if v.len() == components => floats[..components].copy_from_slice(v),
            Given::Bytes(bytes) if bytes.len() == 4 * components => {
                for (float, bytes) in floats.iter_mut().zip(bytes.chunks_exact(4)) {
                    *float = f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                }
            }
            _ => return Err(Error::InvalidOperation),
        }
        Ok(floats)
    }

    /// The single integer of a texture parameter.
    fn texture(self) -> Result<i32> {
        match self {
            Given::Ints(&[id]) => Ok(id),
            Given::Bytes(&[a, b, c, d]) => Ok(i32::from_ne_bytes([a, b, c, d])),
            _ => Err(Error::InvalidOperation),
        }
    }
}

impl Context {
    /// rtParameter*: legal everywhere. `given` is `None` for a null pointer.
    pub fn set_parameter(&mut self, handle: u32, given: Option<Given<'_>>) -> Result<()> {
        let given = not_null(given)?;
        let Handle { parameter, .. } = self.handle_of_bound_class(handle)?;
        let class = self.bound.class().ok_or(Error::InvalidOperation)?;
        let description = &class.class.parameters[parameter];
        let components = description.components as usize;
        let write = |block: &Block, current: &mut Vec<f32>| {
            let slot = block.slot(parameter).ok_or(Error::InvalidOperation)?;
            let value = given.floats(components)?;
            current[slot.offset..slot.offset + components].copy_from_slice(&value[..components]);
            Ok(())
        };
        match description.rate {
            ParameterRate::Triangle => {
                let class = class.clone();
                write(&class.triangle, &mut self.bound.triangle)
            }
            ParameterRate::Vertex => {
                let class = class.clone();
                write(&class.vertex, &mut self.bound.vertex)
            }
            ParameterRate::Shader => {
                let value = match description.kind {
                    ParameterType::Float => {
                        ParameterValue::Floats(given.floats(components)?[..components].to_vec())
                    }
                    ParameterType::Texture => ParameterValue::Texture(given.texture()?),
                };
                let shader = self.bound.shader().and_then(|id| self.shaders.get_mut(id));
                shader.ok_or(Error::InvalidOperation)?.values[parameter] = value;
                Ok(())
            }
        }
    }

    /// rtGetParameterfv: passes the numbers that the next call would capture to `write`.
    pub fn get_parameter(&self, handle: u32, write: Option<Writer<'_, f32>>) -> Result<()> {
        self.outside_block()?;
        let write = not_null(write)?;
        let Handle { parameter, .. } = self.handle_of_bound_class(handle)?;
        let class = self.bound.class().ok_or(Error::InvalidOperation)?;
        let varying = |block: &Block, current: &[f32]| {
            let slot = block.slot(parameter)?;
            current.get(slot.offset..slot.offset + slot.components).map(<[f32]>::to_vec)
        };
        let values = match class.class.parameters[parameter].rate {
            ParameterRate::Triangle => varying(&class.triangle, &self.bound.triangle),
            ParameterRate::Vertex => varying(&class.vertex, &self.bound.vertex),
            ParameterRate::Shader => {
                let shader = self.bound.shader().and_then(|id| self.shaders.get(id));
                shader.map(|shader| match &shader.values[parameter] {
                    ParameterValue::Floats(v) => v.clone(),
                    ParameterValue::Texture(id) => vec![*id as f32],
                })
            }
        };
        write(&values.ok_or(Error::InvalidOperation)?);
        Ok(())
    }

    /// What a handle names, if it is of the bound class.
    fn handle_of_bound_class(&self, handle: u32) -> Result<Handle> {
        let handle = self.classes.handle(handle)?;
        if self.bound.class_id() == Some(handle.class) { Ok(handle) } else { Err(Error::InvalidOperation) }
    }
}
