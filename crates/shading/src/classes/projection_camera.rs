// SPDX-License-Identifier: GPL-3.0-or-later
//! A camera given as OpenGL gives it: a view frame and a projection matrix, perspective or parallel.
//! Clip coordinates as OpenGL's: the picture is [-1, 1] squared, z = -1 is near.
//! Space: eye space faces -z, with y upwards; rays are in world space. A perspective's rays begin at the eye,
//! that is at the point that the matrix sends to (0, 0, z, 0); parallel rays begin at the near plane. Far is
//! ignored.
//! Tests: `tests`.

use glam::{DMat4, DVec3, DVec4};
use gnurt_accel::{Ray, RayBatch};

use crate::shader::{CameraSamples, CameraShader};

/// A camera with a projection matrix.
#[derive(Clone, Debug)]
pub struct ProjectionCamera {
    /// From eye space to world space, rigid.
    world_from_eye: DMat4,
    eye_from_clip: DMat4,
    /// Whether the matrix is for a picture as wide as high, to be fitted to the real one.
    follows_aspect: bool,
}

impl ProjectionCamera {
    /// A camera at `eye` with unit axes `right`, `up`, `forward`; `projection` is column-major and goes from eye space
    /// to clip space. With `follows_aspect` it is made for a square picture, and others see more or less to the sides.
    /// `None` if the matrix has no inverse: then there is no map from the picture to the scene.
    #[must_use]
    pub fn new(
        eye: [f32; 3],
        [right, up, forward]: [[f32; 3]; 3],
        projection: &[f64; 16],
        follows_aspect: bool,
    ) -> Option<Self> {
        let axis = |v: [f32; 3], sign: f64, w: f64| (sign * DVec3::from_array(v.map(f64::from))).extend(w);
        let world_from_eye = DMat4::from_cols(
            axis(right, 1.0, 0.0),
            axis(up, 1.0, 0.0),
            axis(forward, -1.0, 0.0),
            axis(eye, 1.0, 1.0),
        );
        let eye_from_clip = DMat4::from_cols_array(projection).inverse();
        eye_from_clip.is_finite().then_some(Self { world_from_eye, eye_from_clip, follows_aspect })
    }

    /// Ray of a point of the picture, clip coordinates. All zero where the matrix gives none.
    fn ray(&self, clip_x: f64, clip_y: f64) -> Ray {
        let at = |z: f64| self.eye_from_clip * DVec4::new(clip_x, clip_y, z, 1.0);
        let (near, far) = (at(-1.0), at(1.0));
        let pinhole = self.eye_from_clip * DVec4::Z;
        // A point at infinity has w = 0: then the projection is parallel, along that point's direction.
        let is_perspective = pinhole.w.abs() > 1e-12 * pinhole.truncate().length();
        let near_point = near.truncate() / near.w;
        let (origin, mut dir) = if is_perspective {
            let eye = pinhole.truncate() / pinhole.w;
            (eye, near_point - eye)
        } else {
            (near_point, far.truncate() / far.w - near_point)
        };
        if !is_perspective && dir.dot(pinhole.truncate()) == 0.0 {
            dir = pinhole.truncate();
        }
        let origin = self.world_from_eye.transform_point3(origin).as_vec3();
        let dir = self.world_from_eye.transform_vector3(dir).normalize_or_zero().as_vec3();
        Ray::new(origin.into(), dir.into())
    }
}

impl CameraShader for ProjectionCamera {
    fn rays(&self, samples: &CameraSamples, aspect: f32, out: &mut RayBatch) {
        let stretch = if self.follows_aspect { f64::from(aspect) } else { 1.0 };
        out.extend(samples.positions.iter().map(|&[x, y]| {
            let [clip_x, clip_y] = [x, y].map(|v| 2.0 * f64::from(v) - 1.0);
            self.ray(clip_x * stretch, clip_y)
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];

    fn ray(projection: DMat4, follows_aspect: bool, xy: [f32; 2], aspect: f32) -> Ray {
        let camera =
            ProjectionCamera::new([1.0, 2.0, 3.0], AXES, &projection.to_cols_array(), follows_aspect);
        let mut rays = RayBatch::default();
        camera.expect("it has an inverse").rays(&CameraSamples::sharp(&[xy]), aspect, &mut rays);
        rays.get(0)
    }

    #[test]
    fn perspective_rays_begin_at_the_eye() {
        let (near, far) = (0.5, 100.0);
        let projection = DMat4::from_cols(
            DVec4::X,
            DVec4::Y,
            DVec4::new(0.0, 0.0, (far + near) / (near - far), -1.0),
            DVec4::new(0.0, 0.0, 2.0 * far * near / (near - far), 0.0),
        );
        let found = ray(projection, true, [1.0, 0.5], 2.0);
        assert_eq!(found.org, [1.0, 2.0, 3.0], "not at the near plane");
        let slope = found.dir[0] / -found.dir[2];
        assert!((slope - 2.0).abs() < 1e-5, "90 degrees high, twice as wide: {slope}");
        let fixed = ray(projection, false, [1.0, 0.5], 2.0);
        assert!((fixed.dir[0] / -fixed.dir[2] - 1.0).abs() < 1e-5, "the matrix as it is");
    }

    #[test]
    fn parallel_rays_begin_at_the_near_plane() {
        let (near, far) = (1.0, 10.0);
        let projection = DMat4::from_cols(
            DVec4::X / 4.0,
            DVec4::Y / 3.0,
            DVec4::Z * (2.0 / (near - far)),
            DVec4::new(0.0, 0.0, (far + near) / (near - far), 1.0),
        );
        let found = ray(projection, false, [1.0, 0.0], 1.0);
        let expected = Ray::new([5.0, -1.0, 2.0], [0.0, 0.0, -1.0]);
        for k in 0..3 {
            assert!((found.org[k] - expected.org[k]).abs() < 1e-5, "origin {:?}", found.org);
            assert!((found.dir[k] - expected.dir[k]).abs() < 1e-6, "direction {:?}", found.dir);
        }
    }

    #[test]
    fn flat_matrices_are_refused() {
        assert!(ProjectionCamera::new([0.0; 3], AXES, &[0.0; 16], false).is_none(), "no inverse");
    }
}
