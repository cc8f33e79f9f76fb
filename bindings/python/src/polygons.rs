// SPDX-License-Identifier: GPL-3.0-or-later
//! Quads as triangles by Blender's rule, so that both engines show the same ones. Files' polygons are cut by
//! `gnurt::scene::io::reader::Cutter`, whose concave ones have other triangles. Tests: `tests/test_arrays.py`.

use pyo3::buffer::Element;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays::{New, of_type};
use crate::ffi_arrays::Rows;

/// Triangles of polygons with three or four corners: the corners of each, (n, 3), their vertices, (n, 3), and the polygon of
/// each, (n,). `corners` are the vertices of all polygons, one after the other, `totals` how many each has. A quad is divided
/// between its first and third corner, or between the others where that would fold it.
///
/// `None` if a polygon has fewer corners or more. Raises ValueError if the lists do not fit each other.
#[pyfunction]
pub(crate) fn _divide_polygons<'py>(
    py: Python<'py>,
    vertices: &Bound<'py, PyAny>,
    corners: &Bound<'py, PyAny>,
    totals: &Bound<'py, PyAny>,
) -> PyResult<Option<Bound<'py, PyTuple>>> {
    let vertices = rows::<f32>("vertices", vertices, "float32", 3)?;
    let corners = rows::<i32>("corners", corners, "int32", 1)?;
    let totals = rows::<i32>("totals", totals, "int32", 1)?;
    let (points, corners, totals) = (vertices.all().as_chunks::<3>().0, corners.all(), totals.all());
    if totals.iter().any(|total| !(3..=4).contains(total)) {
        return Ok(None);
    }
    if totals.iter().map(|&total| total as usize).sum::<usize>() != corners.len() {
        return Err(PyValueError::new_err("totals: their sum is not the number of corners"));
    }
    let is_known = |corner: i32| usize::try_from(corner).is_ok_and(|corner| corner < points.len());
    if let Some(wrong) = corners.iter().find(|&&corner| !is_known(corner)) {
        return Err(PyValueError::new_err(format!("corners: there is no vertex {wrong}")));
    }
    let count = corners.len() - 2 * totals.len();
    let mut loops = New::<u32>::empty(py, count, 3)?;
    let mut faces = New::<u32>::empty(py, count, 3)?;
    let mut polygons = New::<u32>::empty(py, count, 1)?;
    let rows = loops.all().as_chunks_mut::<3>().0.iter_mut();
    let mut rows = rows.zip(faces.all().as_chunks_mut::<3>().0).zip(polygons.all());
    let mut first = 0;
    for (polygon, &total) in totals.iter().enumerate() {
        let of_polygon = &corners[first..first + total as usize];
        let cuts: &[[u32; 3]] = match *of_polygon {
            [a, b, c, d] if folds([a, b, c, d].map(|corner| points[corner as usize])) => {
                &[[0, 1, 3], [1, 2, 3]]
            }
            [_, _, _, _] => &[[0, 1, 2], [0, 2, 3]],
            _ => &[[0, 1, 2]],
        };
        for (cut, ((into, face), of)) in cuts.iter().zip(&mut rows) {
            *into = cut.map(|corner| first as u32 + corner);
            *face = cut.map(|corner| of_polygon[corner as usize] as u32);
            *of = polygon as u32;
        }
        first += total as usize;
    }
    Ok(Some(PyTuple::new(py, [loops.done(), faces.done(), polygons.done()])?))
}

/// Whether the triangles on both sides of the diagonal from the first corner have opposite sides up.
fn folds([a, b, c, d]: [[f32; 3]; 4]) -> bool {
    let way = |from: [f32; 3], to: [f32; 3]| [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    let cross = |a: [f32; 3], b: [f32; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let across = way(a, c);
    let (first, second) = (cross(way(a, b), across), cross(across, way(a, d)));
    first[0] * second[0] + first[1] * second[1] + first[2] * second[2] < 0.0
}

/// The argument `name`: an array without gaps of a type and a width.
fn rows<T: Element>(name: &str, value: &Bound<'_, PyAny>, dtype: &str, width: usize) -> PyResult<Rows<T>> {
    let found = Rows::<T>::new(&of_type(value, dtype)?)?;
    found
        .filter(|rows| rows.width() == width)
        .ok_or_else(|| PyValueError::new_err(format!("{name}: expected {width} numbers in a row")))
}
