// SPDX-License-Identifier: GPL-3.0-or-later
//! Points of surfaces as input of shaders. The globals have OSL's meaning. Space: world; normals face the
//! ray.
//! Tests: `tests`, `tests/scripts/floor.rs`.

use gnurt_shading::real::{Real, Vector};
use gnurt_shading::{RayKind, SurfaceBatch};
use gnurt_simd::{Level, dispatch_wide, f32x16, prelude::*};
use gnurt_sl::exec::{LANES, Plan, Points, Row};
use gnurt_sl::ir::SymbolKind;

/// Costly inputs of a shader; those that it does not need are undefined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Needs {
    /// The derivatives of positions from pixel to pixel.
    pub(crate) derivatives: bool,
    /// The derivatives of positions by texture coordinates.
    pub(crate) frame: bool,
    /// Areas of meshes, which are this attribute.
    pub(crate) area: Option<usize>,
    /// Times, which are this one.
    pub(crate) time: Option<usize>,
    /// The length of the open shutter, which is this one.
    pub(crate) shutter: Option<usize>,
    /// The points' velocities, which are this one.
    pub(crate) velocity: Option<usize>,
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

/// The purpose of an evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Caller {
    /// The rays that met it.
    Rays,
    /// Shadow rays.
    Shadow,
    /// None: vertices are displaced.
    Vertices,
}

/// Kinds of rays by their names; each is a bit.
pub(crate) const RAYS: [&str; 8] =
    ["camera", "shadow", "reflection", "refraction", "diffuse", "glossy", "subsurface", "displacement"];
/// Rays of cameras.
pub(crate) const CAMERA: u32 = 1;
const SHADOW: u32 = 2;
/// Vertices that are displaced.
const DISPLACEMENT: u32 = 128;
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

/// The points from `first` on, sixteen or fewer. `out` is new, or was written for the same needs.
pub(crate) fn points(hits: &SurfaceBatch, first: usize, caller: Caller, needs: Needs, out: &mut Points) {
    points_at(Level::best(), hits, first, caller, needs, out);
}

fn points_at(
    level: Level,
    hits: &SurfaceBatch,
    first: usize,
    caller: Caller,
    needs: Needs,
    out: &mut Points,
) {
    let count = LANES.min(hits.len() - first);
    let facing = hits.facing_rows(first);
    let all = (1_u32 << count) - 1;
    out.count = count;
    (out.n, out.ng) = (facing.ns, facing.ng);
    (out.backfacing, out.flipped) = ((facing.back & all) as u16, 0);
    // Component k of an attribute, or what stands for it.
    let attribute = |row: &mut Row, number: Option<usize>, (k, missing): (usize, f32)| {
        *row = [missing; LANES];
        let values = number.and_then(|number| hits.attributes.get(number)?.get(k * hits.len() + first..));
        for (to, &value) in row[..count].iter_mut().zip(values.unwrap_or_default()) {
            *to = if value.is_nan() { missing } else { value };
        }
    };
    attribute(&mut out.surface_area, needs.area, (0, 1.0));
    attribute(&mut out.time, needs.time, (0, 0.0));
    attribute(&mut out.dtime, needs.shutter, (0, 0.0));
    out.dpdtime.iter_mut().enumerate().for_each(|(k, row)| attribute(row, needs.velocity, (k, 0.0)));
    let copy = |row: &mut Row, from: &[f32]| match from[first..].first_chunk() {
        Some(all) => *row = *all,
        None => row[..count].copy_from_slice(&from[first..first + count]),
    };
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
        out.ray_kinds[lane] = match caller {
            Caller::Shadow => SHADOW,
            Caller::Vertices => DISPLACEMENT,
            Caller::Rays => kinds(hits.ray_kind(first + lane)),
        };
    }
    if needs.derivatives || needs.frame {
        dispatch_wide!(
            level,
            simd => changes(f32x16::splat(simd, 0.0), hits, (first, 0), needs, out),
            else (0..count).for_each(|lane| changes(0.0_f32, hits, (first, lane), needs, out))
        );
        out.flipped &= all as u16;
    }
}

/// Two directions square to unit ones and to each other: [`Basis::around`], for as many points.
#[inline(always)]
fn around<R: Real>(n: Vector<R>) -> [Vector<R>; 2] {
    let one = n.x.all(1.0);
    let sign = n.z.each(
        #[inline(always)]
        |i| 1.0_f32.copysign(n.z.lane(i)),
    );
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    [
        Vector::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vector::new(b, sign + n.y * n.y * a, -n.y),
    ]
}

/// [`uv_step`](gnurt_shading::batch::uv_step), for as many points.
#[inline(always)]
fn uv_steps<R: Real>([du, dv]: [Vector<R>; 2], step: Vector<R>) -> [R; 2] {
    let (uu, uv, vv) = (du.dot(du), du.dot(dv), dv.dot(dv));
    let area = uu * vv - uv * uv;
    let (a, b) = (du.dot(step), dv.dot(step));
    let (u, v) = ((a * vv - b * uv) / area, (b * uu - a * uv) / area);
    let (known, zero) = (u.is_number() & v.is_number(), u.all(0.0));
    [R::pick(known, u, zero), R::pick(known, v, zero)]
}

#[inline(always)]
fn store<R: Real>(row: &mut Row, lane: usize, x: R) {
    for (i, to) in row[lane..lane + R::LANES].iter_mut().enumerate() {
        *to = x.lane(i);
    }
}

#[inline(always)]
fn store_vector<R: Real>([x, y, z]: [&mut Row; 3], lane: usize, v: Vector<R>) {
    store(x, lane, v.x);
    store(y, lane, v.y);
    store(z, lane, v.z);
}

/// Derivatives of the points' positions, from pixel to pixel and with texture coordinates, for the lanes of
/// `like`, from `lane` on.
#[inline(always)]
fn changes<R: Real>(
    like: R,
    hits: &SurfaceBatch,
    (first, lane): (usize, usize),
    needs: Needs,
    out: &mut Points,
) {
    let at = first + lane;
    let zero = like.all(0.0);
    let none = Vector::grey(zero);
    let [n, ng] = [&out.n, &out.ng].map(
        #[inline(always)]
        |[x, y, z]| Vector::load(like, [x, y, z], lane),
    );
    let [dir, du, dv] = [&hits.ray_dir, &hits.dp_du, &hits.dp_dv].map(
        #[inline(always)]
        |v| Vector::load(like, [&v.x, &v.y, &v.z], at),
    );
    if needs.derivatives {
        // Across the ray, carried along it to the surface.
        let width = like.load(&hits.footprint, at);
        let is_wide = width.above(zero) & width.is_number();
        // Grazing rays would see as far as the horizon.
        let cos = dir.dot(ng).or_less(like.all(-1e-2));
        let across = around(dir);
        // The ray of the next pixel leaves this one by the cone's spread.
        let spread = like.load(&hits.cone_spread, at);
        let spread = R::pick(spread.is_number(), spread, zero);
        let [x, y, z] = &mut out.i;
        store_vector([&mut x.dx, &mut y.dx, &mut z.dx], lane, across[0] * spread);
        store_vector([&mut x.dy, &mut y.dy, &mut z.dy], lane, across[1] * spread);
        let [right, down] = across.map(
            #[inline(always)]
            |step| Vector::pick(is_wide, (step - dir * (step.dot(ng) / cos)) * width, none),
        );
        let [x, y, z] = &mut out.p;
        store_vector([&mut x.dx, &mut y.dx, &mut z.dx], lane, right);
        store_vector([&mut x.dy, &mut y.dy, &mut z.dy], lane, down);
        let ([ux, vx], [uy, vy]) = (uv_steps([du, dv], right), uv_steps([du, dv], down));
        store(&mut out.u.dx, lane, ux);
        store(&mut out.u.dy, lane, uy);
        store(&mut out.v.dx, lane, vx);
        store(&mut out.v.dy, lane, vy);
        // Pixels may have the other orientation.
        out.flipped |= (R::bits(zero.above(right.cross(down).dot(n))) << lane) as u16;
    }
    if needs.frame {
        // Where the mesh has no coordinates, any directions along the surface.
        let is_bare = du.is_zero() | dv.is_zero();
        let [tangent, bitangent] = around(n);
        let [x, y, z] = &mut out.dpdu;
        store_vector([x, y, z], lane, Vector::pick(is_bare, tangent, du));
        let [x, y, z] = &mut out.dpdv;
        store_vector([x, y, z], lane, Vector::pick(is_bare, bitangent, dv));
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnurt_shading::batch::{Vec3s, uv_step};
    use gnurt_shading::sampling::Basis;

    use super::*;

    /// Points that differ in all that counts; some lack width, coordinates, or both.
    fn hits() -> SurfaceBatch {
        let mut hits = SurfaceBatch::default();
        hits.resize(21, gnurt_shading::Detail::Full);
        let of = |i: usize, k: f32| {
            let x = i as f32 * k + 0.3;
            Vec3::new(x.sin(), (1.7 * x).cos(), (2.3 * x).sin() - 0.2)
        };
        let all = |k: f32, scale: f32| {
            let mut list = Vec3s::default();
            (0..21).for_each(|i| list.push(of(i, k).normalize() * scale));
            list
        };
        (hits.ray_dir, hits.ng, hits.ns) = (all(1.1, 1.0), all(2.9, 1.0), all(2.95, 1.0));
        (hits.dp_du, hits.dp_dv) = (all(0.7, 3.0), all(1.9, 0.5));
        hits.ray_dir.set(3, Vec3::new(0.6, 0.8, -0.0));
        hits.dp_du.set(5, Vec3::ZERO);
        hits.dp_dv.set(6, hits.dp_du.get(6));
        // A ray that grazes.
        hits.ng.set(9, Vec3::Y);
        hits.ray_dir.set(9, Vec3::new(1.0, -1e-3, 0.0).normalize());
        hits.cone_spread = (0..21).map(|i| [0.0, 0.02, f32::NAN, 0.3][i % 4]).collect();
        hits.footprint = (0..21).map(|i| [0.0, 0.01, f32::NAN, 0.3, 2.0, f32::INFINITY][i % 6]).collect();
        hits
    }

    #[test]
    fn rows_are_what_points_are_at_every_level() {
        let (mut hits, needs) = (hits(), Needs::default().with_all());
        for without_coordinates in [false, true] {
            if without_coordinates {
                (hits.dp_du, hits.dp_dv) = (Vec3s::default(), Vec3s::default());
            }
            for level in Level::available() {
                for first in [0, 16] {
                    let mut found = Points::default();
                    points_at(level, &hits, first, Caller::Rays, needs, &mut found);
                    for lane in 0..found.count {
                        let (i, point) = (first + lane, found.point(lane));
                        let how = format!("{level}, point {i}");
                        let width = hits.footprint[i];
                        let (dir, ng, ns) = (hits.ray_dir.get(i), hits.facing_ng(i), hits.facing_ns(i));
                        let cos = dir.dot(ng).min(-1e-2);
                        let across = Basis::around(dir);
                        let step = |v: Vec3| match width > 0.0 && width.is_finite() {
                            true => (v - dir * (v.dot(ng) / cos)) * width,
                            false => Vec3::ZERO,
                        };
                        let (dx, dy) = (step(across.tangent), step(across.bitangent));
                        assert_eq!((point.p.dx, point.p.dy), (dx.to_array(), dy.to_array()), "{how}");
                        let spread = if hits.cone_spread[i].is_nan() { 0.0 } else { hits.cone_spread[i] };
                        let turned = [across.tangent, across.bitangent].map(|v| (v * spread).to_array());
                        assert_eq!([point.i.dx, point.i.dy], turned, "{how}");
                        let mut own = [Vec3::ZERO; 2];
                        if !without_coordinates {
                            own = [hits.dp_du.get(i), hits.dp_dv.get(i)];
                        }
                        let ([ux, vx], [uy, vy]) = (uv_step(own, dx), uv_step(own, dy));
                        let changes = [point.u.dx, point.v.dx, point.u.dy, point.v.dy];
                        assert_eq!(changes, [ux, vx, uy, vy], "{how}");
                        assert_eq!(point.flipped, dx.cross(dy).dot(ns) < 0.0, "{how}");
                        if own.contains(&Vec3::ZERO) {
                            let frame = Basis::around(ns);
                            own = [frame.tangent, frame.bitangent];
                        }
                        assert_eq!([point.dpdu, point.dpdv], own.map(|v| v.to_array()), "{how}");
                    }
                }
            }
        }
    }
}
