// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights of a scene by numbers. A sky has a sun, which is a light behind it: it comes, changes and goes with the sky.
//! Tests: `tests/test_pictures.py::test_skies`.

use gnurt::scene::{Light, LightId, Scene, Texture};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;

use crate::describing::NewLight;
use crate::picture::surroundings_error;
use crate::pool::with_all_threads;
use crate::stage::Stage;

/// A light, or the lights of surroundings, before they are in a scene.
pub(crate) struct Made {
    lights: Vec<Light>,
    /// Of those, by the numbers that their lights have for them.
    textures: Vec<Texture>,
}

/// Reads and computes the data of a light: slow work, without access to a scene.
pub(crate) fn made(light: NewLight) -> PyResult<Made> {
    let mut other = Scene::new();
    let put = match light {
        NewLight::Light(light) => return Ok(Made { lights: vec![light], textures: Vec::new() }),
        NewLight::Around(around, up, rotation) => {
            with_all_threads(|workers| around.put_around(&mut other, up, rotation, workers))
        }
        NewLight::Script(script, up, rotation) => {
            gnurt::Surroundings::put_script_around(&script, &mut other, up, rotation)
        }
        NewLight::Texture(texture, radiance, up, rotation) => {
            gnurt::Surroundings::put_texture_around(texture, radiance, &mut other, up, rotation);
            Ok(())
        }
    };
    put.map_err(|error| surroundings_error(&error))?;
    Ok(Made { lights: other.lights().to_vec(), textures: other.textures().to_vec() })
}

/// The number of a new light; of a sky that of its surroundings.
pub(crate) fn add(stage: &mut Stage, made: Made) -> u32 {
    let lights = put_textures(stage, made);
    let number = stage.scene().lights().len() as u32;
    stage.edit(|scene| {
        for light in &lights {
            scene.add_light(light.clone());
        }
    });
    if lights.len() > 1 {
        stage.suns.insert(number, number + 1);
    }
    number
}

/// Replaces a light by another.
pub(crate) fn set(stage: &mut Stage, number: usize, made: Made) -> PyResult<()> {
    let count = stage.scene().lights().len();
    let Some(number) = u32::try_from(number).ok().filter(|_| number < count) else {
        return Err(PyIndexError::new_err(format!("light: {number} is out of range; the scene has {count}")));
    };
    let mut lights = put_textures(stage, made).into_iter();
    let (first, sun) = (lights.next(), lights.next());
    let placement = stage.suns.get(&number).copied();
    // Others keep their numbers: a sun that is gone is dark.
    let sun = sun.or(placement.map(|_| Light::Directional {
        direction: [0.0, -1.0, 0.0],
        irradiance: [0.0; 3],
        angle: 0.0,
    }));
    if let (Some(_), None) = (&sun, placement) {
        stage.suns.insert(number, count as u32);
    }
    stage.edit(|scene| {
        if let Some(light) = &first {
            *scene.edit_light(LightId(number)) = light.clone();
        }
        let Some(sun) = &sun else { return };
        if let Some(placement) = placement {
            *scene.edit_light(LightId(placement)) = sun.clone();
        } else {
            scene.add_light(sun.clone());
        }
    });
    Ok(())
}

/// Adds the textures to the scene; the lights with their numbers there.
fn put_textures(stage: &mut Stage, Made { mut lights, textures }: Made) -> Vec<Light> {
    let first = stage.scene().textures().len() as u32;
    for texture in textures {
        stage.edit(|scene| scene.add_texture(texture.clone()));
    }
    for light in &mut lights {
        if let Some(texture) = light.texture_mut() {
            texture.0 += first;
        }
    }
    lights
}
