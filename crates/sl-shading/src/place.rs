// SPDX-License-Identifier: GPL-3.0-or-later
//! Points of surfaces as shaders see them.
//! Source: original; what the globals hold is OSL's. Space: world; normals face the ray.
//! Proof: `tests/scripts/floor.rs`.

use glam::Vec3;
use gnurt_shading::batch::uv_step;
use gnurt_shading::sampling::Basis;
use gnurt_shading::{RayKind, SurfaceBatch};
use gnurt_sl::exec::{LANES, Plan, Points, Row};
use gnurt_sl::ir::SymbolKind;

/// What a shader reads that is not for nothing; what it does not need holds anything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Needs {
    /// How places change from pixel to pixel.
    pub(crate) derivatives: bool,
    /// How places change with texture coordinates.
    pub(crate) frame: bool,
    /// Areas of meshes, which are this attribute.
    pub(crate) area: Option<usize>,
}

impl Needs {
    /// The same and all that points have.
    pub(crate) fn with_all(self) -> Self {
        Self { derivatives: true, frame: true, ..self }
    }

    /// Of a group.
    pub(crate) fn of(plan: &Plan) -> Self {
        let mut needs = Self::default();
        for symbol in plan.layers.iter().flat_map(|layer| &layer.shader.symbols) {
            if symbol.kind == SymbolKind::Global {
                needs.derivatives |= symbol.derivs;
                needs.frame |= matches!(&*symbol.name, "dPdu" | "dPdv");
            }
        }
        needs
    }
}

/// Who asks what a point does to light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AskedBy {
    /// The rays that met it.
    Rays,
    /// Rays that ask for shadow.
    Shadow,
}

/// Kinds of rays by their names; each is a bit.
pub(crate) const RAYS: [&str; 8] =
    ["camera", "shadow", "reflection", "refraction", "diffuse", "glossy", "subsurface", "displacement"];
/// Rays of cameras.
pub(crate) const CAMERA: u32 = 1;
const SHADOW: u32 = 2;
/// Rays of surfaces that scatter to all sides.
pub(crate) const DIFFUSE: u32 = 16;

/// Bits of a ray's kind.
fn kinds(kind: RayKind) -> u32 {
    match kind {
        RayKind::Camera => CAMERA,
        RayKind::Reflection => 4,
        RayKind::Refraction => 8,
        RayKind::Diffuse => DIFFUSE,
        RayKind::Glossy => 32,
    }
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

fn put(rows: &mut [Row; 3], lane: usize, v: Vec3) {
    let [x, y, z] = rows;
    (x[lane], y[lane], z[lane]) = v.into();
}

/// The points from `first` on, sixteen or fewer. `out` is new, or was written for the same needs.
pub(crate) fn points(hits: &SurfaceBatch, first: usize, asked_by: AskedBy, needs: Needs, out: &mut Points) {
    let count = LANES.min(hits.len() - first);
    let facing = hits.facing_rows(first);
    let all = (1_u32 << count) - 1;
    out.count = count;
    (out.n, out.ng) = (facing.ns, facing.ng);
    (out.backfacing, out.flipped) = ((facing.back & all) as u16, 0);
    out.surface_area = [1.0; LANES];
    if let Some(areas) = needs.area.and_then(|number| hits.attributes.get(number)) {
        out.surface_area.iter_mut().zip(&areas[first..]).for_each(|(to, &area)| *to = area);
    }
    let copy = |row: &mut Row, from: &[f32]| row[..count].copy_from_slice(&from[first..first + count]);
    for (rows, from) in [(&mut out.p, &hits.p), (&mut out.i, &hits.ray_dir)] {
        let [x, y, z] = rows;
        [(x, &from.x), (y, &from.y), (z, &from.z)]
            .into_iter()
            .for_each(|(to, from)| copy(&mut to.value, from));
    }
    copy(&mut out.u.value, &hits.texcoord[0]);
    copy(&mut out.v.value, &hits.texcoord[1]);
    for lane in 0..count {
        out.index[lane] = (first + lane) as i32;
        out.ray_kinds[lane] = match asked_by {
            AskedBy::Shadow => SHADOW,
            AskedBy::Rays => kinds(hits.ray_kind(first + lane)),
        };
    }
    if needs.derivatives || needs.frame {
        (0..count).for_each(|lane| changes(hits, first, lane, needs, out));
    }
}

/// How the place of a point changes, from pixel to pixel and with texture coordinates.
fn changes(hits: &SurfaceBatch, first: usize, lane: usize, needs: Needs, out: &mut Points) {
    let i = first + lane;
    let n = hits.facing_ns(i);
    let own = if hits.dp_du.is_empty() { [Vec3::ZERO; 2] } else { [hits.dp_du.get(i), hits.dp_dv.get(i)] };
    if needs.derivatives {
        let [dx, dy] = steps(hits, i);
        for (k, row) in out.p.iter_mut().enumerate() {
            (row.dx[lane], row.dy[lane]) = (dx[k], dy[k]);
        }
        let (ux, uy) = (uv_step(own, dx), uv_step(own, dy));
        (out.u.dx[lane], out.u.dy[lane]) = (ux[0], uy[0]);
        (out.v.dx[lane], out.v.dy[lane]) = (ux[1], uy[1]);
        // Pixels may go around the other way.
        out.flipped |= u16::from(dx.cross(dy).dot(n) < 0.0) << lane;
    }
    // Where the mesh has no coordinates, any directions along the surface.
    let [dpdu, dpdv] = if own[0] == Vec3::ZERO || own[1] == Vec3::ZERO {
        let frame = Basis::around(n);
        [frame.tangent, frame.bitangent]
    } else {
        own
    };
    put(&mut out.dpdu, lane, dpdu);
    put(&mut out.dpdv, lane, dpdv);
}
