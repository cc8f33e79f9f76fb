// SPDX-License-Identifier: GPL-3.0-or-later
//! Shaders for the materials of a scene by name, as `--shader` of the program gives them.
//! A document of MaterialX with several materials gives each material of the scene the one of its name.
//! Tests: `tests/test_shaders.py`.

use std::sync::Arc;

use gnurt::osl::{Access, Kind, Script, shaders_by_material};
use gnurt::scene::displacement::{Displacement, Offset};
use gnurt::scene::{MaterialId, Surface};
use gnurt::shading::{DisplacementShader, SurfaceShader};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::given::Given;
use crate::scripts;
use crate::textures::Pictures;

/// A shader, and the numbers of the materials that get it.
pub(crate) struct Shaded {
    materials: Vec<usize>,
    script: Script,
    /// `None` for displacement alone.
    surface: Option<Arc<dyn SurfaceShader>>,
    displacement: Option<Arc<dyn DisplacementShader>>,
}

/// Compiles the shaders for the materials with the name `material`, or for all (`*`), of a scene with materials of these
/// names.
pub(crate) fn shaded(
    py: Python<'_>,
    material: &str,
    names: &[String],
    arguments: &Bound<'_, PyDict>,
    pictures: &dyn Pictures,
) -> PyResult<Vec<Shaded>> {
    let is_meant = |name: &&String| material == "*" || material == **name;
    if !names.iter().any(|name| is_meant(&name)) {
        let known: Vec<String> = names.iter().map(|name| format!("'{name}'")).collect();
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        return Err(PyValueError::new_err(format!(
            "material: unknown name '{material}'; the scene has: {known}; '*' is all"
        )));
    }
    let shader = arguments.get_item("shader")?;
    let text = shader.and_then(|shader| shader.str().ok()).map(|text| text.to_string()).unwrap_or_default();
    let names = || names.iter().map(String::as_str);
    let found = py
        .detach(|| shaders_by_material(&text, material, names(), &Access::default()))
        .map_err(|why| PyValueError::new_err(format!("shader: {why}")))?;
    let of_name = |(name, shader): (String, String)| {
        let own = arguments.copy()?;
        if shader != text {
            own.set_item("shader", shader)?;
        }
        let numbers = names().enumerate().filter(|(_, other)| name == "*" || name == *other);
        compiled(py, numbers.map(|(number, _)| number).collect(), &own, pictures)
    };
    found.into_iter().map(of_name).collect()
}

fn compiled(
    py: Python<'_>,
    materials: Vec<usize>,
    arguments: &Bound<'_, PyDict>,
    pictures: &dyn Pictures,
) -> PyResult<Shaded> {
    let mut given = Given::new(arguments);
    let script = scripts::script(&mut given, pictures)?;
    given.end()?;
    let script = script.ok_or_else(|| PyValueError::new_err("shader: expected a file, or source text"))?;
    let wrong = |why: String| PyValueError::new_err(format!("shader: {why}"));
    let displacement = py.detach(|| script.displacement()).map_err(wrong)?;
    let surface = match script.kind() {
        Kind::Displacement => None,
        _ => Some(py.detach(|| script.surface()).map_err(wrong)?),
    };
    Ok(Shaded { materials, script, surface, displacement })
}

impl Shaded {
    /// Puts the shader into a scene; the numbers of its materials.
    pub(crate) fn put(self, stage: &mut crate::stage::Stage) -> Vec<usize> {
        // The scene may have become another one meanwhile.
        let count = stage.scene().materials().len();
        let materials: Vec<usize> = self.materials.into_iter().filter(|&id| id < count).collect();
        if let Some(displacement) = self.displacement {
            let offset = Offset::Shader(stage.add_displacement(displacement, self.script.clone()));
            stage.edit(|scene| {
                for &id in &materials {
                    let id = MaterialId(id as u32);
                    let refinement =
                        scene.displacement(id).map(|before| before.refinement).unwrap_or_default();
                    let displacement = Displacement { refinement, ..Displacement::new(offset) };
                    scene.set_displacement(id, Some(displacement));
                }
            });
        }
        if let Some(surface) = self.surface {
            let number = stage.add_script(self.script, surface);
            stage.edit(|scene| {
                for &id in &materials {
                    scene.edit_material(MaterialId(id as u32)).surface = Surface::Shader(number);
                }
            });
        }
        materials
    }
}
