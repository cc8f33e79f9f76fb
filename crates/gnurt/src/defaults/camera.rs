// SPDX-License-Identifier: GPL-3.0-or-later
//! A camera that shows all of a box in a three-quarter view.
//! Space: world, y upwards, the front of objects towards +z.
//! Invariant: the box's corners are within the picture. Tests: `tests::shows_every_corner`.

use super::Bounds;
use crate::scene::Camera;

/// Vertical angle of view, degrees: that of a portrait lens, so that objects look well proportioned.
const ANGLE: f64 = 35.0;
/// From the middle of the scene to the eye: in front, to the right and above.
const TOWARDS_EYE: [f64; 3] = [0.55, 0.45, 1.0];
/// Margin around the box.
const MARGIN: f64 = 1.04;

/// A camera that shows all of `bounds`; `aspect` = width / height. Without bounds it faces the origin.
#[must_use]
pub fn framing(bounds: Option<Bounds>, aspect: f32) -> Camera {
    let bounds = bounds.unwrap_or(Bounds { min: [-1.0; 3], max: [1.0; 3] });
    let center = bounds.center();
    let length = TOWARDS_EYE.iter().map(|x| x * x).sum::<f64>().sqrt();
    let back = TOWARDS_EYE.map(|x| x / length);
    let distance = distance_to_fit(&bounds, back, f64::from(aspect));
    let eye = [0, 1, 2].map(|k| center[k] + distance * back[k]);
    Camera {
        name: "default".into(),
        eye: eye.map(single),
        target: center.map(single),
        up: [0.0, 1.0, 0.0],
        fov_y: ANGLE as f32,
        ..Camera::default()
    }
}

/// How far from the middle an eye in direction `back` sees every corner.
fn distance_to_fit(bounds: &Bounds, back: [f64; 3], aspect: f64) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let flat = (back[0] * back[0] + back[2] * back[2]).sqrt();
    let right = [back[2] / flat, 0.0, -back[0] / flat];
    let up = [-back[1] * back[0] / flat, flat, -back[1] * back[2] / flat];
    let half_height = (ANGLE.to_radians() / 2.0).tan();
    let half_width = half_height * if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 };
    let center = bounds.center();
    let needed = bounds.corners().map(|corner| {
        let offset = [0, 1, 2].map(|k| corner[k] - center[k]);
        let beside = (dot(offset, right).abs() / half_width).max(dot(offset, up).abs() / half_height);
        dot(offset, back) + beside * MARGIN
    });
    // A single point has no size: the distance is one unit, or as far as keeps eye and target distinct in
    // single precision.
    let least = center.iter().fold(1e-3_f64, |least, x| least.max(x.abs() * 1e-3));
    let fitting = needed.into_iter().fold(0.0, f64::max);
    if fitting > 0.0 { fitting.max(least * 1e-2) } else { least.max(1.0) }
}

/// In single precision, finite.
fn single(x: f64) -> f32 {
    x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shows_every_corner() {
        let boxes = [
            Bounds { min: [-1.0; 3], max: [1.0; 3] },
            Bounds { min: [100.0, 0.0, -3.0], max: [140.0, 1.0, 7.0] },
            Bounds { min: [0.0, 0.0, 0.0], max: [0.0, 5.0, 0.0] },
            Bounds { min: [-1e-3, -1e-3, 0.0], max: [1e-3, 2e-3, 0.0] },
        ];
        for (bounds, aspect) in boxes.into_iter().flat_map(|b| [(b, 1.0), (b, 16.0 / 9.0), (b, 0.3)]) {
            let camera = framing(Some(bounds), aspect);
            let frame = camera.frame().expect("the camera has a view");
            let half_height = (camera.fov_y.to_radians() / 2.0).tan();
            for corner in bounds.corners() {
                let offset = [0, 1, 2].map(|k| corner[k] as f32 - camera.eye[k]);
                let along = |axis: [f32; 3]| (0..3).map(|k| axis[k] * offset[k]).sum::<f32>();
                let depth = along(frame.forward);
                assert!(depth > 0.0, "{corner:?} of {bounds:?} is in front");
                assert!(
                    along(frame.up).abs() <= depth * half_height,
                    "{corner:?} of {bounds:?} is not too high"
                );
                assert!(
                    along(frame.right).abs() <= depth * half_height * aspect,
                    "{corner:?} is not too far aside"
                );
            }
        }
    }

    #[test]
    fn every_scene_has_a_view() {
        let point = |x: f64| Some(Bounds { min: [x; 3], max: [x; 3] });
        for bounds in
            [None, point(0.0), point(1e6), point(-3e38), Some(Bounds { min: [-3e38; 3], max: [3e38; 3] })]
        {
            let camera = framing(bounds, f32::NAN);
            assert!(camera.frame().is_some(), "there is a view of {bounds:?}: {camera:?}");
        }
    }
}
