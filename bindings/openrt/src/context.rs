// SPDX-License-Identifier: GPL-3.0-or-later
//! The context: the state machine that all calls read and change. The calls are in `calls`, a file for each noun.
//! Source: \[DWBS03\], OpenGL 1.x. Invariant: a call that fails has changed nothing; the first error stays until read.
//! Tests: `random::state_machine` (random calls); the C programs of tests/c.

use std::sync::Arc;

use gnurt_plugins::host::Kind;

use crate::frame::Frame;
use crate::stage::Stage;
use crate::state::block::{Assembly, Block};
use crate::state::camera::View;
use crate::state::current::Current;
use crate::state::enums::SceneMode;
use crate::state::error::{Error, Result};
use crate::state::framebuffer::FrameBuffer;
use crate::state::instance::Instances;
use crate::state::listener::Listener;
use crate::state::object::{Objects, OpenObject};
use crate::state::progress::Recorded;
use crate::state::sampling::{Limits, Sampling};
use crate::state::shader::{Bound, Shaders};
use crate::state::shader_class::{Classes, LoadedClass};
use crate::state::stacks::Stacks;
use crate::state::texture::Textures;
use crate::state::usage::Usage;

/// The whole state of the API.
pub(crate) struct Context {
    /// The first error since the program last queried it.
    error: Option<Error>,
    /// The listener for errors.
    pub(crate) listener: Option<Arc<Listener>>,
    /// Threads to render with; 0 = one per core.
    pub(crate) threads: usize,
    pub(crate) stacks: Stacks,
    pub(crate) current: Current,
    pub(crate) classes: Classes,
    pub(crate) shaders: Shaders,
    pub(crate) bound: Bound,
    pub(crate) textures: Textures,
    pub(crate) objects: Objects,
    /// The object between rtNewObject and its end.
    pub(crate) open: Option<OpenObject>,
    /// Geometry outside of objects, for the next frame.
    pub(crate) unnamed: Assembly,
    /// The block between rtBegin and rtEnd.
    pub(crate) block: Option<Block>,
    pub(crate) instances: Instances,
    pub(crate) usage: Usage,
    pub(crate) view: View,
    pub(crate) scene_mode: SceneMode,
    pub(crate) limits: Limits,
    pub(crate) sampling: Sampling,
    /// The contents of the last progressive frame.
    pub(crate) recorded: Option<Recorded>,
    pub(crate) frame_buffer: Option<FrameBuffer>,
    /// Scene and world while no frame is in flight.
    pub(crate) stage: Stage,
    pub(crate) frame: Option<Frame>,
    pub(crate) pool: Option<Arc<gnurt::JoinedPool>>,
}

impl Default for Context {
    fn default() -> Self {
        Self {
            error: None,
            listener: None,
            threads: 0,
            stacks: Stacks::default(),
            current: Current::default(),
            classes: Classes::default(),
            shaders: Shaders::default(),
            bound: Bound::default(),
            textures: Textures::default(),
            objects: Objects::default(),
            open: None,
            unnamed: Assembly::default(),
            block: None,
            instances: Instances::default(),
            usage: Usage::default(),
            view: View::default(),
            scene_mode: SceneMode::Retained,
            limits: Limits::default(),
            sampling: Sampling::default(),
            recorded: None,
            frame_buffer: None,
            stage: Stage::default(),
            frame: None,
            pool: None,
        }
    }
}

impl Context {
    /// A context as rtInit makes it, following the `--rt-*` arguments among `arguments`; others are ignored.
    #[must_use]
    pub(crate) fn with_arguments<'a>(arguments: impl Iterator<Item = &'a [u8]>) -> Self {
        let mut context = Self::default();
        for argument in arguments {
            let count = argument.strip_prefix(b"--rt-threads=").map(String::from_utf8_lossy);
            context.threads = count.and_then(|count| count.parse().ok()).unwrap_or(context.threads);
        }
        context
    }

    /// Notes an error if none is noted yet.
    pub(crate) fn record(&mut self, error: Error) {
        self.error.get_or_insert(error);
    }

    /// rtGetError: the code of the recorded error, which is cleared.
    pub(crate) fn take_error(&mut self) -> Result<u32> {
        self.outside_block()?;
        Ok(self.error.take().map_or(Error::NONE_CODE, Error::code))
    }

    /// rtExit, before the context is dropped: waits for the frame in flight.
    pub(crate) fn exit(&mut self) -> Result<()> {
        self.outside_block()?;
        self.end_frame();
        Ok(())
    }

    /// Waits for the frame in flight; its failure can no longer be reported.
    fn end_frame(&mut self) {
        if let Some(frame) = self.frame.take() {
            let _ = frame.finish();
        }
    }

    /// Fails between rtBegin and rtEnd (BE).
    pub(crate) fn outside_block(&self) -> Result<()> {
        if self.block.is_some() { Err(Error::InvalidOperation) } else { Ok(()) }
    }

    /// Fails while an object is open (OBJ).
    pub(crate) fn no_open_object(&self) -> Result<()> {
        if self.open.is_some() { Err(Error::InvalidOperation) } else { Ok(()) }
    }

    /// The bound shader and its class, if it is of a surface.
    pub(crate) fn bound_surface(&self) -> Option<(u32, Arc<LoadedClass>)> {
        let class = self.bound.class().filter(|class| class.kind == Kind::Surface)?;
        Some((self.bound.shader()?, class.clone()))
    }
}

/// No thread of the context outlives it: a program may unload the library afterwards.
impl Drop for Context {
    fn drop(&mut self) {
        self.end_frame();
    }
}
