// SPDX-License-Identifier: GPL-3.0-or-later
//! Surroundings of a scene, which light it: one colour, a built-in sky, or a picture. Pictures are
//! latitude-longitude ones, as the field's collections of skies have them.
//! Tests: `tests`, and the command line's `tests/program/surroundings.rs`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::osl::{Script, is_carried};

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

    /// The file that they are read from; none of a shader that the program carries.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Picture(path) | Self::Shader(path, _) if is_carried(path) => None,
            Self::Picture(path) | Self::Shader(path, _) => Some(path),
            Self::Uniform(_) | Self::Sky(_) => None,
        }
    }

    /// Puts them around a scene, whose own environment then counts no more; its other lights do. `up` is the
    /// up direction, of any length, +y if it is the zero vector; `yaw` rotates them around it, in degrees,
    /// counter-clockwise seen from above. The workers decompress an EXR.
    ///
    /// # Errors
    /// [`Error::Image`] if the picture cannot be read, [`Error::Surroundings`] if the shader does not compile; the scene stays as
    /// it was.
    pub fn put_around(
        &self,
        scene: &mut Scene,
        up: [f32; 3],
        yaw: f64,
        workers: image::Workers,
    ) -> Result<(), Error> {
        let world_from_light = placed(up, yaw);
        match self {
            Self::Uniform(radiance) => {
                scene.add_light(Light::Environment { radiance: *radiance, texture: None, world_from_light });
            }
            Self::Sky(sky) => sky.add_to(scene, world_from_light),
            Self::Picture(path) if !script_sky::is_script(path) => {
                put_texels(
                    (image::read_texture_with(path, workers)?, None),
                    &name_of(path),
                    scene,
                    world_from_light,
                );
            }
            Self::Picture(path) => put_sky(path, &[], scene, world_from_light)?,
            Self::Shader(path, given) => put_sky(path, given, scene, world_from_light)?,
        }
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
        let world_from_light = placed(up, yaw);
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
        let world_from_light = placed(up, yaw);
        let texture = Some(scene.add_texture(texture));
        scene.add_light(Light::Environment { radiance, texture, world_from_light });
    }
}

/// Adds a sky in the shading language.
fn put_sky(
    path: &Path,
    given: &[(String, String)],
    scene: &mut Scene,
    world_from_light: Affine,
) -> Result<(), Error> {
    let texels = script_sky::texels(path, given).map_err(Error::Surroundings)?;
    put_texels(texels, &name_of(path), scene, world_from_light);
    Ok(())
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Adds an environment of a picture, and of the one that rays of the camera see where it is another.
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

/// The transform of an environment whose +y is `up`, turned around it by `yaw` degrees.
fn placed(up: [f32; 3], yaw: f64) -> Affine {
    upright(up) * Affine::rotation([0.0, 1.0, 0.0], yaw.to_radians())
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
    use crate::threads::workers;

    /// Where the environment's up and middle are in the world.
    fn orientation(up: [f32; 3], yaw: f64) -> [[f64; 3]; 2] {
        let mut scene = Scene::new();
        Surroundings::Uniform([1.0; 3])
            .put_around(&mut scene, up, yaw, &workers(None))
            .expect("no file is read");
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
        let emitter = Light::Point { position: [0.0; 3], intensity: [1.0; 3], radius: 0.0 };
        scene.add_light(emitter.clone());
        let missing = Surroundings::Picture("no/such/sky.hdr".into());
        let before = scene.lights().to_vec();
        assert!(
            missing.put_around(&mut scene, [0.0, 1.0, 0.0], 0.0, &workers(None)).is_err(),
            "there is no such file"
        );
        assert_eq!(scene.lights(), before, "nothing has changed");
        Surroundings::sky("builtin:day")
            .expect("a sky")
            .put_around(&mut scene, [0.0, 1.0, 0.0], 0.0, &workers(None))
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
