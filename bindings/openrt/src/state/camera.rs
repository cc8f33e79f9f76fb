// SPDX-License-Identifier: GPL-3.0-or-later
//! The default camera's transform, and the camera with a projection.
//! Source: after OpenGL 1.x and its utility library. Space: world; right-handed, the camera faces along -z.
//! Tests: tests/c/scene.c, tests/c/errors.c.

use std::sync::Arc;

use gnurt::scene::Camera;
use gnurt::shading::CameraShader;
use gnurt::shading::classes::ProjectionCamera;

use super::matrix::Matrix;
use super::stacks::Entry;

/// Where the default camera is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    eye: [f32; 3],
    /// Unit axes: right, up, forward.
    axes: [[f32; 3]; 3],
}

impl View {
    /// From an eye to a point; `None` if that is no view.
    pub(crate) fn looking(eye: [f64; 3], center: [f64; 3], up: [f64; 3]) -> Option<Self> {
        let [eye, target, up] = [eye, center, up].map(|v| v.map(|x| x as f32));
        let camera =
            Camera { name: String::new(), eye, target, up, fov_y: DEFAULT_FOV as f32, ..Camera::default() };
        let all_finite = [eye, target, up].iter().flatten().all(|x| x.is_finite());
        let frame = camera.frame().filter(|_| all_finite)?;
        Some(Self { eye, axes: [frame.right, frame.up, frame.forward] })
    }

    /// The camera of this view with a projection; with the initial one if that has no inverse.
    pub(crate) fn camera(self, projection: Entry) -> Arc<dyn CameraShader> {
        let initial = Matrix::perspective(DEFAULT_FOV, [0.1, 1000.0]).unwrap_or(Matrix::IDENTITY);
        let is_set = projection.matrix != Matrix::IDENTITY;
        let (matrix, follows_aspect) =
            if is_set { (projection.matrix, projection.follows_aspect) } else { (initial, true) };
        let View { eye, axes } = self;
        let camera = |matrix: Matrix, follows| ProjectionCamera::new(eye, axes, &matrix.0, follows);
        let camera = camera(matrix, follows_aspect).or_else(|| camera(initial, true));
        Arc::new(camera.expect("the initial projection has an inverse"))
    }
}

impl Default for View {
    fn default() -> Self {
        Self { eye: [0.0; 3], axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]] }
    }
}

/// Vertical angle of view where the program has not set a projection.
const DEFAULT_FOV: f64 = 60.0;
