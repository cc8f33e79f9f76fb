// SPDX-License-Identifier: GPL-3.0-or-later
//! A scene, and its world, updated by edits. For the rebuilt parts see ARCHITECTURE.md, Edits. The world
//! shows a copy of the scene at one time, with default lights if it has none. Edits apply to both, so that a
//! commit does only the necessary work; where the copy differs from the scene, it is made again.
//! Tests: `tests/test_pictures.py::test_edits_show`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use gnurt::defaults::{self, Bounds, Purpose};
use gnurt::image::WorkingSpace;
use gnurt::osl::{CameraScript, Script};
use gnurt::render::{CommitOptions, Integrator, RenderOptions, ShaderTable, World};
use gnurt::scene::animation::Exposure;
use gnurt::scene::displacement::Offset;
use gnurt::scene::{Affine, Camera, CameraId, InstanceId, Scene, Surface, Texture, TextureId};
use gnurt::shading::texture::TextureSampler;
use gnurt::shading::{CameraShader, DisplacementShader, LightShader, PixelShader, SurfaceShader};
use gnurt::{FramePose, ThreadPool, camera_rays_along, named_camera_shader, put_named_shaders};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;

use crate::moments;

/// How a scene is to be seen.
pub(crate) struct View {
    pub(crate) camera: Aim,
    /// The clip and the time in it, in seconds.
    pub(crate) at: Option<(Clip, f64)>,
    /// For how long the shutter is open from then, in seconds.
    pub(crate) shutter: f64,
    /// Size, samples and integrator of the picture.
    pub(crate) picture: RenderOptions,
    /// Rays that replace the camera's, and the script that makes them.
    pub(crate) camera_shader: Option<(Script, CameraScript)>,
    /// The pixel shader, and its script.
    pub(crate) pixel_shader: Option<(Script, Arc<dyn PixelShader>)>,
    /// Motion during an open shutter, in addition to a clip.
    pub(crate) motion: Option<MotionKeys>,
    pub(crate) force_diffuse: bool,
    /// The space in which light is computed.
    pub(crate) space: WorkingSpace,
    /// Whether names of the scene go into the picture.
    pub(crate) needs_names: bool,
    /// The box around the clip at all of its times, where that is known.
    pub(crate) bounds: Option<Bounds>,
}

/// Transforms of instances, and cameras, at times evenly spaced while the shutter is open.
#[derive(Default)]
pub(crate) struct MotionKeys {
    /// By numbers of instances.
    pub(crate) instances: Vec<(usize, Vec<Affine>)>,
    /// Instances whose meshes move along their moments.
    pub(crate) meshes: Vec<usize>,
    /// Of the camera that is used.
    pub(crate) cameras: Vec<Camera>,
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
    pub(crate) camera: Arc<dyn CameraShader>,
    /// Stops that suit the light, where that is known before.
    pub(crate) exposure: Option<f32>,
    /// The light groups of its scene.
    pub(crate) groups: Vec<String>,
    /// The scene, if names of it are needed.
    pub(crate) named: Option<Scene>,
}

/// A frame of a film, and those before and after it.
pub(crate) struct Poses {
    pub(crate) now: FramePose,
    pub(crate) around: [Option<FramePose>; 2],
}

/// A scene with the scripts of its shaders, for light in Rec. 709, and the suns of its skies.
pub(crate) struct Parts {
    pub(crate) scene: Scene,
    pub(crate) surfaces: Vec<Script>,
    pub(crate) displacements: Vec<Script>,
    pub(crate) lights: Vec<Script>,
    pub(crate) suns: BTreeMap<u32, u32>,
}

/// A scene and its world.
#[derive(Default)]
pub(crate) struct Stage {
    scene: Scene,
    shown: Option<Shown>,
    /// The shaders of materials.
    shaders: ShaderTable,
    /// Those of its surfaces, lights and displacements, in order.
    scripts: Vec<Script>,
    light_scripts: Vec<Script>,
    displacement_scripts: Vec<Script>,
    /// The space that the shaders are made for.
    space: WorkingSpace,
    /// Those of the last view.
    of_view: Vec<Script>,
    /// Textures as shaders read them.
    samplers: BTreeMap<u32, Arc<TextureSampler>>,
    /// Lights that are the suns of others.
    pub(crate) suns: BTreeMap<u32, u32>,
    /// Pending and reported messages.
    progress: Vec<String>,
    reported: BTreeSet<String>,
}

struct Shown {
    scene: Scene,
    world: World,
    /// Whether it is posed at a time of a clip, which is no state to edit.
    is_posed: bool,
    /// Meshes have the shapes of moments, and not their own.
    is_bent: bool,
    /// Lights were added, for these.
    lit_for: Option<(Camera, bool)>,
    exposure: Option<f32>,
}

/// What the compiler says about a script, line by line.
fn warnings_of(script: &Script) -> impl Iterator<Item = String> {
    script.warnings().iter().map(|warning| warning.trim_end().to_owned())
}

impl Stage {
    /// Of a scene as it was read: shaders that its file names are compiled.
    pub(crate) fn of(mut scene: Scene) -> Self {
        let mut shaders = ShaderTable::default();
        let named = put_named_shaders(&mut scene, &mut shaders, WorkingSpace::Rec709);
        let (scripts, displacement_scripts) = (named.surfaces, named.displacements);
        Self { scene, shaders, scripts, displacement_scripts, progress: named.reported, ..Self::default() }
    }

    /// All that it is made of.
    pub(crate) fn parts(&self) -> Parts {
        Parts {
            scene: self.scene.clone(),
            surfaces: self.scripts.clone(),
            displacements: self.displacement_scripts.clone(),
            lights: self.light_scripts.clone(),
            suns: self.suns.clone(),
        }
    }

    /// Of parts: shaders are compiled.
    pub(crate) fn of_parts(parts: Parts) -> Result<Self, String> {
        let Parts { scene, surfaces, displacements, lights, suns } = parts;
        let displacement = |script: &Script| {
            let is_none = || format!("{}: it is no displacement", script.name());
            script.displacement()?.ok_or_else(is_none)
        };
        let shaders = ShaderTable {
            surfaces: surfaces.iter().map(Script::surface).collect::<Result<_, _>>()?,
            displacements: displacements.iter().map(displacement).collect::<Result<_, String>>()?,
            lights: lights.iter().map(Script::light).collect::<Result<_, _>>()?,
            ..ShaderTable::default()
        };
        let of_surfaces = scene.materials().iter().filter_map(|material| match material.surface {
            Surface::Shader(number) => Some((number, surfaces.len())),
            _ => None,
        });
        let of_displacements =
            scene.displacements().filter_map(|(_, displacement)| match displacement.offset {
                Offset::Shader(number) => Some((number, displacements.len())),
                _ => None,
            });
        if of_surfaces.chain(of_displacements).any(|(number, count)| number as usize >= count) {
            return Err("a shader of the scene is missing".into());
        }
        let (scripts, displacement_scripts, light_scripts) = (surfaces, displacements, lights);
        Ok(Self { scene, shaders, scripts, displacement_scripts, light_scripts, suns, ..Self::default() })
    }

    /// Its description, for another one, without the world.
    pub(crate) fn copy(&mut self) -> Self {
        let (shaders, scripts) = (self.shaders.clone(), self.scripts.clone());
        let (light_scripts, space) = (self.light_scripts.clone(), self.space);
        let (displacement_scripts, suns) = (self.displacement_scripts.clone(), self.suns.clone());
        let (scene, progress) = (self.scene.clone(), self.progress());
        Self {
            scene,
            shaders,
            scripts,
            light_scripts,
            displacement_scripts,
            space,
            suns,
            progress,
            ..Self::default()
        }
    }

    /// The number of a surface that a shader makes.
    pub(crate) fn add_script(&mut self, script: Script, surface: Arc<dyn SurfaceShader>) -> u32 {
        self.progress.extend(warnings_of(&script));
        // The next picture makes all of them for its space.
        self.reset_space();
        self.shaders.surfaces.push(surface);
        self.scripts.push(script);
        (self.shaders.surfaces.len() - 1) as u32
    }

    /// The number of a displacement.
    pub(crate) fn add_displacement(&mut self, shader: Arc<dyn DisplacementShader>, script: Script) -> u32 {
        self.progress.extend(warnings_of(&script));
        self.shaders.displacements.push(shader);
        self.displacement_scripts.push(script);
        (self.shaders.displacements.len() - 1) as u32
    }

    /// Shaders for light in Rec. 709, as new ones are.
    fn reset_space(&mut self) {
        // It succeeded for the space of now.
        let _ = self.set_space(WorkingSpace::default());
    }

    /// Shaders for light in this space.
    fn set_space(&mut self, space: WorkingSpace) -> Result<(), String> {
        if self.space == space {
            return Ok(());
        }
        let scripts: Vec<Script> = self.scripts.iter().map(|script| script.within(space)).collect();
        let lights: Vec<Script> = self.light_scripts.iter().map(|script| script.within(space)).collect();
        self.shaders.surfaces = scripts.iter().map(Script::surface).collect::<Result<_, _>>()?;
        self.shaders.lights = lights.iter().map(Script::light).collect::<Result<_, _>>()?;
        (self.scripts, self.light_scripts, self.space) = (scripts, lights, space);
        Ok(())
    }

    /// The number of a new light with a shader, or replaces such a light.
    pub(crate) fn put_light_script(
        &mut self,
        number: Option<usize>,
        script: Script,
        light: Arc<dyn LightShader>,
    ) -> PyResult<u32> {
        let count = self.shaders.lights.len();
        let number = number.unwrap_or(count);
        if number > count {
            return Err(PyIndexError::new_err(format!(
                "light: {number} is out of range; the scene has {count} light shaders"
            )));
        }
        self.progress.extend(warnings_of(&script));
        self.reset_space();
        if number == count {
            self.shaders.lights.push(light);
            self.light_scripts.push(script);
        } else {
            (self.shaders.lights[number], self.light_scripts[number]) = (light, script);
        }
        // Lights that were added because there were none.
        self.edit(|_| ());
        Ok(number as u32)
    }

    /// The texture of a number.
    pub(crate) fn texture(&self, number: usize) -> PyResult<Texture> {
        let all = self.scene.textures();
        all.get(number).cloned().ok_or_else(|| crate::textures::unknown(number, all.len()))
    }

    /// The same as shaders read it.
    pub(crate) fn sampler(&mut self, number: usize) -> PyResult<Arc<TextureSampler>> {
        let texels = self.texture(number)?.texels;
        let made = || Arc::new(gnurt::osl::sampler(texels));
        Ok(self.samplers.entry(number as u32).or_insert_with(made).clone())
    }

    /// Replaces a texture; shaders keep the old one.
    pub(crate) fn set_texture(&mut self, number: usize, texture: &Texture) -> PyResult<()> {
        self.texture(number)?;
        self.samplers.remove(&(number as u32));
        self.edit(|scene| *scene.edit_texture(TextureId(number as u32)) = texture.clone());
        Ok(())
    }

    /// Unreported messages of shaders.
    pub(crate) fn progress(&mut self) -> Vec<String> {
        let of_scene = self.scripts.iter().chain(&self.light_scripts).chain(&self.displacement_scripts);
        let faults = of_scene.chain(&self.of_view).flat_map(Script::faults);
        let progress = std::mem::take(&mut self.progress).into_iter().chain(faults);
        progress.filter(|line| self.reported.insert(line.clone())).collect()
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

    /// Changes a value by text, as the program's `--set` does.
    pub(crate) fn change(&mut self, change: &str) -> Result<(), String> {
        let change = gnurt::Override::parse(change)?;
        self.shown = None;
        change.apply(&mut self.scene)
    }

    /// Makes it ready.
    pub(crate) fn shoot(&mut self, view: &View, pool: &ThreadPool) -> PyResult<Shot> {
        let error = |error: &dyn std::fmt::Display| PyValueError::new_err(error.to_string());
        self.set_space(view.space).map_err(|why| error(&why))?;
        let clip = self.clip(view)?;
        let bounds = match view.bounds {
            Some(bounds) => Some(bounds),
            None => clip.and_then(|(clip, _)| defaults::bounds_over(&mut self.scene.clone(), clip)),
        };
        let camera = self.camera(view, bounds)?;
        let number = if matches!(view.camera, Aim::Own(_)) { None } else { self.number(view)? };
        let camera_shader = self.camera_shader(view, number);
        let is_plain = matches!(view.picture.integrator, Integrator::Eyelight | Integrator::Normals);
        let request = (camera.clone(), is_plain);
        if self.shown.as_ref().is_some_and(|shown| shown.is_bent) {
            self.shown = None;
        }
        if self.shown.as_ref().is_some_and(|shown| shown.lit_for.as_ref().is_some_and(|lit| *lit != request))
        {
            self.shown = None;
        }
        let shown = self.shown.get_or_insert_with(|| Shown::new(&self.scene, &self.shaders, bounds, request));
        let mut exposure = Exposure::default();
        match clip {
            Some((clip, opens)) => {
                exposure = shown.scene.expose(clip, opens, opens + view.shutter);
                shown.is_posed = true;
            }
            None if shown.is_posed => {
                shown.scene.rest();
            }
            None => {}
        }
        if let Some(motion) = &view.motion {
            shown.move_along(motion, &mut exposure)?;
            if motion.cameras.len() > 1 {
                // Rays have times only where something moves; no camera of the scene has this number.
                exposure.cameras.push((CameraId(u32::MAX), motion.cameras.clone()));
            }
        }
        // A camera of the scene moves with it.
        let camera = number.map_or(camera, |number| shown.scene.cameras()[number].clone());
        let (force_diffuse, space) = (view.force_diffuse, view.space);
        let options = CommitOptions { force_diffuse, space, ..CommitOptions::default() };
        let options = options.for_picture(&shown.scene, &view.picture);
        let pixel = view.pixel_shader.as_ref().map(|(_, pixel)| pixel.clone());
        let shaders = ShaderTable { pixel, ..self.shaders.clone() };
        let scene = &shown.scene;
        let committed = shown.world.commit_exposed(scene, &exposure, &shaders, &options, pool);
        self.progress.extend(committed.map_err(|why| error(&why))?.warnings);
        let no_view = || PyValueError::new_err("camera: has no view: a number of it is too large");
        let moves = exposure.cameras.iter().find(|(id, _)| Some(id.index()) == number);
        let keys = moves.map_or(std::slice::from_ref(&camera), |(_, keys)| keys);
        let keys = view
            .motion
            .as_ref()
            .map(|motion| &motion.cameras[..])
            .filter(|keys| !keys.is_empty())
            .unwrap_or(keys);
        let rays = camera_rays_along(keys, camera_shader.as_ref(), [view.picture.width, view.picture.height])
            .ok_or_else(no_view)?;
        let exposure =
            if view.picture.integrator == Integrator::Normals { Some(0.0) } else { shown.exposure };
        let groups = scene.labels().group_names().into_iter().map(str::to_owned).collect();
        let named = view.needs_names.then(|| scene.clone());
        Ok(Shot { world: shown.world.clone(), camera: rays, exposure, groups, named })
    }

    /// The box around the clip of a view at all of its times.
    pub(crate) fn bounds(&self, view: &View) -> PyResult<Option<Bounds>> {
        let clip = self.clip(view)?;
        Ok(clip.and_then(|(clip, _)| defaults::bounds_over(&mut self.scene.clone(), clip)))
    }

    /// The first time of a view's clip, in seconds.
    pub(crate) fn clip_start(&self, view: &View) -> PyResult<Option<f64>> {
        let clip = self.clip(view)?;
        Ok(clip.and_then(|(clip, _)| Some(self.scene.animation()?.clips.get(clip)?.range()[0])))
    }

    /// Makes a frame of a clip ready, with its pose and those at two other times.
    pub(crate) fn shoot_between(
        &mut self,
        view: &View,
        around: [Option<f64>; 2],
        pool: &ThreadPool,
    ) -> PyResult<(Shot, Poses)> {
        let shot = self.shoot(view, pool)?;
        let clip = self.clip(view)?.map_or(0, |(clip, _)| clip);
        let number = if matches!(view.camera, Aim::Own(_)) { None } else { self.number(view)? };
        let own = self.camera(view, view.bounds)?;
        let shown = self.shown.as_mut().ok_or_else(|| PyValueError::new_err("the scene is not shown"))?;
        let pose = |scene: &Scene| {
            let camera = number.map_or(&own, |number| &scene.cameras()[number]);
            FramePose::of(scene, camera)
        };
        let now = pose(&shown.scene);
        let around = around.map(|time| {
            time.map(|seconds| {
                shown.scene.pose(clip, seconds);
                pose(&shown.scene)
            })
        });
        Ok((shot, Poses { now, around }))
    }

    /// The shader of camera rays: the requested one, or that of the scene's file.
    fn camera_shader(&mut self, view: &View, number: Option<usize>) -> Option<CameraScript> {
        let named = number.filter(|_| view.camera_shader.is_none()).and_then(|number| {
            let made = named_camera_shader(&self.scene, CameraId(number as u32));
            made.unwrap_or_else(|why| {
                self.progress.push(why);
                None
            })
        });
        let camera = view.camera_shader.clone().or(named);
        self.of_view.clear();
        self.of_view.extend(view.pixel_shader.iter().map(|(script, _)| script.clone()));
        self.of_view.extend(camera.iter().map(|(script, _)| script.clone()));
        for script in &self.of_view {
            self.progress.extend(warnings_of(script));
        }
        camera.map(|(_, camera)| camera)
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
                "animation: unknown clip '{name}'; the scene has {}",
                listed(&names)
            ))),
        }
    }

    /// The number of the scene's camera for this view; `None` if it has none.
    fn number(&self, view: &View) -> PyResult<Option<usize>> {
        let cameras = self.scene.cameras();
        match &view.camera {
            Aim::Number(number) if *number < cameras.len() => Ok(Some(*number)),
            Aim::Number(number) => Err(PyIndexError::new_err(format!(
                "camera: {number} is out of range; the scene has {}",
                cameras.len()
            ))),
            Aim::Named(name) => {
                let found = cameras.iter().position(|camera| camera.name == *name);
                found.map(Some).ok_or_else(|| {
                    let names: Vec<&str> = cameras.iter().map(|camera| &camera.name[..]).collect();
                    PyValueError::new_err(format!(
                        "camera: unknown name '{name}'; the scene has {}",
                        listed(&names)
                    ))
                })
            }
            Aim::First | Aim::Own(_) => Ok((!cameras.is_empty()).then_some(0)),
        }
    }

    fn camera(&self, view: &View, bounds: Option<Bounds>) -> PyResult<Camera> {
        if let Aim::Own(camera) = &view.camera {
            return Ok(camera.clone());
        }
        let aspect = view.picture.width as f32 / view.picture.height as f32;
        Ok(match self.number(view)? {
            Some(number) => self.scene.cameras()[number].clone(),
            None => defaults::framing(bounds.or_else(|| defaults::bounds_of(&self.scene)), aspect),
        })
    }
}

impl Shown {
    /// Moves instances along their keys while the shutter is open.
    fn move_along(&mut self, motion: &MotionKeys, exposure: &mut Exposure) -> PyResult<()> {
        let count = self.scene.instances().len();
        for (number, keys) in &motion.instances {
            if *number >= count {
                return Err(PyIndexError::new_err(format!(
                    "motion: instance {number} is out of range; the scene has {count}"
                )));
            }
            let id = InstanceId(*number as u32);
            self.scene.edit_instance(id).world_from_object = keys[0];
            if keys.len() > 1 {
                exposure.instances.push((id, keys.clone()));
            }
            self.is_posed = true;
        }
        exposure.instances.sort_by_key(|(id, _)| id.0);
        for number in &motion.meshes {
            if *number >= count {
                return Err(PyIndexError::new_err(format!(
                    "motion: instance {number} is out of range; the scene has {count}"
                )));
            }
            let object = self.scene.instance(InstanceId(*number as u32)).object;
            for id in self.scene.object(object).meshes.clone() {
                let keys = moments::of(self.scene.mesh(id)).map_err(PyValueError::new_err)?;
                if exposure.meshes.iter().all(|(known, _)| *known != id) {
                    self.scene.replace_mesh(id, keys[0].clone());
                    exposure.meshes.push((id, keys));
                }
            }
            (self.is_posed, self.is_bent) = (true, true);
        }
        exposure.meshes.sort_by_key(|(id, _)| id.0);
        Ok(())
    }

    fn new(
        scene: &Scene,
        shaders: &ShaderTable,
        bounds: Option<Bounds>,
        (camera, is_plain): (Camera, bool),
    ) -> Self {
        let mut scene = scene.clone();
        let up = [0.0, 1.0, 0.0];
        let note = match bounds {
            _ if is_plain => defaults::complete_plain_lights(&mut scene, shaders, &camera),
            Some(_) => {
                defaults::complete_lights_around(&mut scene, shaders, bounds, &camera, up, Purpose::Screen)
            }
            None => defaults::complete_lights(&mut scene, shaders, &camera, up, Purpose::Screen),
        };
        Self {
            scene,
            world: World::new(),
            is_posed: false,
            is_bent: false,
            lit_for: note.map(|_| (camera, is_plain)),
            exposure: note.and_then(defaults::Note::exposure),
        }
    }
}

/// Names as messages give them.
fn listed(names: &[&str]) -> String {
    match names {
        [] => "none".into(),
        _ => format!("'{}'", names.join("', '")),
    }
}
