// SPDX-License-Identifier: GPL-3.0-or-later
//! Hashes of arrays, by which Blender's persistent data tells what has changed. Source: XXH3. Tests: `tests/test_arrays.py`.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use twox_hash::XxHash3_128;

use crate::ffi_arrays::Rows;

/// A hash of an array's numbers, 16 bytes: XXH3. Not meant against forgery.
#[pyfunction]
pub(crate) fn _hash_array<'py>(py: Python<'py>, array: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyBytes>> {
    let bytes =
        Rows::<u8>::new(array)?.ok_or_else(|| PyTypeError::new_err("array: expected bytes without gaps"))?;
    Ok(PyBytes::new(py, &XxHash3_128::oneshot(bytes.all()).to_le_bytes()))
}
