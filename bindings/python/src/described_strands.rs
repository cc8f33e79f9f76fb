// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves and spheres of a scene from arrays with a row for each vertex. Tests: `tests/test_strands.py`.

use std::str::FromStr;

use gnurt::scene::{CurveBasis, CurveForm, Curves, Mesh as SceneMesh, Primitives};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{Numbers, transform};
use crate::described_mesh::{DescribedMesh, vertex_attributes};
use crate::given::Given;

struct Basis(CurveBasis);

impl FromStr for Basis {
    type Err = &'static str;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        Ok(Self(match word {
            "linear" => CurveBasis::Linear,
            "bezier" => CurveBasis::Bezier,
            "bspline" => CurveBasis::BSpline,
            "catmull-rom" => CurveBasis::CatmullRom,
            _ => return Err("expected \"linear\", \"bezier\", \"bspline\" or \"catmull-rom\""),
        }))
    }
}

struct Form(CurveForm);

impl FromStr for Form {
    type Err = &'static str;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        Ok(Self(match word {
            "flat" => CurveForm::Flat,
            "round" => CurveForm::Round,
            "oriented" => CurveForm::Oriented,
            _ => return Err("expected \"flat\", \"round\" or \"oriented\""),
        }))
    }
}

/// Rows of one array, one for each vertex.
fn rows<const N: usize>(given: &mut Given, name: &'static str, count: usize) -> PyResult<Vec<[f32; N]>> {
    let Some(value) = given.get(name)? else { return Ok(Vec::new()) };
    let numbers = Numbers::new(name, &value, Some(N))?;
    if numbers.count() != count {
        let found = numbers.count();
        return Err(PyValueError::new_err(format!(
            "{name}: expected shape ({count}, {N}), not ({found}, {N})"
        )));
    }
    Ok(numbers.singles::<N>())
}

/// A radius for each vertex, or one for all.
fn radii(given: &mut Given, count: usize) -> PyResult<Vec<f32>> {
    let value = given.get("radii")?.ok_or_else(|| PyTypeError::new_err("radii: is missing"))?;
    let radii = match value.extract::<f32>() {
        Ok(one) => vec![one; count],
        Err(_) => {
            Numbers::new("radii", &value, None)?.singles::<1>().into_iter().map(|[radius]| radius).collect()
        }
    };
    if radii.len() != count {
        let found = radii.len();
        return Err(PyValueError::new_err(format!(
            "radii: expected one number or shape ({count},), not ({found},)"
        )));
    }
    match radii.iter().find(|radius| !(radius.is_finite() && **radius >= 0.0)) {
        Some(bad) => {
            Err(PyValueError::new_err(format!("radii: expected finite numbers from 0 on, not {bad}")))
        }
        None => Ok(radii),
    }
}

/// How many vertices each strand has; by default all are one.
fn counts(given: &mut Given, vertices: usize) -> PyResult<Vec<usize>> {
    let Some(value) = given.get("counts")? else { return Ok(vec![vertices]) };
    let counts: Vec<i64> = value
        .try_iter()
        .and_then(|all| all.map(|count| count?.extract()).collect())
        .map_err(|_| PyTypeError::new_err("counts: expected whole numbers, one for each strand"))?;
    let all: Option<i64> =
        counts.iter().try_fold(0_i64, |sum, &count| sum.checked_add(count).filter(|_| count >= 0));
    if all != i64::try_from(vertices).ok() {
        return Err(PyValueError::new_err(format!(
            "counts: expected numbers from 0 on whose sum is {vertices}, the number of vertices"
        )));
    }
    Ok(counts.into_iter().map(|count| count as usize).collect())
}

/// Curves, or spheres, by the arguments.
pub(crate) fn strands(given: &mut Given, has_curves: bool) -> PyResult<DescribedMesh> {
    let vertices = given.get("vertices")?.ok_or_else(|| PyTypeError::new_err("vertices: is missing"))?;
    let positions = Numbers::new("vertices", &vertices, Some(3))?.singles::<3>();
    let count = positions.len();
    let radii = radii(given, count)?;
    let mut mesh = SceneMesh { positions, ..SceneMesh::default() };
    mesh.primitives = if has_curves {
        let basis = given.choice::<Basis>("basis")?.map_or(CurveBasis::BSpline, |basis| basis.0);
        let form = given.choice::<Form>("form")?.map_or(CurveForm::Round, |form| form.0);
        let counts = counts(given, count)?;
        mesh.normals = rows::<3>(given, "normals", count)?;
        if (form == CurveForm::Oriented) == mesh.normals.is_empty() {
            return Err(PyValueError::new_err("normals: go with form=\"oriented\", and are needed there"));
        }
        Primitives::Curves(Box::new(Curves { radii, ..Curves::of_strands(basis, form, counts) }))
    } else {
        Primitives::Spheres(radii)
    };
    mesh.texcoords = rows::<2>(given, "texcoords", count)?;
    mesh.colors = rows::<4>(given, "colors", count)?;
    mesh.attributes = vertex_attributes(given, count)?;
    let name = given.text("name")?.unwrap_or_default();
    mesh.name.clone_from(&name);
    let materials = given.whole("material", 0, u64::from(u32::MAX))?.map(|number| vec![number as usize]);
    let placement = given.get("transform")?.map(|value| transform("transform", &value)).transpose()?;
    mesh.check().map_err(PyValueError::new_err)?;
    Ok(DescribedMesh { name, parts: vec![(0, mesh)], materials, placement })
}
