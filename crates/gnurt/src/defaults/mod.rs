// SPDX-License-Identifier: GPL-3.0-or-later
//! What a scene gets that lacks a camera or any light, so that every scene can be looked at.
//! Source: original; the key light over the left shoulder is the custom of scan repositories and of ../shared/scenes.
//! Space: world, y upwards. Proof: `tests` of the submodules.

mod bounds;
mod camera;
mod lights;
mod sight;

use std::fmt;

pub use bounds::{Bounds, bounds_of};
pub use camera::framing;
pub use lights::{lit_from, lit_within, shines};

use crate::scene::{Camera, Scene};

/// Something that was added to a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Note {
    /// A camera that shows everything.
    Camera,
    /// A key light and a grey background.
    Lights,
    /// A lamp beside the camera, which stands within the scene, and a grey background.
    Lamp,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Camera => "the scene has no camera; one that shows all of it is used",
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
    let lights = first.and_then(|camera| complete_lights(scene, &camera));
    camera.into_iter().chain(lights).collect()
}

/// Adds a camera that shows everything if there is none.
pub fn complete_camera(scene: &mut Scene, aspect: f32) -> Option<Note> {
    if !scene.cameras().is_empty() {
        return None;
    }
    let camera = framing(bounds_of(scene), aspect);
    scene.add_camera(camera);
    Some(Note::Camera)
}

/// Adds lights that suit `camera` if nothing in the scene gives light.
pub fn complete_lights(scene: &mut Scene, camera: &Camera) -> Option<Note> {
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
        assert_eq!(complete(&mut scene, 1.0), [Note::Camera, Note::Lights], "an empty scene has neither");
        assert_eq!(scene.cameras().len(), 1, "one camera");
        assert_eq!(complete(&mut scene, 1.0), [], "now it has both");
    }
}
