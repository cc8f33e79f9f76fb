// SPDX-License-Identifier: GPL-3.0-or-later
//! Starting and ending frames (rtStartRendering to rtSwapBuffers).
//! Source: \[DWBS03\] (frame semantics). Tests: tests/c/scene.c, tests/c/frames.c, tests/c/errors.c.

use std::sync::Arc;

use gnurt::memory::{check_more, picture_bytes};
use gnurt::render::RenderOptions;
use gnurt_plugins::host::print_line;

use crate::context::Context;
use crate::frame::{FrameThread, Job, reported};
use crate::state::enums::{MatrixMode, SceneMode};
use crate::state::error::{Error, Result};
use crate::state::flight::Flight;
use crate::state::framebuffer::FrameBuffer;
use crate::state::usage::Usage;

impl Context {
    /// rtStartRendering. Fails but starts a frame if a plugin does not support it: the frame is then rendered
    /// without that plugin.
    pub(crate) fn start_rendering(&mut self) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        if self.frame.is_some() {
            return Err(Error::InvalidOperation);
        }
        let target = self.frame_buffer.clone().ok_or(Error::InvalidOperation)?;
        self.check_memory(&target)?;
        let pool = self.pool()?;
        let thread = FrameThread::start().map_err(|error| reported(&error, Error::OutOfMemory))?;
        self.prune();
        let mut stage = std::mem::take(&mut self.stage);
        self.update(&mut stage);
        let plugins = self.plugins(&stage);
        let shaders = self.shader_table(&mut stage, &plugins);
        let camera = shaders
            .camera
            .clone()
            .unwrap_or_else(|| self.view.camera(self.stacks.top(MatrixMode::Projection)));
        let continues = self.continues(&stage, [target.width, target.height]);
        let rendering = self.rendering();
        let reported = self.notify(plugins.problems());
        let sampling = match &rendering {
            Some((class, values)) => class.sampling(values, self.sampling),
            None => self.sampling,
        };
        let job = Job { shaders, camera, limits: self.limits, sampling, continues, rendering, target, pool };
        self.frame = Some(thread.render(stage, job, plugins));
        if self.scene_mode == SceneMode::Immediate {
            self.instances.clear();
            let Usage { rendering_object, pixel, .. } = self.usage;
            self.usage = Usage { rendering_object, pixel, ..Default::default() };
        }
        reported
    }

    /// Whether memory allows a picture of this size, where the frames before had less: checked before
    /// anything is begun, since the parts of a picture are made one by one.
    fn check_memory(&self, target: &FrameBuffer) -> Result<()> {
        let [pixels, held] =
            [u64::from(target.width) * u64::from(target.height), self.stage.colors.len() as u64];
        if pixels <= held {
            return Ok(());
        }
        let options = RenderOptions { width: target.width, height: target.height, ..Default::default() };
        let more = picture_bytes(&options, false) / pixels * (pixels - held);
        check_more([target.width, target.height], more).map_err(|error| reported(&error, Error::OutOfMemory))
    }

    /// Reports faults of plugins; returns an error if there were any.
    pub(super) fn notify(&mut self, lines: &[String]) -> Result<()> {
        if lines.is_empty() {
            return Ok(());
        }
        lines.iter().for_each(print_line);
        self.classes.set_info_log(&lines.join("\n"));
        Err(Error::InvalidOperation)
    }

    /// rtEndRendering.
    pub(crate) fn end_rendering(&mut self) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        let frame = self.frame.take().ok_or(Error::InvalidOperation)?;
        let (stage, outcome, faults) = frame.finish();
        self.stage = stage;
        self.shaders.end_blocks();
        outcome.and(self.notify(&faults))
    }

    /// The frame in flight, if the calls that end it are legal now: callers wait for it without blocking
    /// others.
    #[must_use]
    pub(crate) fn flight(&self) -> Option<Arc<Flight>> {
        self.outside_block().and(self.no_open_object()).ok()?;
        self.frame.as_ref().map(|frame| frame.flight().clone())
    }

    /// rtCancelRendering.
    pub(crate) fn cancel_rendering(&mut self) -> Result<()> {
        self.outside_block()?;
        self.frame.as_ref().ok_or(Error::InvalidOperation)?.flight().cancel();
        Ok(())
    }

    /// The first half of rtRender: a frame is in flight afterwards.
    pub(crate) fn begin_render(&mut self) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        if self.frame.is_none() { self.start_rendering() } else { Ok(()) }
    }

    /// rtSwapBuffers.
    pub(crate) fn swap_buffers(&mut self) -> Result<()> {
        self.outside_block()?;
        self.no_open_object()?;
        if self.frame_buffer.is_none() {
            return Err(Error::InvalidOperation);
        }
        let ended = if self.frame.is_some() { self.end_rendering() } else { Ok(()) };
        self.start_rendering().and(ended)
    }
}
