// SPDX-License-Identifier: GPL-3.0-or-later
//! Frames in flight: the thread that renders one, and its end.
//! Source: \[DWBS03\] (frame semantics). A frame owns the stage while it is in flight: edits wait for the next start.
//! Invariant: at most one frame is in flight; the program's memory is written only before its end returns. The thread is there before
//! anything is taken from the program's description, so that a frame that cannot start has no effect.
//! Tests: tests/c/scene.c, tests/c/errors.c.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::thread::{Builder, JoinHandle};

use gnurt::render::{
    Accumulation, CommitError, CommitOptions, Integrator, RenderError, RenderOptions, ShaderTable, World,
};
use gnurt::shading::CameraShader;
use gnurt_plugins::host::{PluginFrame, print_line};

use crate::stage::Stage;
use crate::state::error::{Error, Result};
use crate::state::flight::{Flight, Landing};
use crate::state::framebuffer::FrameBuffer;
use crate::state::rendering_object::RenderingClass;
use crate::state::sampling::{Limits, Sampling};
use crate::state::value::ParameterValue;

/// Depths above this one are rendered as this one: shaders recurse, and a thread's stack is finite.
const DEEPEST: u32 = 1024;

/// A rendering object's class and values.
pub(crate) type Rendering = (&'static RenderingClass, Vec<ParameterValue>);

/// Everything that a frame needs in addition to the stage.
pub(crate) struct Job {
    pub(crate) shaders: ShaderTable,
    pub(crate) camera: Arc<dyn CameraShader>,
    pub(crate) limits: Limits,
    pub(crate) sampling: Sampling,
    /// Whether samples are added to those of the frame before.
    pub(crate) continues: bool,
    /// Changes options by a rendering object.
    pub(crate) rendering: Option<Rendering>,
    pub(crate) target: FrameBuffer,
    pub(crate) pool: Arc<gnurt::JoinedPool>,
}

/// A frame in flight: a thread that gives the stage back.
pub(crate) struct Frame {
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
        stage.report = committed.map_err(|error| reported(&error, kind_of_commit(&error)))?;
        let accumulation = match &mut stage.accumulation {
            Some(accumulation) if self.continues && *accumulation.options() == options => accumulation,
            Some(accumulation) => {
                accumulation.restart(options).map_err(|error| reported(&error, kind_of_options(&error)))?;
                accumulation
            }
            none => {
                let new = Accumulation::new(options);
                none.insert(new.map_err(|error| reported(&error, kind_of_options(&error)))?)
            }
        };
        // One sample of each pixel first: a frame that is cancelled later has something to show.
        for pass in [1, samples - 1].into_iter().filter(|&pass| pass > 0) {
            if !accumulation.pass(&stage.world, &*self.camera, pass, &self.pool, flight) {
                break;
            }
        }
        if accumulation.samples() > 0 {
            let pixels = self.target.width as usize * self.target.height as usize;
            let missing = pixels.saturating_sub(stage.colors.len());
            stage.colors.try_reserve_exact(missing).map_err(|error| reported(&error, Error::OutOfMemory))?;
            stage.colors.resize(pixels, [0.0; 4]);
            accumulation.write_colors(&mut stage.colors, &self.pool);
            self.target.show(&stage.colors);
        }
        Ok(())
    }
}

/// Prints an error, and returns its code for the program.
pub(crate) fn reported(error: &dyn std::fmt::Display, code: Error) -> Error {
    print_line(error);
    code
}

/// The code of a commit that failed. That ids name nothing is a mistake of this library.
fn kind_of_commit(error: &CommitError) -> Error {
    match error {
        CommitError::TooLarge(_) => Error::OutOfMemory,
        // Closing an object that contains itself, or that nests too deep, is an error.
        CommitError::DanglingId { .. }
        | CommitError::UnknownShader { .. }
        | CommitError::UnknownDisplacement { .. }
        | CommitError::BadMedium { .. }
        | CommitError::Nesting(_) => Error::InvalidOperation,
    }
}

/// The code of options that leave nothing to render.
fn kind_of_options(error: &RenderError) -> Error {
    match error {
        RenderError::NothingToDo { .. } | RenderError::TooLarge { .. } => Error::InvalidValue,
        // Programs of this library request neither pieces nor layers of light.
        RenderError::LayersOfLight { .. }
        | RenderError::InterleavedLayers
        | RenderError::Expression(_)
        | RenderError::EmptyCrop { .. }
        | RenderError::NoSuchPixel { .. }
        | RenderError::NoSuchPiece { .. }
        | RenderError::NoSuchRows { .. }
        | RenderError::InterleavedPiece => Error::InvalidOperation,
    }
}

/// A thread that waits for a frame to render. Dropped, it ends.
pub(crate) struct FrameThread {
    thread: JoinHandle<(Stage, Result<()>)>,
    flight: Arc<Flight>,
    hand_over: Sender<(Stage, Job)>,
}

impl FrameThread {
    /// Starts it.
    pub(crate) fn start() -> std::io::Result<Self> {
        let (hand_over, take_over) = channel::<(Stage, Job)>();
        let flight = Arc::new(Flight::default());
        let landing = Landing(flight.clone());
        let work = move || {
            let Ok((mut stage, job)) = take_over.recv() else { return (Stage::default(), Ok(())) };
            let run = || job.run(&mut stage, &landing.0);
            let outcome = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| {
                // A commit that broke off has left half a world: the next one begins from the scene.
                stage.world = World::new();
                stage.accumulation = None;
                Err(Error::InvalidOperation)
            });
            drop(job);
            drop(landing);
            (stage, outcome)
        };
        let thread = Builder::new().name("openrt-frame".to_owned()).spawn(work)?;
        Ok(Self { thread, flight, hand_over })
    }

    /// Renders a frame.
    pub(crate) fn render(self, stage: Stage, job: Job, plugins: PluginFrame) -> Frame {
        let Self { thread, flight, hand_over } = self;
        let target = job.target.address();
        // The thread waits for this; if it is gone, the frame ends as one whose thread was lost.
        let _ = hand_over.send((stage, job));
        Frame { thread, flight, plugins, target }
    }
}

impl Frame {
    /// Where the program's memory begins that it is written to.
    pub(crate) fn target(&self) -> usize {
        self.target
    }

    /// The state that program and frame share.
    pub(crate) fn flight(&self) -> &Arc<Flight> {
        &self.flight
    }

    /// Waits for the picture. Also returns the faults of plugins.
    pub(crate) fn finish(self) -> (Stage, Result<()>, Vec<String>) {
        // The thread catches all panics; losing it anyway loses the stage.
        let joined = self.thread.join();
        let (stage, outcome) = joined.unwrap_or_else(|_| (Stage::default(), Err(Error::InvalidOperation)));
        (stage, outcome, self.plugins.faults())
    }
}
