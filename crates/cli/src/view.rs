// SPDX-License-Identifier: GPL-3.0-or-later
//! The camera of a picture: the scene's, the requested one, or a default one, each part of it replaceable.
//! See docs/reference/cli.md. Tests: `tests/program/cameras.rs`.

use std::sync::Arc;

use gnurt::defaults::{self, Bounds, Purpose};
use gnurt::image::system_reason;
use gnurt::render::{Integrator, ShaderTable};
use gnurt::scene::animation::Exposure;
use gnurt::scene::{Camera, Lens, Projection, Scene};
use gnurt::shading::CameraShader;
use gnurt::{camera_rays, camera_rays_along};

use crate::arguments::{Resolution, ViewArguments};
use crate::failure::Failure;
use crate::messages::Messages;
use crate::nearest::nearest;
use crate::shaders::{self, CameraShaderChoice};
use crate::workers::with_workers;

/// Checks that need no scene.
pub(crate) fn check(view: &ViewArguments) -> Result<(), Failure> {
    if let Some(path) = view.surroundings.file()
        && let Err(error) = std::fs::metadata(path)
    {
        return Err(Failure::data(format_args!(
            "--environment {}: {}; give a picture, a radiance like 1,1,1 or builtin:day",
            path.display(),
            system_reason(&error)
        )));
    }
    for volume in &view.surroundings.volumes {
        if let Err(error) = std::fs::metadata(volume.path()) {
            let (path, reason) = (volume.path().display(), system_reason(&error));
            return Err(Failure::data(format_args!("--volume {path}: {reason}")));
        }
    }
    if let Some(choice) = view.camera_shader() {
        let of_lenses = [
            ("--fov", view.fov.is_some()),
            ("--projection", view.projection.is_some()),
            ("--view-height", view.view_height.is_some()),
            ("--shift", view.shift.is_some()),
            ("--aperture", view.aperture.is_some()),
            ("--focus", view.focus.is_some()),
        ];
        if let Some((option, _)) = of_lenses.iter().find(|(_, is_given)| *is_given) {
            return Err(Failure::usage(format_args!(
                "{option} conflicts with --camera {}, which makes all rays; give its parameters as {}:NAME=VALUE",
                choice.class, choice.class
            )));
        }
    }
    match (view.eye, view.target) {
        (Some(eye), Some(target)) if eye == target => Err(same_place()),
        _ => Ok(()),
    }
}

/// How a scene is seen.
#[derive(Clone)]
pub(crate) struct Chosen {
    pub(crate) camera: Camera,
    pub(crate) rays: Arc<dyn CameraShader>,
    /// The shader that makes them, if one does.
    pub(crate) shader: Option<CameraShaderChoice>,
    /// The exposure for the added light, in stops.
    pub(crate) exposure: Option<f32>,
}

impl Chosen {
    /// The exposure of an integrator's pictures, where it is known before: that of light that was added, and none for colours that
    /// are no light.
    pub(crate) fn exposure_of(&self, integrator: Integrator) -> Option<f32> {
        if integrator == Integrator::Normals { Some(0.0) } else { self.exposure }
    }
}

/// The camera's position, where a scene has no light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Lit for this use of the picture.
    Studio(Purpose),
    /// Under lights and nothing else: where it is measured, or only its shapes are shown.
    Plain,
}

impl Stage {
    /// The view for pictures of this integrator, for screens or as files of floats.
    pub(crate) fn of(integrator: Integrator, is_for_screens: bool) -> Self {
        match integrator {
            Integrator::Eyelight | Integrator::Normals => Self::Plain,
            _ => Self::Studio(if is_for_screens { Purpose::Screen } else { Purpose::Numbers }),
        }
    }
}

/// The camera, and its rays; puts the scene into its surroundings, adds cameras and lights if it and `table`
/// have none, and reports that. The scene's shaders are applied by then: added objects retain their own
/// surfaces.
pub(crate) fn choose(
    scene: &mut Scene,
    table: &ShaderTable,
    view: &ViewArguments,
    resolution: Resolution,
    stage: Stage,
    messages: Messages,
) -> Result<Chosen, Failure> {
    choose_around(scene, table, None, view, resolution, stage, messages)
}

/// The same for a scene that moves within `bounds`; `None` = that stays where it is.
pub(crate) fn choose_around(
    scene: &mut Scene,
    table: &ShaderTable,
    bounds: Option<Bounds>,
    view: &ViewArguments,
    resolution: Resolution,
    stage: Stage,
    messages: Messages,
) -> Result<Chosen, Failure> {
    let aspect = resolution.width as f32 / resolution.height as f32;
    if scene.cameras().is_empty() && view.camera_name().is_some() {
        find_named(scene, view)?;
    }
    let note = match bounds {
        Some(_) => defaults::complete_camera_around(scene, bounds, aspect),
        None => defaults::complete_camera(scene, aspect),
    };
    let shader = shaders::camera(scene, find_named(scene, view)?.unwrap_or(0), view, messages)?;
    let (camera, rays) = aim(scene, view, shader.as_ref(), resolution)?;
    if let Some(note) = note {
        let is_all_given = view.eye.is_some() && view.target.is_some();
        if !is_all_given {
            messages.note(note);
        }
    }
    if camera.frame().is_some_and(|frame| frame.up_replaced) {
        messages.warning("the camera's up is parallel to its view; another up is used");
    }
    if let Some(environment) = &view.surroundings.environment {
        let up = view.up.unwrap_or([0.0, 1.0, 0.0]);
        let turn = view.surroundings.environment_turn;
        with_workers(|workers| environment.put_around(scene, up, turn, workers)).map_err(Failure::data)?;
    }
    for volume in &view.surroundings.volumes {
        volume.add_to(scene).map_err(Failure::data)?;
    }
    if let Some(fog) = &view.surroundings.fog {
        fog.put_around(scene, camera.eye);
    }
    let added = match stage {
        Stage::Studio(purpose) => {
            let up = view.up.unwrap_or([0.0, 1.0, 0.0]);
            match bounds {
                Some(_) => defaults::complete_lights_around(scene, table, bounds, &camera, up, purpose),
                None => defaults::complete_lights(scene, table, &camera, up, purpose),
            }
        }
        Stage::Plain => defaults::complete_plain_lights(scene, table, &camera),
    };
    if let Some(note) = added {
        messages.note(note);
    }
    Ok(Chosen { camera, rays, shader, exposure: added.and_then(defaults::Note::exposure) })
}

/// Says what an integrator leaves out of a scene.
pub(crate) fn tell_left_out(scene: &Scene, integrator: Integrator, messages: Messages) {
    if scene.has_media() && integrator.without_pilot() != Integrator::Path {
        messages.warning(format_args!(
            "--integrator {integrator} leaves out media that scatter or give off light; path shows them"
        ));
    }
    if !scene.labels().light_links.is_empty() && integrator.without_pilot() != Integrator::Path {
        messages.warning(format_args!(
            "--integrator {integrator} ignores the links of lights to instances; path follows them"
        ));
    }
}

/// The requested camera, posed as in the scene now, and its rays.
pub(crate) fn aim(
    scene: &Scene,
    view: &ViewArguments,
    shader: Option<&CameraShaderChoice>,
    resolution: Resolution,
) -> Result<(Camera, Arc<dyn CameraShader>), Failure> {
    let named = find_named(scene, view)?.unwrap_or(0);
    let camera = replaced(&scene.cameras()[named], view)?;
    if camera.eye == camera.target {
        return Err(same_place());
    }
    if let Some(fault) = camera.fault() {
        let is_by_angle = Camera { fov_y: 45.0, ..camera.clone() }.fault().is_none();
        let option = view.fov.filter(|_| is_by_angle).map(|fov| format!("--fov '{fov}': "));
        let option = option.unwrap_or_default();
        return Err(Failure::usage(format_args!("{option}the camera shows nothing: {fault}")));
    }
    let size = [resolution.width, resolution.height];
    let rays = camera_rays(&camera, shader.map(|shader| &shader.camera), size).ok_or_else(no_view)?;
    Ok((camera, rays))
}

/// The motion of that camera while the shutter is open, and its rays, if it moves then.
pub(crate) fn motion(
    scene: &Scene,
    exposure: &Exposure,
    view: &ViewArguments,
    shader: Option<&CameraShaderChoice>,
    resolution: Resolution,
) -> Result<Option<CameraMotion>, Failure> {
    let named = find_named(scene, view)?.unwrap_or(0);
    let keys = exposure.cameras.iter().find(|(id, _)| id.index() == named).map(|(_, keys)| keys);
    let keys = keys.into_iter().flatten().map(|camera| replaced(camera, view));
    let keys: Vec<Camera> = keys.collect::<Result<_, _>>()?;
    if keys.iter().all(|key| *key == keys[0]) {
        return Ok(None);
    }
    let size = [resolution.width, resolution.height];
    let rays = camera_rays_along(&keys, shader.map(|shader| &shader.camera), size).ok_or_else(no_view)?;
    Ok(Some(CameraMotion { keys, rays }))
}

/// A camera that moves while the shutter is open.
pub(crate) struct CameraMotion {
    pub(crate) keys: Vec<Camera>,
    pub(crate) rays: Arc<dyn CameraShader>,
}

fn no_view() -> Failure {
    Failure::usage("the camera has no view: a number of it is too large or too small")
}

fn find_named(scene: &Scene, view: &ViewArguments) -> Result<Option<usize>, Failure> {
    match view.camera_name() {
        Some(name) => find(scene.cameras(), name).map(Some),
        // The one that its file wants.
        None => Ok(scene.labels().camera.map(|id| id.index())),
    }
}

fn same_place() -> Failure {
    Failure::usage("--eye and --target are the same point; they must differ")
}

/// `camera` with the given parts replaced.
fn replaced(camera: &Camera, view: &ViewArguments) -> Result<Camera, Failure> {
    let mut replaced = Camera {
        eye: view.eye.unwrap_or(camera.eye),
        target: view.target.unwrap_or(camera.target),
        up: view.up.unwrap_or(camera.up),
        fov_y: view.fov.unwrap_or(camera.fov_y),
        projection: view.projection.unwrap_or(camera.projection),
        lens: Lens {
            aperture: view.aperture.unwrap_or(camera.lens.aperture),
            focus: view.focus.or(camera.lens.focus),
        },
        shift: view.shift.unwrap_or(camera.shift),
        ..camera.clone()
    };
    if view.shift.is_none() && !replaced.projection.is_flat() {
        replaced.shift = [0.0; 2];
    }
    let retained = match camera.projection {
        Projection::Orthographic { height } => Some(height),
        _ => None,
    };
    let like_perspective = replaced.height_at_target();
    if let Projection::Orthographic { height } = &mut replaced.projection {
        *height = view.view_height.or(retained).unwrap_or(like_perspective);
    } else if view.view_height.is_some() {
        let message =
            format!("--view-height is of orthographic cameras, and this is a {}", replaced.projection);
        return Err(Failure::usage(format_args!(
            "{message}; add --projection orthographic, or leave it out"
        )));
    }
    if view.focus.is_some() && replaced.lens.aperture == 0.0 {
        return Err(Failure::usage(
            "--focus has no effect on a pinhole, which sees all sharp; give an --aperture as well",
        ));
    }
    Ok(replaced)
}

/// The index of the camera of this name, or else of this number.
fn find(cameras: &[Camera], name: &str) -> Result<usize, Failure> {
    let by_name = cameras.iter().position(|camera| camera.name == name);
    let by_number = || name.parse().ok().filter(|&index| index < cameras.len());
    by_name.or_else(by_number).ok_or_else(|| Failure::usage(unknown_camera(cameras, name)))
}

fn unknown_camera(cameras: &[Camera], name: &str) -> String {
    if cameras.is_empty() {
        return format!("--camera '{name}': the scene has no camera; place one with --eye and --target");
    }
    let names: Vec<&str> = cameras.iter().map(|camera| &camera.name[..]).collect();
    let meant = nearest(name, &names).map(|meant| format!("did you mean '{meant}'? ")).unwrap_or_default();
    let list: Vec<String> = names.iter().enumerate().map(|(i, name)| format!("{i} '{name}'")).collect();
    format!("--camera '{name}': no such camera; {meant}valid are: {}", list.join(", "))
}
