// SPDX-License-Identifier: GPL-3.0-or-later
//! Setting and reading shader parameters at their three rates (rtParameter*, rtGetParameterfv).
//! Source: \[DWBS03\]; the paper's Figure 1 (one family of calls for all rates).
//! Tests: tests/c/scene.c, tests/c/errors.c.

use gnurt::shading::classes::ParameterRate;
use gnurt_plugins::host::DataType;

use crate::context::Context;
use crate::state::error::{Error, Result, Writer, not_null};
use crate::state::parameter::GivenValue;
use crate::state::shader_class::{Handle, Layout};
use crate::state::value::ParameterValue;

impl Context {
    /// rtParameter*: legal everywhere. `given` is `None` for a null pointer.
    pub(crate) fn set_parameter(&mut self, handle: u32, given: Option<GivenValue<'_>>) -> Result<()> {
        let given = not_null(given)?;
        let Handle { parameter, .. } = self.handle_of_bound_class(handle)?;
        let class = self.bound.class().ok_or(Error::InvalidOperation)?.clone();
        let description = &class.parameters[parameter];
        let components = description.count;
        let write = |layout: &Layout, current: &mut Vec<f32>| {
            let slot = layout.slot(parameter).ok_or(Error::InvalidOperation)?;
            let value = given.numbers(description)?;
            current[slot.offset..slot.offset + components].copy_from_slice(&value[..components]);
            Ok(())
        };
        match description.rate {
            ParameterRate::Triangle => write(&class.triangle, &mut self.bound.values.triangle),
            ParameterRate::Vertex => write(&class.vertex, &mut self.bound.values.vertex),
            ParameterRate::Shader => {
                let shader = self.bound.shader().and_then(|id| self.shaders.get_mut(id));
                let shader = shader.ok_or(Error::InvalidOperation)?;
                if let Some(block) = &shader.block {
                    match given {
                        GivenValue::String(text) if description.kind == DataType::Text => {
                            block.write_text(parameter, text);
                        }
                        _ => block.write(parameter, &given.bytes(description)?),
                    }
                    return Ok(());
                }
                shader.values[parameter] = match description.kind {
                    DataType::F32 => ParameterValue::Floats(given.floats(components)?[..components].to_vec()),
                    DataType::Text => ParameterValue::Text(Some(given.text()?)),
                    _ => ParameterValue::Integer(given.integer()?),
                };
                Ok(())
            }
        }
    }

    /// rtGetParameterfv: passes the numbers that the next call would capture to `write`.
    pub(crate) fn get_parameter(&self, handle: u32, write: Option<Writer<'_, f32>>) -> Result<()> {
        self.outside_block()?;
        let write = not_null(write)?;
        let Handle { parameter, .. } = self.handle_of_bound_class(handle)?;
        let class = self.bound.class().ok_or(Error::InvalidOperation)?;
        let varying = |layout: &Layout, current: &[f32]| {
            let slot = layout.slot(parameter)?;
            current.get(slot.offset..slot.offset + slot.components).map(<[f32]>::to_vec)
        };
        let description = &class.parameters[parameter];
        if description.kind == DataType::Text {
            return Err(Error::InvalidOperation);
        }
        let values = match description.rate {
            ParameterRate::Triangle => varying(&class.triangle, &self.bound.values.triangle),
            ParameterRate::Vertex => varying(&class.vertex, &self.bound.values.vertex),
            ParameterRate::Shader => {
                let shader = self.bound.shader().and_then(|id| self.shaders.get(id));
                shader.map(|shader| match (&shader.block, shader.values.get(parameter)) {
                    (Some(block), _) => block.numbers(parameter),
                    (None, Some(ParameterValue::Floats(v))) => v.clone(),
                    (None, Some(ParameterValue::Integer(id))) => vec![*id as f32],
                    (None, Some(ParameterValue::Text(_)) | None) => Vec::new(),
                })
            }
        };
        write(&values.ok_or(Error::InvalidOperation)?);
        Ok(())
    }

    /// The handle, if it is of the bound class.
    fn handle_of_bound_class(&self, handle: u32) -> Result<Handle> {
        let handle = self.classes.handle(handle)?;
        if self.bound.class_id() == Some(handle.class) { Ok(handle) } else { Err(Error::InvalidOperation) }
    }
}
