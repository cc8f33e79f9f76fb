// SPDX-License-Identifier: GPL-3.0-or-later
//! Environment shaders: run for directions, or made a picture once, which integrators can sample.
//! Space: world.
//! Tests: `tests/scripts/kinds.rs`.

use glam::Vec3;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{EnvironmentShader, Vec3s};
use gnurt_sl::exec::{LANES, Point, Points};
use gnurt_sl_lib::Dual;

use crate::parts::Flattened;
use crate::world::{Common, Ran, World};

/// A sky.
pub(crate) struct ScriptSky {
    pub(crate) common: Common,
    /// Bits of the kinds of the rays that see it.
    pub(crate) ray_kinds: u32,
}

impl EnvironmentShader for ScriptSky {
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
        let world = World::empty(&self.common);
        let mut lobes = ClosureBatch::default();
        lobes.reset(LANES);
        let fill = |first: usize, points: &mut Points| {
            points.count = LANES.min(dir.len() - first);
            for lane in 0..points.count {
                let d = dir.get(first + lane);
                let back = (-d).to_array();
                let point = Point {
                    p: Dual::from(d.to_array()),
                    i: Dual::from(d.to_array()),
                    n: back,
                    ng: back,
                    ray_kinds: self.ray_kinds,
                    index: (first + lane) as i32,
                    ..Point::default()
                };
                points.set(lane, &point);
            }
        };
        self.common.run_all(&world, dir.len(), fill, |Ran { first, points, results, open }| {
            let incoming = Flattened::flatten_lists(points, results, (&mut lobes, 0), open, self.common.map);
            for lane in 0..points.count {
                let light = incoming.lights.emission.get(lane) + incoming.lights.radiance.get(lane);
                out.set(first + lane, if light.is_finite() { light } else { Vec3::ZERO });
            }
        });
    }
}
