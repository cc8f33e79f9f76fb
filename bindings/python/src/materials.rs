// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials of a scene by numbers, and those with shaders before they are in it. Tests: `tests/test_pictures.py`.

use std::sync::Arc;

use gnurt::osl::Script;
use gnurt::scene::{Displacement, Material, MaterialId, MediumId, Scene as Description, Surface};
use gnurt::shading::SurfaceShader;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;

use crate::describing::{NewLook, NewMaterial};
use crate::displacements::CompiledDisplacement;
use crate::stage::Stage;
use crate::{media, textures};

/// A material before it is in a scene.
pub(crate) struct Compiled {
    look: Look,
    displacement: CompiledDisplacement,
}

enum Look {
    Material(Material),
    Script(String, Script, Option<MediumId>, Arc<dyn SurfaceShader>),
}

impl Compiled {
    /// Shaders take their time, so neither the interpreter nor the scene waits for them.
    pub(crate) fn new(py: Python<'_>, NewMaterial { look, displacement }: NewMaterial) -> PyResult<Self> {
        let wrong = |what: &str, why: String| PyValueError::new_err(format!("{what}: {why}"));
        py.detach(move || {
            let script = match &look {
                NewLook::Material(_) => None,
                NewLook::Script(_, script, _) => Some(script),
            };
            let displacement = CompiledDisplacement::new(displacement, script)
                .map_err(|why| wrong("displacement_shader", why))?;
            let look = match look {
                NewLook::Material(material) => Look::Material(material),
                NewLook::Script(name, script, medium) => {
                    let surface = script.surface().map_err(|why| wrong("shader", why))?;
                    Look::Script(name, script, medium, surface)
                }
            };
            Ok(Self { look, displacement })
        })
    }

    /// As the scene has it.
    pub(crate) fn put(self, stage: &mut Stage) -> PyResult<(Material, Option<Displacement>)> {
        let medium = match &self.look {
            Look::Material(material) => material.medium,
            Look::Script(_, _, medium, _) => *medium,
        };
        medium.map(|medium| media::medium_id(stage.scene(), medium.index())).transpose()?;
        let material = match self.look {
            Look::Material(material) => material,
            Look::Script(name, script, medium, surface) => {
                let surface = Surface::Shader(stage.add_script(script, surface));
                Material { medium, ..Material::of(name, surface) }
            }
        };
        textures::check(&material, stage.scene().textures().len())?;
        Ok((material, self.displacement.put(stage)?))
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
