// SPDX-License-Identifier: GPL-3.0-or-later
//! Frames: the snapshot at their start, the thread that renders them, their end (rtStartRendering to rtSwapBuffers).
//! Source: \[DWBS03\] (frame semantics). A frame owns the stage while it is in flight: edits wait for the next start.
//! Invariant: at most one frame is in flight; the program's memory is written only before its end returns.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::thread::{Builder, JoinHandle};

use gnurt::render::{Accumulation, CommitOptions, Integrator, RenderOptions, ShaderTable, World};
use gnurt::scene::Affine;
use gnurt::shading::CameraShader;
use gnurt::shading::classes::Shader as Made;

use crate::class::Code;
use crate::context::Context;
use crate::enums::SceneMode;
use crate::error::{Error, Result};
use crate::flight::{Flight, Landing};
use crate::framebuffer::FrameBuffer;
use crate::plugin_frame::{FrameState, PluginFrame};
use crate::progressive::Sampling;
use crate::rendering_object::RenderingClass;
use crate::shader::ParameterValue;
use crate::stage::{Stage, UNNAMED};
use crate::usage::Usage;

/// Depths above this one are rendered as this one: shaders recurse, and a thread's stack is finite.
const DEEPEST: u32 = 1024;

/// Numbers that a program may choose about rendering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Greatest depth of a ray; camera rays have 0.
    pub max_depth: u32,
    /// How far from their surface rays begin, world units.
    pub epsilon: f32,
}

impl Default for Limits {
    fn default() -> Self {
        Self { max_depth: 16, epsilon: 1e-4 }
    }
}

/// A rendering object's class and values.
type Rendering = (&'static RenderingClass, Vec<ParameterValue>);

/// Everything that a frame needs beside the stage.
struct Job {
    shaders: ShaderTable,
    camera: Arc<dyn CameraShader>,
    limits: Limits,
    sampling: Sampling,
    /// Whether samples are added to those of the frame before.
    continues: bool,
    /// Changes options as a rendering object asks for.
    rendering: Option<Rendering>,
    target: FrameBuffer,
    pool: Arc<gnurt::JoinedPool>,
}

/// A frame in flight: a thread that gives the stage back.
pub struct Frame {
    thread: JoinHandle<(Stage, Result<()>)>,
    flight: Arc<Flight>,
    /// The plugins that shade it.
    plugins: PluginFrame,
    /// Where the program's memory begins that it is written to.
    target: usize,
}

impl Job {
    /// Renders into the program's memory, which stays as it is if the frame is cancelled before each pixel has a sample.
    fn run(&self, stage: &mut Stage, flight: &Flight) -> Result<()> {
        let Sampling { samples, progressive } = self.sampling;
        let mut options = RenderOptions {
            width: self.target.width,
            height: self.target.height,
            spp: if progressive { u32::MAX } else { samples },
            pixel_centres: samples == 1 && !progressive,
            integrator: Integrator::Whitted,
            max_depth: self.limits.max_depth,
            ray_epsilon: self.limits.epsilon,
            ..Default::default()
        };
        if let Some((class, values)) = &self.rendering {
            class.apply(values, &mut options);
        }
        options.max_depth = options.max_depth.min(DEEPEST);
        let committed =
            stage.world.commit(&stage.scene, &self.shaders, &CommitOptions::default(), &self.pool);
        committed.map_err(|error| fail(&error))?;
        let accumulation = match &mut stage.accumulation {
            Some(accumulation) if self.continues && *accumulation.options() == options => accumulation,
            Some(accumulation) => {
                accumulation.restart(options).map_err(|error| fail(&error))?;
                accumulation
            }
            none => none.insert(Accumulation::new(options).map_err(|error| fail(&error))?),
        };
        // One sample of each pixel first: a frame that is cancelled later has something to show.
        for pass in [1, samples - 1].into_iter().filter(|&pass| pass > 0) {
            if !accumulation.pass(&stage.world, &*self.camera, pass, &self.pool, flight) {
                break;
            }
        }
        if accumulation.samples() > 0 {
            stage.colors.resize(self.target.width as usize * self.target.height as usize, [0.0; 4]);
            accumulation.write_colors(&mut stage.colors, &self.pool);
            self.target.show(&stage.colors);
        }
        Ok(())
    }
}

/// Tells the person what went wrong; the program gets a code.
fn fail(error: &dyn std::fmt::Display) -> Error {
    eprintln!("libOpenRT: {error}");
    Error::OutOfMemory
}

impl Frame {
    /// Starts a thread for a job. The stage comes back if there is no thread to be had.
    fn start(stage: Stage, job: Job, plugins: PluginFrame) -> std::result::Result<Self, Box<Stage>> {
        // The stage follows through a channel once the thread is there: a thread that is not would take it along.
        let (hand_over, take_over) = channel::<Stage>();
        let flight = Arc::new(Flight::default());
        let landing = Landing(flight.clone());
        let target = job.target.address();
        let work = move || {
            let mut stage = take_over.recv().unwrap_or_default();
            let run = || job.run(&mut stage, &landing.0);
            let outcome = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| {
                // A commit that broke off has left half a world: the next one begins from the scene.
                stage.world = World::new();
                stage.accumulation = None;
                Err(Error::InvalidOperation)
            });
            (stage, outcome)
        };
        match Builder::new().name("openrt-frame".to_owned()).spawn(work) {
            Ok(thread) => match hand_over.send(stage) {
                Ok(()) => Ok(Self { thread, flight, plugins, target }),
                Err(unsent) => Err(Box::new(unsent.0)),
            },
            Err(_) => Err(Box::new(stage)),
        }
    }

    /// Where the program's memory begins that it is written to.
    pub(crate) fn target(&self) -> usize {
        self.target
    }

    /// Waits for the picture. Also returns what was wrong with plugins.
    pub fn finish(self) -> (Stage, Result<()>, Vec<String>) {
        // The thread catches all panics; losing it anyway loses the stage.
        let joined = self.thread.join();
        let (stage, outcome) = joined.unwrap_or_else(|_| (Stage::default(), Err(Error::InvalidOperation)));
        (stage, outcome, self.plugins.faults())
    }
}

impl Context {
    /// rtStartRendering. Fails but starts a frame if a plugin cannot take part in it: it goes on without that one.
    pub fn start_rendering(&mut self) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        if self.frame.is_some() {
            return Err(Error::InvalidOperation);
        }
        let target = self.frame_buffer.clone().ok_or(Error::InvalidOperation)?;
        let pool = self.pool()?;
        self.prune();
        let mut stage = std::mem::take(&mut self.stage);
        self.update(&mut stage);
        let plugins = self.plugins(&stage);
        let shaders = self.shader_table(&mut stage, &plugins);
        let camera = shaders.camera.clone().unwrap_or_else(|| self.default_camera());
        let continues = self.continues(&stage, [target.width, target.height]);
        let rendering = self.rendering();
        if self.scene_mode == SceneMode::Immediate {
            self.instances.clear();
            self.usage = Usage { rendering_object: self.usage.rendering_object, ..Default::default() };
        }
        let told = self.tell(plugins.problems());
        let sampling = match &rendering {
            Some((class, values)) => class.sampling(values, self.sampling),
            None => self.sampling,
        };
        let job = Job { shaders, camera, limits: self.limits, sampling, continues, rendering, target, pool };
        match Frame::start(stage, job, plugins) {
            Ok(frame) => self.frame = Some(frame),
            Err(stage) => {
                self.stage = *stage;
                return Err(Error::OutOfMemory);
            }
        }
        told
    }

    /// Tells what was wrong with plugins: an error if anything was.
    fn tell(&mut self, lines: &[String]) -> Result<()> {
        if lines.is_empty() {
            return Ok(());
        }
        lines.iter().for_each(|line| eprintln!("libOpenRT: {line}"));
        self.classes.set_info_log(&lines.join("\n"));
        Err(Error::InvalidOperation)
    }

    /// rtEndRendering.
    pub fn end_rendering(&mut self) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        let frame = self.frame.take().ok_or(Error::InvalidOperation)?;
        let (stage, outcome, faults) = frame.finish();
        self.stage = stage;
        outcome.and(self.tell(&faults))
    }

    /// The frame in flight, if the calls that end it are legal now: what callers wait for without keeping others out.
    #[must_use]
    pub fn flight(&self) -> Option<Arc<Flight>> {
        self.outside_block().and(self.no_open_object()).ok()?;
        self.frame.as_ref().map(|frame| frame.flight.clone())
    }

    /// rtCancelRendering.
    pub fn cancel_rendering(&mut self) -> Result<()> {
        self.outside_block()?;
        self.frame.as_ref().ok_or(Error::InvalidOperation)?.flight.cancel();
        Ok(())
    }

    /// The first half of rtRender: a frame is in flight afterwards.
    pub fn begin_render(&mut self) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        if self.frame.is_none() { self.start_rendering() } else { Ok(()) }
    }

    /// rtSwapBuffers.
    pub fn swap_buffers(&mut self) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        if self.frame_buffer.is_none() {
            return Err(Error::InvalidOperation);
        }
        let ended = if self.frame.is_some() { self.end_rendering() } else { Ok(()) };
        self.start_rendering().and(ended)
    }

    /// rtSceneMode.
    pub fn set_scene_mode(&mut self, mode: u32) -> Result<()> {
        self.outside_block()?;
        self.scene_mode = SceneMode::from_code(mode)?;
        Ok(())
    }

    /// rtSetMaxRayRecursionDepth.
    pub fn set_max_depth(&mut self, depth: u32) -> Result<()> {
        self.outside_block()?;
        i32::try_from(depth).map_err(|_| Error::InvalidValue)?;
        self.limits.max_depth = depth;
        Ok(())
    }

    /// rtSetRayEpsilon.
    pub fn set_ray_epsilon(&mut self, epsilon: f32) -> Result<()> {
        self.outside_block()?;
        if !(epsilon >= 0.0 && epsilon.is_finite()) {
            return Err(Error::InvalidValue);
        }
        self.limits.epsilon = epsilon;
        Ok(())
    }

    /// rtGetRayEpsilon.
    pub fn ray_epsilon(&self) -> Result<f32> {
        self.outside_block()?;
        Ok(self.limits.epsilon)
    }

    /// Frees objects and shaders that were removed and that nothing shows any more.
    fn prune(&mut self) {
        let shown: std::collections::BTreeSet<u32> = self.instances.iter().map(|i| i.object).collect();
        self.objects.prune(|id| shown.contains(&id));
        let of_objects = self.objects.defined.values().flat_map(|object| object.shaders.iter().copied());
        let of_unnamed = self.unnamed.geometry.shaders();
        let used = of_objects.chain(of_unnamed).chain(self.usage.ids()).collect();
        self.shaders.prune(&used);
    }

    /// Brings the stage up to date with the program's objects and instances.
    fn update(&mut self, stage: &mut Stage) {
        let unnamed = std::mem::take(&mut self.unnamed).geometry;
        let has_unnamed = !unnamed.is_empty();
        stage.keep_objects(|id| self.objects.defined.contains_key(&id) || id == UNNAMED && has_unnamed);
        for (&id, object) in &mut self.objects.defined {
            if let Some(meshes) = object.fresh.take() {
                stage.define(id, meshes);
            }
        }
        if has_unnamed {
            stage.define(UNNAMED, unnamed.finish());
        }
        let placed = self.instances.iter().map(|i| (i.object, i.world_from_object.to_affine()));
        stage.show(placed.chain(has_unnamed.then_some((UNNAMED, Affine::IDENTITY))));
    }

    /// All shaders in use, with their present values.
    fn shader_table(&self, stage: &mut Stage, plugins: &PluginFrame) -> ShaderTable {
        let mut table = stage.surfaces(&self.shaders, &self.textures, plugins);
        for id in self.usage.ids() {
            match self.shaders.in_use(id).and_then(|shader| shader.make(id, &self.textures, plugins)) {
                Some(Made::Light(light)) => table.lights.push(light),
                Some(Made::Camera(camera)) => table.camera = Some(camera),
                Some(Made::Environment(environment)) => table.environment = Some(environment),
                Some(Made::Surface(_)) | None => {}
            }
        }
        table
    }

    /// The plugins among the shaders in use, prepared for a frame.
    fn plugins(&self, stage: &Stage) -> PluginFrame {
        let ids = stage.shader_ids().chain(self.usage.ids());
        let blocks = ids.filter_map(|id| Some((id, self.shaders.in_use(id)?.block.as_ref()?)));
        PluginFrame::new(blocks, || {
            let sampler = |id: u32| Some((id, self.textures.sampler(i32::try_from(id).ok()?)?));
            let textures = self.textures.ids().filter_map(sampler).collect();
            let shown = self.instances.entries().filter(|(_, instance)| stage.has_object(instance.object));
            let mut ids = Vec::new();
            for (place, [object, instance]) in stage.places().zip(shown.map(|(id, i)| [i.object, id])) {
                ids.resize(ids.len().max(place + 1), [UNNAMED; 2]);
                ids[place] = [object, instance];
            }
            FrameState { textures, ids }
        })
    }

    /// The rendering object in use.
    fn rendering(&self) -> Option<Rendering> {
        let shader = self.shaders.in_use(self.usage.rendering_object?)?;
        match &shader.class.code {
            Code::Rendering(class) => Some((class, shader.values.clone())),
            _ => None,
        }
    }

    /// The threads, made when the first frame needs them.
    fn pool(&mut self) -> Result<Arc<gnurt::JoinedPool>> {
        if let Some(pool) = &self.pool {
            return Ok(pool.clone());
        }
        let pool = Arc::new(gnurt::JoinedPool::new(self.threads).map_err(|error| fail(&error))?);
        self.pool = Some(pool.clone());
        Ok(pool)
    }
}
