// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders in the shading language, from arguments: a file or source text, and values of parameters.
//! Tests: `tests/test_shaders.py`.

use std::path::{Path, PathBuf};

use gnurt::osl::{Access, ParameterValue, Script};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::given::Given;
use crate::textures::{Pictures, named};

/// The shader that is given, if one is.
pub(crate) fn script(given: &mut Given, pictures: &dyn Pictures) -> PyResult<Option<Script>> {
    let textures = given.get("textures")?;
    let access = Access { pictures: named(textures.as_ref(), pictures)?, ..Access::default() };
    match script_named(given, "shader", "parameters", &access)? {
        None if textures.is_some() => {
            Err(PyValueError::new_err("textures: are those of a shader; give shader=, too"))
        }
        script => Ok(script),
    }
}

/// The same by the names of two other arguments.
pub(crate) fn script_named(
    given: &mut Given,
    of_shader: &'static str,
    of_parameters: &'static str,
    access: &Access,
) -> PyResult<Option<Script>> {
    let (shader, parameters) = (given.get(of_shader)?, given.get(of_parameters)?);
    let Some(shader) = shader else {
        return match parameters {
            None => Ok(None),
            Some(_) => Err(PyValueError::new_err(format!(
                "{of_parameters}: are those of a shader; give {of_shader}=, too"
            ))),
        };
    };
    // Other threads of the program run while it is compiled.
    let py = shader.py();
    let made = match shader.extract::<String>() {
        // Neither is a path.
        Ok(text) if text.contains("<materialx") => {
            py.detach(|| Script::from_text(Path::new("shader.mtlx"), &text, access))
        }
        // No shader is without a body.
        Ok(text) if text.contains('{') => {
            py.detach(|| Script::from_text(Path::new("shader.osl"), &text, access))
        }
        _ => match shader.extract::<PathBuf>() {
            Ok(path) => py.detach(|| Script::open(&path, access)),
            Err(_) => {
                return Err(PyTypeError::new_err(format!("{of_shader}: expected a file, or source text")));
            }
        },
    };
    let mut script = made.map_err(|why| PyValueError::new_err(format!("{of_shader}: {why}")))?;
    let Some(parameters) = parameters else { return Ok(Some(script)) };
    let no_dict = || PyTypeError::new_err(format!("{of_parameters}: expected a dict of names and values"));
    let parameters = parameters.cast_into::<PyDict>().map_err(|_| no_dict())?;
    for (name, given) in parameters {
        let no_name = |_| PyTypeError::new_err(format!("{of_parameters}: names are texts"));
        let name: String = name.extract().map_err(no_name)?;
        let value = value(&given).ok_or_else(|| {
            PyTypeError::new_err(format!(
                "{of_parameters}: '{name}': expected a number, a text, or several of them, not {given}"
            ))
        })?;
        script.set(&name, &value).map_err(|why| PyValueError::new_err(format!("{of_parameters}: {why}")))?;
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
