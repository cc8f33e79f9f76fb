// SPDX-License-Identifier: GPL-3.0-or-later
//! Media from arguments: fog, smoke and the contents of bodies; density in arrays or in files of OpenVDB and NanoVDB.
//! Space: arrays fill the unit cube, [x, y, z], which a transform takes to the world. Units: 1 over world units, radiance.
//! Tests: `tests/test_media.py`.

use std::path::PathBuf;
use std::sync::Arc;

use gnurt::scene::medium::{DensityGrid, Extent, Medium, Phase};
use gnurt::scene::volume_cells::VolumeCells;
use gnurt::scene::{Affine, MediumId, Scene};
use gnurt::{Error, VolumeFile};
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{New, array, of_type, transform};
use crate::ffi_arrays::Rows;
use crate::given::Given;
use crate::picture::image_error;

const MOST: f64 = f32::MAX as f64;
/// The largest absolute value of a mean cosine.
const STEEPEST: f64 = 0.999;

fn volume_error(error: &Error) -> PyErr {
    match error {
        Error::Image(error) => image_error(error),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// The number of a medium of a scene.
pub(crate) fn medium_id(scene: &Scene, number: usize) -> PyResult<MediumId> {
    let count = scene.media().len();
    match u32::try_from(number) {
        Ok(id) if number < count => Ok(MediumId(id)),
        _ => Err(PyIndexError::new_err(format!("medium: {number} is out of range; the scene has {count}"))),
    }
}

/// A medium. A file is read here.
pub(crate) fn medium(py: Python<'_>, given: &mut Given) -> PyResult<Medium> {
    let name = given.text("name")?.unwrap_or_default();
    let none = [0.0; 3];
    let coefficients = [given.color("absorption")?, given.color("scattering")?, given.color("emission")?];
    let [absorption, scattering, emission] = coefficients.map(|color| color.unwrap_or(none));
    let cosine = |given: &mut Given, name| -> PyResult<f32> {
        Ok(given.number(name, -STEEPEST, STEEPEST)?.unwrap_or(0.0) as f32)
    };
    let phase = Phase {
        anisotropy: cosine(given, "anisotropy")?,
        second_anisotropy: cosine(given, "second_anisotropy")?,
        second_share: given.number("second_share", 0.0, 1.0)?.unwrap_or(0.0) as f32,
    };
    let grid = grid(py, given)?.map(Arc::new);
    let word = given.text("extent")?;
    let usual = if grid.is_some() { "free" } else { "bodies" };
    let (centre, radius) = (given.numbers("centre")?, given.number("radius", 1e-30, MOST)?);
    let extent = match word.as_deref().unwrap_or(usual) {
        "bodies" => Extent::Bodies,
        "free" if grid.is_some() => Extent::Free,
        "free" => return Err(PyValueError::new_err("extent: 'free' needs density or file")),
        "around" => Extent::Around {
            centre: centre.unwrap_or_default(),
            radius: radius.map_or(f32::INFINITY, |radius| radius as f32),
        },
        other => {
            return Err(PyValueError::new_err(format!(
                "extent: expected bodies, around or free, not '{other}'"
            )));
        }
    };
    if !matches!(extent, Extent::Around { .. }) && (centre.is_some() || radius.is_some()) {
        return Err(PyValueError::new_err("radius: the ball is that of extent='around'"));
    }
    let priority = given.get("priority")?.map(|value| value.extract::<i32>()).transpose();
    let priority = priority.map_err(|_| PyTypeError::new_err("priority: expected a whole number"))?;
    let priority = priority.unwrap_or(0);
    let adds = given.flag("adds")?.unwrap_or(false);
    let medium = Medium { name, absorption, scattering, emission, phase, extent, grid, priority, adds };
    match medium.problem() {
        Some(problem) => Err(PyValueError::new_err(format!("medium: {problem}"))),
        None => Ok(medium),
    }
}

/// Density in an array or a file; `None` if neither is given.
fn grid(py: Python<'_>, given: &mut Given) -> PyResult<Option<DensityGrid>> {
    let (density, glow) = (given.get("density")?, given.get("emission_grid")?);
    let (file, name) = (given.get("file")?, given.text("grid")?);
    let (heat, kelvin) = (given.text("temperature_grid")?, given.number("kelvin", 1e-30, MOST)?);
    if (heat.is_some() && file.is_none()) || (kelvin.is_some() && heat.is_none()) {
        let which =
            if heat.is_some() { "temperature_grid: needs file" } else { "kelvin: needs temperature_grid" };
        return Err(PyValueError::new_err(which));
    }
    let place = given.get("transform")?;
    let place = place.map(|value| transform("transform", &value)).transpose()?;
    let place = place.map_or(Affine::IDENTITY, |columns| Affine { columns });
    match (density, file) {
        (Some(_), Some(_)) => Err(PyValueError::new_err("density: conflicts with file; give one of them")),
        (Some(density), None) => {
            if name.is_some() {
                return Err(PyValueError::new_err("grid: is the name of a grid in a file; give file, too"));
            }
            let (size, density) = cells("density", &density)?;
            let emission = match glow {
                None => Vec::new(),
                Some(glow) => glow_cells(&glow, size)?,
            };
            Ok(Some(DensityGrid { size, density, emission, world_from_unit: place }))
        }
        (None, Some(file)) => {
            let path: PathBuf =
                file.extract().map_err(|_| PyTypeError::new_err("file: expected the path of a file"))?;
            let glow = glow.map(|glow| glow.extract::<String>()).transpose();
            let glow =
                glow.map_err(|_| PyTypeError::new_err("emission_grid: expected a name of the file"))?;
            let mut file = VolumeFile::new(path, name, glow);
            if let Some(heat) = heat {
                file = file.heated(heat, kelvin.unwrap_or(1.0) as f32);
            }
            let mut found = py.detach(|| file.cells()).map_err(|error| volume_error(&error))?;
            found.world_from_unit = place * found.world_from_unit;
            Ok(Some(found))
        }
        (None, None) if glow.is_some() || name.is_some() => {
            let which = if glow.is_some() { "emission_grid" } else { "grid" };
            Err(PyValueError::new_err(format!("{which}: needs density or file")))
        }
        (None, None) => Ok(None),
    }
}

fn shape(array: &Bound<'_, PyAny>) -> PyResult<Vec<usize>> {
    array.getattr("shape")?.extract()
}

/// An array [x, y, z] as cells, x first.
fn cells(name: &str, value: &Bound<'_, PyAny>) -> PyResult<([u32; 3], Vec<f32>)> {
    let array = array(name, value)?;
    let found = shape(&array)?;
    let size: Option<[u32; 3]> = match found[..] {
        [x, y, z] => [x, y, z].map(|n| u32::try_from(n).unwrap_or(0)).into(),
        _ => None,
    };
    let Some(size) = size.filter(|size| size.iter().all(|&n| n > 0)) else {
        return Err(PyValueError::new_err(format!("{name}: expected shape (x, y, z), not {found:?}")));
    };
    let flat = array.call_method1("ravel", ("F",))?;
    Ok((size, numbers(name, &flat)?))
}

/// Factors of emission, one or three for each cell.
fn glow_cells(value: &Bound<'_, PyAny>, size: [u32; 3]) -> PyResult<Vec<[f32; 3]>> {
    const NAME: &str = "emission_grid";
    let array = array(NAME, value)?;
    let found = shape(&array)?;
    let expected = size.map(|n| n as usize);
    if found[..] == expected {
        let flat = numbers(NAME, &array.call_method1("ravel", ("F",))?)?;
        return Ok(flat.into_iter().map(|x| [x; 3]).collect());
    }
    if found[..] != [expected[0], expected[1], expected[2], 3] {
        return Err(PyValueError::new_err(format!(
            "{NAME}: expected the shape of density, with or without three numbers of each cell, not {found:?}"
        )));
    }
    let flat = array.call_method1("transpose", (2, 1, 0, 3))?.call_method1("ravel", ())?;
    Ok(numbers(NAME, &flat)?.as_chunks::<3>().0.to_vec())
}

/// Finite numbers from 0 on of an array of one dimension.
fn numbers(name: &str, flat: &Bound<'_, PyAny>) -> PyResult<Vec<f32>> {
    let flat = of_type(flat, "float32")
        .map_err(|error| PyTypeError::new_err(format!("{name}: expected numbers ({error})")))?;
    let rows = Rows::<f32>::new(&flat)?;
    let values = rows.as_ref().map(Rows::all).unwrap_or_default();
    match values.iter().find(|x| !(x.is_finite() && **x >= 0.0)) {
        Some(bad) => {
            Err(PyValueError::new_err(format!("{name}: expected finite numbers from 0 on, not {bad}")))
        }
        None => Ok(values.to_vec()),
    }
}

/// The grids of a file of OpenVDB or NanoVDB: a dict of names, each with an array [x, y, z] and the transform from the unit cube.
#[pyfunction]
#[pyo3(signature = (path, names=None))]
pub(crate) fn _read_volume<'py>(
    py: Python<'py>,
    path: PathBuf,
    names: Option<Vec<String>>,
) -> PyResult<Bound<'py, PyDict>> {
    let found =
        py.detach(|| gnurt::read_volume(&path, names.as_deref())).map_err(|error| volume_error(&error))?;
    let all = PyDict::new(py);
    for VolumeCells { name, size, channels, values, world_from_unit } in found {
        if all.contains(&name)? {
            continue;
        }
        let [x, y, z] = size.map(|n| n as usize);
        let mut array = New::<f32>::empty(py, values.len(), 1)?;
        array.all().copy_from_slice(&values);
        let array = array.done().into_bound(py);
        let array = match channels {
            1 => array.call_method1("reshape", (z, y, x))?.call_method1("transpose", (2, 1, 0))?,
            _ => {
                array.call_method1("reshape", (z, y, x, channels))?.call_method1("transpose", (2, 1, 0, 3))?
            }
        };
        let [a, b, c, d] = world_from_unit.columns;
        let row = |k: usize| [a[k], b[k], c[k], d[k]];
        let rows = vec![row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]];
        let matrix = crate::arrays::numpy(py)?.call_method1("array", (rows,))?;
        all.set_item(name, (array, matrix))?;
    }
    Ok(all)
}
