// SPDX-License-Identifier: GPL-3.0-or-later
//! The pinhole camera that shaders and files describe, as a shader of rays.
//! Source: references/README point 5 (frame, vertical angle, square pixels). Space: world.
//! Proof: `tests::{corners_and_centre, degenerate_cameras_see_nothing}`.

use glam::Vec3;
use gnurt_accel::{Moment, RayBatch};
use gnurt_scene::Camera;
use gnurt_shading::{CameraSamples, CameraShader};

/// A pinhole camera with a vertical angle of view; the horizontal one follows from the aspect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerspectiveCamera {
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half the picture's height at distance 1.
    half_height: f32,
}

impl PerspectiveCamera {
    /// The camera of a description; `None` if it has no view (eye = target, a value that is not finite, an angle
    /// that is not between 0 and 180 degrees).
    #[must_use]
    pub fn new(camera: &Camera) -> Option<Self> {
        let frame = camera.frame()?;
        let half_height = (f64::from(camera.fov_y).to_radians() / 2.0).tan() as f32;
        let eye = Vec3::from(camera.eye);
        let usable =
            camera.fov_y > 0.0 && camera.fov_y < 180.0 && half_height > 0.0 && half_height.is_finite();
        (usable && eye.is_finite()).then(|| Self {
            eye,
            right: frame.right.into(),
            up: frame.up.into(),
            forward: frame.forward.into(),
            half_height,
        })
    }

    /// A camera on the way from this one to another.
    pub(crate) fn between(&self, other: &Self, moment: &Moment) -> Self {
        let mix = |a: Vec3, b: Vec3| Vec3::from(moment.mix3(a.into(), b.into()));
        Self {
            eye: mix(self.eye, other.eye),
            right: mix(self.right, other.right).normalize_or(self.right),
            up: mix(self.up, other.up).normalize_or(self.up),
            forward: mix(self.forward, other.forward).normalize_or(self.forward),
            half_height: moment.mix(self.half_height, other.half_height),
        }
    }

    /// Where the pinhole is.
    #[must_use]
    pub fn eye(&self) -> [f32; 3] {
        self.eye.into()
    }

    /// Unit direction into the picture.
    #[must_use]
    pub fn forward(&self) -> [f32; 3] {
        self.forward.into()
    }
}

impl CameraShader for PerspectiveCamera {
    fn rays(&self, samples: &CameraSamples, aspect: f32, out: &mut RayBatch) {
        let (right, up) = (self.right * (self.half_height * aspect), self.up * self.half_height);
        let first = out.len();
        let end = first + samples.len();
        let [dx, dy, dz] = &mut out.dir;
        [&mut *dx, &mut *dy, &mut *dz].into_iter().for_each(|array| array.resize(end, 0.0));
        let places = dx[first..].iter_mut().zip(&mut dy[first..]).zip(&mut dz[first..]);
        for (((dx, dy), dz), [x, y]) in places.zip(samples.places) {
            let dir = self.forward + right * (2.0 * x - 1.0) + up * (2.0 * y - 1.0);
            [*dx, *dy, *dz] = dir.normalize().into();
        }
        out.org.iter_mut().zip(self.eye.to_array()).for_each(|(array, x)| array.resize(end, x));
        out.t_near.resize(end, 0.0);
        out.t_far.resize(end, f32::INFINITY);
        if !out.mask.is_empty() {
            out.mask.resize(end, u32::MAX);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            name: String::new(),
            eye: [1.0, 2.0, 3.0],
            target: [1.0, 2.0, -7.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 90.0,
        }
    }

    #[test]
    fn corners_and_centre() {
        let camera = PerspectiveCamera::new(&camera()).expect("a view");
        let mut rays = RayBatch::default();
        camera.rays(&CameraSamples::sharp(&[[0.5, 0.5], [0.0, 0.0], [1.0, 1.0]]), 2.0, &mut rays);
        assert_eq!(rays.get(0).dir, [0.0, 0.0, -1.0], "the middle looks forward");
        let corner = Vec3::new(2.0, 1.0, 1.0).normalize();
        let dirs = [1, 2].map(|i| Vec3::from(rays.get(i).dir));
        assert!((dirs[0] + corner).length() < 1e-6, "lower left: twice as wide as high, {}", dirs[0]);
        assert!((dirs[1] - corner * Vec3::new(1.0, 1.0, -1.0)).length() < 1e-6, "upper right, {}", dirs[1]);
        assert_eq!(rays.get(1).org, [1.0, 2.0, 3.0], "from the eye");
    }

    #[test]
    fn degenerate_cameras_see_nothing() {
        let with = |edit: fn(&mut Camera)| {
            let mut camera = camera();
            edit(&mut camera);
            PerspectiveCamera::new(&camera)
        };
        assert_eq!(with(|c| c.target = c.eye), None, "no direction");
        assert_eq!(with(|c| c.eye[0] = f32::NAN), None, "no place");
        assert_eq!(with(|c| c.fov_y = 0.0), None, "no angle");
        assert_eq!(with(|c| c.fov_y = 180.0), None, "too wide an angle");
        assert!(with(|c| c.up = [0.0, 0.0, 1.0]).is_some(), "an up along the view is replaced");
    }
}
