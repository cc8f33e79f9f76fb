// SPDX-License-Identifier: GPL-3.0-or-later
//! The argument of a call for a shader's parameter, as the numbers or bytes of the parameter's type.
//! Source: \[DWBS03\]; the paper's Figure 1 (one family of calls for all rates).
//! Tests: tests/c/scene.c, tests/c/errors.c.

use std::ffi::CStr;

use gnurt_plugins::host::{DataType, Parameter};

use super::error::{Error, Result};

/// The argument of a call.
#[derive(Clone, Copy, Debug)]
pub(crate) enum GivenValue<'a> {
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

impl GivenValue<'_> {
    /// The floats of a parameter with `components` of them, in the front of the result.
    pub(crate) fn floats(self, components: usize) -> Result<[f32; MAX_COMPONENTS]> {
        let mut floats = [0.0; MAX_COMPONENTS];
        match self {
            GivenValue::Floats(v) if v.len() == components => floats[..components].copy_from_slice(v),
            GivenValue::Bytes(bytes) if bytes.len() == 4 * components => {
                for (float, bytes) in floats.iter_mut().zip(bytes.chunks_exact(4)) {
                    *float = f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                }
            }
            _ => return Err(Error::InvalidOperation),
        }
        Ok(floats)
    }

    /// The floats of a parameter that varies, in the front of the result.
    pub(crate) fn numbers(self, parameter: &Parameter) -> Result<[f32; MAX_COMPONENTS]> {
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
    pub(crate) fn bytes(self, parameter: &Parameter) -> Result<Vec<u8>> {
        let Parameter { kind, count, .. } = *parameter;
        match self {
            GivenValue::Floats(v) if kind == DataType::F32 && v.len() == count => {
                Ok(v.iter().flat_map(|x| x.to_ne_bytes()).collect())
            }
            GivenValue::Ints(v) if kind.is_integer() && v.len() == count => {
                let bytes = |&value: &i32| kind.encode_integer(value).ok_or(Error::InvalidValue);
                Ok(v.iter().map(bytes).collect::<Result<Vec<_>>>()?.concat())
            }
            GivenValue::Double(x) if kind == DataType::F64 && count == 1 => Ok(x.to_ne_bytes().to_vec()),
            GivenValue::Bytes(v) if kind != DataType::Text && v.len() == count * kind.size() => {
                Ok(v.to_vec())
            }
            _ => Err(Error::InvalidOperation),
        }
    }

    /// The text of a script's parameter.
    pub(crate) fn text(self) -> Result<String> {
        match self {
            GivenValue::String(text) => Ok(text.to_string_lossy().into_owned()),
            _ => Err(Error::InvalidOperation),
        }
    }

    /// The single integer of a built-in class.
    pub(crate) fn integer(self) -> Result<i32> {
        match self {
            GivenValue::Ints(&[id]) => Ok(id),
            GivenValue::Bytes(&[a, b, c, d]) => Ok(i32::from_ne_bytes([a, b, c, d])),
            _ => Err(Error::InvalidOperation),
        }
    }
}
