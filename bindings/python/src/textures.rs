// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures of a scene: pictures from files and arrays, known by numbers.
//! Materials and lights read them by number; shaders call them by names that `textures=` gives. Tests: `tests/test_textures.py`.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use gnurt::image::{read_data_texture, read_texture};
use gnurt::scene::texture::{Filter, TextureRef, Wrap};
use gnurt::scene::{Material, Texture, TextureId};
use gnurt::shading::texture::TextureSampler;
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::given::Given;
use crate::picture::image_error;
use crate::pixels::texels;

/// The textures that a scene has.
pub(crate) trait Pictures {
    /// That of a number.
    fn texture(&self, number: usize) -> PyResult<Texture>;
    /// The same as shaders read it.
    fn sampler(&self, number: usize) -> PyResult<Arc<TextureSampler>>;
}

/// That there is no texture of a number.
pub(crate) fn unknown(number: usize, count: usize) -> PyErr {
    PyIndexError::new_err(format!("texture: {number} is out of range; the scene has {count}"))
}

/// Checks the textures that a material reads.
pub(crate) fn check(material: &Material, count: usize) -> PyResult<()> {
    match material.textures().find(|(texture, _)| texture.texture.index() >= count) {
        Some((texture, _)) => Err(unknown(texture.texture.index(), count)),
        None => Ok(()),
    }
}

/// Pictures of a shader: a dict of its names for them, and numbers.
pub(crate) fn named(
    given: Option<&Bound<'_, PyAny>>,
    pictures: &dyn Pictures,
) -> PyResult<Arc<HashMap<String, Arc<TextureSampler>>>> {
    let Some(given) = given else { return Ok(Arc::default()) };
    let wrong = || PyTypeError::new_err("textures: expected a dict of names and numbers of textures");
    let given = given.cast::<PyDict>().map_err(|_| wrong())?;
    let mut all = HashMap::new();
    for (name, number) in given {
        let (name, number): (String, usize) =
            (name.extract().map_err(|_| wrong())?, number.extract().map_err(|_| wrong())?);
        all.insert(name, pictures.sampler(number)?);
    }
    Ok(Arc::new(all))
}

/// A texture that a material reads: a number, or `(number, (a, b, c, d, e, f))` with the transform of [`TextureRef`].
pub(crate) fn reference(given: &mut Given, name: &'static str) -> PyResult<Option<TextureRef>> {
    let Some(value) = given.get(name)? else { return Ok(None) };
    let id = |number: usize| {
        u32::try_from(number).map(TextureId).map_err(|_| PyIndexError::new_err(format!("{name}: {number}")))
    };
    if let Ok(number) = value.extract::<usize>() {
        return Ok(Some(TextureRef::new(id(number)?)));
    }
    match value.extract::<(usize, [f32; 6])>() {
        Ok((number, uv_from_mesh)) if uv_from_mesh.iter().all(|x| x.is_finite()) => {
            Ok(Some(TextureRef { uv_from_mesh, ..TextureRef::new(id(number)?) }))
        }
        _ => Err(PyTypeError::new_err(format!(
            "{name}: expected the number of a texture, or (number, (a, b, c, d, e, f)) with finite numbers"
        ))),
    }
}

/// A texture by its arguments.
pub(crate) fn texture(py: Python<'_>, given: &mut Given) -> PyResult<Texture> {
    let source = given.get("source")?.ok_or_else(|| PyTypeError::new_err("source: is missing"))?;
    let name = given.text("name")?;
    let is_color = match given.text("colorspace")?.as_deref() {
        None | Some("srgb") => true,
        Some("linear") => false,
        Some(other) => {
            return Err(PyValueError::new_err(format!("colorspace: expected srgb or linear, not '{other}'")));
        }
    };
    let wrap = match given.get("wrap")? {
        None => [Wrap::Repeat; 2],
        Some(value) => match (value.extract::<String>(), value.extract::<[String; 2]>()) {
            (Ok(both), _) => [wrap(&both)?; 2],
            (_, Ok([u, v])) => [wrap(&u)?, wrap(&v)?],
            _ => return Err(PyTypeError::new_err("wrap: expected a word, or one for u and one for v")),
        },
    };
    let filter = match given.text("filter")?.as_deref() {
        None | Some("linear") => Filter::Linear,
        Some("nearest") => Filter::Nearest,
        Some(other) => {
            return Err(PyValueError::new_err(format!("filter: expected linear or nearest, not '{other}'")));
        }
    };
    let (texels, found) = match source.extract::<PathBuf>() {
        Ok(path) => {
            let read = |path: &PathBuf| if is_color { read_texture(path) } else { read_data_texture(path) };
            let texels = py.detach(|| read(&path)).map_err(|error| image_error(&error))?;
            (texels, path.file_name().unwrap_or_default().to_string_lossy().into_owned())
        }
        Err(_) => (texels(&source, is_color)?, String::new()),
    };
    Ok(Texture { name: name.unwrap_or(found), texels: Arc::new(texels), wrap, filter })
}

fn wrap(word: &str) -> PyResult<Wrap> {
    match word {
        "repeat" => Ok(Wrap::Repeat),
        "mirror" => Ok(Wrap::MirroredRepeat),
        "clamp" => Ok(Wrap::ClampToEdge),
        _ => Err(PyValueError::new_err(format!("wrap: expected repeat, mirror or clamp, not '{word}'"))),
    }
}
