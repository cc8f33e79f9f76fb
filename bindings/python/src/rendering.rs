// SPDX-License-Identifier: GPL-3.0-or-later
//! Options of a picture, and progressive pictures. Names as the program's options.
//! Tests: `tests/test_pictures.py`.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use gnurt::denoise::Method;
use gnurt::image::{self, WorkingSpace};
use gnurt::layers::{self, LayerList};
use gnurt::mattes;
use gnurt::memory::check_memory;
use gnurt::osl::{Access, CameraScript, Script};
use gnurt::render::{
    Accumulation, Integrator, LightLayer, Mattes, RenderError, RenderOptions, RenderStats, missing_output,
    render_on, unknown_labels,
};
use gnurt::scene::Affine;
use gnurt::shading::PixelShader;
use pyo3::exceptions::{PyMemoryError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;

use crate::arrays::transform;
use crate::describing;
use crate::given::Given;
use crate::picture::{Picture, take_noise_out};
use crate::pool::ThreadCount;
use crate::scripts::script_named;
use crate::stage::{Aim, Clip, MotionKeys, Shot, View};
use crate::watch::{Watch, watched};

/// All arguments of a rendering.
pub(crate) struct BuildRequest {
    pub(crate) view: View,
    pub(crate) threads: ThreadCount,
    layers: bool,
    /// The layers that are kept; `None` = all that there are.
    list: Option<LayerList>,
    light_groups: bool,
    denoise: Option<Method>,
}

impl BuildRequest {
    pub(crate) fn new(arguments: &Bound<'_, PyDict>) -> PyResult<Self> {
        const SIDE: u64 = 1 << 31;
        const MOST: f64 = f32::MAX as f64;
        let mut given = Given::new(arguments);
        let side = |given: &mut Given, name, default| -> PyResult<u32> {
            Ok(given.whole(name, 1, SIDE)?.unwrap_or(default) as u32)
        };
        let default = RenderOptions::default();
        let (width, height) = (side(&mut given, "width", 640)?, side(&mut given, "height", 480)?);
        let (has_layers, list) = layer_list(&mut given)?;
        let light_groups = given.flag("light_groups")?.unwrap_or(false);
        let layers = has_layers || light_groups;
        let depth = given.whole("crypto_depth", 2, Mattes::DEEPEST.into())?;
        let denoise = denoiser(&mut given)?;
        let crop: Option<[f32; 4]> = given.numbers("crop")?;
        let time = given.number("time", 0.001, 1e9)?;
        let options = RenderOptions {
            width,
            height,
            spp: given.whole("spp", 1, (1 << 31) - 1)?.unwrap_or(16) as u32,
            seed: given.whole("seed", 0, u64::MAX)?.unwrap_or(0),
            integrator: given.choice("integrator")?.unwrap_or(gnurt::render::Integrator::Path),
            filter: given.choice("filter")?.unwrap_or_default(),
            pixel_noise: given.choice("pixel_noise")?.unwrap_or_default(),
            max_depth: given.whole("max_depth", 1, 1 << 16)?.unwrap_or(16) as u32,
            vpls: given.whole("vpls", 1, 1 << 24)?.unwrap_or(1024) as u32,
            clamp: given.number("clamp", 0.0, MOST)?.map(|x| x as f32),
            guiding: given.choice("guide")?.unwrap_or_default(),
            caustics: given.choice("caustics")?.unwrap_or_default(),
            noise: given.number("noise", 1e-6, 1.0)?.map(|x| x as f32),
            crop: crop.map(|corners| corners.map(|x| x.max(0.0) as u32)),
            time_limit: time.map(Duration::from_secs_f64),
            aovs: layers || denoise.is_some(),
            seen: denoise.is_some() || list.as_ref().is_some_and(LayerList::has_seen),
            light_layers: list.iter().flat_map(|list| list.light.clone()).collect(),
            mattes: Mattes {
                kinds: list.iter().flat_map(|list| list.mattes.clone()).collect(),
                depth: depth.map_or(Mattes::DEPTH, |depth| depth as u32),
            },
            ..default
        };
        options.region().map_err(|error| PyValueError::new_err(error.to_string()))?;
        if light_groups && options.integrator.without_pilot() != Integrator::Path {
            let integrator = options.integrator.name();
            return Err(PyValueError::new_err(RenderError::LayersOfLight { integrator }.to_string()));
        }
        if options.noise.is_some() && options.integrator.has_virtual_lights() {
            return Err(PyValueError::new_err(format!(
                "noise: unsupported with integrator '{}', whose pixels share their noise; give spp",
                options.integrator
            )));
        }
        check_memory(&options, denoise.is_some())
            .map_err(|error| PyMemoryError::new_err(error.to_string()))?;
        let space = given.choice("working_space")?.unwrap_or_default();
        let view = View {
            space,
            camera: aim(&mut given)?,
            at: moment(&mut given)?,
            shutter: given.number("shutter", 0.0, 1e9)?.unwrap_or(0.0),
            camera_shader: camera_shader(&mut given)?,
            pixel_shader: pixel_shader(&mut given, space)?,
            motion: motion_keys(&mut given)?,
            needs_names: !options.mattes.kinds.is_empty(),
            picture: options,
            force_diffuse: given.flag("force_diffuse")?.unwrap_or(false),
            bounds: None,
        };
        if view.at.is_some() && view.motion.is_some() {
            return Err(PyValueError::new_err("motion: conflicts with at=, which plays the scene's clip"));
        }
        if view.shutter > 0.0 && view.at.is_none() {
            return Err(PyValueError::new_err("shutter: its opening time is missing; give at=SECONDS, too"));
        }
        let threads = given.whole("threads", 0, 1024)?.unwrap_or(0) as usize;
        given.end()?;
        Ok(Self { view, threads: ThreadCount::new(threads)?, layers, list, light_groups, denoise })
    }

    pub(crate) fn options(&self) -> &RenderOptions {
        &self.view.picture
    }

    pub(crate) fn denoiser(&self) -> Option<Method> {
        self.denoise
    }

    /// The part of the picture that is rendered, if it is not all.
    pub(crate) fn crop(&self) -> Option<[u32; 4]> {
        self.options().crop.and_then(|_| self.options().region().ok())
    }

    /// The origin of a picture, under the seed of the request plus a number.
    pub(crate) fn making(&self, shot: Shot, number: u64) -> Making {
        let Shot { exposure, named, .. } = shot;
        Making { exposure, named, seed: self.options().seed.wrapping_add(number) }
    }

    /// The picture of a shot, without samples, under the seed of the request plus a number.
    fn begun(&self, shot: &Shot, number: u64) -> PyResult<Accumulation> {
        let error = |why: &dyn std::fmt::Display| PyValueError::new_err(format!("layers: {why}"));
        let mut options = self.options().clone();
        options.seed = options.seed.wrapping_add(number);
        if self.light_groups {
            let groups: Vec<&str> = shot.groups.iter().map(String::as_str).collect();
            let is_new =
                |layer: &LightLayer| options.light_layers.iter().all(|known| known.name != layer.name);
            let more: Vec<LightLayer> = LightLayer::of_groups(&groups).into_iter().filter(is_new).collect();
            options.light_layers.extend(more);
        }
        if !options.light_layers.is_empty() {
            if let Some(why) = missing_output(&shot.world, &options.light_layers) {
                return Err(error(&why));
            }
            let unknown = unknown_labels(&shot.world, &options.light_layers).map_err(|why| error(&why))?;
            if let Some(label) = unknown.first() {
                return Err(error(&format_args!(
                    "no light, material or light group is called '{label}'; light groups are: {}",
                    shot.groups.join(", ")
                )));
            }
        }
        Accumulation::new(options).map_err(|why| error(&why))
    }

    /// The finished picture of the input that `ready` prepares.
    pub(crate) fn render(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
        ready: impl FnOnce() -> PyResult<Shot> + Send,
    ) -> PyResult<Picture> {
        watched(py, progress, |watch| {
            let shot = ready()?;
            let pool = self.threads.pool()?;
            let (picture, light_layers, stats) = self.rendered(&shot, 0, &pool, watch, &mut |_| {})?;
            self.finished(picture, &light_layers, &stats, &self.making(shot, 0))
        })
    }

    /// The picture of a shot with all layers and noise, to which `add` adds; its layers of light, and statistics.
    pub(crate) fn rendered(
        &self,
        shot: &Shot,
        number: u64,
        pool: &gnurt::ThreadPool,
        watch: &Watch,
        add: &mut dyn FnMut(&mut image::Picture),
    ) -> PyResult<(image::Picture, Vec<LightLayer>, RenderStats)> {
        let begun = self.begun(shot, number)?;
        let light_layers = begun.options().light_layers.clone();
        let mut frame = render_on(begun, &shot.world, &*shot.camera, pool, watch, None, &mut |_| {});
        if self.options().aovs {
            add(&mut frame.picture);
        }
        Ok((frame.picture, light_layers, frame.stats))
    }

    /// A picture as callers get it.
    pub(crate) fn finished(
        &self,
        mut picture: image::Picture,
        light_layers: &[LightLayer],
        stats: &RenderStats,
        making: &Making,
    ) -> PyResult<Picture> {
        if let Some(method) = self.denoise {
            take_noise_out(&mut picture, method, self.crop(), self.threads)?;
        }
        Ok(self.dressed(picture, light_layers, stats, making))
    }

    /// The same once the noise is out.
    pub(crate) fn dressed(
        &self,
        mut picture: image::Picture,
        light_layers: &[LightLayer],
        stats: &RenderStats,
        making: &Making,
    ) -> Picture {
        picture.convert_from(self.view.space);
        let crop = self.crop();
        if self.denoise.is_some() && !self.layers {
            picture.make_opaque(crop);
            picture.layers.clear();
        }
        if let Some(list) = self.list.as_ref().filter(|_| self.layers) {
            list.apply(&mut picture, light_layers);
        }
        if !self.list.as_ref().is_some_and(LayerList::has_seen) {
            layers::drop_seen(&mut picture);
        }
        if let Some(scene) = &making.named {
            mattes::describe(&mut picture, scene);
        }
        picture.set_metadata("seed", making.seed.to_string());
        picture.set_metadata("integrator", self.options().integrator.to_string());
        picture.set_metadata("filter", self.options().filter.to_string());
        if self.layers {
            picture.set_metadata("samplesPerPixel", stats.spp_max.to_string());
        }
        Picture { picture, exposure: making.exposure, crop, space: self.view.space }
    }
}

/// The parts of a shot that its finished picture needs.
pub(crate) struct Making {
    pub(crate) exposure: Option<f32>,
    /// The scene, if names of it are needed.
    pub(crate) named: Option<gnurt::scene::Scene>,
    pub(crate) seed: u64,
}

/// `True`, a text with words between commas, or a list of words: whether there are layers, and which.
fn layer_list(given: &mut Given) -> PyResult<(bool, Option<LayerList>)> {
    let Some(value) = given.get("layers")? else { return Ok((false, None)) };
    if let Ok(are_wanted) = value.extract::<bool>() {
        return Ok((are_wanted, None));
    }
    let text = match value.extract::<String>() {
        Ok(text) => text,
        Err(_) => value
            .extract::<Vec<String>>()
            .map_err(|_| PyTypeError::new_err("layers: expected True, a text or a list of texts"))?
            .join(","),
    };
    let list = layers::layers(&text).map_err(|why| PyValueError::new_err(format!("layers: {why}")))?;
    Ok((true, Some(list)))
}

/// `None` and `False` leave the noise, `True` is the best that is there.
fn denoiser(given: &mut Given) -> PyResult<Option<Method>> {
    let Some(how) = given.get("denoise")? else { return Ok(None) };
    if let Ok(is_wanted) = how.extract::<bool>() {
        return Ok(is_wanted.then_some(Method::Auto));
    }
    given.choice("denoise")
}

fn aim(given: &mut Given) -> PyResult<Aim> {
    given.get("camera")?.map_or(Ok(Aim::First), |camera| aimed(&camera))
}

fn aimed(camera: &Bound<'_, PyAny>) -> PyResult<Aim> {
    if let Ok(number) = camera.extract::<usize>() {
        return Ok(Aim::Number(number));
    }
    if let Ok(name) = camera.extract::<String>() {
        return Ok(Aim::Named(name));
    }
    match camera.getattr("_arguments").and_then(|arguments| Ok(arguments.call0()?.cast_into::<PyDict>()?)) {
        Ok(arguments) => describing::camera(&mut Given::new(&arguments)).map(Aim::Own),
        Err(_) => Err(PyTypeError::new_err("camera: expected a number, a name or a gnurt.Camera")),
    }
}

/// The shader of camera rays.
fn camera_shader(given: &mut Given) -> PyResult<Option<(Script, CameraScript)>> {
    let Some(script) = script_named(given, "camera_shader", "camera_parameters", &Access::default())? else {
        return Ok(None);
    };
    let made = script.camera_anywhere();
    made.map(|camera| Some((script, camera)))
        .map_err(|why| PyValueError::new_err(format!("camera_shader: {why}")))
}

/// The pixel shader.
fn pixel_shader(given: &mut Given, space: WorkingSpace) -> PyResult<Option<(Script, Arc<dyn PixelShader>)>> {
    let access = Access { space, ..Access::default() };
    let Some(script) = script_named(given, "pixel_shader", "pixel_parameters", &access)? else {
        return Ok(None);
    };
    let made = script.pixel();
    made.map(|pixel| Some((script, pixel)))
        .map_err(|why| PyValueError::new_err(format!("pixel_shader: {why}")))
}

/// Motion during an open shutter: instances by number with matrices, and cameras, at evenly spaced times.
fn motion_keys(given: &mut Given) -> PyResult<Option<MotionKeys>> {
    let Some(motion) = given.get("motion")? else { return Ok(None) };
    let wrong = || PyTypeError::new_err("motion: expected a dict of 'instances', 'meshes' and 'cameras'");
    let motion = motion.cast_into::<PyDict>().map_err(|_| wrong())?;
    let mut inner = Given::new(&motion);
    let mut keys = MotionKeys::default();
    if let Some(instances) = inner.get("instances")? {
        for (number, matrices) in instances.cast_into::<PyDict>().map_err(|_| wrong())? {
            let mut places = Vec::new();
            for key in matrices.try_iter()? {
                places.push(Affine { columns: transform("motion", &key?)? });
            }
            if places.is_empty() {
                return Err(PyValueError::new_err("motion: an instance has no matrix"));
            }
            keys.instances.push((number.extract()?, places));
        }
    }
    if let Some(meshes) = inner.get("meshes")? {
        keys.meshes = meshes.extract().map_err(|_| {
            PyTypeError::new_err("motion: expected 'meshes' as a list of numbers of instances")
        })?;
    }
    if let Some(cameras) = inner.get("cameras")? {
        for camera in cameras.try_iter()? {
            let Aim::Own(camera) = aimed(&camera?)? else { return Err(wrong()) };
            keys.cameras.push(camera);
        }
    }
    inner.end()?;
    Ok(Some(keys))
}

fn moment(given: &mut Given) -> PyResult<Option<(Clip, f64)>> {
    const MOST: f64 = 1e9;
    let at = given.number("at", -MOST, MOST)?;
    let clip = given.text("animation")?;
    match (at, clip) {
        (None, None) => Ok(None),
        (None, Some(_)) => Err(PyValueError::new_err("animation: the time is missing; give at=SECONDS, too")),
        (Some(at), None) => Ok(Some((Clip::First, at))),
        (Some(at), Some(name)) => Ok(Some((Clip::Named(name), at))),
    }
}

/// A picture that grows.
#[pyclass(module = "gnurt", frozen)]
pub(crate) struct Growing {
    request: BuildRequest,
    shot: Shot,
    so_far: Mutex<Accumulation>,
}

impl Growing {
    pub(crate) fn new(request: BuildRequest, shot: Shot) -> PyResult<Self> {
        let begun = request.begun(&shot, 0)?;
        Ok(Self { request, shot, so_far: Mutex::new(begun) })
    }
}

#[pymethods]
impl Growing {
    /// Adds samples for each pixel; whether the picture is complete.
    #[pyo3(signature = (samples, progress=None))]
    fn grow(&self, py: Python<'_>, samples: u32, progress: Option<&Bound<'_, PyAny>>) -> PyResult<bool> {
        watched(py, progress, |watch| {
            let mut so_far = self.so_far.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let pool = self.request.threads.pool()?;
            so_far.pass(&self.shot.world, &*self.shot.camera, samples, &pool, watch);
            Ok(so_far.is_complete())
        })
    }

    #[getter]
    fn samples(&self, py: Python<'_>) -> u32 {
        self.so_far.lock_py_attached(py).unwrap_or_else(std::sync::PoisonError::into_inner).samples()
    }

    /// The picture so far.
    fn picture(&self, py: Python<'_>) -> PyResult<Picture> {
        let (picture, light, stats) = {
            let so_far = self.so_far.lock_py_attached(py).unwrap_or_else(std::sync::PoisonError::into_inner);
            (so_far.picture(), so_far.options().light_layers.clone(), so_far.stats().clone())
        };
        let making = Making {
            exposure: self.shot.exposure,
            named: self.shot.named.clone(),
            seed: self.request.options().seed,
        };
        py.detach(|| self.request.finished(picture, &light, &stats, &making))
    }
}
