// SPDX-License-Identifier: GPL-3.0-or-later
//! `ThinLensCameraShader`, `OrthographicCameraShader`, `FisheyeCameraShader`, `PanoramicCameraShader`:
//! cameras with a position, a target and a lens.
//!
//! | parameter | of | default | meaning |
//! |---|---|---|---|
//! | eye | all | 0 0 0 | the middle of the lens |
//! | target | all | 0 0 -1 | the middle of the picture |
//! | up | all | 0 1 0 | up in the picture; need not be perpendicular to the view |
//! | aperture | all | 0 | diameter of the lens; 0 = all is sharp |
//! | focus | all | 0 | distance of the focus; 0 = that of the target |
//! | fov | thin lens, fisheye | 60, 180 | vertical angle of view in degrees |
//! | height | orthographic | 2 | height of the visible region |
//!
//! The projections are [`ProjectiveCamera`]'s. A camera with invalid numbers sees nothing.
//! Tests: `tests`.

use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::{Ray, RayBatch};

use super::class::{Kind, Parameter, Shader, ShaderClass, Values};
use crate::camera_projection::CameraProjection;
use crate::projective_camera::ProjectiveCamera;
use crate::sampling::Basis;
use crate::shader::{CameraSamples, CameraShader};

const EYE: Parameter = Parameter::floats("eye", &[0.0; 3]);
const TARGET: Parameter = Parameter::floats("target", &[0.0, 0.0, -1.0]);
const UP: Parameter = Parameter::floats("up", &[0.0, 1.0, 0.0]);
const APERTURE: Parameter = Parameter::floats("aperture", &[0.0]);
const FOCUS: Parameter = Parameter::floats("focus", &[0.0]);

pub(super) static THIN_LENS: ShaderClass = ShaderClass {
    name: "ThinLensCameraShader",
    kind: Kind::Camera,
    parameters: &[EYE, TARGET, UP, APERTURE, FOCUS, Parameter::floats("fov", &[60.0])],
    make: |values| {
        let half_height = (values.float(5).to_radians() / 2.0).tan();
        let good = values.float(5) < 180.0 && half_height > 0.0 && half_height.is_finite();
        camera(values, good.then_some(CameraProjection::Perspective { half_height }))
    },
};

pub(super) static ORTHOGRAPHIC: ShaderClass = ShaderClass {
    name: "OrthographicCameraShader",
    kind: Kind::Camera,
    parameters: &[EYE, TARGET, UP, APERTURE, FOCUS, Parameter::floats("height", &[2.0])],
    make: |values| {
        let half_height = values.float(5) / 2.0;
        let good = half_height > 0.0 && half_height.is_finite();
        camera(values, good.then_some(CameraProjection::Parallel { half_height }))
    },
};

pub(super) static FISHEYE: ShaderClass = ShaderClass {
    name: "FisheyeCameraShader",
    kind: Kind::Camera,
    parameters: &[EYE, TARGET, UP, APERTURE, FOCUS, Parameter::floats("fov", &[180.0])],
    make: |values| {
        let degrees = values.float(5);
        let half_angle = degrees.to_radians() / 2.0;
        camera(
            values,
            (degrees > 0.0 && degrees <= 360.0).then_some(CameraProjection::Fisheye { half_angle }),
        )
    },
};

pub(super) static PANORAMIC: ShaderClass = ShaderClass {
    name: "PanoramicCameraShader",
    kind: Kind::Camera,
    parameters: &[EYE, TARGET, UP, APERTURE, FOCUS],
    make: |values| camera(values, Some(CameraProjection::Panorama)),
};

/// The camera; with an invalid number, one that sees nothing.
fn camera(values: &Values, projection: Option<CameraProjection>) -> Shader {
    match projection.and_then(|projection| looking(values, projection)) {
        Some(camera) => Shader::Camera(Arc::new(camera)),
        None => Shader::Camera(Arc::new(Blind)),
    }
}

fn looking(values: &Values, projection: CameraProjection) -> Option<ProjectiveCamera> {
    let [eye, target, up] = [0, 1, 2].map(|i| values.vec3(i));
    let forward = (target - eye).try_normalize().filter(|_| eye.is_finite())?;
    // If `up` is undefined, any other direction will do.
    let Basis { tangent: up, bitangent: right, .. } = Basis::along(forward, up.normalize_or_zero());
    let (radius, focus) = (values.float(3) / 2.0, values.float(4));
    let focus = if focus == 0.0 { eye.distance(target) } else { focus };
    let good = radius >= 0.0 && radius.is_finite() && focus > 0.0 && focus.is_finite();
    good.then_some(ProjectiveCamera { eye, right, up, forward, projection, radius, focus, shift: [0.0; 2] })
}

/// A camera that sees nothing: its rays have no direction.
struct Blind;

impl CameraShader for Blind {
    fn rays(&self, samples: &CameraSamples, _aspect: f32, out: &mut RayBatch) {
        out.extend(samples.positions.iter().map(|_| Ray::new([0.0; 3], Vec3::ZERO.into())));
    }
}

#[cfg(test)]
mod tests {
    use super::super::class::Value;
    use super::*;

    fn ray(class: &ShaderClass, edit: &[(usize, Vec<f32>)], position: [f32; 2]) -> Ray {
        let mut values = class.defaults();
        edit.iter().for_each(|(i, numbers)| values.0[*i] = Value::Floats(numbers.clone()));
        let Shader::Camera(camera) = class.make(&values) else { panic!("a camera") };
        let mut rays = RayBatch::default();
        camera.rays(&CameraSamples::sharp(&[position]), 1.0, &mut rays);
        rays.get(0)
    }

    #[test]
    fn they_look_where_they_are_told() {
        let near = |a: [f32; 3], b: [f32; 3]| Vec3::from(a).distance(b.into()) < 1e-5;
        for class in [&THIN_LENS, &ORTHOGRAPHIC, &FISHEYE, &PANORAMIC] {
            let edit = [(0, vec![1.0, 0.0, 0.0]), (1, vec![9.0, 0.0, 0.0]), (2, vec![0.0, 0.0, 3.0])];
            let middle = ray(class, &edit, [0.5, 0.5]);
            assert!(near(middle.dir, [1.0, 0.0, 0.0]), "{}: {:?}", class.name, middle.dir);
            // For a view along x with z upwards, -y is to the right.
            let right = ray(class, &edit, [0.75, 0.5]);
            assert!(right.dir[1] < 0.0 || right.org[1] < 0.0, "{}: {right:?}", class.name);
        }
        let edge = ray(&ORTHOGRAPHIC, &[], [0.5, 1.0]);
        assert!(near(edge.org, [0.0, 1.0, 0.0]), "half of the height above the eye: {:?}", edge.org);
        assert!(near(ray(&FISHEYE, &[], [0.5, 1.0]).dir, [0.0, 1.0, 0.0]), "180 degrees high");
    }

    #[test]
    fn nonsense_sees_nothing() {
        let nan = vec![f32::NAN];
        for (class, position, numbers) in [
            (&THIN_LENS, 5, vec![180.0]),
            (&THIN_LENS, 1, vec![0.0; 3]),
            (&THIN_LENS, 3, nan.clone()),
            (&ORTHOGRAPHIC, 5, vec![-1.0]),
            (&FISHEYE, 5, vec![361.0]),
            (&PANORAMIC, 4, vec![-1.0]),
            (&PANORAMIC, 0, vec![f32::NAN, 0.0, 0.0]),
        ] {
            let found = ray(class, &[(position, numbers.clone())], [0.4, 0.4]).dir;
            assert_eq!(found, [0.0; 3], "{} with {numbers:?}", class.name);
        }
    }
}
