// SPDX-License-Identifier: GPL-3.0-or-later
//! A line in double precision, prepared for blocks and for the nodes of a grid.
//! Source: the shear of [WBW13]. Tests: `tests/doubles.rs` of `gnurt-accel`.

use gnurt_accel_core::Ray;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::slab::SLACK;
use gnurt_accel_core::triangle::axes_from;
use gnurt_simd::{Simd, f64x8, prelude::*};

use super::grid::Grid;

/// `org + t * dir` for `t` from `near` on; each coordinate of both may be off by so much, as inside of an instance.
#[derive(Clone, Copy, Debug)]
pub struct DoubleLine {
    /// Origin.
    pub org: [f64; 3],
    /// Direction, of any length but zero.
    pub dir: [f64; 3],
    /// Nothing before counts; not negative.
    pub near: f64,
    /// The error of the origin.
    pub off_org: f64,
    /// The error of the direction.
    pub off_dir: f64,
}

/// The line for one tree: it starts at `start`, and moves by 1 along its longest axis for each unit of its parameters.
#[derive(Clone, Copy)]
pub(super) struct Prepared {
    axes: [usize; 3],
    /// Along these axes.
    org: [f64; 3],
    shear: [f64; 2],
    /// 1 or -1: along the longest axis.
    sign: f64,
    /// The error of the origin.
    off: f64,
    /// The error of an edge for the greatest of its corners: see `block.rs`.
    error: f64,
    start: f64,
    per_unit: f64,
    scale: f64,
    slack: f64,
    near: f64,
    pub(super) for_nodes: Ray,
    /// The greatest coordinate for which nodes allow.
    pub(super) greatest: f32,
}

#[inline(always)]
fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn largest(v: [f64; 3]) -> f64 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

impl Prepared {
    /// For a tree whose greatest coordinate is `greatest`. `None` where the direction is lost to its error.
    #[inline(always)]
    pub(super) fn new(line: &DoubleLine, grid: &Grid, greatest: f32) -> Option<Self> {
        let per_unit = largest(line.dir);
        if !(per_unit > 0.0 && per_unit.is_finite() && line.org.iter().all(|x| x.is_finite())) {
            return None;
        }
        let start = grid.start(&line.org, &line.dir);
        let (mut org, mut rounding) = (line.org, 0.0);
        if start != 0.0 {
            org = [0, 1, 2].map(|k| line.org[k] + start * line.dir[k]);
            rounding = start * per_unit + largest(line.org) + largest(org);
        }
        let drift = if line.off_dir == 0.0 { 0.0 } else { start * line.off_dir };
        let off = line.off_org + drift + f64::EPSILON * rounding;
        let last = DirectionClass::of_doubles(&line.dir).longest_axis;
        let per = 1.0 / per_unit;
        let off_shear = 2.0 * (line.off_dir * per).min(1.0) + 2.0 * f64::EPSILON;
        // The inverse of the least numbers is infinite.
        let mut dir = line.dir.map(|x| if per < f64::INFINITY { x * per } else { x / per_unit });
        dir[last] = 1f64.copysign(line.dir[last]);
        let from = minus(org, grid.center);
        // The farthest corner, rounding included.
        let far = 1.01 * (largest(from) + grid.radius) + 4.0 * f64::EPSILON * (largest(org) + grid.away);
        let local = from.map(|x| x * grid.scale);
        let away = largest(local);
        let greatest64 = f64::from(greatest);
        // The line's difference from that of floats, as coordinates for which nodes allow.
        let off_local = off * grid.scale + off_shear * (away + 2.0 * greatest64);
        let slack = 1e-6 * (2.0 * greatest64 + away) + 4.0 * off_local;
        let lost = (off_local / f64::from(SLACK)).min(1e30) as f32;
        let units = (line.near - start) * per_unit;
        let lower = (units * grid.scale - slack - 1e-6 * (units * grid.scale).abs()).max(0.0);
        // Beyond the reach of floats all lines are as far.
        let float = |x: f64| x.clamp(-1e30, 1e30) as f32;
        let for_nodes = Ray { t_near: float(lower), ..Ray::new(local.map(float), dir.map(float)) };
        let axes @ [x, y, z] = axes_from(last);
        Some(Self {
            axes,
            org: [org[x], org[y], org[z]],
            shear: [dir[x] * dir[z], dir[y] * dir[z]],
            sign: dir[z],
            off,
            // Sheared corners are at most twice as far as corners.
            error: 32.0 * f64::EPSILON * far + 4.0 * (2.0 * off + off_shear * far),
            start,
            per_unit,
            scale: grid.scale,
            slack,
            near: units - 1e-13 * units.abs() - slack * grid.unit,
            for_nodes,
            greatest: 2.0 * greatest + lost,
        })
    }

    /// A parameter of the line as a depth along the longest axis, or a little more.
    #[inline(always)]
    pub(super) fn depth(&self, t: f64) -> f64 {
        if t == f64::NEG_INFINITY {
            return t;
        }
        let units = (t - self.start) * self.per_unit;
        units + 1e-13 * (units.abs() + self.start * self.per_unit) + self.off * 16.0
    }

    /// A parameter for nodes, or a little more.
    #[inline(always)]
    pub(super) fn reach(&self, t: f64) -> f32 {
        if t == f64::NEG_INFINITY {
            return f32::NEG_INFINITY;
        }
        let at = (t - self.start) * self.per_unit * self.scale;
        (at + 1e-6 * at.abs() + self.slack) as f32
    }
}

/// The same in lanes.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd> {
    pub(super) axes: [usize; 3],
    pub(super) org: [f64x8<S>; 3],
    pub(super) shear: [f64x8<S>; 2],
    pub(super) sign: f64x8<S>,
    pub(super) error: f64x8<S>,
    pub(super) near: f64x8<S>,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, line: &Prepared) -> Self {
        let ([x, y, z], [u, v]) = (line.org, line.shear);
        Self {
            axes: line.axes,
            org: [f64x8::splat(simd, x), f64x8::splat(simd, y), f64x8::splat(simd, z)],
            shear: [f64x8::splat(simd, u), f64x8::splat(simd, v)],
            sign: f64x8::splat(simd, line.sign),
            error: f64x8::splat(simd, line.error),
            near: f64x8::splat(simd, line.near),
        }
    }
}

/// A line as it was given, in lanes.
#[derive(Clone, Copy)]
pub(super) struct Given<S: Simd> {
    pub(super) org: [f64x8<S>; 3],
    pub(super) dir: [f64x8<S>; 3],
}

impl<S: Simd> Given<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, [x, y, z]: [f64; 3], [u, v, w]: [f64; 3]) -> Self {
        Self {
            org: [f64x8::splat(simd, x), f64x8::splat(simd, y), f64x8::splat(simd, z)],
            dir: [f64x8::splat(simd, u), f64x8::splat(simd, v), f64x8::splat(simd, w)],
        }
    }
}
