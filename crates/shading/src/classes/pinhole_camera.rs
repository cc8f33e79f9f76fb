// SPDX-License-Identifier: GPL-3.0-or-later
//! `PinholeCameraShader`: a pinhole camera given by the corners of its picture.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | origin | shader | 0 0 0 | the pinhole |
//! | lowerLeft | shader | -0.577 -0.577 -1 | from the origin to the lower left corner of the picture |
//! | vertical | shader | 0 1.155 0 | along the picture's left edge, upwards |
//! | horizontal | shader | 1.155 0 0 | along the picture's lower edge, to the right |
//!
//! The ray through (x, y) goes along `lowerLeft + x horizontal + y vertical`. The defaults are the default camera of
//! OpenRT: 60 degrees along -z, square. The picture's aspect does not matter: it is in the parameters.
//! Source: name and parameters as OpenRT programs know them. Tests: `tests::looks_through_its_corners`.

use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::{Ray, RayBatch};

use super::class::{Kind, Parameter, Shader, ShaderClass};
use crate::shader::{CameraSamples, CameraShader};

/// Tangent of 30 degrees.
const TAN_30: f32 = 0.577_350_26;

pub(super) static CLASS: ShaderClass = ShaderClass {
    name: "PinholeCameraShader",
    kind: Kind::Camera,
    parameters: &[
        Parameter::floats("origin", &[0.0; 3]),
        Parameter::floats("lowerLeft", &[-TAN_30, -TAN_30, -1.0]),
        Parameter::floats("vertical", &[0.0, 2.0 * TAN_30, 0.0]),
        Parameter::floats("horizontal", &[2.0 * TAN_30, 0.0, 0.0]),
    ],
    make: |values| {
        let [origin, lower_left, vertical, horizontal] = [0, 1, 2, 3].map(|i| values.vec3(i));
        Shader::Camera(Arc::new(PinholeCamera { origin, lower_left, vertical, horizontal }))
    },
};

struct PinholeCamera {
    origin: Vec3,
    lower_left: Vec3,
    vertical: Vec3,
    horizontal: Vec3,
}

impl CameraShader for PinholeCamera {
    fn rays(&self, samples: &CameraSamples, _aspect: f32, out: &mut RayBatch) {
        for &[x, y] in samples.positions {
            let dir = self.lower_left + x * self.horizontal + y * self.vertical;
            // A camera without a view sees nothing: a ray with a zero direction hits nothing.
            out.push(Ray::new(self.origin.into(), dir.normalize_or_zero().into()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_through_its_corners() {
        let Shader::Camera(camera) = CLASS.make(&CLASS.defaults()) else { panic!("a camera") };
        let mut rays = RayBatch::default();
        camera.rays(&CameraSamples::sharp(&[[0.5, 0.5], [0.5, 1.0]]), 7.0, &mut rays);
        assert_eq!(rays.get(0), Ray::new([0.0; 3], [0.0, 0.0, -1.0]), "the middle");
        let angle = (-rays.get(1).dir[2]).acos().to_degrees();
        assert!((angle - 30.0).abs() < 1e-3, "upper edge: {angle}");
    }
}
