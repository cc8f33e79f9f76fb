// SPDX-License-Identifier: GPL-3.0-or-later
//! The default camera (rtLookAt, rtPerspective, rtFrustum, rtOrtho).
//! Source: original, after OpenGL 1.x and its utility library. Space: world; right-handed, the eye looks along -z.
//! Proof: tests/c/scene.c, tests/c/errors.c.

use std::sync::Arc;

use gnurt::scene::Camera;
use gnurt::shading::CameraShader;
use gnurt::shading::classes::ProjectionCamera;

use crate::context::Context;
use crate::enums::MatrixMode;
use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::stacks::Entry;

/// Where the default camera is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    eye: [f32; 3],
    /// Unit axes: right, up, forward.
    axes: [[f32; 3]; 3],
}

impl Default for View {
    fn default() -> Self {
        Self { eye: [0.0; 3], axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]] }
    }
}

/// Vertical angle of view where the program has not set a projection.
const DEFAULT_FOV: f64 = 60.0;

/// A view volume as rtFrustum and rtOrtho take it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Left and right.
    pub x: [f64; 2],
    /// Bottom and top.
    pub y: [f64; 2],
    /// Near and far.
    pub z: [f64; 2],
}

impl Context {
    /// rtLookAt.
    pub fn look_at(&mut self, eye: [f64; 3], center: [f64; 3], up: [f64; 3]) -> Result<()> {
        self.outside_block()?;
        let [eye, target, up] = [eye, center, up].map(|v| v.map(|x| x as f32));
        let camera = Camera { name: String::new(), eye, target, up, fov_y: DEFAULT_FOV as f32 };
        let all_finite = [eye, target, up].iter().flatten().all(|x| x.is_finite());
        let frame = camera.frame().filter(|_| all_finite).ok_or(Error::InvalidValue)?;
        self.view = View { eye, axes: [frame.right, frame.up, frame.forward] };
        Ok(())
    }

    /// rtPerspective.
    pub fn perspective(&mut self, fov_y: f64, planes: [f64; 2]) -> Result<()> {
        self.outside_block()?;
        let matrix = Matrix::perspective(fov_y, planes).ok_or(Error::InvalidValue)?;
        self.stacks.set_top(MatrixMode::Projection, Entry { matrix, follows_aspect: true });
        Ok(())
    }

    /// rtFrustum.
    pub fn frustum(&mut self, volume: Volume) -> Result<()> {
        self.outside_block()?;
        let factor = Matrix::frustum(volume.x, volume.y, volume.z).ok_or(Error::InvalidValue)?;
        self.stacks.multiply(MatrixMode::Projection, factor);
        Ok(())
    }

    /// rtOrtho.
    pub fn ortho(&mut self, volume: Volume) -> Result<()> {
        self.outside_block()?;
        let factor = Matrix::ortho(volume.x, volume.y, volume.z).ok_or(Error::InvalidValue)?;
        self.stacks.multiply(MatrixMode::Projection, factor);
        Ok(())
    }

    /// The default camera as it is now; the initial projection if the program's has no inverse.
    pub(crate) fn default_camera(&self) -> Arc<dyn CameraShader> {
        let entry = self.stacks.top(MatrixMode::Projection);
        let initial = Matrix::perspective(DEFAULT_FOV, [0.1, 1000.0]).unwrap_or(Matrix::IDENTITY);
        let is_set = entry.matrix != Matrix::IDENTITY;
        let (matrix, follows_aspect) =
            if is_set { (entry.matrix, entry.follows_aspect) } else { (initial, true) };
        let View { eye, axes } = self.view;
        let camera = |matrix: Matrix, follows| ProjectionCamera::new(eye, axes, &matrix.0, follows);
        let camera = camera(matrix, follows_aspect).or_else(|| camera(initial, true));
        Arc::new(camera.expect("the initial projection has an inverse"))
    }
}
