// SPDX-License-Identifier: GPL-3.0-or-later
//! Pixel shaders: the colours of samples of pixels. `P` and `I` are the camera's ray, with its changes from
//! pixel to pixel; `(color) trace (P, I)` along it is the integrator's result, without another ray. Space:
//! world; `raster` is in pixels from the upper left corner.
//! Tests: `tests/scripts/pixels.rs`.

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_shading::{AttributeRequest, PixelSamples, PixelShader, Tracer, Vec3s};
use gnurt_sl::exec::{LANES, Point, Points, Results};
use gnurt_sl_lib::Dual;

use crate::surface_state::CAMERA;
use crate::world::{Common, World, vector};

/// The parameter that pixels show.
pub(crate) const SHOWN: &str = "Cpixel";

/// The colours of pixels.
pub(crate) struct ScriptPixel {
    pub(crate) common: Common,
}

/// A sample as shaders see it.
fn point(samples: &PixelSamples, ray: &Ray, i: usize) -> Point {
    let [width, height] = samples.size.map(|n| n.max(1) as f32);
    let neighbours = samples.neighbours.map(|rays| (i < rays.len()).then(|| rays.get(i)));
    // Nothing changes towards where nothing is seen.
    let change = |from: [f32; 3], of: fn(&Ray) -> [f32; 3]| {
        let to = |k: usize| neighbours[k].as_ref().filter(|ray| ray.dir != [0.0; 3]).map_or(from, of);
        let step = |k: usize| (Vec3::from(to(k)) - Vec3::from(from)).to_array();
        Dual::new(from, step(0), step(1))
    };
    let [u, v] = samples.camera.positions[i];
    let back = (-Vec3::from(ray.dir)).to_array();
    Point {
        p: change(ray.org, |ray| ray.org),
        i: change(ray.dir, |ray| ray.dir),
        n: back,
        ng: back,
        u: Dual::new(u, 1.0 / width, 0.0),
        v: Dual::new(v, 0.0, -1.0 / height),
        time: samples.camera.time(i),
        dtime: samples.camera.duration(),
        xi: samples.camera.lens(i),
        raster: [u * width, (1.0 - v) * height],
        ray_kinds: CAMERA,
        index: i as i32,
        ..Point::default()
    }
}

impl PixelShader for ScriptPixel {
    fn needs_names(&self) -> bool {
        self.common.requests.iter().any(|request| request.name == AttributeRequest::IDS)
    }

    fn show(&self, tracer: &mut dyn Tracer, samples: &PixelSamples, out: &mut Vec3s) {
        let Some(row) = self.common.row(SHOWN) else { return };
        let world = World::before(&self.common, samples, tracer);
        let (mut points, mut results) = (Points::default(), Results::default());
        let mut lanes = Vec::with_capacity(LANES);
        let count = samples.rays.len().min(samples.camera.positions.len()).min(out.len());
        let mut next = 0;
        while next < count {
            lanes.clear();
            while next < count && lanes.len() < LANES {
                let ray = samples.rays.get(next);
                // Where the camera sees nothing, nothing is shown.
                if ray.dir != [0.0; 3] {
                    points.set(lanes.len(), &point(samples, &ray, next));
                    lanes.push(next);
                }
                next += 1;
            }
            points.count = lanes.len();
            if lanes.is_empty() {
                return;
            }
            self.common.run(&world, &points, &mut results);
            for (lane, &i) in lanes.iter().enumerate() {
                out.set(i, vector(&results, row, lane));
            }
        }
    }
}
