// SPDX-License-Identifier: GPL-3.0-or-later
//! Events along the paths of a sample, as readable lines. Space: world.

use glam::Vec3;
use gnurt_accel::{HitBatch, Ray, RayBatch};
use gnurt_shading::{LightBatch, SurfaceBatch, SurfaceShader, Vec3s};

/// Lines of values as they come by.
#[derive(Clone, Debug, Default)]
pub(crate) struct Log {
    depth: usize,
    pub(crate) lines: Vec<String>,
}

impl Log {
    /// Rays after this many bounces, and their hits.
    pub(crate) fn rays(&mut self, depth: u32, rays: &RayBatch, hits: &HitBatch) {
        self.depth = depth as usize;
        for i in 0..rays.len() {
            self.line("ray", ray(&rays.get(i)));
            let hit = hits.get(i).map_or_else(
                || "nothing".to_owned(),
                |hit| {
                    let ids =
                        format!("instance {} mesh {} triangle {}", hit.inst_id, hit.geom_id, hit.prim_id);
                    format!("t {} u {} v {}  {ids}", hit.t, hit.u, hit.v)
                },
            );
            self.line("hit", hit);
        }
    }

    /// The points of a call of a shader, and their closures.
    pub(crate) fn surface(&mut self, shader: &dyn SurfaceShader, points: &SurfaceBatch) {
        self.depth = points.depth as usize;
        for i in 0..points.len() {
            let side = if points.front(i) { "front" } else { "back" };
            self.line("point", format!("{}  error {}  {side}", triple(points.p.get(i)), points.error[i]));
            self.line(
                "normals",
                format!("{}  shading {}", triple(points.ng.get(i)), triple(points.ns.get(i))),
            );
            self.line("uv", format!("{} {}", points.texcoord[0][i], points.texcoord[1][i]));
            for line in shader.describe(points, i) {
                self.line("shader", line);
            }
        }
    }

    /// Light from one light at the points.
    pub(crate) fn light(&mut self, number: usize, light: &LightBatch) {
        for i in 0..light.dist.len() {
            let (dir, radiance) = (triple(light.dir.get(i)), triple(light.radiance.get(i)));
            self.line(
                "light",
                format!("{number}  towards {dir}  distance {}  arriving {radiance}", light.dist[i]),
            );
        }
    }

    /// Rays towards lights and their transmittance.
    pub(crate) fn shadows(&mut self, rays: &RayBatch, transmittance: &Vec3s) {
        for i in 0..rays.len() {
            self.line("shadow", format!("{}  through {}", ray(&rays.get(i)), triple(transmittance.get(i))));
        }
    }

    fn line(&mut self, what: &str, value: String) {
        self.lines.push(format!("{:indent$}{what:<9} {value}", "", indent = 2 * self.depth));
    }
}

fn ray(ray: &Ray) -> String {
    format!("from {}  along {}  t {} to {}", triple(ray.org), triple(ray.dir), ray.t_near, ray.t_far)
}

/// A vector as text.
pub(crate) fn triple(v: impl Into<Vec3>) -> String {
    let v = v.into();
    format!("({}, {}, {})", v.x, v.y, v.z)
}
