// SPDX-License-Identifier: GPL-3.0-or-later
//! Where and how frames are rendered (rtSetFrameBuffer, rtSceneMode, rtSetSamplesPerPixel, rtProgressive, ...).
//! Source: \[DWBS03\] for the frame buffer. Tests: tests/c/errors.c, tests/c/frames.c.

use std::sync::Arc;

use crate::context::Context;
use crate::state::enums::{FrameFormat, SceneMode};
use crate::state::error::{Error, Result, not_null};
use crate::state::framebuffer::{FrameBuffer, FrameMemory, RT_IN_FLIGHT_BIT, RT_NEXT_FRAME_BIT};

/// The limit of the renderer.
const MOST_PIXELS: u64 = 1 << 31;

impl Context {
    /// rtSetFrameBuffer. `memory` is `None` for a null pointer.
    pub(crate) fn set_frame_buffer(
        &mut self,
        memory: Option<Arc<dyn FrameMemory>>,
        [width, height]: [u32; 2],
        format: u32,
    ) -> Result<()> {
        self.outside_block()?;
        let memory = not_null(memory)?;
        let format = FrameFormat::from_code(format)?;
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels > MOST_PIXELS {
            return Err(Error::InvalidValue);
        }
        self.frame_buffer = Some(FrameBuffer { memory, width, height, format });
        Ok(())
    }

    /// rtFrameBufferUse: the use of the memory at this address by frames, present and future.
    pub(crate) fn frame_buffer_use(&self, address: usize) -> u32 {
        let next = self.frame_buffer.as_ref().is_some_and(|buffer| buffer.address() == address);
        let in_flight = self.frame.as_ref().is_some_and(|frame| frame.target() == address);
        [(next, RT_NEXT_FRAME_BIT), (in_flight, RT_IN_FLIGHT_BIT)]
            .map(|(is, bit)| u32::from(is) * bit)
            .iter()
            .sum()
    }

    /// rtSceneMode.
    pub(crate) fn set_scene_mode(&mut self, mode: u32) -> Result<()> {
        self.outside_block()?;
        self.scene_mode = SceneMode::from_code(mode)?;
        Ok(())
    }

    /// rtSetMaxRayRecursionDepth.
    pub(crate) fn set_max_depth(&mut self, depth: u32) -> Result<()> {
        self.outside_block()?;
        i32::try_from(depth).map_err(|_| Error::InvalidValue)?;
        self.limits.max_depth = depth;
        Ok(())
    }

    /// rtSetRayEpsilon.
    pub(crate) fn set_ray_epsilon(&mut self, epsilon: f32) -> Result<()> {
        self.outside_block()?;
        if !(epsilon >= 0.0 && epsilon.is_finite()) {
            return Err(Error::InvalidValue);
        }
        self.limits.epsilon = epsilon;
        Ok(())
    }

    /// rtGetRayEpsilon.
    pub(crate) fn ray_epsilon(&self) -> Result<f32> {
        self.outside_block()?;
        Ok(self.limits.epsilon)
    }

    /// rtSetSamplesPerPixel.
    pub(crate) fn set_samples_per_pixel(&mut self, samples: u32) -> Result<()> {
        self.outside_block()?;
        if samples == 0 {
            return Err(Error::InvalidValue);
        }
        self.sampling.samples = samples;
        Ok(())
    }

    /// rtProgressive.
    pub(crate) fn set_progressive(&mut self, on: bool) -> Result<()> {
        self.outside_block()?;
        self.sampling.progressive = on;
        Ok(())
    }
}
