// SPDX-License-Identifier: GPL-3.0-or-later
//! Light shaders as lights.
//! Space: world.
//! Tests: `tests/scripts/kinds.rs`.

use glam::Vec3;
use gnurt_shading::{LightBatch, LightShader, Vec3s};
use gnurt_sl::exec::{LANES, Point, Points, Results};
use gnurt_sl_lib::Dual;

use crate::world::{Common, World, vector};

/// A light.
pub(crate) struct ScriptLight {
    pub(crate) common: Common,
}

impl LightShader for ScriptLight {
    fn illuminate(&self, p: &Vec3s, normal: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch) {
        let world = World::empty(&self.common);
        let [direction, color, distance, density] =
            ["L", "Cl", "lightdist", "lightpdf"].map(|name| self.common.row(name));
        let (Some(direction), Some(color)) = (direction, color) else { return };
        let (mut points, mut results) = (Points::default(), Results::default());
        for first in (0..p.len()).step_by(LANES) {
            points.count = LANES.min(p.len() - first);
            for lane in 0..points.count {
                let i = first + lane;
                let (position, n) = (p.get(i).to_array(), normal.get(i).to_array());
                let point = Point {
                    p: Dual::from(position),
                    ps: Dual::from(position),
                    n,
                    ng: n,
                    xi: random.get(i).copied().unwrap_or([0.5; 2]),
                    index: i as i32,
                    ..Point::default()
                };
                points.set(lane, &point);
            }
            self.common.run(&world, &points, &mut results);
            for lane in 0..points.count {
                let i = first + lane;
                let Some(dir) = vector(&results, direction, lane).try_normalize() else { continue };
                let light = self.common.map.of(vector(&results, color, lane).max(Vec3::ZERO));
                if light == Vec3::ZERO || !light.is_finite() {
                    continue;
                }
                let far = distance.map_or(1e30, |row| results.rows[row][lane]);
                out.dir.set(i, dir);
                out.dist[i] = if far >= 1e30 || far <= 0.0 { f32::INFINITY } else { far };
                out.radiance.set(i, light);
                let pdf = density.map_or(0.0, |row| results.rows[row][lane]);
                out.pdf[i] = if pdf.is_finite() { pdf.max(0.0) } else { 0.0 };
            }
        }
    }
}
