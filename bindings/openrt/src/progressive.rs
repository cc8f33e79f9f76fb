// SPDX-License-Identifier: GPL-3.0-or-later
//! Samples per pixel, and frames that go on where the last one ended (rtSetSamplesPerPixel, rtProgressive).
//! Source: original. Invariant: samples of two frames are only added if everything that the picture depends on is equal.
//! Proof: tests/c/frames.c.

use gnurt::scene::edit::Cursor;

use crate::camera::View;
use crate::context::Context;
use crate::enums::MatrixMode;
use crate::error::{Error, Result};
use crate::frame::Limits;
use crate::shader::ParameterValue;
use crate::stacks::Entry;
use crate::stage::Stage;
use crate::usage::Usage;

/// What a program has asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Samples that a frame takes of each pixel.
    pub samples: u32,
    /// Whether frames of an unchanged scene add up.
    pub progressive: bool,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { samples: 1, progressive: false }
    }
}

/// Everything that a picture depends on.
#[derive(Clone, PartialEq)]
pub struct Seen {
    scene: Cursor,
    shaders: Vec<(u32, Vec<ParameterValue>, Option<u64>)>,
    textures: u64,
    usage: Usage,
    view: View,
    projection: Entry,
    limits: Limits,
    size: [u32; 2],
}

impl Context {
    /// rtSetSamplesPerPixel.
    pub fn set_samples_per_pixel(&mut self, samples: u32) -> Result<()> {
        self.outside_block()?;
        if samples == 0 {
            return Err(Error::InvalidValue);
        }
        self.sampling.samples = samples;
        Ok(())
    }

    /// rtProgressive.
    pub fn set_progressive(&mut self, on: bool) -> Result<()> {
        self.outside_block()?;
        self.sampling.progressive = on;
        Ok(())
    }

    /// Whether the frame that starts shows what the last one showed, so that their samples may be added.
    pub(crate) fn continues(&mut self, stage: &Stage, size: [u32; 2]) -> bool {
        if !self.sampling.progressive {
            self.seen = None;
            return false;
        }
        let now = Seen {
            scene: stage.scene.cursor(),
            shaders: self
                .shaders
                .iter()
                .map(|(id, shader)| {
                    (id, shader.values.clone(), shader.block.as_ref().map(|block| block.version()))
                })
                .collect(),
            textures: self.textures.revision(),
            usage: self.usage.clone(),
            view: self.view,
            projection: self.stacks.top(MatrixMode::Projection),
            limits: self.limits,
            size,
        };
        let continues = self.seen.as_ref() == Some(&now);
        self.seen = Some(now);
        continues
    }
}
