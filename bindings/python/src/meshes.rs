// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes of a ray scene, by their numbers, which stay when others are removed.
//! Invariant: corner numbers are in range. Tests: `tests/test_scene.py`.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{Numbers, array, numpy, of_type, transform};
use crate::ffi_arrays::Rows;

/// Triangles. The arrays are stored, so that they can be pickled and built again.
pub(crate) struct Mesh {
    /// float32, or float64 in a scene of that; (n, 3), without gaps.
    pub(crate) vertices: Py<PyAny>,
    /// uint32, (m, 3), without gaps.
    pub(crate) faces: Py<PyAny>,
    /// Columns of an affine map.
    pub(crate) placement: Option<[[f64; 3]; 4]>,
    /// Which edit of the scene gave it these vertices; edits count from 1.
    pub(crate) shape: u64,
    /// Which edit gave it these vertices or this transform.
    pub(crate) state: u64,
}

/// Rows of three numbers of a stored array.
pub(crate) fn triples<T: pyo3::buffer::Element + Copy>(array: &Bound<'_, PyAny>) -> PyResult<Vec<[T; 3]>> {
    let rows = Rows::<T>::new(array)?.ok_or_else(|| PyValueError::new_err("an array has gaps"))?;
    Ok(rows.all().chunks_exact(3).map(|row| [row[0], row[1], row[2]]).collect())
}

impl Mesh {
    /// Checked. `copy` is for arrays that need no conversion.
    pub(crate) fn new(
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        placement: Option<&Bound<'_, PyAny>>,
        copy: bool,
        dtype: &str,
    ) -> PyResult<Self> {
        let count = Numbers::new("vertices", vertices, Some(3))?.count();
        let retained = |array: &Bound<'_, PyAny>, given: &Bound<'_, PyAny>| -> PyResult<Py<PyAny>> {
            // A converted array is already a copy.
            let is_theirs =
                || numpy(array.py())?.call_method1("may_share_memory", (array, given))?.is_truthy();
            let ours = if copy && is_theirs()? { array.call_method0("copy")? } else { array.clone() };
            // Receivers of `__getstate__` cannot change checked arrays.
            let view = ours.call_method0("view")?;
            view.call_method1("setflags", (false,))?;
            Ok(view.unbind())
        };
        let (given, found) = (array("vertices", vertices)?, array("faces", faces)?);
        let (kind, shape): (String, Vec<usize>) =
            (found.getattr("dtype")?.getattr("kind")?.extract()?, found.getattr("shape")?.extract()?);
        if !matches!(kind.as_str(), "i" | "u") {
            let dtype = found.getattr("dtype")?;
            return Err(PyTypeError::new_err(format!("faces: expected whole numbers, not {dtype}")));
        }
        if !matches!(shape[..], [_, 3]) {
            let shape = found.getattr("shape")?;
            return Err(PyValueError::new_err(format!("faces: expected shape (m, 3), not {shape}")));
        }
        let wide = of_type(&found, "int64")?;
        let rows = Rows::<i64>::new(&wide)?.ok_or_else(|| PyValueError::new_err("faces: has gaps"))?;
        if let Some(bad) = rows.all().iter().position(|&corner| corner < 0 || corner as u64 >= count as u64) {
            let (row, corner) = (bad / 3, rows.all()[bad]);
            return Err(PyValueError::new_err(format!(
                "faces: row {row} names vertex {corner}, and there are {count} vertices, from 0 on"
            )));
        }
        Ok(Self {
            vertices: retained(&of_type(&given, dtype)?, &given)?,
            faces: retained(&of_type(&found, "uint32")?, &found)?,
            placement: placement.map(|placement| transform("transform", placement)).transpose()?,
            shape: 0,
            state: 0,
        })
    }

    /// The same arrays.
    pub(crate) fn shared(&self, py: Python<'_>) -> Self {
        Self { vertices: self.vertices.clone_ref(py), faces: self.faces.clone_ref(py), ..*self }
    }

    /// Other vertices for it, checked: as many.
    pub(crate) fn moved(
        &self,
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        copy: bool,
        dtype: &str,
    ) -> PyResult<Py<PyAny>> {
        let new = Self::new(vertices, self.faces.bind(py), None, copy, dtype)?;
        let count = |mesh: &Self| mesh.vertices.bind(py).len();
        if count(&new)? != count(self)? {
            let (expected, found) = (count(self)?, count(&new)?);
            return Err(PyValueError::new_err(format!(
                "vertices: expected shape ({expected}, 3) as before, not ({found}, 3)"
            )));
        }
        Ok(new.vertices)
    }

    pub(crate) fn positions(&self, py: Python<'_>) -> PyResult<Vec<[f32; 3]>> {
        triples(self.vertices.bind(py))
    }

    pub(crate) fn indices(&self, py: Python<'_>) -> PyResult<Vec<[u32; 3]>> {
        triples(self.faces.bind(py))
    }
}

/// A transformed point.
pub(crate) fn carried([x, y, z, w]: &[[f64; 3]; 4], point: [f32; 3]) -> [f32; 3] {
    let [a, b, c] = point.map(f64::from);
    [0, 1, 2].map(|k| (x[k] * a + y[k] * b + z[k] * c + w[k]) as f32)
}
