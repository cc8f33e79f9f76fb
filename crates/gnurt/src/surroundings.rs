// SPDX-License-Identifier: GPL-3.0-or-later
//! Surroundings of a scene, which light it: one colour, a built-in sky, or a picture. Pictures are
//! latitude-longitude ones, as the field's collections of skies have them.
//! Tests: `tests`, and the command line's `tests/program/surroundings.rs`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnurt_sl_shading::Script;

use crate::error::Error;
use crate::image::{self, Texels};
use crate::load::BUILTIN;
use crate::scene::builtin::{BuiltinSky, SKIES};
use crate::scene::texture::{Filter, Wrap};
use crate::scene::{Affine, Light, Scene, Texture};
use crate::script_sky;

/// Radiance of rays that leave a scene.
#[derive(Clone, Debug)]
pub enum Surroundings {
    /// The same radiance from everywhere: linear red, green, blue.
    Uniform([f32; 3]),
    /// A sky with its sun.
    Sky(&'static BuiltinSky),
    /// A latitude-longitude picture: radiance, its upper edge above, its middle along -z; or a sky in the shading language
    /// (`.osl`), whose z is above.
    Picture(PathBuf),
    /// A sky in the shading language, with values of its parameters as people write them: numbers between commas, or a text.
    Shader(PathBuf, Vec<(String, String)>),
}

impl Surroundings {
    /// The sky of this name, with or without `builtin:`.
    #[must_use]
    pub fn sky(name: &str) -> Option<Self> {
        let name = name.strip_prefix(BUILTIN).unwrap_or(name);
        SKIES.iter().find(|sky| sky.name == name).map(Self::Sky)
    }

    /// The file that they are read from.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Picture(path) | Self::Shader(path, _) => Some(path),
            Self::Uniform(_) | Self::Sky(_) => None,
        }
    }

    /// Puts them around a scene, whose own environment then counts no more; its other lights do. `up` is the
    /// up direction, of any length, +y if it is the zero vector; `yaw` rotates them around it, in degrees,
    /// counter-clockwise seen from above.
    ///
    /// # Errors
    /// [`Error::Image`] if the picture cannot be read, [`Error::Surroundings`] if the shader does not compile; the scene stays as
    /// it was.
    pub fn put_around(&self, scene: &mut Scene, up: [f32; 3], yaw: f64) -> Result<(), Error> {
        let given = if let Self::Shader(_, given) = self { &given[..] } else { &[] };
        let read = |path: &Path| match script_sky::is_script(path) || !given.is_empty() {
            true => script_sky::texels(path, given).map_err(Error::Surroundings),
            false => Ok((image::read_texture(path)?, None)),
        };
        let texels = self.file().map(read).transpose()?;
        let world_from_light = upright(up) * Affine::rotation([0.0, 1.0, 0.0], yaw.to_radians());
        let (radiance, texture) = match (self, texels) {
            (Self::Sky(sky), _) => {
                sky.add_to(scene, world_from_light);
                return Ok(());
            }
            (Self::Uniform(radiance), _) => (*radiance, None),
            (Self::Picture(path) | Self::Shader(path, _), Some(texels)) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                put_texels(texels, &name, scene, world_from_light);
                return Ok(());
            }
            (Self::Picture(_) | Self::Shader(..), None) => ([1.0; 3], None),
        };
        scene.add_light(Light::Environment { radiance, texture, world_from_light });
        Ok(())
    }

    /// Puts a sky in the shading language around a scene, with the values that the script has.
    ///
    /// # Errors
    /// [`Error::Surroundings`] if it is no sky; the scene stays as it was.
    pub fn put_script_around(
        script: &Script,
        scene: &mut Scene,
        up: [f32; 3],
        yaw: f64,
    ) -> Result<(), Error> {
        let texels = script_sky::texels_of(script).map_err(Error::Surroundings)?;
        let world_from_light = upright(up) * Affine::rotation([0.0, 1.0, 0.0], yaw.to_radians());
        put_texels(texels, script.name(), scene, world_from_light);
        Ok(())
    }

    /// Puts a latitude-longitude picture around a scene, multiplied by a radiance.
    pub fn put_texture_around(
        texture: Texture,
        radiance: [f32; 3],
        scene: &mut Scene,
        up: [f32; 3],
        yaw: f64,
    ) {
        let world_from_light = upright(up) * Affine::rotation([0.0, 1.0, 0.0], yaw.to_radians());
        let texture = Some(scene.add_texture(texture));
        scene.add_light(Light::Environment { radiance, texture, world_from_light });
    }
}

/// Adds an environment of a picture, and the picture for rays of the camera where it is another.
fn put_texels(
    (sky, shown): (Texels, Option<Texels>),
    name: &str,
    scene: &mut Scene,
    world_from_light: Affine,
) {
    let texture = |texels| Texture {
        name: name.into(),
        texels: Arc::new(texels),
        wrap: [Wrap::Repeat, Wrap::ClampToEdge],
        filter: Filter::Linear,
    };
    let sky = scene.add_texture(texture(sky));
    if let Some(texels) = shown {
        let texture = scene.add_texture(texture(texels));
        scene.add_light(Light::Backdrop { texture, world_from_light });
    }
    scene.add_light(Light::Environment { radiance: [1.0; 3], texture: Some(sky), world_from_light });
}

/// The smallest rotation that takes +y to `up`.
pub(crate) fn upright(up: [f32; 3]) -> Affine {
    let up = up.map(f64::from);
    let length = up.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return Affine::IDENTITY;
    }
    let [x, y, z] = up.map(|x| x / length);
    let across = (x * x + z * z).sqrt();
    // y cross up; upside down, any axis in the plane will do.
    let axis = if across > 0.0 { [z, 0.0, -x] } else { [1.0, 0.0, 0.0] };
    Affine::rotation(axis, across.atan2(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the environment's up and middle are in the world.
    fn orientation(up: [f32; 3], yaw: f64) -> [[f64; 3]; 2] {
        let mut scene = Scene::new();
        Surroundings::Uniform([1.0; 3]).put_around(&mut scene, up, yaw).expect("no file is read");
        let [Light::Environment { world_from_light, .. }] = scene.lights() else { panic!("one environment") };
        [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0]].map(|v| world_from_light.vector(v))
    }

    #[track_caller]
    fn assert_near(found: [[f64; 3]; 2], expected: [[f64; 3]; 2]) {
        let near = found.iter().flatten().zip(expected.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near, "{found:?} instead of {expected:?}");
    }

    #[test]
    fn they_stand_upright_and_turn() {
        assert_near(orientation([0.0, 2.0, 0.0], 0.0), [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]);
        assert_near(orientation([0.0, 0.0, 1.0], 0.0), [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
        assert_near(orientation([0.0, -1.0, 0.0], 0.0), [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_near(orientation([0.0, 1.0, 0.0], 90.0), [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
        assert_near(orientation([0.0; 3], 0.0), [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]);
    }

    #[test]
    fn they_replace_an_environment_and_no_lamp() {
        let mut scene = Scene::new();
        scene.add_light(Light::Environment {
            radiance: [9.0; 3],
            texture: None,
            world_from_light: Affine::IDENTITY,
        });
        let emitter = Light::Point { position: [0.0; 3], intensity: [1.0; 3] };
        scene.add_light(emitter.clone());
        let missing = Surroundings::Picture("no/such/sky.hdr".into());
        let before = scene.lights().to_vec();
        assert!(missing.put_around(&mut scene, [0.0, 1.0, 0.0], 0.0).is_err(), "there is no such file");
        assert_eq!(scene.lights(), before, "nothing has changed");
        Surroundings::sky("builtin:day")
            .expect("a sky")
            .put_around(&mut scene, [0.0, 1.0, 0.0], 0.0)
            .expect("no file");
        let mut environments =
            scene.lights().iter().filter(|light| matches!(light, Light::Environment { .. }));
        let last = environments.next_back().expect("an environment");
        assert!(matches!(last, Light::Environment { texture: Some(_), .. }), "the last one counts: {last:?}");
        assert!(scene.lights().contains(&emitter), "the lamp stays");
    }

    #[test]
    fn skies_have_names() {
        for sky in SKIES {
            assert!(
                matches!(Surroundings::sky(sky.name), Some(Surroundings::Sky(found)) if found.name == sky.name)
            );
        }
        assert!(Surroundings::sky("night").is_none(), "not one of them");
    }
}
