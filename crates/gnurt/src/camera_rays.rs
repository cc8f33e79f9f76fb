// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays of a camera of a description: by its own settings, or by a shader that replaces it.
//! Space: world. Tests: `tests`, and the command line's `tests/program/scripts.rs`.

use std::sync::Arc;

use crate::osl::{CameraFrame, CameraScript};

use crate::render::{MovingCamera, SceneCamera};
use crate::scene::Camera;
use crate::shading::CameraShader;

/// The rays of a camera for a picture of `size` pixels; by `script`, if there is one. `None` if it has no view.
#[must_use]
pub fn camera_rays(
    camera: &Camera,
    script: Option<&CameraScript>,
    size: [u32; 2],
) -> Option<Arc<dyn CameraShader>> {
    camera_rays_along(std::slice::from_ref(camera), script, size)
}

/// The same for a camera that moves while the shutter is open: `keys` are evenly spaced over that time, one or more.
#[must_use]
pub fn camera_rays_along(
    keys: &[Camera],
    script: Option<&CameraScript>,
    size: [u32; 2],
) -> Option<Arc<dyn CameraShader>> {
    match (script, keys) {
        (Some(script), keys) => {
            let frames: Vec<CameraFrame> =
                keys.iter().map(|key| frame_of(key, size)).collect::<Option<_>>()?;
            script.at(&frames)
        }
        (None, [camera]) => Some(Arc::new(SceneCamera::new(camera)?)),
        (None, keys) => Some(Arc::new(MovingCamera::new(keys)?)),
    }
}

/// The frame of a camera.
fn frame_of(camera: &Camera, pixels: [u32; 2]) -> Option<CameraFrame> {
    let frame = camera.frame().filter(|_| camera.eye.iter().all(|x| x.is_finite()))?;
    let back = frame.forward.map(|x| -x);
    Some(CameraFrame { eye: camera.eye, right: frame.right, up: frame.up, back, pixels })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::RayBatch;
    use crate::osl::{Access, Script};
    use crate::shading::CameraSamples;

    const TEXT: &str = "camera pinhole (float fov = 45, float aspect = 1) {
        float half = tan (radians (0.5 * fov));
        P = point (\"camera\", 0, 0, 0);
        I = vector (\"camera\", (2 * u - 1) * half * aspect, (2 * v - 1) * half, -1); }";

    #[test]
    fn a_pinhole_is_a_pinhole() {
        let script = Script::from_text("p.osl".as_ref(), TEXT, &Access::default()).expect("it compiles");
        let script = script.camera_anywhere().expect("a camera");
        let first = Camera { eye: [1.0, 2.0, 3.0], target: [4.0, 2.5, 1.0], ..Camera::default() };
        let last = Camera { eye: [2.0, 2.0, 3.0], target: [4.5, 2.5, 1.0], ..Camera::default() };
        let frames: Vec<[f32; 2]> = (0..40).map(|i| [i as f32 / 39.0, (i * 7 % 40) as f32 / 39.0]).collect();
        let times: Vec<f32> = (0..40).map(|i| i as f32 / 40.0).collect();
        for (keys, times) in [(vec![first.clone()], &[][..]), (vec![first.clone(), last], &times)] {
            let [mut built_in, mut scripted] = [RayBatch::default(), RayBatch::default()];
            for (script, rays) in [(None, &mut built_in), (Some(&script), &mut scripted)] {
                let camera = camera_rays_along(&keys, script, [60, 40]).expect("a view");
                camera.rays(&CameraSamples { positions: &frames, lens: &[], times }, 1.5, rays);
            }
            for i in 0..frames.len() {
                let (a, b) = (built_in.get(i), scripted.get(i));
                let apart = |a: [f32; 3], b: [f32; 3]| (0..3).any(|k| (a[k] - b[k]).abs() > 2e-6);
                assert!(!apart(a.org, b.org) && !apart(a.dir, b.dir), "ray {i}: {a:?}, {b:?}");
            }
        }
        assert!(camera_rays(&Camera { target: first.eye, ..first }, Some(&script), [1, 1]).is_none());
    }
}
