// SPDX-License-Identifier: GPL-3.0-or-later
//! Displacement of a material's surfaces from arguments, and its way into a scene.
//! Tests: `tests/test_displacement.py`.

use std::sync::Arc;

use gnurt::osl::{Access, Kind, Script};
use gnurt::scene::displacement::{Displacement, Offset, Refinement, VectorSpace};
use gnurt::scene::{MaterialId, Scene};
use gnurt::shading::DisplacementShader;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::given::Given;
use crate::scripts::script_named;
use crate::stage::Stage;
use crate::textures::{Pictures, named, reference, unknown};

const MOST: f64 = f32::MAX as f64;

/// A displacement by arguments.
pub(crate) struct NewDisplacement {
    offset: NewOffset,
    scale: f32,
    midlevel: f32,
    refinement: Refinement,
}

enum NewOffset {
    None,
    Offset(Offset),
    Script(Box<Script>),
}

/// A displacement before it is in a scene.
pub(crate) struct CompiledDisplacement {
    offset: CompiledOffset,
    scale: f32,
    midlevel: f32,
    refinement: Refinement,
}

enum CompiledOffset {
    None,
    Offset(Offset),
    /// A shader, and the script that it was made of.
    Shader(Arc<dyn DisplacementShader>, Box<Script>),
}

/// The displacement that is given, if one is.
pub(crate) fn displacement(given: &mut Given, pictures: &dyn Pictures) -> PyResult<NewDisplacement> {
    let height = given.number("displacement", -MOST, MOST)?;
    let texture = reference(given, "displacement_texture")?;
    let textures = given.get("displacement_textures")?;
    let access = Access { pictures: named(textures.as_ref(), pictures)?, ..Access::default() };
    let script = script_named(given, "displacement_shader", "displacement_parameters", &access)?;
    let vector = match given.text("displacement_vector")?.as_deref() {
        None => None,
        Some("object") => Some(VectorSpace::Object),
        Some("tangent") => Some(VectorSpace::Tangent),
        Some(other) => {
            return Err(PyValueError::new_err(format!(
                "displacement_vector: expected object or tangent, not '{other}'"
            )));
        }
    };
    let channel = given.whole("displacement_channel", 0, 3)?.unwrap_or(0) as u8;
    let levels = given.whole("displacement_levels", 0, 12)?;
    let edges = given.number("displacement_edge", f64::from(f32::MIN_POSITIVE), MOST)?;
    let refinement = match (levels, edges) {
        (None, None) => Refinement::None,
        (Some(levels), None) => Refinement::Levels(levels as u8),
        (None, Some(longest)) => Refinement::Edges(longest as f32),
        (Some(_), Some(_)) => {
            return Err(PyValueError::new_err(
                "displacement_edge: give that or displacement_levels, not both",
            ));
        }
    };
    let offset = match (height, texture, script) {
        (None, None, None) => NewOffset::None,
        (Some(height), None, None) => NewOffset::Offset(Offset::Constant(height as f32)),
        (None, Some(texture), None) => NewOffset::Offset(match vector {
            None => Offset::Height { texture, channel },
            Some(space) => Offset::Vector { texture, space },
        }),
        (None, None, Some(script)) => match script.kind() {
            Kind::Displacement | Kind::Surface => NewOffset::Script(Box::new(script)),
            other => {
                return Err(PyValueError::new_err(format!(
                    "displacement_shader: expected a displacement, not a {}",
                    other.kind_name()
                )));
            }
        },
        _ => {
            return Err(PyValueError::new_err(
                "displacement: give one of displacement, displacement_texture and displacement_shader",
            ));
        }
    };
    let number = |value: Option<f64>, default: f32| value.map_or(default, |value| value as f32);
    let scale = number(given.number("displacement_scale", -MOST, MOST)?, 1.0);
    let midlevel = number(given.number("displacement_midlevel", -MOST, MOST)?, 0.0);
    Ok(NewDisplacement { offset, scale, midlevel, refinement })
}

impl CompiledDisplacement {
    /// Compiles it; `surface` is the script of the material, which may have a displacement of its own.
    pub(crate) fn new(new: NewDisplacement, surface: Option<&Script>) -> Result<Self, String> {
        let NewDisplacement { offset, scale, midlevel, refinement } = new;
        let offset = match offset {
            NewOffset::Offset(offset) => CompiledOffset::Offset(offset),
            NewOffset::Script(script) => match script.displacement()? {
                Some(shader) => CompiledOffset::Shader(shader, script),
                None => {
                    let name = script.name();
                    return Err(format!(
                        "{name}: it is no displacement, and has no output vector displacement"
                    ));
                }
            },
            NewOffset::None => match surface {
                Some(script) => match script.displacement()? {
                    Some(shader) => CompiledOffset::Shader(shader, Box::new(script.clone())),
                    None => CompiledOffset::None,
                },
                None => CompiledOffset::None,
            },
        };
        Ok(Self { offset, scale, midlevel, refinement })
    }

    /// As the scene has it.
    pub(crate) fn put(self, stage: &mut Stage) -> PyResult<Option<Displacement>> {
        let Self { offset, scale, midlevel, refinement } = self;
        let offset = match offset {
            CompiledOffset::None => return Ok(None),
            CompiledOffset::Offset(offset) => offset,
            CompiledOffset::Shader(shader, script) => Offset::Shader(stage.add_displacement(shader, *script)),
        };
        let made = Displacement { offset, scale, midlevel, refinement };
        let count = stage.scene().textures().len();
        match made.texture().filter(|texture| texture.texture.index() >= count) {
            Some(texture) => Err(unknown(texture.texture.index(), count)),
            None => Ok(Some(made)),
        }
    }
}

/// Displaces the surfaces of a material, or no longer.
pub(crate) fn set(scene: &mut Scene, material: MaterialId, displacement: Option<Displacement>) {
    if displacement.is_some() || scene.displacement(material).is_some() {
        scene.set_displacement(material, displacement);
    }
}
