// SPDX-License-Identifier: GPL-3.0-or-later
//! The shader of all surfaces whose materials have equal traits: it finds the material of each point in the table.
//! Rays of the camera see surfaces without their holes; `pixel.rs` adds these, with the layers behind them.
//! Space: world. Tests: tests/materials.rs.

use std::sync::Arc;

use glam::Vec3;
use gnurt::shading::bsdf::{ClosureBatch, Lobes, Medium};
use gnurt::shading::{SurfaceBatch, SurfaceShader, Tracer, Vec3s};

use crate::attribute::Point;
use crate::material::class;
use crate::table::{At, Table};

/// All surfaces of some traits.
pub(crate) struct Surfaces {
    pub(crate) table: Arc<Table>,
    /// Bits of [`class`].
    pub(crate) class: u32,
}

impl Surfaces {
    fn at(&self, hits: &SurfaceBatch, i: usize) -> Option<At<'_>> {
        let normal = hits.ns.get(i);
        self.table.at(hits.inst_id[i], hits.prim_id[i], [hits.u[i], hits.v[i]], hits.p.get(i), normal)
    }

    fn has(&self, bit: u32) -> bool {
        self.class & bit != 0
    }
}

/// The shading normal that a material's map makes of a normal, both unit and on the same side.
pub(crate) fn mapped(at: &At, ns: Vec3) -> Vec3 {
    let Some(map) = at.surface.material.normal_map() else { return ns };
    let [x, y, z, _] = map.value(at).map(|x| 2.0 * x - 1.0);
    let frame = match at.tangent() {
        Some((tangent, side)) => Some([tangent, ns.cross(tangent) * side]),
        None => at.axes(map.input),
    };
    let Some([u, v]) = frame else { return ns };
    let tangent = (u - ns * ns.dot(u)).normalize_or_zero();
    let across = ns.cross(tangent);
    let bitangent = if across.dot(v) < 0.0 { -across } else { across };
    let bent = (tangent * x + bitangent * y + ns * z).try_normalize();
    bent.filter(|bent| bent.dot(ns) > 0.0).unwrap_or(ns)
}

impl SurfaceShader for Surfaces {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        let mut lobes = Lobes::default();
        for i in 0..hits.len() {
            let Some(at) = self.at(hits, i) else { continue };
            let (material, front) = (&at.surface.material, hits.front(i));
            let absorption = material.lobes(&at, front, &mut lobes);
            let mut normal = hits.facing_ns(i);
            if material.normal_map().is_some() {
                // The map lies on the front.
                let ns = hits.ns.get(i);
                let bent = mapped(&at, ns);
                normal = if ns.dot(hits.facing_ng(i)) < 0.0 { -bent } else { bent };
                normal = hits.point(i).bent_normal(normal, -hits.ray_dir.get(i));
            }
            out.set(i, normal, lobes.as_slice());
            if self.has(class::EMITS) {
                out.emit(i, material.emission(&at));
            }
            if self.has(class::FILLED) {
                out.fill(i, Medium::behind(absorption, front));
            }
            if self.has(class::HOLES) && hits.depth > 0 {
                out.fade(i, material.coverage(&at));
            }
        }
    }

    fn emits(&self) -> bool {
        self.has(class::EMITS)
    }

    fn gaps(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        for i in 0..hits.len() {
            let stopped = self.at(hits, i).map_or(1.0, |at| at.surface.material.coverage(&at));
            out.set(i, Vec3::splat(1.0 - stopped));
        }
    }

    fn transmit(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        if self.has(class::HOLES) {
            self.gaps(tracer, hits, out);
        }
    }

    fn is_opaque(&self) -> bool {
        !self.has(class::HOLES) && !self.has(class::GLASS)
    }

    fn is_solid(&self) -> bool {
        !self.has(class::HOLES)
    }

    fn has_medium(&self) -> bool {
        self.has(class::FILLED)
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        for i in 0..hits.len() {
            if let Some(at) = self.at(hits, i) {
                out.set(i, at.surface.material.base(&at));
            }
        }
    }

    fn describe(&self, hits: &SurfaceBatch, lane: usize) -> Vec<String> {
        let at = self.at(hits, lane);
        at.map(|at| format!("surface {}, primitive {}", at.surface.id, at.primitive())).into_iter().collect()
    }
}

/// All lamps.
pub(crate) struct AreaLights {
    pub(crate) table: Arc<Table>,
}

impl SurfaceShader for AreaLights {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for i in 0..hits.len() {
            if let Some(area_light) = self.table.area_light(hits.inst_id[i]) {
                out.emit(i, area_light.radiance(hits.ng.get(i), -hits.ray_dir.get(i)));
            }
        }
    }

    fn emits(&self) -> bool {
        true
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, Vec3::ONE));
    }
}
