// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras and clips of a scene that keys choose from: lists that are circles. Tests: `controls::tests`.

use gnurt::scene::{Camera, Scene};

/// A clip's name, and the times of its first and last key.
pub type NamedClip = (String, [f64; 2]);

/// Cameras and clips, and the chosen ones.
#[derive(Clone, Debug, Default)]
pub struct Choices {
    cameras: Vec<Camera>,
    camera: Option<usize>,
    clips: Vec<NamedClip>,
    clip: Option<usize>,
}

impl Choices {
    /// These, with a clip that is chosen already.
    #[must_use]
    pub fn new(cameras: Vec<Camera>, clips: Vec<NamedClip>, clip: Option<usize>) -> Self {
        Self { cameras, camera: None, clips, clip }
    }

    /// Those of a scene.
    #[must_use]
    pub fn of(scene: &Scene, clip: Option<usize>) -> Self {
        let clips = scene.animation().map(|animation| &animation.clips[..]).unwrap_or_default();
        let clips = clips.iter().map(|clip| (clip.name.clone(), clip.range())).collect();
        Self::new(scene.cameras().to_vec(), clips, clip)
    }

    /// The index of the chosen clip.
    #[must_use]
    pub fn clip(&self) -> Option<usize> {
        self.clip
    }

    /// The next camera of the list, or one before.
    pub(crate) fn next_camera(&mut self, by: isize) -> Option<&Camera> {
        self.camera = neighbour(self.camera, by, self.cameras.len());
        self.cameras.get(self.camera?)
    }

    /// The range of the next clip of the list, or of one before; `None` if there is no other one.
    pub(crate) fn next_clip(&mut self, by: isize) -> Option<[f64; 2]> {
        let next = neighbour(self.clip, by, self.clips.len());
        if next == self.clip {
            return None;
        }
        self.clip = next;
        self.clips.get(self.clip?).map(|(_, range)| *range)
    }

    /// A line about what was chosen by keys.
    pub(crate) fn line(&self) -> Option<String> {
        let camera = self.camera.and_then(|at| Some((at, &self.cameras.get(at)?.name)));
        let clip = self.clip.filter(|_| self.clips.len() > 1);
        let clip = clip.and_then(|at| Some((at, &self.clips.get(at)?.0)));
        let of = |what: &str, chosen: Option<(usize, &String)>, count: usize| {
            chosen.map(|(at, name)| format!("{what} {} of {count} {name}", at + 1))
        };
        let parts = [of("camera", camera, self.cameras.len()), of("clip", clip, self.clips.len())];
        let line = parts.into_iter().flatten().collect::<Vec<_>>().join("  ");
        (!line.is_empty()).then_some(line)
    }
}

/// The element of a list of this length at this distance; from none the first or the last one.
fn neighbour(at: Option<usize>, by: isize, count: usize) -> Option<usize> {
    let next = match at {
        Some(at) => at as isize + by,
        None if by > 0 => by - 1,
        None => by,
    };
    (count > 0).then(|| next.rem_euclid(count as isize) as usize)
}
