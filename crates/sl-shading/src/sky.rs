// SPDX-License-Identifier: GPL-3.0-or-later
//! Environment shaders: asked for directions, or made a picture once, which integrators can sample.
//! Source: original. Space: world.
//! Proof: `tests/scripts/kinds.rs`.

use glam::Vec3;
use gnurt_shading::{EnvironmentShader, Vec3s};
use gnurt_sl::exec::{LANES, Point, Points, Results};
use gnurt_sl_lib::Dual;

use crate::parts::{self, At};
use crate::world::{CAMERA, Common, World};

/// A sky.
pub(crate) struct ScriptSky {
    pub(crate) common: Common,
}

impl EnvironmentShader for ScriptSky {
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
        let world = World::empty(&self.common);
        let (mut points, mut results) = (Points::default(), Results::default());
        for first in (0..dir.len()).step_by(LANES) {
            points.count = LANES.min(dir.len() - first);
            for lane in 0..points.count {
                let d = dir.get(first + lane);
                let back = (-d).to_array();
                let point = Point {
                    p: Dual::from(d.to_array()),
                    i: Dual::from(d.to_array()),
                    n: back,
                    ng: back,
                    ray_kinds: CAMERA,
                    index: (first + lane) as i32,
                    ..Point::default()
                };
                points.set(lane, &point);
            }
            self.common.run(&world, &points, &mut results);
            for lane in 0..points.count {
                let back = -dir.get(first + lane);
                let parts =
                    parts::of(&results.closures, results.ci[lane], At { ng: back, ns: back, front: true });
                let light = parts.emission + parts.radiance;
                out.set(first + lane, if light.is_finite() { light } else { Vec3::ZERO });
            }
        }
    }
}
