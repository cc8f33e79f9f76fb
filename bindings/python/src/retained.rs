// SPDX-License-Identifier: GPL-3.0-or-later
//! Arrays of a program that a ray scene keeps: checked, of one type, without gaps, and not to be written to.
//! Tests: `tests/test_arrays.py`, `tests/test_primitives.py`.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{Numbers, array, numpy, of_type};
use crate::ffi_arrays::Rows;

/// An array for keeping; a copy if `copy`, or if it was converted from the one that was given.
pub(crate) fn retained(
    array: &Bound<'_, PyAny>,
    given: &Bound<'_, PyAny>,
    copy: bool,
) -> PyResult<Py<PyAny>> {
    // A converted array is already a copy.
    let is_theirs = || numpy(array.py())?.call_method1("may_share_memory", (array, given))?.is_truthy();
    let ours = if copy && is_theirs()? { array.call_method0("copy")? } else { array.clone() };
    // Receivers of `__getstate__` cannot change checked arrays.
    let view = ours.call_method0("view")?;
    view.call_method1("setflags", (false,))?;
    Ok(view.unbind())
}

/// Numbers of the argument `name` in rows of `width`, one for each vertex if their number is known.
pub(crate) fn rows(
    name: &str,
    value: &Bound<'_, PyAny>,
    width: usize,
    vertices: Option<usize>,
    dtype: &str,
    copy: bool,
) -> PyResult<Py<PyAny>> {
    let count = Numbers::new(name, value, Some(width))?.count();
    if let Some(vertices) = vertices.filter(|vertices| *vertices != count) {
        return Err(PyValueError::new_err(format!(
            "{name}: expected shape ({vertices}, {width}), a row for each vertex, not ({count}, {width})"
        )));
    }
    let given = array(name, value)?;
    retained(&of_type(&given, dtype)?, &given, copy)
}

/// A radius for each vertex, float32; one number is that of all.
pub(crate) fn radii(value: &Bound<'_, PyAny>, vertices: usize, copy: bool) -> PyResult<Py<PyAny>> {
    let py = value.py();
    let mut given = array("radii", value)?;
    if given.getattr("ndim")?.extract::<usize>()? == 0 {
        given = numpy(py)?.call_method1("full", (vertices, given))?;
    }
    let count = Numbers::new("radii", &given, None)?.count();
    if count != vertices {
        return Err(PyValueError::new_err(format!(
            "radii: expected one number or shape ({vertices},), one for each vertex, not ({count},)"
        )));
    }
    let floats = of_type(&given, "float32")?;
    let all = Rows::<f32>::new(&floats)?.ok_or_else(|| PyValueError::new_err("radii: has gaps"))?;
    if let Some((row, bad)) = all.all().iter().enumerate().find(|(_, r)| !(r.is_finite() && **r >= 0.0)) {
        return Err(PyValueError::new_err(format!(
            "radii: row {row} is {bad}; expected finite numbers from 0 on"
        )));
    }
    retained(&floats, &given, copy)
}

/// Whole numbers in rows of `width`, or in one dimension where that is `None`.
pub(crate) fn whole<'py>(
    name: &str,
    found: &Bound<'py, PyAny>,
    width: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let (kind, shape): (String, Vec<usize>) =
        (found.getattr("dtype")?.getattr("kind")?.extract()?, found.getattr("shape")?.extract()?);
    // An empty list is of floats for numpy.
    if !matches!(kind.as_str(), "i" | "u") && shape != [0] {
        let dtype = found.getattr("dtype")?;
        return Err(PyTypeError::new_err(format!("{name}: expected whole numbers, not {dtype}")));
    }
    let fits = match width {
        Some(width) => shape.len() == 2 && shape[1] == width,
        None => shape.len() == 1,
    };
    if !fits {
        let shape = found.getattr("shape")?;
        let expected = width.map_or("(m,)".into(), |width| format!("(m, {width})"));
        return Err(PyValueError::new_err(format!("{name}: expected shape {expected}, not {shape}")));
    }
    Ok(found.clone())
}
