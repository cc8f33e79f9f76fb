// SPDX-License-Identifier: GPL-3.0-or-later
//! All primitives that touch a box. Source: separating axes, [Eri04] section 5.2.9, in double precision.
//! Space: that of the queried tree; through instances with rotations and distortions, triangles are
//! transformed to it.
//! Invariant: an excluded primitive surely misses the box: undecided ones are included. Tests:
//! `tests/surfaces/overlaps.rs`.

use crate::near::name_all;
use crate::target::Target;
use crate::{PrimitiveId, Query};
use gnurt_accel_core::Aabb;
use gnurt_accel_core::curve::{CurvePiece, Segment};
use gnurt_accel_core::exact::{InstancePath, Triangle};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::Region;

/// Slots and numbers of the primitives that touch the box, its sides included, some of them twice. A box with
/// a NaN or without a point touches nothing.
fn touching(target: Target, mask: u32, min: [f64; 3], max: [f64; 3], found: &mut Vec<(u32, u32)>) {
    found.clear();
    if !(0..3).all(|k| min[k] <= max[k]) {
        return;
    }
    // An infinite box is cut to the bounds of the tree.
    let bounds = target.around();
    if bounds.is_empty() {
        return;
    }
    let low = [0, 1, 2].map(|k| min[k].max(f64::from(bounds.min[k].next_down())));
    let high = [0, 1, 2].map(|k| max[k].min(f64::from(bounds.max[k].next_up())));
    if (0..3).any(|k| low[k] > high[k]) {
        return;
    }
    target.show(&Region::within(low, high), mask, &mut |surface| {
        let is_touched = match &surface.primitive {
            Primitive::Triangle(corners) => {
                triangle_touches(&Triangle::new(corners, surface.path), low, high)
            }
            Primitive::Sphere(center, radius) => match surface.path {
                None => sphere_touches(center.map(f64::from), f64::from(*radius), low, high),
                Some(_) => {
                    let side = |sign: f64| center.map(|x| f64::from(x) + sign * f64::from(*radius));
                    box_touches([side(-1.0), side(1.0)], surface.path, low, high)
                }
            },
            Primitive::Disc(center, radius, normal) => {
                disc_touches(*center, *radius, *normal, surface.path, low, high)
            }
            Primitive::Curve(curves, prim_id, part) => curves
                .segment(*prim_id)
                .is_some_and(|segment| curve_touches(&segment, *part, surface.path, low, high)),
            Primitive::User(user, prim_id) => {
                let bounds = user.bounds(*prim_id);
                box_touches([bounds.min, bounds.max].map(|side| side.map(f64::from)), surface.path, low, high)
            }
        };
        if is_touched {
            found.push((surface.slot, surface.number));
        }
    });
}

/// Whether a triangle and a box may have a point in common.
fn triangle_touches(triangle: &Triangle, min: [f64; 3], max: [f64; 3]) -> bool {
    let corners = triangle.near;
    let size = corners.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs()));
    let off = triangle.error + 4.0 * f64::EPSILON * size;
    // The part of the box that is beside the triangle is as good as all of it, and of the triangle's size.
    let [a, b, c] = corners;
    let low = [0, 1, 2].map(|k| min[k].max(a[k].min(b[k]).min(c[k]) - off));
    let high = [0, 1, 2].map(|k| max[k].min(a[k].max(b[k]).max(c[k]) + off));
    if (0..3).any(|k| low[k] > high[k]) {
        return false;
    }
    let half = [0, 1, 2].map(|k| 0.5 * (high[k] - low[k]));
    let from = corners.map(|corner| [0, 1, 2].map(|k| corner[k] - (low[k] + half[k])));
    let edge = |i: usize, j: usize| [0, 1, 2].map(|k| corners[j][k] - corners[i][k]);
    let edges = [edge(0, 1), edge(1, 2), edge(2, 0)];
    let largest = |v: &[f64; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
    let width = from.iter().map(largest).fold(largest(&half), f64::max);
    let is_separate = |axis: [f64; 3], off_axis: f64| {
        let along = |v: [f64; 3]| axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2];
        let [p, q, r] = from.map(along);
        let reach = along([0, 1, 2].map(|k| half[k] * axis[k].signum()));
        let slack = 6.0 * (off_axis * width + largest(&axis) * (2.0 * off + 4.0 * f64::EPSILON * width));
        p.min(q).min(r) > reach + slack || p.max(q).max(r) < -reach - slack
    };
    let off_edge = 2.0 * off;
    for edge in edges {
        let [x, y, z] = edge;
        if [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]].into_iter().any(|axis| is_separate(axis, off_edge)) {
            return false;
        }
    }
    let ([x, y, z], [u, v, w]) = (edges[0], edges[1]);
    let longest = largest(&edges[0]).max(largest(&edges[1]));
    let off_normal = 4.0 * off_edge * (longest + off_edge) + 4.0 * f64::EPSILON * longest * longest;
    !is_separate([y * w - z * v, z * u - x * w, x * v - y * u], off_normal)
}

/// Whether a sphere's surface and a box have a point in common, up to rounding.
fn sphere_touches(center: [f64; 3], radius: f64, min: [f64; 3], max: [f64; 3]) -> bool {
    let (mut nearest, mut farthest) = (0.0, 0.0);
    for k in 0..3 {
        let offset = (min[k] - center[k]).max(center[k] - max[k]).max(0.0);
        let across = (center[k] - min[k]).max(max[k] - center[k]);
        (nearest, farthest) = (nearest + offset * offset, farthest + across * across);
    }
    let square = radius * radius;
    nearest <= square * (1.0 + 1e-14) && farthest >= square * (1.0 - 1e-14)
}

/// Whether a disc and a box may have a point in common: a sphere's box where it faces rays.
fn disc_touches(
    center: [f32; 3],
    radius: f32,
    normal: Option<[f32; 3]>,
    path: Option<&InstancePath>,
    low: [f64; 3],
    high: [f64; 3],
) -> bool {
    let normal = normal.map_or([0.0; 3], |normal| normal.map(f64::from));
    let square = normal.iter().map(|x| x * x).sum::<f64>();
    let half = [0, 1, 2].map(|k: usize| {
        let share = if square > 0.0 { 1.0 - normal[k] * normal[k] / square } else { 1.0 };
        f64::from(radius) * share.max(0.0).sqrt() * (1.0 + 1e-14)
    });
    let side = |sign: f64| [0, 1, 2].map(|k: usize| (f64::from(center[k]) + sign * half[k]) as f32);
    let [min, max] = [side(-1.0).map(f32::next_down), side(1.0).map(f32::next_up)];
    box_touches([min, max].map(|side| side.map(f64::from)), path, low, high)
}

/// Whether a piece of a curve and a box may have a point in common, by the boxes of short parts of it.
fn curve_touches(
    segment: &Segment,
    part: [f64; 2],
    path: Option<&InstancePath>,
    low: [f64; 3],
    high: [f64; 3],
) -> bool {
    let mut touches = false;
    segment.pieces(part, 16, |CurvePiece { bounds: Aabb { min, max }, .. }| {
        touches |= box_touches([min, max].map(|side| side.map(f64::from)), path, low, high);
    });
    touches
}

/// Whether a box of an object, as large as it is where the object is placed, touches a box.
fn box_touches(sides: [[f64; 3]; 2], path: Option<&InstancePath>, min: [f64; 3], max: [f64; 3]) -> bool {
    let Some(path) = path else {
        return (0..3).all(|k| sides[0][k] <= max[k] && sides[1][k] >= min[k]);
    };
    let (mut low, mut high, mut worst) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0f64);
    for corner in 0..8usize {
        let (carried, off) = path.carry([0, 1, 2].map(|k| sides[corner >> k & 1][k]), 0.0);
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(carried[k]), high[k].max(carried[k]));
        }
        worst = worst.max(off);
    }
    (0..3).all(|k| low[k] - worst <= max[k] && high[k] + worst >= min[k])
}

impl Target<'_> {
    /// All primitives that touch a box.
    pub(crate) fn touching_box(
        self,
        query: &Query,
        min: [f64; 3],
        max: [f64; 3],
        ids: &mut Vec<PrimitiveId>,
    ) {
        let mut found = Vec::new();
        touching(self, query.mask, min, max, &mut found);
        name_all(self, &found, ids);
    }
}
