// SPDX-License-Identifier: GPL-3.0-or-later
//! A camera that moves while the shutter is open. Source: [CPC84]: each ray starts at the camera's position at its time.
//! Between keys the eye moves straight, and axes are interpolated and normalised: keys must be so close that
//! the rotation between two is small, as those of an `Exposure` are. Space: world. Tests: `tests`,
//! crates/render/tests/shutter.rs.

use gnurt_accel::{KeyInterval, RayBatch};
use gnurt_scene::Camera;
use gnurt_shading::{CameraProjection, CameraSamples, CameraShader};

use crate::camera::SceneCamera;

/// A camera at times evenly spaced over the open shutter.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingCamera {
    keys: Vec<SceneCamera>,
}

impl MovingCamera {
    /// Through these cameras, one or more; `None` if one of them has no view.
    #[must_use]
    pub fn new(keys: &[Camera]) -> Option<Self> {
        let keys: Vec<SceneCamera> = keys.iter().map(SceneCamera::new).collect::<Option<_>>()?;
        (!keys.is_empty()).then_some(Self { keys })
    }

    /// The camera at a time from 0 to 1.
    #[must_use]
    pub fn at(&self, time: f32) -> SceneCamera {
        let interval = KeyInterval::of(time, self.keys.len());
        self.keys[interval.key].interpolated(&self.keys[interval.next], &interval)
    }
}

impl CameraShader for MovingCamera {
    fn rays(&self, samples: &CameraSamples, aspect: f32, out: &mut RayBatch) {
        for i in 0..samples.len() {
            let lens = samples.lens.get(i..=i).unwrap_or(&[]);
            let one = CameraSamples { positions: &samples.positions[i..=i], lens, times: &[] };
            self.at(samples.time(i)).rays(&one, aspect, out);
        }
    }

    fn projection(&self) -> Option<CameraProjection> {
        self.at(0.5).projection()
    }

    fn has_lens(&self) -> bool {
        self.keys.iter().any(SceneCamera::has_lens)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_leave_from_where_the_camera_is() {
        let camera = |x: f32| Camera {
            name: String::new(),
            eye: [x, 0.0, 0.0],
            target: [x, 0.0, -1.0 - x],
            up: [0.0, 1.0, 0.0],
            fov_y: 90.0,
            ..Camera::default()
        };
        let moving = MovingCamera::new(&[camera(0.0), camera(2.0), camera(6.0)]).expect("views");
        let mut rays = RayBatch::default();
        let positions = [[0.5, 0.5], [0.5, 0.5], [0.25, 1.0]];
        let samples = CameraSamples { positions: &positions, lens: &[], times: &[0.25, 0.75, 1.0] };
        moving.rays(&samples, 1.0, &mut rays);
        assert_eq!([0, 1, 2].map(|i| rays.get(i).org[0]), [1.0, 4.0, 6.0], "along its way");
        assert_eq!(rays.get(1).dir, [0.0, 0.0, -1.0], "the middle looks forward");
        let mut last = RayBatch::default();
        let still = SceneCamera::new(&camera(6.0)).expect("a view");
        still.rays(&CameraSamples::sharp(&positions[2..]), 1.0, &mut last);
        assert_eq!(rays.get(2), last.get(0), "at the end as if it stood there");
        assert_eq!(MovingCamera::new(&[]), None, "nowhere");
    }
}
