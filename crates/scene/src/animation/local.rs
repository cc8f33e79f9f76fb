// SPDX-License-Identifier: GPL-3.0-or-later
//! Transforms of nodes relative to their parents, and rotations.
//! Source: glTF 2.0 section 3.5.2; slerp after appendix C.4, on the shorter way. Double precision.
//! Quaternions are `x y z w`, of any length but zero. Tests: `tests`.

use serde::{Deserialize, Serialize};

use crate::affine::Affine;

/// Where a node is relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Local {
    /// As one matrix, which channels never change.
    Matrix(Affine),
    /// As three parts, which channels may replace.
    Parts(Trs),
}

impl Local {
    /// `parent_from_here`.
    #[must_use]
    pub fn affine(&self) -> Affine {
        match self {
            Self::Matrix(matrix) => *matrix,
            Self::Parts(parts) => parts.affine(),
        }
    }
}

/// Scale first, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trs {
    /// Moved by this.
    pub translation: [f64; 3],
    /// Rotation by this quaternion; `None` = no rotation.
    pub rotation: Option<[f64; 4]>,
    /// Scaled by this.
    pub scale: [f64; 3],
}

impl Default for Trs {
    fn default() -> Self {
        Self { translation: [0.0; 3], rotation: None, scale: [1.0; 3] }
    }
}

impl Trs {
    /// The three parts as one transform.
    #[must_use]
    pub fn affine(&self) -> Affine {
        let rotation = self.rotation.map_or(Affine::IDENTITY, from_quaternion);
        Affine::translation(self.translation) * rotation * Affine::scale(self.scale)
    }
}

/// The rotation of a quaternion of any length; identity for zero.
fn from_quaternion(q: [f64; 4]) -> Affine {
    let Some([x, y, z, w]) = unit(q) else { return Affine::IDENTITY };
    Affine {
        columns: [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
            [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
            [0.0; 3],
        ],
    }
}

/// A quaternion of length 1; `None` where it has no length.
pub(super) fn unit(q: [f64; 4]) -> Option<[f64; 4]> {
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 0.0 && length.is_finite()).then(|| q.map(|x| x / length))
}

/// From `a` to `b` with constant speed on the shorter arc; `t` in `[0, 1]`.
pub(super) fn slerp(a: [f64; 4], b: [f64; 4], t: f64) -> [f64; 4] {
    let (Some(a), Some(b)) = (unit(a), unit(b)) else { return if t < 1.0 { a } else { b } };
    let cosine: f64 = a.iter().zip(&b).map(|(x, y)| x * y).sum();
    // A quaternion and its negative are the same rotation; the one on the same side is nearer.
    let (cosine, b) = if cosine < 0.0 { (-cosine, b.map(|x| -x)) } else { (cosine, b) };
    let angle = cosine.min(1.0).acos();
    let sine = angle.sin();
    // If the two are the same to eight digits, linear interpolation suffices and avoids a division by zero.
    let (from, to) = match sine > 1e-8 {
        true => (((1.0 - t) * angle).sin() / sine, (t * angle).sin() / sine),
        false => (1.0 - t, t),
    };
    std::array::from_fn(|k| from * a[k] + to * b[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rotation around an axis.
    fn axis_angle(axis: [f64; 3], degrees: f64) -> [f64; 4] {
        let (s, c) = (degrees.to_radians() / 2.0).sin_cos();
        [axis[0] * s, axis[1] * s, axis[2] * s, c]
    }

    #[test]
    fn slerp_turns_evenly_on_the_shorter_way() {
        let (a, b) = (axis_angle([0.0, 0.0, 1.0], 10.0), axis_angle([0.0, 0.0, 1.0], 100.0));
        for (t, degrees) in [(0.0, 10.0), (0.25, 32.5), (0.5, 55.0), (1.0, 100.0)] {
            let expected = Affine::rotation([0.0, 0.0, 1.0], f64::to_radians(degrees));
            for b in [b, b.map(|x| -x), b.map(|x| 7.0 * x)] {
                let found = from_quaternion(slerp(a, b, t));
                let differences = found.columns.iter().flatten().zip(expected.columns.iter().flatten());
                let most = differences.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
                assert!(most < 1e-12, "at {t}: {found:?}, not {expected:?}");
            }
        }
        assert_eq!(slerp(a, a, 0.3), a, "the same turn");
        assert_eq!(slerp([0.0; 4], a, 0.3), [0.0; 4], "no turn at all stays what it is");
        assert_eq!(from_quaternion([0.0; 4]), Affine::IDENTITY, "and turns nothing");
    }
}
