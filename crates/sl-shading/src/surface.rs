// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces: points of a batch to points of a group, closures to lobes.
//! Source: original; what the globals hold is OSL's. Space: world; normals face the ray, as OSL's renderers have them.
//! A shader that asks for rays or lights itself (`trace`, `illuminance`, `radiance`) is shaded as Whitted's renderer does: what it has
//! worked out counts as if the surface emitted it, its other closures are lit by all lights. Others' closures are what integrators scatter.
//! Proof: `tests/scripts.rs`.

use glam::Vec3;
use gnurt_shading::batch::uv_step;
use gnurt_shading::bsdf::{ClosureBatch, Scattering};
use gnurt_shading::materials::scattered_radiance;
use gnurt_shading::sampling::Basis;
use gnurt_shading::{AttributeRequest, RadianceShader, SurfaceBatch, SurfaceShader, Tracer, Vec3s};
use gnurt_sl::exec::{LANES, Point, Points, Results};
use gnurt_sl_lib::Dual;

use crate::parts::{self, At, Parts};
use crate::world::{CAMERA, Common, SHADOW, World};

/// Least share of light that a surface stops where it scatters some, so that what it scatters is not drawn too seldom.
const THERE: f32 = 1.0 / 16.0;

/// A surface.
pub(crate) struct ScriptSurface {
    pub(crate) common: Common,
    /// Whether it works out radiance by rays and lights of its own.
    pub(crate) is_radiance: bool,
    /// Whether light may go straight through, or through glass.
    pub(crate) is_see_through: bool,
    /// Whether light may go straight through.
    pub(crate) is_holey: bool,
    /// Whether it may give off light.
    pub(crate) is_lamp: bool,
}

/// How a place changes from pixel to pixel: across the ray, carried along it to the surface.
fn steps(hits: &SurfaceBatch, i: usize) -> [Vec3; 2] {
    let width = hits.footprint.get(i).copied().unwrap_or(0.0);
    if width <= 0.0 || !width.is_finite() {
        return [Vec3::ZERO; 2];
    }
    let (dir, ng) = (hits.ray_dir.get(i), hits.facing_ng(i));
    let across = Basis::around(dir);
    // Grazing rays would see all the way to the horizon.
    let cos = dir.dot(ng).min(-1e-2);
    [across.tangent, across.bitangent].map(|step| (step - dir * (step.dot(ng) / cos)) * width)
}

/// A point as shaders see it.
fn point(hits: &SurfaceBatch, i: usize, ray_kinds: u32) -> Point {
    let [dx, dy] = steps(hits, i);
    let (p, n) = (hits.p.get(i), hits.facing_ns(i));
    let own = if hits.dp_du.is_empty() { [Vec3::ZERO; 2] } else { [hits.dp_du.get(i), hits.dp_dv.get(i)] };
    let (ux, uy) = (uv_step(own, dx), uv_step(own, dy));
    // Where the mesh has no coordinates, any directions along the surface.
    let [dpdu, dpdv] = if own[0] == Vec3::ZERO || own[1] == Vec3::ZERO {
        let frame = Basis::around(n);
        [frame.tangent, frame.bitangent]
    } else {
        own
    };
    let dir = hits.ray_dir.get(i);
    Point {
        p: Dual::new(p.to_array(), dx.to_array(), dy.to_array()),
        i: Dual::from(dir.to_array()),
        n: n.to_array(),
        ng: hits.facing_ng(i).to_array(),
        u: Dual::new(hits.texcoord[0][i], ux[0], uy[0]),
        v: Dual::new(hits.texcoord[1][i], ux[1], uy[1]),
        dpdu: dpdu.to_array(),
        dpdv: dpdv.to_array(),
        surface_area: 1.0,
        backfacing: !hits.front(i),
        // Pixels may go around the other way.
        flipped: dx.cross(dy).dot(n) < 0.0,
        ray_kinds,
        index: i as i32,
        ..Point::default()
    }
}

fn kinds_of(hits: &SurfaceBatch) -> u32 {
    if hits.depth == 0 { CAMERA } else { 0 }
}

impl ScriptSurface {
    /// Runs it for all points; calls `with(lane, what it does)`.
    fn each(&self, world: &World, hits: &SurfaceBatch, ray_kinds: u32, mut with: impl FnMut(usize, Parts)) {
        let (mut points, mut results) = (Points::default(), Results::default());
        for first in (0..hits.len()).step_by(LANES) {
            points.count = LANES.min(hits.len() - first);
            for lane in 0..points.count {
                points.set(lane, &point(hits, first + lane, ray_kinds));
            }
            self.common.run(world, &points, &mut results);
            for lane in 0..points.count {
                let i = first + lane;
                let parts = parts::of(&results.closures, results.ci[lane], At::lane(hits, i));
                if parts.is_full {
                    self.common.faults.note(&format!(
                        "{}: a point has more than {} lobes; the last ones are left out",
                        self.common.name,
                        gnurt_shading::bsdf::MOST
                    ));
                }
                with(i, parts);
            }
        }
    }

    /// Writes what a point does to light.
    fn write(hits: &SurfaceBatch, i: usize, parts: &Parts, out: &mut ClosureBatch) {
        let through = parts.through.clamp(Vec3::ZERO, Vec3::ONE);
        let shared = through.min_element();
        let is_lit = !parts.lobes.as_slice().is_empty() || parts.emission != Vec3::ZERO;
        // What all channels let through is a hole; what is left of colours goes on as through a pane.
        let mut hole = if is_lit { shared.min(1.0 - THERE) } else { shared };
        if hole < 1e-3 {
            hole = 0.0;
        }
        let there = 1.0 - hole;
        if hole > 0.0 {
            out.cover(i, there);
        }
        if there <= 0.0 {
            return;
        }
        let mut lobes = parts.lobes;
        let tint = through - Vec3::splat(hole);
        if tint.max_element() > 1e-3 {
            lobes = lobes.plus(gnurt_shading::bsdf::Lobe::glass(1.0, Vec3::ZERO, tint.max(Vec3::ZERO), true));
        }
        let lobes = lobes.times(Vec3::splat(1.0 / there));
        if parts.emission != Vec3::ZERO && parts.emission.is_finite() {
            out.emit(i, parts.emission / there);
        }
        let wo = -hits.ray_dir.get(i);
        let (at, ns) = (hits.point(i), hits.facing_ns(i));
        // The heaviest lobe's normal is the point's; mirror images stay above.
        let heaviest =
            lobes.as_slice().iter().max_by(|a, b| a.weight.element_sum().total_cmp(&b.weight.element_sum()));
        let main = heaviest.map_or(Vec3::ZERO, |lobe| lobe.normal);
        let of = |n: Vec3| at.bent_normal(if n == Vec3::ZERO { ns } else { n }, wo);
        let mut own: Vec<gnurt_shading::bsdf::Lobe> = lobes.as_slice().to_vec();
        for lobe in &mut own {
            lobe.normal = if lobe.normal == main { Vec3::ZERO } else { of(lobe.normal) };
        }
        out.set(i, of(main), &own);
    }
}

impl SurfaceShader for ScriptSurface {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        let world = World::around(&self.common, hits, None);
        self.each(&world, hits, kinds_of(hits), |i, parts| Self::write(hits, i, &parts, out));
    }

    fn radiance(&self) -> Option<&dyn RadianceShader> {
        self.is_radiance.then_some(self)
    }

    fn emits(&self) -> bool {
        self.is_lamp
    }

    fn transmit(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let world = World::around(&self.common, hits, None);
        self.each(&world, hits, SHADOW, |i, parts| {
            // Glass counts as thin, so that windows let light in.
            let bsdf = gnurt_shading::bsdf::Bsdf::new(hits.facing_ns(i), parts.lobes);
            let [_, straight] = bsdf.delta_branches(-hits.ray_dir.get(i));
            let glass = straight.map_or(Vec3::ZERO, |branch| branch.weight);
            out.set(i, (parts.through + glass).clamp(Vec3::ZERO, Vec3::ONE));
        });
    }

    fn is_opaque(&self) -> bool {
        !self.is_see_through
    }

    fn gaps(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let world = World::around(&self.common, hits, None);
        self.each(&world, hits, SHADOW, |i, parts| {
            out.set(i, Vec3::splat(parts.through.clamp(Vec3::ZERO, Vec3::ONE).min_element()));
        });
    }

    fn is_solid(&self) -> bool {
        !self.is_holey
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        let world = World::around(&self.common, hits, None);
        self.each(&world, hits, kinds_of(hits), |i, parts| {
            let bsdf = gnurt_shading::bsdf::Bsdf::new(hits.facing_ns(i), parts.lobes);
            out.set(i, bsdf.albedo(-hits.ray_dir.get(i)).clamp(Vec3::ZERO, Vec3::ONE));
        });
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.common.requests
    }

    fn tell(&self, hits: &SurfaceBatch, lane: usize) -> Vec<String> {
        let world = World::around(&self.common, hits, None);
        self.common.program.tell(&world, &point(hits, lane, kinds_of(hits)))
    }
}

impl RadianceShader for ScriptSurface {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let mut closures = ClosureBatch::default();
        closures.reset(hits.len());
        {
            let world = World::around(&self.common, hits, Some(&mut *tracer));
            self.each(&world, hits, kinds_of(hits), |i, parts| {
                if parts.radiance.is_finite() {
                    out.add(i, parts.radiance);
                }
                // What goes straight through is followed by who asks.
                let parts = Parts { through: Vec3::ZERO, emission: Vec3::ZERO, ..parts };
                Self::write(hits, i, &parts, &mut closures);
            });
        }
        let points: Vec<Scattering> = (0..hits.len()).map(|i| closures.point(i)).collect();
        if points.iter().any(|point| !point.bsdf.is_black()) {
            scattered_radiance(tracer, hits, &points, out);
        }
    }
}
