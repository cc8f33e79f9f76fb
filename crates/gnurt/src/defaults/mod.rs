// SPDX-License-Identifier: GPL-3.0-or-later
//! Defaults for a scene without a camera or any light, so that every scene can be shown. The key light over
//! the left shoulder is the custom of scan repositories and of photographers.
//! Space: world, y upwards unless another axis is given. Tests: `tests` of the submodules.

mod added;
mod bounds;
mod camera;
mod distance_rays;
mod lights;
mod own_light;
mod studio;

use std::fmt;

pub use added::{Added, Stock};
pub use bounds::{Bounds, bounds_of, bounds_over};
pub use camera::framing;
pub use lights::{lit_from, lit_within};
pub use own_light::{OwnLight, Purpose, own_light};

use lights::is_open;

use crate::render::ShaderTable;
use crate::scene::{Camera, Scene};

/// The exposure that suits the studio, in stops: its light is known, so that black objects stay black and
/// white ones white.
pub const STUDIO_EXPOSURE: f32 = 0.0;

/// Something that was added to a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Note {
    /// A camera that shows everything.
    Camera,
    /// The studio: a plain sky with soft light and a floor that only catches shadow.
    Studio {
        /// Whether the scene has emissive textures, taken for displays.
        displays: bool,
    },
    /// A key light and a grey background.
    Lights,
    /// A light near the camera within the scene, and a grey background.
    Lamp {
        /// Whether the scene has emissive textures, taken for displays.
        displays: bool,
    },
    /// Nothing, though the scene's only light is displays: the picture is a file of floats.
    DisplaysOnly,
}

impl Note {
    /// The exposure that suits the light that was added, if that is known.
    #[must_use]
    pub fn exposure(self) -> Option<f32> {
        matches!(self, Self::Studio { .. }).then_some(STUDIO_EXPOSURE)
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let own = match self {
            Self::Studio { displays: true } | Self::Lamp { displays: true } => {
                "the scene has no light but displays (emissive textures of radiance up to 1)"
            }
            _ => "the scene has no light",
        };
        match self {
            Self::Camera => f.write_str("the scene has no camera; one that shows all of it is used"),
            Self::Studio { .. } => {
                write!(f, "{own}; a default studio is used: soft light from a plain sky, and a shadow-catcher floor")
            }
            Self::Lights => {
                write!(f, "{own}; a light over the camera's left shoulder and a grey background are used")
            }
            Self::Lamp { .. } => {
                write!(f, "{own}; a light near the camera, which is inside, and a grey background are used")
            }
            Self::DisplaysOnly => f.write_str(
                "the scene has no light but displays (emissive textures of radiance up to 1), and a file of floats gets no other; --environment builtin:day adds a sky",
            ),
        }
    }
}

/// Adds a camera and lights where there are none, for a picture on a screen; `aspect` = width / height of the picture to come.
pub fn complete(scene: &mut Scene, aspect: f32) -> Vec<Note> {
    let camera = complete_camera(scene, aspect);
    let first = scene.cameras().first().cloned();
    let lights = first.and_then(|camera| {
        complete_lights(scene, &ShaderTable::default(), &camera, [0.0, 1.0, 0.0], Purpose::Screen)
    });
    camera.into_iter().chain(lights).collect()
}

/// Adds a camera that shows everything if there is none.
pub fn complete_camera(scene: &mut Scene, aspect: f32) -> Option<Note> {
    if !scene.cameras().is_empty() {
        return None;
    }
    complete_camera_around(scene, bounds_of(scene), aspect)
}

/// Adds a camera that shows all of `bounds` if there is none.
pub fn complete_camera_around(scene: &mut Scene, bounds: Option<Bounds>, aspect: f32) -> Option<Note> {
    if !scene.cameras().is_empty() {
        return None;
    }
    let camera = framing(bounds, aspect);
    scene.add_camera(camera);
    Some(Note::Camera)
}

/// Puts a scene that needs light (`own_light`) into a studio, seen by `camera`; `up` is the up direction
/// there, +y unless it is clearly another axis. A camera in a room gets a light instead.
pub fn complete_lights(
    scene: &mut Scene,
    shaders: &ShaderTable,
    camera: &Camera,
    up: [f32; 3],
    purpose: Purpose,
) -> Option<Note> {
    // Bounds cost a visit of every vertex: not computed where they are not needed.
    let bounds = purpose.needs_light(own_light(scene, shaders)).then(|| bounds_of(scene)).flatten();
    complete_lights_around(scene, shaders, bounds, camera, up, purpose)
}

/// The same for a scene that moves within `bounds`.
pub fn complete_lights_around(
    scene: &mut Scene,
    shaders: &ShaderTable,
    bounds: Option<Bounds>,
    camera: &Camera,
    up: [f32; 3],
    purpose: Purpose,
) -> Option<Note> {
    let own = own_light(scene, shaders);
    let displays = own == OwnLight::Displays;
    if !purpose.needs_light(own) {
        return displays.then_some(Note::DisplaysOnly);
    }
    let (axis, eye) = (studio::axis_of(up), camera.eye.map(f64::from));
    let is_within = bounds.is_some_and(|bounds| bounds.contains(eye)) && !is_open(scene, eye, axis);
    if let Some(lights) = is_within.then(|| lit_within(scene, camera)).flatten() {
        for light in lights {
            scene.add_light(light);
        }
        return Some(Note::Lamp { displays });
    }
    studio::add(scene, camera, bounds, axis);
    Some(Note::Studio { displays })
}

/// Adds lights without extent, and nothing else, to a scene in which nothing emits: for measurements.
pub fn complete_plain_lights(scene: &mut Scene, shaders: &ShaderTable, camera: &Camera) -> Option<Note> {
    if !Purpose::Numbers.needs_light(own_light(scene, shaders)) {
        return None;
    }
    let (lights, note) = match lit_within(scene, camera) {
        Some(lights) => (lights, Note::Lamp { displays: false }),
        None => (lit_from(camera), Note::Lights),
    };
    for light in lights {
        scene.add_light(light);
    }
    Some(note)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complete_adds_once() {
        let mut scene = Scene::new();
        assert_eq!(
            complete(&mut scene, 1.0),
            [Note::Camera, Note::Studio { displays: false }],
            "an empty scene has neither"
        );
        assert_eq!(scene.cameras().len(), 1, "one camera");
        assert_eq!(complete(&mut scene, 1.0), [], "now it has both");
    }
}
