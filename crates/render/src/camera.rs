// SPDX-License-Identifier: GPL-3.0-or-later
//! The camera that a description holds, as a shader of rays.
//! Source: references/README point 5 (frame, vertical angle, square pixels); projections and lens: `gnurt_shading::ProjectiveCamera`.
//! Space: world. Tests: `tests::{corners_and_centre, degenerate_cameras_see_nothing}`, tests/path.rs (depth of field).

use glam::Vec3;
use gnurt_accel::{KeyInterval, RayBatch};
use gnurt_scene::{Camera, Projection};
use gnurt_shading::{CameraProjection, CameraSamples, CameraShader, ProjectiveCamera};

/// The camera of a description: of any projection, with or without a lens; the horizontal angle of view follows from the aspect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneCamera(ProjectiveCamera);

impl SceneCamera {
    /// The camera of a description; `None` if that has a [`fault`](Camera::fault).
    #[must_use]
    pub fn new(camera: &Camera) -> Option<Self> {
        if camera.fault().is_some() {
            return None;
        }
        let frame = camera.frame()?;
        let half_angle = f64::from(camera.fov_y).to_radians() / 2.0;
        let camera_projection = match camera.projection {
            Projection::Perspective => CameraProjection::Perspective { half_height: half_angle.tan() as f32 },
            Projection::Orthographic { height } => CameraProjection::Parallel { half_height: height / 2.0 },
            Projection::Fisheye => CameraProjection::Fisheye { half_angle: half_angle as f32 },
            Projection::Panorama => CameraProjection::Panorama,
        };
        // An angle may round to none, or to one too wide.
        let usable = match camera_projection {
            CameraProjection::Perspective { half_height } => half_height > 0.0 && half_height.is_finite(),
            _ => true,
        };
        usable.then(|| {
            Self(ProjectiveCamera {
                eye: camera.eye.into(),
                right: frame.right.into(),
                up: frame.up.into(),
                forward: frame.forward.into(),
                projection: camera_projection,
                radius: camera.lens.aperture / 2.0,
                focus: camera.focus_distance(),
                shift: camera.shift,
            })
        })
    }

    /// A camera between this one and another of the same projection.
    pub(crate) fn interpolated(&self, other: &Self, interval: &KeyInterval) -> Self {
        let (from, to) = (&self.0, &other.0);
        let mix = |a: Vec3, b: Vec3| Vec3::from(interval.mix3(a.into(), b.into()));
        let camera_projection = match (from.projection, to.projection) {
            (
                CameraProjection::Perspective { half_height: a },
                CameraProjection::Perspective { half_height: b },
            ) => CameraProjection::Perspective { half_height: interval.mix(a, b) },
            (
                CameraProjection::Parallel { half_height: a },
                CameraProjection::Parallel { half_height: b },
            ) => CameraProjection::Parallel { half_height: interval.mix(a, b) },
            (CameraProjection::Fisheye { half_angle: a }, CameraProjection::Fisheye { half_angle: b }) => {
                CameraProjection::Fisheye { half_angle: interval.mix(a, b) }
            }
            (camera_projection, _) => camera_projection,
        };
        Self(ProjectiveCamera {
            eye: mix(from.eye, to.eye),
            right: mix(from.right, to.right).normalize_or(from.right),
            up: mix(from.up, to.up).normalize_or(from.up),
            forward: mix(from.forward, to.forward).normalize_or(from.forward),
            projection: camera_projection,
            radius: interval.mix(from.radius, to.radius),
            focus: interval.mix(from.focus, to.focus),
            shift: std::array::from_fn(|k| interval.mix(from.shift[k], to.shift[k])),
        })
    }

    /// Where the pinhole, or the middle of the lens, is.
    #[must_use]
    pub fn eye(&self) -> [f32; 3] {
        self.0.eye.into()
    }

    /// Unit direction into the picture.
    #[must_use]
    pub fn forward(&self) -> [f32; 3] {
        self.0.forward.into()
    }
}

impl CameraShader for SceneCamera {
    fn rays(&self, samples: &CameraSamples, aspect: f32, out: &mut RayBatch) {
        self.0.rays(samples, aspect, out);
    }

    fn has_lens(&self) -> bool {
        self.0.has_lens()
    }

    fn projection(&self) -> Option<CameraProjection> {
        Some(self.0.projection)
    }

    fn project(&self, p: Vec3, aspect: f32) -> Option<[f32; 2]> {
        self.0.project(p, aspect)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera { eye: [1.0, 2.0, 3.0], target: [1.0, 2.0, -7.0], fov_y: 90.0, ..Camera::default() }
    }

    #[test]
    fn corners_and_centre() {
        let camera = SceneCamera::new(&camera()).expect("a view");
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
    fn descriptions_become_looks() {
        let with = |projection, aperture| {
            let mut camera = Camera { projection, ..camera() };
            camera.lens.aperture = aperture;
            SceneCamera::new(&camera).expect("a view").0
        };
        let parallel = with(Projection::Orthographic { height: 3.0 }, 0.5);
        assert_eq!(
            parallel.projection,
            CameraProjection::Parallel { half_height: 1.5 },
            "half of the height"
        );
        assert_eq!((parallel.radius, parallel.focus), (0.25, 10.0), "half of the aperture; the target");
        assert!(!with(Projection::Panorama, 0.0).has_lens(), "a pinhole has none");
    }

    #[test]
    fn degenerate_cameras_see_nothing() {
        let with = |edit: fn(&mut Camera)| {
            let mut camera = camera();
            edit(&mut camera);
            SceneCamera::new(&camera)
        };
        assert_eq!(with(|c| c.target = c.eye), None, "no direction");
        assert_eq!(with(|c| c.eye[0] = f32::NAN), None, "no place");
        assert_eq!(with(|c| c.fov_y = 0.0), None, "no angle");
        assert_eq!(with(|c| c.fov_y = 180.0), None, "too wide an angle");
        assert_eq!(with(|c| c.lens.aperture = f32::NAN), None, "no aperture");
        assert!(with(|c| c.up = [0.0, 0.0, 1.0]).is_some(), "an up along the view is replaced");
    }
}
