// SPDX-License-Identifier: GPL-3.0-or-later
//! The default camera (rtLookAt, rtPerspective, rtFrustum, rtOrtho).
//! Source: OpenGL 1.x and its utility library. Tests: tests/c/scene.c, tests/c/errors.c.

use crate::context::Context;
use crate::state::camera::View;
use crate::state::enums::MatrixMode;
use crate::state::error::{Error, Result};
use crate::state::matrix::Matrix;
use crate::state::stacks::Entry;

/// A view volume as rtFrustum and rtOrtho take it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Volume {
    /// Left and right.
    pub(crate) x: [f64; 2],
    /// Bottom and top.
    pub(crate) y: [f64; 2],
    /// Near and far.
    pub(crate) z: [f64; 2],
}

impl Context {
    /// rtLookAt.
    pub(crate) fn look_at(&mut self, eye: [f64; 3], center: [f64; 3], up: [f64; 3]) -> Result<()> {
        self.outside_block()?;
        self.view = View::looking(eye, center, up).ok_or(Error::InvalidValue)?;
        Ok(())
    }

    /// rtPerspective.
    pub(crate) fn perspective(&mut self, fov_y: f64, planes: [f64; 2]) -> Result<()> {
        self.outside_block()?;
        let matrix = Matrix::perspective(fov_y, planes).ok_or(Error::InvalidValue)?;
        self.stacks.set_top(MatrixMode::Projection, Entry { matrix, follows_aspect: true });
        Ok(())
    }

    /// rtFrustum.
    pub(crate) fn frustum(&mut self, volume: Volume) -> Result<()> {
        self.outside_block()?;
        let factor = Matrix::frustum(volume.x, volume.y, volume.z).ok_or(Error::InvalidValue)?;
        self.stacks.multiply(MatrixMode::Projection, factor);
        Ok(())
    }

    /// rtOrtho.
    pub(crate) fn ortho(&mut self, volume: Volume) -> Result<()> {
        self.outside_block()?;
        let factor = Matrix::ortho(volume.x, volume.y, volume.z).ok_or(Error::InvalidValue)?;
        self.stacks.multiply(MatrixMode::Projection, factor);
        Ok(())
    }
}
