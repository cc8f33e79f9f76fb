// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt.Scene` for pickle: the bytes of its description, and its shaders as the texts of their files and values.
//! A scene of a pickle gives the same pictures, also where those files have changed. Files that shaders read while they run,
//! such as pictures by name, are read again. Pickles are for processes of one version. Tests: `tests/test_scene_pickles.py`.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use gnurt::image::Texels;
use gnurt::osl::{ParameterValue, Recipe, Script};
use gnurt::scene::snapshot;
use gnurt::shading::texture::TextureSampler;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::stage::{Parts, Stage};

/// A shader as Python's values: path, texts by paths, folders of included files, folder of all files, values by names,
/// numbers of pictures by names.
type Row = (
    PathBuf,
    Vec<(PathBuf, String)>,
    Vec<String>,
    Option<PathBuf>,
    Vec<(String, Value)>,
    Vec<(String, usize)>,
);

/// Values of a parameter. Python's whole numbers are no floats here.
#[derive(FromPyObject, IntoPyObject)]
enum Value {
    Ints(Vec<i32>),
    Floats(Vec<f32>),
    Texts(Vec<String>),
}

fn row(script: &Script, pictures: &mut Vec<Arc<Texels>>) -> Row {
    let Recipe { path, texts, includes, confined_to, values, pictures: named } = script.recipe();
    let mut number = |sampler: Arc<TextureSampler>| {
        let known = pictures.iter().position(|texels| Arc::ptr_eq(texels, &sampler.texels));
        known.unwrap_or_else(|| {
            pictures.push(sampler.texels.clone());
            pictures.len() - 1
        })
    };
    let named = named.into_iter().map(|(name, sampler)| (name, number(sampler))).collect();
    let value = |(name, value)| match value {
        ParameterValue::Ints(all) => (name, Value::Ints(all)),
        ParameterValue::Floats(all) => (name, Value::Floats(all)),
        ParameterValue::Texts(all) => (name, Value::Texts(all)),
    };
    (path, texts, includes, confined_to, values.into_iter().map(value).collect(), named)
}

fn recipe(row: Row, pictures: &[Arc<TextureSampler>]) -> PyResult<Recipe> {
    let (path, texts, includes, confined_to, values, named) = row;
    let value = |(name, value)| match value {
        Value::Ints(all) => (name, ParameterValue::Ints(all)),
        Value::Floats(all) => (name, ParameterValue::Floats(all)),
        Value::Texts(all) => (name, ParameterValue::Texts(all)),
    };
    let picture = |(name, number): (String, usize)| Some((name, pictures.get(number)?.clone()));
    let named: Option<_> = named.into_iter().map(picture).collect();
    let pictures = named.ok_or_else(|| fault("a picture of a shader is missing"))?;
    Ok(Recipe {
        path,
        texts,
        includes,
        confined_to,
        values: values.into_iter().map(value).collect(),
        pictures,
    })
}

fn fault(why: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("pickled scene: {why}"))
}

/// A scene as a dict of bytes, texts and numbers.
pub(crate) fn state<'py>(py: Python<'py>, parts: &Parts) -> PyResult<Bound<'py, PyDict>> {
    let mut pictures = Vec::new();
    let mut rows = |scripts: &[Script]| -> Vec<Row> {
        scripts.iter().map(|script| row(script, &mut pictures)).collect()
    };
    let (surfaces, displacements, lights) =
        (rows(&parts.surfaces), rows(&parts.displacements), rows(&parts.lights));
    let bytes = py
        .detach(|| snapshot::to_bytes(&parts.scene, &pictures))
        .map_err(|why| PyValueError::new_err(format!("a scene that cannot be pickled: {why}")))?;
    let all = PyDict::new(py);
    all.set_item("scene", PyBytes::new(py, &bytes))?;
    all.set_item("surfaces", surfaces)?;
    all.set_item("displacements", displacements)?;
    all.set_item("lights", lights)?;
    all.set_item("suns", parts.suns.clone())?;
    Ok(all)
}

/// The scene of such a dict, with its shaders compiled.
pub(crate) fn stage(py: Python<'_>, state: &Bound<'_, PyDict>) -> PyResult<Stage> {
    let part = |name: &str| state.get_item(name)?.ok_or_else(|| fault(format!("it has no '{name}'")));
    let (bytes, suns) = (part("scene")?, part("suns")?.extract::<BTreeMap<u32, u32>>()?);
    let bytes = bytes.cast::<PyBytes>()?.as_bytes();
    let (scene, pictures) = py.detach(|| snapshot::from_bytes(bytes)).map_err(fault)?;
    let lights = scene.lights().len() as u32;
    if suns.iter().any(|(&sky, &sun)| sky >= lights || sun >= lights) {
        return Err(fault("a light is missing"));
    }
    // Each picture has one sampler, whatever shaders call it.
    let mut known = HashMap::new();
    let mut sampler = |texels: Arc<Texels>| {
        let made = || Arc::new(gnurt::osl::sampler(texels.clone()));
        known.entry(Arc::as_ptr(&texels)).or_insert_with(made).clone()
    };
    let pictures: Vec<_> = pictures.into_iter().map(&mut sampler).collect();
    let recipes = |name: &str| -> PyResult<Vec<Recipe>> {
        let rows: Vec<Row> = part(name)?.extract()?;
        rows.into_iter().map(|row| recipe(row, &pictures)).collect()
    };
    let (surfaces, displacements, lights) =
        (recipes("surfaces")?, recipes("displacements")?, recipes("lights")?);
    let scripts = |recipes: Vec<Recipe>| -> Result<Vec<Script>, String> {
        recipes.into_iter().map(Script::of_recipe).collect()
    };
    let made = py.detach(|| -> Result<Stage, String> {
        let (surfaces, displacements, lights) =
            (scripts(surfaces)?, scripts(displacements)?, scripts(lights)?);
        Stage::of_parts(Parts { scene, surfaces, displacements, lights, suns })
    });
    made.map_err(fault)
}
