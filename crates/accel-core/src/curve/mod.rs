// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves with a width: hair, grass, wires. The bases, the three forms and their parameters are Embree's.
//! Space: object. All arithmetic is in double precision, without fused operations: every level and every structure gives the
//! same bits. Floats only skip pieces that a ray surely misses (`accel-bvh/src/curves.rs`).
//! Tests: `tests/curves.rs` of `gnurt-accel`.

mod cone;
mod cubic;
mod input;
mod near;
mod pieces;
mod ray;
mod ribbon;
mod rough;
mod segment;
mod starts;
mod tube;

pub use input::{CurveBasis, CurveForm, Curves, OwnedCurves};
pub use ray::{CurveHit, Offer, RayFrame};
pub use rough::{Passing, Rough, RoughRay};
pub use segment::{CurvePiece, Segment};
pub use starts::Starts;

type Vector = [f64; 3];

#[inline(always)]
fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + t * b`.
#[inline(always)]
fn along(a: Vector, t: f64, b: Vector) -> Vector {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}

#[inline(always)]
fn scaled(a: Vector, t: f64) -> Vector {
    [a[0] * t, a[1] * t, a[2] * t]
}

/// A point of a curve without its radius.
#[inline(always)]
fn place([x, y, z, _]: [f64; 4]) -> Vector {
    [x, y, z]
}
