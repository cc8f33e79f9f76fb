// SPDX-License-Identifier: GPL-3.0-or-later
//! The map from doubles to the floats of nodes: a centre and a power of two. Tests: `tests::boxes_hold_what_they_held`.

use gnurt_accel_core::Aabb;

/// Coordinates of nodes are `(x - center) * scale`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) center: [f64; 3],
    pub(super) scale: f64,
    /// Of coordinates of nodes: 1 over the scale.
    pub(super) unit: f64,
    /// Half the diagonal of the box around all.
    pub(super) radius: f64,
    /// The greatest coordinate of the centre.
    pub(super) away: f64,
}

/// A box: least and greatest coordinates.
pub(super) type Box64 = [[f64; 3]; 2];

impl Grid {
    /// For what is in a box; an empty one, from +inf to -inf, has any.
    pub(super) fn around([min, max]: &Box64) -> Self {
        let center = [0, 1, 2].map(|k| 0.5 * min[k] + 0.5 * max[k]);
        let sides = [0, 1, 2].map(|k| 0.5 * max[k] - 0.5 * min[k]);
        let radius = sides.iter().map(|side| side * side).sum::<f64>().sqrt();
        let (center, scale, radius) = if radius.is_finite() && radius > 0.0 {
            let exponent = radius.log2().ceil().clamp(-1000.0, 1000.0) as i32;
            (center, 2f64.powi(-exponent), radius)
        } else {
            (center.map(|x| if x.is_finite() { x } else { 0.0 }), 1.0, 0.0)
        };
        let away = center.into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        Self { center, scale, unit: 1.0 / scale, radius, away }
    }

    /// A point, rounded.
    #[inline(always)]
    pub(super) fn local(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (point[k] - self.center[k]) * self.scale)
    }

    /// A box, rounded outwards.
    pub(super) fn outwards(&self, [min, max]: &Box64) -> Aabb {
        let (min, max) = (self.local(*min), self.local(*max));
        // One step for this rounding, and one for that of the difference.
        Aabb {
            min: min.map(|x| (x as f32).next_down().next_down()),
            max: max.map(|x| (x as f32).next_up().next_up()),
        }
    }

    /// The parameter from which on a line is followed: 0, or shortly before it comes to the box from afar, so that nothing is lost
    /// to the distance.
    #[inline(always)]
    pub(super) fn start(&self, org: &[f64; 3], dir: &[f64; 3]) -> f64 {
        let to = [0, 1, 2].map(|k| self.center[k] - org[k]);
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        if dot(&to, &to) <= 16.0 * self.radius * self.radius {
            return 0.0;
        }
        let (along, square) = (dot(&to, dir), dot(dir, dir));
        let (middle, length) = (along / square, square.sqrt());
        let start = middle - 2.0 * self.radius / length;
        if start * length > 2.0 * self.radius && start.is_finite() { start } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_testkit::Random;

    #[test]
    fn boxes_hold_what_they_held() {
        let mut random = Random::new(5);
        for offset in [0.0, 1e8, -1e15] {
            let mut point = || [0, 1, 2].map(|_| offset + f64::from(random.unit()) * 3.0);
            let points: Vec<[f64; 3]> = (0..100).map(|_| point()).collect();
            let bound = |pick: fn(f64, f64) -> f64, from| {
                points.iter().fold([from; 3], |all, at| [0, 1, 2].map(|k| pick(all[k], at[k])))
            };
            let all = [bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY)];
            let grid = Grid::around(&all);
            for at in points {
                let Aabb { min, max } = grid.outwards(&[at, at]);
                for k in 0..3 {
                    // Exactly: the difference is a double or rounded by less than a step of floats.
                    let exact = (at[k] - grid.center[k]) * grid.scale;
                    assert!(f64::from(min[k]) < exact && exact < f64::from(max[k]), "{at:?} at {offset}");
                    assert!(exact.abs() <= 1.001, "{exact} is near 1");
                }
            }
        }
    }
}
