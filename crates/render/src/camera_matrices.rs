// SPDX-License-Identifier: GPL-3.0-or-later
//! A camera as matrices, for programs that put something else into its pictures.
//! The matrices have the form that pbrt-v4's film writes. Row-major, of column vectors; double precision.
//! Tests: `tests::matrices_lead_to_the_picture`.

use gnurt_scene::{Camera, Projection};

/// Where points of the world are for a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMatrices {
    /// From world space to that of the camera: x right, y up, z into the picture.
    pub camera_from_world: [f64; 16],
    /// From world space to (0, 0) = upper left and (1, 1) = lower right corner of the picture, after division by the last
    /// coordinate. `None` for fisheyes and panoramas, which are no matrices.
    pub ndc_from_world: Option<[f64; 16]>,
}

impl CameraMatrices {
    /// Those of a camera whose picture is `aspect` times as wide as high; `None` if it has no view.
    #[must_use]
    pub fn new(camera: &Camera, aspect: f32) -> Option<Self> {
        let frame = camera.frame()?;
        let row = |axis: [f32; 3]| {
            let along: f64 = (0..3).map(|k| f64::from(axis[k]) * f64::from(camera.eye[k])).sum();
            [f64::from(axis[0]), f64::from(axis[1]), f64::from(axis[2]), -along]
        };
        let [x, y, z] = [frame.right, frame.up, frame.forward].map(row);
        let join = |rows: [[f64; 4]; 4]| std::array::from_fn(|i| rows[i / 4][i % 4]);
        Some(Self {
            camera_from_world: join([x, y, z, [0.0, 0.0, 0.0, 1.0]]),
            ndc_from_world: ndc([x, y, z], camera, f64::from(aspect)).map(join),
        })
    }
}

/// The rows of the matrix to the picture, from those of the matrix to the camera.
fn ndc([x, y, z]: [[f64; 4]; 3], camera: &Camera, aspect: f64) -> Option<[[f64; 4]; 4]> {
    const ONE: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
    let (half_height, last) = match camera.projection {
        Projection::Perspective => ((f64::from(camera.fov_y).to_radians() / 2.0).tan(), z),
        Projection::Orthographic { height } => (f64::from(height) / 2.0, ONE),
        Projection::Fisheye | Projection::Panorama => return None,
    };
    let half_width = half_height * aspect;
    let [aside, above] = camera.shift.map(f64::from);
    let across = std::array::from_fn(|i| 0.5 * (x[i] / half_width + last[i]) - aside / aspect * last[i]);
    let down = std::array::from_fn(|i| 0.5 * (last[i] - y[i] / half_height) + above * last[i]);
    Some([across, down, z, last])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_lead_to_the_picture() {
        let camera = Camera {
            name: String::new(),
            eye: [1.0, 2.0, 3.0],
            target: [1.0, 2.0, -7.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 90.0,
            ..Camera::default()
        };
        let CameraMatrices { camera_from_world: to_camera, ndc_from_world: to_ndc } =
            CameraMatrices::new(&camera, 2.0).expect("a view");
        let apply = |m: &[f64; 16], p: [f64; 3]| -> [f64; 4] {
            std::array::from_fn(|r| {
                m[4 * r] * p[0] + m[4 * r + 1] * p[1] + m[4 * r + 2] * p[2] + m[4 * r + 3]
            })
        };
        assert_eq!(apply(&to_camera, [1.0, 2.0, -1.0]), [0.0, 0.0, 4.0, 1.0], "4 in front of the eye");
        let to_ndc = to_ndc.expect("a perspective is a matrix");
        let corner = apply(&to_ndc, [1.0 + 8.0, 2.0 - 4.0, -1.0]).map(|x| x / 4.0);
        assert!(
            (corner[0] - 1.0).abs() < 1e-6 && (corner[1] - 1.0).abs() < 1e-6,
            "the lower right corner: {corner:?}"
        );
        let shifted = Camera { shift: [0.5, -0.25], ..camera.clone() };
        let shifted = CameraMatrices::new(&shifted, 2.0).expect("a view").ndc_from_world.expect("a matrix");
        let corner = apply(&shifted, [1.0 + 8.0, 2.0 - 4.0, -1.0]).map(|x| x / 4.0);
        assert!(
            (corner[0] - 0.75).abs() < 1e-6 && (corner[1] - 0.75).abs() < 1e-6,
            "half a height to the right is a quarter of the width: {corner:?}"
        );

        let projection = Projection::Orthographic { height: 8.0 };
        let parallel = CameraMatrices::new(&Camera { projection, ..camera.clone() }, 2.0).expect("a view");
        let corner = apply(&parallel.ndc_from_world.expect("so is this"), [1.0 + 8.0, 2.0 - 4.0, -1.0]);
        assert_eq!([corner[0], corner[1], corner[3]], [1.0; 3], "the lower right corner: {corner:?}");
        let panorama = CameraMatrices::new(&Camera { projection: Projection::Panorama, ..camera }, 2.0);
        assert_eq!(panorama.expect("a view").ndc_from_world, None, "no matrix leads there");
    }
}
