// SPDX-License-Identifier: GPL-3.0-or-later
//! A scene, and what of it is ready for rays. Source: original; what an edit makes again: ARCHITECTURE.md, Edits.
//! What is shown is a copy with lights where there are none, at a moment. Edits of the scene go to both, so that a commit does what
//! is due; where the copy differs from the scene, it is made anew. Proof: `tests/test_pictures.py::test_edits_show`.

use gnurt::ThreadPool;
use gnurt::defaults::{self, Bounds};
use gnurt::render::{CommitOptions, Integrator, SceneCamera, ShaderTable, World};
use gnurt::scene::{Camera, Scene};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;

/// How a scene is to be seen.
pub(crate) struct View {
    pub(crate) camera: Aim,
    /// The clip and the moment of it, in seconds.
    pub(crate) at: Option<(Clip, f64)>,
    pub(crate) aspect: f32,
    pub(crate) integrator: Integrator,
    pub(crate) force_diffuse: bool,
}

/// Which camera.
pub(crate) enum Aim {
    First,
    Number(usize),
    Named(String),
    Own(Camera),
}

/// Which clip of an animation.
pub(crate) enum Clip {
    First,
    Named(String),
}

/// A world and a camera that are ready.
pub(crate) struct Shot {
    pub(crate) world: World,
    pub(crate) camera: SceneCamera,
    /// Stops that suit the light, where that is known before.
    pub(crate) exposure: Option<f32>,
}

/// A scene and its world.
#[derive(Default)]
pub(crate) struct Stage {
    scene: Scene,
    shown: Option<Shown>,
}

struct Shown {
    scene: Scene,
    world: World,
    /// Whether it is at a moment of a clip, which is no state to edit.
    is_posed: bool,
    /// Lights were added, for these.
    lit_for: Option<(Camera, bool)>,
    exposure: Option<f32>,
}

impl Stage {
    pub(crate) fn of(scene: Scene) -> Self {
        Self { scene, shown: None }
    }

    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Edits the scene, twice where it is shown: as often as that gives the same.
    pub(crate) fn edit<R>(&mut self, mut edit: impl FnMut(&mut Scene) -> R) -> R {
        match &mut self.shown {
            Some(shown) if !shown.is_posed && shown.lit_for.is_none() => {
                edit(&mut shown.scene);
            }
            _ => self.shown = None,
        }
        edit(&mut self.scene)
    }

    /// Makes it ready.
    pub(crate) fn shoot(&mut self, view: &View, pool: &ThreadPool) -> PyResult<Shot> {
        let clip = self.clip(view)?;
        let bounds = clip.and_then(|(clip, _)| defaults::bounds_over(&mut self.scene.clone(), clip));
        let camera = self.camera(view, bounds)?;
        let number = if matches!(view.camera, Aim::Own(_)) { None } else { self.number(view)? };
        let is_plain = matches!(view.integrator, Integrator::Eyelight | Integrator::Normals);
        let wanted = (camera.clone(), is_plain);
        if self.shown.as_ref().is_some_and(|shown| shown.lit_for.as_ref().is_some_and(|lit| *lit != wanted)) {
            self.shown = None;
        }
        let shown = self.shown.get_or_insert_with(|| Shown::new(&self.scene, bounds, wanted));
        match clip {
            Some((clip, seconds)) => {
                shown.scene.pose(clip, seconds);
                shown.is_posed = true;
            }
            None if shown.is_posed => {
                shown.scene.rest();
            }
            None => {}
        }
        // A camera of the scene moves with it.
        let camera = number.map_or(camera, |number| shown.scene.cameras()[number].clone());
        let options = CommitOptions { force_diffuse: view.force_diffuse, ..CommitOptions::default() };
        let error = |error: &dyn std::fmt::Display| PyValueError::new_err(error.to_string());
        let table = ShaderTable::default();
        shown.world.commit(&shown.scene, &table, &options, pool).map_err(|why| error(&why))?;
        let rays = SceneCamera::new(&camera)
            .ok_or_else(|| PyValueError::new_err("camera: has no view: a number of it is too large"))?;
        let exposure = if view.integrator == Integrator::Normals { Some(0.0) } else { shown.exposure };
        Ok(Shot { world: shown.world.clone(), camera: rays, exposure })
    }

    fn clip(&self, view: &View) -> PyResult<Option<(usize, f64)>> {
        let Some((clip, seconds)) = &view.at else { return Ok(None) };
        let clips = self.scene.animation().map_or(&[][..], |animation| &animation.clips);
        let found = match clip {
            Clip::First => (!clips.is_empty()).then_some(0),
            Clip::Named(name) => clips.iter().position(|clip| clip.name == *name),
        };
        let names: Vec<&str> = clips.iter().map(|clip| &clip.name[..]).collect();
        match (found, clip) {
            (Some(found), _) => Ok(Some((found, *seconds))),
            (None, Clip::First) => Err(PyValueError::new_err("at: the scene has no animation")),
            (None, Clip::Named(name)) => Err(PyValueError::new_err(format!(
                "animation: there is no '{name}'; the scene has {names:?}"
            ))),
        }
    }

    /// The place of the scene's camera that is meant; `None` if it has none.
    fn number(&self, view: &View) -> PyResult<Option<usize>> {
        let cameras = self.scene.cameras();
        match &view.camera {
            Aim::Number(number) if *number < cameras.len() => Ok(Some(*number)),
            Aim::Number(number) => Err(PyIndexError::new_err(format!(
                "camera: there is no camera {number}; the scene has {}",
                cameras.len()
            ))),
            Aim::Named(name) => {
                let found = cameras.iter().position(|camera| camera.name == *name);
                found.map(Some).ok_or_else(|| {
                    let names: Vec<&str> = cameras.iter().map(|camera| &camera.name[..]).collect();
                    PyValueError::new_err(format!("camera: there is no '{name}'; the scene has {names:?}"))
                })
            }
            Aim::First | Aim::Own(_) => Ok((!cameras.is_empty()).then_some(0)),
        }
    }

    fn camera(&self, view: &View, bounds: Option<Bounds>) -> PyResult<Camera> {
        if let Aim::Own(camera) = &view.camera {
            return Ok(camera.clone());
        }
        Ok(match self.number(view)? {
            Some(number) => self.scene.cameras()[number].clone(),
            None => defaults::framing(bounds.or_else(|| defaults::bounds_of(&self.scene)), view.aspect),
        })
    }
}

impl Shown {
    fn new(scene: &Scene, bounds: Option<Bounds>, (camera, is_plain): (Camera, bool)) -> Self {
        let mut scene = scene.clone();
        let up = [0.0, 1.0, 0.0];
        let note = match bounds {
            _ if is_plain => defaults::complete_plain_lights(&mut scene, &camera),
            Some(_) => defaults::complete_lights_around(&mut scene, bounds, &camera, up),
            None => defaults::complete_lights(&mut scene, &camera, up),
        };
        Self {
            scene,
            world: World::new(),
            is_posed: false,
            lit_for: note.map(|_| (camera, is_plain)),
            exposure: note.and_then(defaults::Note::exposure),
        }
    }
}
