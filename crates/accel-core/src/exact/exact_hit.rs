// SPDX-License-Identifier: GPL-3.0-or-later
//! Where a line meets a triangle, rounded once. Space: any. Cost: some ten microseconds.
//! Tests: `tests::as_by_hand`, `triangle::precise::tests`.

use super::dyadic::Dyadic;

/// The line's parameter, and weights of the second and the third corner; for a line that misses the triangle
/// those of a point on its edge: negative weights become zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ExactHit {
    pub(crate) t: f64,
    pub(crate) u: f64,
    pub(crate) v: f64,
}

impl ExactHit {
    /// Of the line through `org` towards `dir`, whose last component is not 0. `None` in the triangle's plane.
    pub(crate) fn of(corners: &[[f32; 3]; 3], org: &[f32; 3], dir: &[f32; 3]) -> Option<Self> {
        let exact = |x: f32| Dyadic::new(f64::from(x));
        let [dx, dy, dz] = dir.map(exact);
        let from = corners.map(|corner| [0, 1, 2].map(|k| exact(corner[k]).minus(&exact(org[k]))));
        let minor = |a: &Dyadic, b: &Dyadic, c: &Dyadic, d: &Dyadic| a.times(d).minus(&b.times(c));
        let along = from.each_ref().map(|[x, y, z]| [minor(x, &dx, z, &dz), minor(y, &dy, z, &dz)]);
        let weight = |b: usize, c: usize| minor(&along[c][0], &along[c][1], &along[b][0], &along[b][1]);
        let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
        let zero = Dyadic::new(0.0);
        let sum = |all: &[Dyadic; 3]| all.iter().fold(zero.clone(), |sum, w| sum.plus(w));
        let side = sum(&weights).sign();
        if side == 0 {
            return None;
        }
        let weights = weights.map(|w| if w.sign() == side { w } else { zero.clone() });
        let whole = sum(&weights);
        let depth = weights.iter().zip(&from).fold(zero, |depth, (w, [.., z])| depth.plus(&w.times(z)));
        let t = depth.over(&whole.times(&dz));
        Some(Self { t, u: weights[1].over(&whole), v: weights[2].over(&whole) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_by_hand() {
        let corners = [[0.0, 0.0, 4.0], [4.0, 0.0, 8.0], [0.0, 4.0, 4.0]];
        let met = ExactHit::of(&corners, &[1.0, 2.0, 0.0], &[0.0, 0.0, 2.0]);
        assert_eq!(met, Some(ExactHit { t: 2.5, u: 0.25, v: 0.5 }), "inside");
        let beside = ExactHit::of(&corners, &[-1.0, 2.0, 0.0], &[0.0, 0.0, 2.0]);
        assert_eq!(beside, Some(ExactHit { t: 2.0, u: 0.0, v: 0.4 }), "on the edge");
        let edge_on = ExactHit::of(&corners, &[0.0, 1.0, 4.0], &[1.0, 0.0, 1.0]);
        assert_eq!(edge_on, None, "in the plane");
        let far = ExactHit::of(&corners, &[1.0, 2.0, -1e20], &[0.0, 0.0, 1.0]).map(|met| met.t);
        assert_eq!(far, Some(1e20f32.into()), "what is lost beside it is lost in rounding");
    }
}
