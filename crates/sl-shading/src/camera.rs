// SPDX-License-Identifier: GPL-3.0-or-later
//! Camera shaders as cameras.
//! Space: world; the shader's space `camera` is that of a camera that looks along its -z and has y up.
//! Tests: `tests/scripts/kinds.rs`.

use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::{KeyInterval, Ray, RayBatch};
use gnurt_shading::script::CameraFrame;
use gnurt_shading::{CameraProperties, CameraSamples, CameraShader};
use gnurt_sl::exec::{LANES, Point, Points, Results};
use gnurt_sl_lib::Dual;

use crate::world::{Common, World, vector};

/// The frame at a time from 0 to 1, along frames evenly spaced over that time: the eye moves straight
/// from one to the next, axes are mixed and normalised. Panics if there is none.
fn along(frames: &[CameraFrame], time: f32) -> CameraFrame {
    let interval = KeyInterval::of(time, frames.len());
    let (a, b) = (&frames[interval.key], &frames[interval.next]);
    let mix = |a: [f32; 3], b: [f32; 3]| Vec3::from(interval.mix3(a, b));
    let axis = |a: [f32; 3], b: [f32; 3]| mix(a, b).normalize_or(a.into()).to_array();
    CameraFrame {
        eye: mix(a.eye, b.eye).to_array(),
        right: axis(a.right, b.right),
        up: axis(a.up, b.up),
        back: axis(a.back, b.back),
        pixels: a.pixels,
    }
}

/// From the camera's space to the world.
fn matrix(frame: &CameraFrame) -> [[f32; 4]; 4] {
    let row = |[x, y, z]: [f32; 3], w: f32| [x, y, z, w];
    [row(frame.right, 0.0), row(frame.up, 0.0), row(frame.back, 0.0), row(frame.eye, 1.0)]
}

/// A camera's shader without its frame. Cheap to clone.
#[derive(Clone)]
pub struct CameraScript {
    pub(crate) common: Arc<Common>,
    pub(crate) has_lens: bool,
}

impl CameraScript {
    /// The camera with its frames while the shutter is open: evenly spaced over that time, one or more;
    /// `None` if there is none.
    #[must_use]
    pub fn at(&self, frames: &[CameraFrame]) -> Option<Arc<dyn CameraShader>> {
        let Self { common, has_lens } = self.clone();
        (!frames.is_empty())
            .then(|| Arc::new(ScriptCamera { common, frames: frames.to_vec(), has_lens }) as _)
    }
}

/// A camera.
struct ScriptCamera {
    common: Arc<Common>,
    /// Where it is while the shutter is open, one or more.
    frames: Vec<CameraFrame>,
    has_lens: bool,
}

impl ScriptCamera {
    fn frame(&self, time: f32) -> CameraFrame {
        match &self.frames[..] {
            [frame] => *frame,
            frames => along(frames, time),
        }
    }
}

impl CameraShader for ScriptCamera {
    fn rays(&self, samples: &CameraSamples, aspect: f32, out: &mut RayBatch) {
        let world_from_camera = |time: f32| matrix(&self.frame(time));
        let mut world = World::empty(&self.common);
        world.world_from_camera = Some(&world_from_camera);
        world.camera_is_still = self.frames.len() == 1;
        world.aspect = aspect;
        world.camera = Some(CameraProperties {
            resolution: self.frames[0].pixels,
            projection: None,
            shutter: [0.0, samples.duration()],
        });
        let [w, h] = self.frames[0].pixels.map(|n| n.max(1) as f32);
        let (mut points, mut results) = (Points::default(), Results::default());
        let [from, along, weight, near, far] =
            ["P", "I", "weight", "tmin", "tmax"].map(|name| self.common.row(name));
        for first in (0..samples.len()).step_by(LANES) {
            points.count = LANES.min(samples.len() - first);
            for lane in 0..points.count {
                let i = first + lane;
                let [u, v] = samples.positions[i];
                let CameraFrame { eye, back, .. } = self.frame(samples.time(i));
                let point = Point {
                    p: Dual::from(eye),
                    i: Dual::from(back.map(|x| -x)),
                    n: back,
                    ng: back,
                    u: Dual::new(u, 1.0 / w, 0.0),
                    v: Dual::new(v, 0.0, -1.0 / h),
                    time: samples.time(i),
                    dtime: samples.duration(),
                    xi: samples.lens(i),
                    raster: [u * w, (1.0 - v) * h],
                    index: i as i32,
                    ..Point::default()
                };
                points.set(lane, &point);
            }
            self.common.run(&world, &points, &mut results);
            let number = |row: Option<usize>, lane: usize| row.map(|row| results.rows[row][lane]);
            let triple = |row: Option<usize>, lane: usize| row.map(|row| vector(&results, row, lane));
            for lane in 0..points.count {
                let org = triple(from, lane)
                    .filter(|p| p.is_finite())
                    .unwrap_or_else(|| Vec3::from(self.frame(samples.time(first + lane)).eye));
                let incoming = triple(weight, lane).is_none_or(|weight| weight != Vec3::ZERO);
                let dir = triple(along, lane).filter(|_| incoming).and_then(Vec3::try_normalize);
                let t_near = number(near, lane).unwrap_or(0.0).max(0.0);
                let t_far = number(far, lane).filter(|&t| t < 1e30).unwrap_or(f32::INFINITY);
                // A ray without a direction sees nothing.
                let ray =
                    Ray::new(org.to_array(), dir.unwrap_or(Vec3::ZERO).to_array()).within(t_near, t_far);
                out.push(ray);
            }
        }
    }

    fn has_lens(&self) -> bool {
        self.has_lens
    }
}
