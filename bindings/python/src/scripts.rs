// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders in the shading language, from arguments: a file or source text, and values of parameters.
//! Source: original. Proof: `tests/test_shaders.py`.

use std::path::{Path, PathBuf};

use gnurt::osl::{Access, ParameterValue, Script};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::given::Given;

/// The shader that is given, if one is.
pub(crate) fn script(given: &mut Given) -> PyResult<Option<Script>> {
    let (shader, parameters) = (given.get("shader")?, given.get("parameters")?);
    let Some(shader) = shader else {
        return match parameters {
            None => Ok(None),
            Some(_) => Err(PyValueError::new_err("parameters: are those of a shader; give shader=, too")),
        };
    };
    let access = Access::default();
    let made = match shader.extract::<String>() {
        // No shader is without a body.
        Ok(text) if text.contains('{') => Script::from_text(Path::new("shader.osl"), &text, &access),
        _ => match shader.extract::<PathBuf>() {
            Ok(path) => Script::open(&path, &access),
            Err(_) => return Err(PyTypeError::new_err("shader: expected a file, or source text")),
        },
    };
    let mut script = made.map_err(|why| PyValueError::new_err(format!("shader: {why}")))?;
    let Some(parameters) = parameters else { return Ok(Some(script)) };
    let parameters = parameters
        .cast_into::<PyDict>()
        .map_err(|_| PyTypeError::new_err("parameters: expected a dict of names and values"))?;
    for (name, given) in parameters {
        let name: String = name.extract().map_err(|_| PyTypeError::new_err("parameters: names are texts"))?;
        let value = value(&given).ok_or_else(|| {
            PyTypeError::new_err(format!(
                "parameters: '{name}': expected a number, a text, or several of them, not {given}"
            ))
        })?;
        script.set(&name, &value).map_err(|why| PyValueError::new_err(format!("parameters: {why}")))?;
    }
    Ok(Some(script))
}

fn value(given: &Bound<'_, PyAny>) -> Option<ParameterValue> {
    if let Ok(text) = given.extract() {
        return Some(ParameterValue::Texts(vec![text]));
    }
    if let Ok(number) = given.extract() {
        return Some(ParameterValue::Ints(vec![number]));
    }
    if let Ok(number) = given.extract() {
        return Some(ParameterValue::Floats(vec![number]));
    }
    let all: Vec<Bound<'_, PyAny>> = given.try_iter().ok()?.collect::<PyResult<_>>().ok()?;
    list(&all)
        .map(ParameterValue::Ints)
        .or_else(|| list(&all).map(ParameterValue::Floats))
        .or_else(|| list(&all).map(ParameterValue::Texts))
}

fn list<'a, 'py, T: for<'b> FromPyObject<'b, 'py>>(all: &'a [Bound<'py, PyAny>]) -> Option<Vec<T>> {
    all.iter().map(|item| item.extract().ok()).collect()
}
