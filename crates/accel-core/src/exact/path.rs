// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangles transformed to the space of the query, through all instances on the path: rounded, with a bound
//! of the error, and exactly. Spaces: corners come in that of their object and go out in that of the
//! question.
//! Tests: `tests/surfaces/crossings.rs`.

use super::number::{Number, V3, of};

/// The maps from an object out to the space of the query.
#[derive(Clone, Copy, Debug)]
pub struct InstancePath<'a> {
    /// Images of the axes, then of the origin, in the next space outwards.
    pub columns: &'a [[f64; 3]; 4],
    /// From there on.
    pub outer: Option<&'a InstancePath<'a>>,
}

/// The unit in the last place of 1, twice the rounding error.
pub(super) const UNIT: f64 = f64::EPSILON;

impl InstancePath<'_> {
    /// A point, and how far off any of its coordinates may be.
    pub fn carry(&self, p: [f64; 3], error: f64) -> ([f64; 3], f64) {
        let [x, y, z, o] = self.columns;
        let mut carried = [0.0; 3];
        let mut worst = 0.0f64;
        for k in 0..3 {
            carried[k] = x[k] * p[0] + y[k] * p[1] + z[k] * p[2] + o[k];
            let sizes = x[k].abs() * (p[0].abs() * 4.0 * UNIT + error)
                + y[k].abs() * (p[1].abs() * 4.0 * UNIT + error)
                + z[k].abs() * (p[2].abs() * 4.0 * UNIT + error);
            worst = worst.max(sizes + 2.0 * UNIT * o[k].abs());
        }
        match self.outer {
            None => (carried, worst),
            Some(outer) => outer.carry(carried, worst),
        }
    }

    fn carry_exactly<N: Number>(&self, p: V3<N>) -> Option<V3<N>> {
        let [x, y, z, o] = self.columns;
        let along = |k: usize| {
            let sum = N::new(x[k]).times(&p[0])?.plus(&N::new(y[k]).times(&p[1])?)?;
            sum.plus(&N::new(z[k]).times(&p[2])?)?.plus(&N::new(o[k]))
        };
        let carried = [along(0)?, along(1)?, along(2)?];
        match self.outer {
            None => Some(carried),
            Some(outer) => outer.carry_exactly(carried),
        }
    }
}

/// A triangle in the space of the query.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<'a> {
    /// The corners in the space of the object.
    pub corners: [[f64; 3]; 3],
    pub(super) path: Option<&'a InstancePath<'a>>,
    /// The corners, rounded.
    pub near: [[f64; 3]; 3],
    /// How far off any coordinate may be.
    pub error: f64,
}

impl<'a> Triangle<'a> {
    /// From corners in the space of an object at `path`, or in the space of the query.
    pub fn new(corners: &[[f32; 3]; 3], path: Option<&'a InstancePath<'a>>) -> Self {
        Self::of_doubles(corners.map(|corner| corner.map(f64::from)), path)
    }

    /// The same of corners in double precision.
    #[inline]
    pub fn of_doubles(corners: [[f64; 3]; 3], path: Option<&'a InstancePath<'a>>) -> Self {
        let (mut near, mut error) = (corners, 0.0f64);
        if let Some(path) = path {
            for (near, plain) in near.iter_mut().zip(corners) {
                let (carried, off) = path.carry(plain, 0.0);
                (*near, error) = (carried, error.max(off));
            }
        }
        Self { corners, path, near, error }
    }

    /// A corner exactly, where that is such a number.
    pub(super) fn corner<N: Number>(&self, i: usize) -> Option<V3<N>> {
        let plain = of(self.corners[i]);
        self.path.map_or(Some(plain.clone()), |path| path.carry_exactly(plain))
    }
}
