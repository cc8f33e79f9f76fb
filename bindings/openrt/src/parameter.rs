// SPDX-License-Identifier: GPL-3.0-or-later
//! Setting and reading shader parameters at their three rates (rtParameter*, rtGetParameterfv).
//! Source: \[DWBS03\]; the paper's Figure 1 (one family of calls for all rates).
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::ffi::CStr;

use gnurt::shading::classes::ParameterRate;

use crate::class::{DataType, Parameter};
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
    Double(f64),
    /// rtParameterRaw.
    Bytes(&'a [u8]),
    /// rtParameterString.
    String(&'a CStr),
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

    /// The floats of a parameter that varies, in the front of the result.
    fn numbers(self, parameter: &Parameter) -> Result<[f32; MAX_COMPONENTS]> {
        if parameter.kind == DataType::F32 {
            return self.floats(parameter.count);
        }
        let (bytes, size) = (self.bytes(parameter)?, parameter.kind.size());
        let mut floats = [0.0; MAX_COMPONENTS];
        for (float, bytes) in floats.iter_mut().zip(bytes.chunks_exact(size)) {
            *float = parameter.kind.decode(bytes) as f32;
        }
        Ok(floats)
    }

    /// The bytes of a parameter in a plugin's block.
    fn bytes(self, parameter: &Parameter) -> Result<Vec<u8>> {
        let Parameter { kind, count, .. } = *parameter;
        match self {
            Given::Floats(v) if kind == DataType::F32 && v.len() == count => {
                Ok(v.iter().flat_map(|x| x.to_ne_bytes()).collect())
            }
            Given::Ints(v) if kind.is_integer() && v.len() == count => {
                let bytes = |&value: &i32| kind.encode_integer(value).ok_or(Error::InvalidValue);
                Ok(v.iter().map(bytes).collect::<Result<Vec<_>>>()?.concat())
            }
            Given::Double(x) if kind == DataType::F64 && count == 1 => Ok(x.to_ne_bytes().to_vec()),
            Given::Bytes(v) if kind != DataType::Text && v.len() == count * kind.size() => Ok(v.to_vec()),
            _ => Err(Error::InvalidOperation),
        }
    }

    /// The single integer of a built-in class.
    fn integer(self) -> Result<i32> {
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
        let class = self.bound.class().ok_or(Error::InvalidOperation)?.clone();
        let description = &class.parameters[parameter];
        let components = description.count;
        let write = |block: &Block, current: &mut Vec<f32>| {
            let slot = block.slot(parameter).ok_or(Error::InvalidOperation)?;
            let value = given.numbers(description)?;
            current[slot.offset..slot.offset + components].copy_from_slice(&value[..components]);
            Ok(())
        };
        match description.rate {
            ParameterRate::Triangle => write(&class.triangle, &mut self.bound.triangle),
            ParameterRate::Vertex => write(&class.vertex, &mut self.bound.vertex),
            ParameterRate::Shader => {
                let shader = self.bound.shader().and_then(|id| self.shaders.get_mut(id));
                let shader = shader.ok_or(Error::InvalidOperation)?;
                if let Some(block) = &shader.block {
                    match given {
                        Given::String(text) if description.kind == DataType::Text => {
                            block.write_text(parameter, text);
                        }
                        _ => block.write(parameter, &given.bytes(description)?),
                    }
                    return Ok(());
                }
                shader.values[parameter] = match description.kind {
                    DataType::F32 => ParameterValue::Floats(given.floats(components)?[..components].to_vec()),
                    _ => ParameterValue::Integer(given.integer()?),
                };
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
        let description = &class.parameters[parameter];
        if description.kind == DataType::Text {
            return Err(Error::InvalidOperation);
        }
        let values = match description.rate {
            ParameterRate::Triangle => varying(&class.triangle, &self.bound.triangle),
            ParameterRate::Vertex => varying(&class.vertex, &self.bound.vertex),
            ParameterRate::Shader => {
                let shader = self.bound.shader().and_then(|id| self.shaders.get(id));
                shader.map(|shader| match (&shader.block, shader.values.get(parameter)) {
                    (Some(block), _) => block.numbers(parameter),
                    (None, Some(ParameterValue::Floats(v))) => v.clone(),
                    (None, Some(ParameterValue::Integer(id))) => vec![*id as f32],
                    (None, None) => Vec::new(),
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
