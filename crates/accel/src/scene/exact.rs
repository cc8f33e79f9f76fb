// SPDX-License-Identifier: GPL-3.0-or-later
//! An affine map in double precision, and its inverse. Tests: `instance::tests::carries_rays`, `tests/far_away.rs`.

use gnurt_accel_core::affine::inverse;

use crate::Ray;

/// A map into the world, and the linear part of its inverse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exact {
    /// Rows of the linear part of the map into the object.
    pub(super) rows: [[f64; 3]; 3],
    /// Images of the axes, then of the origin.
    pub(super) columns: [[f64; 3]; 4],
}

impl Exact {
    /// The inverse, where there is one.
    #[inline]
    pub(super) fn new(columns: &[[f64; 3]; 4]) -> Option<Self> {
        Some(Self { rows: inverse(columns)?, columns: *columns })
    }

    /// By how much of its distance a ray is off that floats carry over and back, in units of what they round: a turn and
    /// scales along the object's axes are 3 at most, sheared axes more. For any origin and direction: the sum over the ways
    /// from one axis of the world to another, of the magnitudes on them.
    pub(super) fn spread(&self) -> f64 {
        let [a, b, c, _] = self.columns;
        let sum = |row: [f64; 3]| row[0].abs() + row[1].abs() + row[2].abs();
        let over = [sum(self.rows[0]), sum(self.rows[1]), sum(self.rows[2])];
        let along = |k: usize| a[k].abs() * over[0] + b[k].abs() * over[1] + c[k].abs() * over[2];
        along(0).max(along(1)).max(along(2))
    }

    /// The data for rays.
    pub(super) fn stand(&self) -> Stand {
        Stand { rows: self.rows, translation: self.columns[3] }
    }
}

/// A transform as rays need it: rows of the linear part of its inverse, and the object's origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand {
    pub(super) rows: [[f64; 3]; 3],
    pub(super) translation: [f64; 3],
}

impl Stand {
    /// A point of the world in the object's space.
    pub(super) fn point(&self, world: [f64; 3]) -> [f64; 3] {
        let from = [0, 1, 2].map(|k| world[k] - self.translation[k]);
        self.rows.map(|row| row[0] * from[0] + row[1] * from[1] + row[2] * from[2])
    }

    /// A ray whose origin is known in double precision, and that origin in the object's space.
    pub(super) fn ray(&self, ray: &Ray, origin: &[f64; 3]) -> (Ray, [f64; 3]) {
        let inside = self.point(*origin);
        let dir = ray.dir.map(f64::from);
        let dir = self.rows.map(|row| (row[0] * dir[0] + row[1] * dir[1] + row[2] * dir[2]) as f32);
        (Ray { org: inside.map(|x| x as f32), dir, ..*ray }, inside)
    }
}
