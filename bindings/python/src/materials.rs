// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials of a scene by numbers, and those with shaders before they are in it. Tests: `tests/test_pictures.py`.

use std::sync::Arc;

use gnurt::osl::Script;
use gnurt::scene::{Material, MaterialId, MediumId, Scene as Description, Surface};
use gnurt::shading::SurfaceShader;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;

use crate::describing::NewMaterial;
use crate::stage::Stage;
use crate::{media, textures};

/// A material before it is in a scene.
pub(crate) enum Compiled {
    Material(Material),
    Script(String, Script, Option<MediumId>, Arc<dyn SurfaceShader>),
}

impl Compiled {
    /// Shaders take their time, so neither the interpreter nor the scene waits for them.
    pub(crate) fn new(py: Python<'_>, material: NewMaterial) -> PyResult<Self> {
        match material {
            NewMaterial::Material(material) => Ok(Self::Material(material)),
            NewMaterial::Script(name, script, medium) => py.detach(move || match script.surface() {
                Ok(surface) => Ok(Self::Script(name, script, medium, surface)),
                Err(why) => Err(PyValueError::new_err(format!("shader: {why}"))),
            }),
        }
    }

    /// As the scene has it.
    pub(crate) fn put(self, stage: &mut Stage) -> PyResult<Material> {
        let medium = match &self {
            Self::Material(material) => material.medium,
            Self::Script(_, _, medium, _) => *medium,
        };
        medium.map(|medium| media::medium_id(stage.scene(), medium.index())).transpose()?;
        let material = match self {
            Self::Material(material) => material,
            Self::Script(name, script, medium, surface) => {
                let surface = Surface::Shader(stage.add_script(script, surface));
                Material { medium, ..Material::of(name, surface) }
            }
        };
        textures::check(&material, stage.scene().textures().len())?;
        Ok(material)
    }
}

/// The number of a material of a scene.
pub(crate) fn material_id(scene: &Description, material: usize) -> PyResult<MaterialId> {
    let count = scene.materials().len();
    match u32::try_from(material) {
        Ok(id) if material < count => Ok(MaterialId(id)),
        _ => {
            Err(PyIndexError::new_err(format!("material: {material} is out of range; the scene has {count}")))
        }
    }
}

/// The material of meshes that are given none.
pub(crate) fn plain(scene: &mut Description) -> MaterialId {
    const NAME: &str = "default";
    let known = scene.materials().iter().position(|material| material.name == NAME);
    known.map_or_else(
        || scene.add_material(gnurt::scene::Material::matte(NAME, [0.8; 3])),
        |number| MaterialId(number as u32),
    )
}
