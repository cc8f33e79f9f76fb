// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras: perspective, orthographic and omnidirectional, through a lens, for a part of the picture, between two planes.
//! Source: ANARI 1.1, KHR_CAMERA_*. Directions are unit, so that `t` is the distance from the camera. Tests: tests/cameras.rs.

use glam::Vec3;
use gnurt::accel::RayBatch;
use gnurt::scene::Affine;
use gnurt::shading::{CameraProjection, CameraSamples, CameraShader, ProjectiveCamera};

use crate::motion::{self, Motion, Shutter};
use crate::object::Object;
use crate::transforms::{linear, point};
use crate::types;

/// A camera.
pub(crate) struct View {
    inner: ProjectiveCamera,
    region: [f32; 4],
    aspect: Option<f32>,
    near: Option<f32>,
    far: Option<f32>,
    pub(crate) shutter: Shutter,
    motion: Option<Motion>,
}

impl View {
    /// The camera of an object; an error in words where it sees nothing.
    pub(crate) fn new(object: &Object) -> Result<Self, String> {
        let now = object.committed();
        let vector = |name: &str, default: [f32; 3]| Vec3::from(now.vec3(name).unwrap_or(default));
        let forward = vector("direction", [0.0, 0.0, -1.0]);
        let forward = forward.try_normalize().ok_or("parameter 'direction': without length")?;
        let up = vector("up", [0.0, 1.0, 0.0]);
        let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let eye = vector("position", [0.0; 3]);
        if !eye.is_finite() {
            return Err(format!("parameter 'position': {eye}: out of range"));
        }
        let projection = match object.subtype.as_str() {
            "perspective" => {
                let angle = now.f32("fovy").unwrap_or(std::f32::consts::FRAC_PI_3);
                if !(angle > 0.0 && angle < std::f32::consts::PI) {
                    return Err(format!(
                        "parameter 'fovy': {angle}: out of range; it must be above 0 and below pi"
                    ));
                }
                CameraProjection::Perspective { half_height: (angle / 2.0).tan() }
            }
            "orthographic" => {
                let height = now.f32("height").unwrap_or(1.0);
                if !(height > 0.0 && height.is_finite()) {
                    return Err(format!("parameter 'height': {height}: out of range; it must be above 0"));
                }
                CameraProjection::Parallel { half_height: height / 2.0 }
            }
            "omnidirectional" => CameraProjection::Panorama,
            other => return Err(format!("subtype '{other}': unsupported")),
        };
        let lens = |name: &str, default: f32| {
            let value = now.f32(name).unwrap_or(default);
            if value >= 0.0 && value.is_finite() { value } else { default }
        };
        let inner = ProjectiveCamera {
            eye,
            right,
            up: right.cross(forward),
            forward,
            projection,
            radius: lens("apertureRadius", 0.0),
            focus: lens("focusDistance", 1.0).max(f32::MIN_POSITIVE),
            shift: [0.0; 2],
        };
        let shutter = motion::shutter(&now)?;
        let motion = Motion::of(&now);
        let region = now.floats("imageRegion", &[types::FLOAT32_BOX2, types::FLOAT32_VEC4]);
        Ok(Self {
            inner,
            region: region.unwrap_or([0.0, 0.0, 1.0, 1.0]),
            aspect: now.f32("aspect").filter(|aspect| *aspect > 0.0 && aspect.is_finite()),
            near: now.f32("near").filter(|near| *near > 0.0),
            far: now.f32("far").filter(|far| *far > 0.0),
            shutter,
            motion,
        })
    }

    /// Whether it moves while the shutter is open.
    pub(crate) fn moves(&self) -> bool {
        self.motion.is_some() && self.shutter[0] < self.shutter[1]
    }

    /// The camera at a share of the time that the shutter is open.
    fn at(&self, share: f32) -> ProjectiveCamera {
        match &self.motion {
            Some(motion) => moved(&self.inner, &motion.at(motion::time_at(self.shutter, share))),
            None => self.inner,
        }
    }

    /// The ray through a place of the frame, (0, 0) its lower left corner, and the middle of the lens.
    pub(crate) fn ray(&self, at: [f32; 2], aspect: f32) -> gnurt::accel::Ray {
        let mut rays = RayBatch::default();
        self.rays(&CameraSamples::sharp(&[at]), aspect, &mut rays);
        rays.get(0)
    }
}

impl CameraShader for View {
    fn rays(&self, samples: &CameraSamples, aspect: f32, out: &mut RayBatch) {
        let [left, low, right, high] = self.region;
        let within = |&[x, y]: &[f32; 2]| [left + (right - left) * x, low + (high - low) * y];
        let positions: Vec<[f32; 2]> = samples.positions.iter().map(within).collect();
        let (first, aspect) = (out.len(), self.aspect.unwrap_or(aspect));
        if self.moves() {
            for i in 0..samples.len() {
                let lens = samples.lens.get(i..=i).unwrap_or(&[]);
                let one = CameraSamples { positions: &positions[i..=i], lens, times: &[] };
                self.at(samples.time(i)).rays(&one, aspect, out);
            }
        } else {
            self.at(0.5).rays(&CameraSamples { positions: &positions, ..*samples }, aspect, out);
        }
        if self.near.is_none() && self.far.is_none() {
            return;
        }
        for i in first..out.len() {
            let time = if self.moves() { samples.time(i - first) } else { 0.5 };
            let cos = Vec3::from(out.get(i).dir).dot(self.at(time).forward);
            // Planes across the view; without one for all directions, spheres.
            let scale =
                if self.inner.projection == CameraProjection::Panorama || cos <= 0.0 { 1.0 } else { cos };
            if let Some(near) = self.near {
                out.t_near[i] = near / scale;
            }
            if let Some(far) = self.far {
                out.t_far[i] = far / scale;
            }
        }
    }

    fn has_lens(&self) -> bool {
        self.inner.has_lens()
    }
}

/// A camera that a matrix takes somewhere else: its axes stay unit.
fn moved(camera: &ProjectiveCamera, matrix: &Affine) -> ProjectiveCamera {
    let turn = linear(matrix);
    let forward = (turn * camera.forward).normalize_or(camera.forward);
    let right = forward.cross(turn * camera.up).try_normalize().unwrap_or(camera.right);
    ProjectiveCamera { eye: point(matrix, camera.eye), right, up: right.cross(forward), forward, ..*camera }
}
