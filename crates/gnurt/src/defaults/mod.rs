// SPDX-License-Identifier: GPL-3.0-or-later
//! What a scene gets that lacks a camera or any light, so that every scene can be looked at.
//! Source: original; the key light over the left shoulder is the custom of scan repositories and of photographers.
//! Space: world, y upwards unless another axis is given. Proof: `tests` of the submodules.

mod added;
mod bounds;
mod camera;
mod lights;
mod sight;
mod studio;

use std::fmt;

pub use added::{Added, Stock};
pub use bounds::{Bounds, bounds_of, bounds_over};
pub use camera::framing;
pub use lights::{lit_from, lit_within, shines};

use lights::{glows, is_open};

use crate::scene::{Camera, Scene};

/// The exposure that suits the studio, in stops: its light is known, so that black things stay black and white ones white.
pub const STUDIO_EXPOSURE: f32 = 0.0;

/// Something that was added to a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Note {
    /// A camera that shows everything.
    Camera,
    /// The studio: a plain sky with soft light and a floor that only catches shadow.
    Studio {
        /// Whether something in the scene glows, but not enough to light it.
        glows: bool,
    },
    /// A key light and a grey background.
    Lights,
    /// A lamp beside the camera, which stands within the scene, and a grey background.
    Lamp,
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
        f.write_str(match self {
            Self::Camera => "the scene has no camera; one that shows all of it is used",
            Self::Studio { glows: false } => {
                "the scene has no light; it stands in a studio: soft light from a plain sky, a floor that only catches shadow"
            }
            Self::Studio { glows: true } => {
                "the scene has no light but what glows on it; it stands in a studio: soft light from a plain sky, a floor that only catches shadow"
            }
            Self::Lights => {
                "the scene has no light; a light over the camera's left shoulder and a grey background are used"
            }
            Self::Lamp => {
                "the scene has no light; a lamp beside the camera, which is inside, and a grey background are used"
            }
        })
    }
}

/// Adds a camera and lights where there are none; `aspect` = width / height of the picture to come.
pub fn complete(scene: &mut Scene, aspect: f32) -> Vec<Note> {
    let camera = complete_camera(scene, aspect);
    let first = scene.cameras().first().cloned();
    let lights = first.and_then(|camera| complete_lights(scene, &camera, [0.0, 1.0, 0.0]));
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

/// Puts a scene in which nothing gives light into a studio, seen by `camera`; `up` is what is up there, +y unless it is clearly
/// another axis. A camera that stands in a room gets a lamp instead.
pub fn complete_lights(scene: &mut Scene, camera: &Camera, up: [f32; 3]) -> Option<Note> {
    if shines(scene) {
        return None;
    }
    complete_lights_around(scene, bounds_of(scene), camera, up)
}

/// The same for a scene that moves within `bounds`.
pub fn complete_lights_around(
    scene: &mut Scene,
    bounds: Option<Bounds>,
    camera: &Camera,
    up: [f32; 3],
) -> Option<Note> {
    if shines(scene) {
        return None;
    }
    let (axis, eye) = (studio::axis_of(up), camera.eye.map(f64::from));
    let is_within = bounds.is_some_and(|bounds| bounds.contains(eye)) && !is_open(scene, eye, axis);
    if let Some(lights) = is_within.then(|| lit_within(scene, camera)).flatten() {
        for light in lights {
            scene.add_light(light);
        }
        return Some(Note::Lamp);
    }
    let glows = glows(scene);
    studio::add(scene, camera, bounds, axis);
    Some(Note::Studio { glows })
}

/// Adds lights without extent, and nothing else, to a scene in which nothing gives light: for those who measure.
pub fn complete_plain_lights(scene: &mut Scene, camera: &Camera) -> Option<Note> {
    if shines(scene) {
        return None;
    }
    let (lights, note) = match lit_within(scene, camera) {
        Some(lights) => (lights, Note::Lamp),
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
            [Note::Camera, Note::Studio { glows: false }],
            "an empty scene has neither"
        );
        assert_eq!(scene.cameras().len(), 1, "one camera");
        assert_eq!(complete(&mut scene, 1.0), [], "now it has both");
    }
}
