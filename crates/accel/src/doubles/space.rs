// SPDX-License-Identifier: GPL-3.0-or-later
//! The map of an instance in double precision, and bounds of the loss on the way back. Tests: `tests::the_bound_holds`.

use gnurt_accel_bvh::DoubleLine;

const UNIT: f64 = f64::EPSILON;

/// An affine map that can be inverted, and its rounded inverse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Map {
    /// Images of the axes, then of the origin.
    pub(super) columns: [[f64; 3]; 4],
    /// Rows of the inverse of the linear part.
    back: [[f64; 3]; 3],
    /// The greatest sum of sizes of a row of the inverse.
    growth: f64,
}

/// A map that is not finite, or that flattens space.
pub(super) struct NotInvertible;

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn largest(v: [f64; 3]) -> f64 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

impl Map {
    pub(super) fn new(columns: &[[f64; 3]; 4]) -> Result<Self, NotInvertible> {
        let [x, y, z, _] = *columns;
        let volume = dot(x, cross(y, z));
        let back = [cross(y, z), cross(z, x), cross(x, y)].map(|row| row.map(|value| value / volume));
        let growth = back.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
        let is_sound = columns.iter().chain(&back).flatten().all(|x| x.is_finite());
        if !is_sound || volume == 0.0 {
            Err(NotInvertible)
        } else {
            Ok(Self { columns: *columns, back, growth })
        }
    }

    /// A point of the instance in the space around it.
    pub(super) fn outwards(&self, p: [f64; 3]) -> [f64; 3] {
        let [x, y, z, o] = self.columns;
        [0, 1, 2].map(|k| x[k] * p[0] + y[k] * p[1] + z[k] * p[2] + o[k])
    }

    /// The box around the image of a box.
    pub(super) fn around(&self, [min, max]: &[[f64; 3]; 2]) -> [[f64; 3]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        if min[0] > max[0] {
            return [low, high];
        }
        for corner in 0..8 {
            let at = self.outwards([0, 1, 2].map(|k| if corner >> k & 1 == 0 { min[k] } else { max[k] }));
            for k in 0..3 {
                let sizes: f64 =
                    (0..3).map(|i| self.columns[i][k].abs() * min[i].abs().max(max[i].abs())).sum();
                let off = 4.0 * UNIT * (sizes + self.columns[3][k].abs());
                (low[k], high[k]) = (low[k].min(at[k] - off), high[k].max(at[k] + off));
            }
        }
        [low, high]
    }

    /// A vector in the instance, and a bound of the error of each component; `from` may be off by `off`.
    fn inwards(&self, from: [f64; 3], off: f64) -> ([f64; 3], f64) {
        let to = self.back.map(|row| dot(row, from));
        let [x, y, z, _] = self.columns;
        let (mut rest, mut worst) = ([0.0; 3], 0.0f64);
        for k in 0..3 {
            let sizes = x[k].abs() * to[0].abs() + y[k].abs() * to[1].abs() + z[k].abs() * to[2].abs();
            rest[k] = x[k] * to[0] + y[k] * to[1] + z[k] * to[2] - from[k];
            worst = worst.max(4.0 * UNIT * (sizes + from[k].abs()));
        }
        // The part that does not come back, carried inwards; the inverse itself is off by much less than a tenth.
        (to, 1.1 * self.growth * (largest(rest) + worst + off))
    }

    /// A point in the instance.
    pub(super) fn point_inwards(&self, point: [f64; 3], off: f64) -> ([f64; 3], f64) {
        let o = self.columns[3];
        let from = [0, 1, 2].map(|k| point[k] - o[k]);
        let rounding = UNIT * largest(from);
        self.inwards(from, off + rounding)
    }

    /// A line in the instance, with the same parameter.
    pub(super) fn line(&self, line: &DoubleLine) -> DoubleLine {
        let (org, off_org) = self.point_inwards(line.org, line.off_org);
        let (dir, off_dir) = self.inwards(line.dir, line.off_dir);
        DoubleLine { org, dir, near: line.near, off_org, off_dir }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    #[test]
    fn the_bound_holds() {
        let mut random = Random::new(8);
        for i in 0..2000 {
            let mut number = || f64::from(random.unit()) * 2.0 - 1.0;
            let mut columns = [[0.0; 3]; 4].map(|column| column.map(|_: f64| number()));
            columns[3] = columns[3].map(|x| x * 1e8);
            // Points whose images are exact: small integers times powers of two.
            columns.iter_mut().flatten().for_each(|x| *x = (*x * 64.0).round() / 64.0);
            let inside = [number(), number(), number()].map(|x| (x * 1024.0).round());
            let Ok(map) = Map::new(&columns) else { continue };
            let (found, off) = map.point_inwards(map.outwards(inside), 0.0);
            for k in 0..3 {
                assert!((found[k] - inside[k]).abs() <= off, "{i}: {found:?} for {inside:?} within {off}");
            }
        }
    }
}
