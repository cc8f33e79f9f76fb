// SPDX-License-Identifier: GPL-3.0-or-later
//! A rotation between two transforms, with the interpolation of the stretch.
//! Source: rotations follow the shorter arc at constant speed [Sho85], as glTF's do; a matrix is decomposed
//! into translation, rotation and stretch by Gram and Schmidt, which recovers these three.
//! Space: columns are images of the object's axes. Invariant: between two times points leave the straight
//! line by less than the square of the time between them, times an eighth of their greatest acceleration.
//! Tests: `path::tests`.

use super::box64::Box64;
use super::exact::Exact;

type Quaternion = [f64; 4];
pub(super) type Columns = [[f64; 3]; 4];

/// An upper triangular matrix, by columns: of the first one number, of the second two.
type Stretch = [f64; 6];

/// A rotation, and the stretch before it.
type Parts = (Quaternion, Stretch);

/// How the linear part of a matrix becomes another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rotation {
    /// The first rotation, and the unit quaternion a quarter of a circle further along the arc.
    from: Quaternion,
    beyond: Quaternion,
    /// The length of the arc: half the angle of the rotation.
    arc: f64,
    /// The stretch before the rotation, at both ends.
    stretch: [Stretch; 2],
    /// Whether these two are equal except for rounding: then the first counts.
    is_rigid: bool,
}

/// The greatest rotation, in radians, between two of the boxes that bound an object's path.
const STEP: f64 = 0.05;

impl Rotation {
    /// The shorter arc; `None` if one of the transforms is flat or not finite.
    pub(super) fn new(from: &Columns, to: &Columns) -> Option<Self> {
        let ((from, stretch), (to, stretch_to)) = (decompose(from)?, decompose(to)?);
        let dot: f64 = (0..4).map(|k| from[k] * to[k]).sum();
        let to = if dot < 0.0 { to.map(|x| -x) } else { to };
        let across: Quaternion = std::array::from_fn(|k| to[k] - dot.abs() * from[k]);
        let sine = length(&across);
        let beyond = if sine > 0.0 { across.map(|x| x / sine) } else { [0.0; 4] };
        let arc = sine.atan2(dot.abs());
        let is_rigid = is_same(&stretch, &stretch_to);
        Some(Self { from, beyond, arc, stretch: [stretch, stretch_to], is_rigid })
    }

    /// The angle of the rotation, in radians.
    pub(super) fn angle(&self) -> f64 {
        2.0 * self.arc
    }

    /// The linear part at a fraction of the piece, as columns.
    pub(super) fn linear(&self, share: f64) -> [[f64; 3]; 3] {
        // Written out for speed: rays come here, each at its time.
        let (sine, cosine) = (share * self.arc).sin_cos();
        let (from, beyond) = (&self.from, &self.beyond);
        let along = |k: usize| cosine * from[k] + sine * beyond[k];
        let [x, y, z] = axes(&[along(0), along(1), along(2), along(3)]);
        let [ax, bx, by, cx, cy, cz] = self.stretch_at(share);
        let a = [x[0] * ax, x[1] * ax, x[2] * ax];
        let b = [x[0] * bx + y[0] * by, x[1] * bx + y[1] * by, x[2] * bx + y[2] * by];
        let c = [
            x[0] * cx + y[0] * cy + z[0] * cz,
            x[1] * cx + y[1] * cy + z[1] * cz,
            x[2] * cx + y[2] * cy + z[2] * cz,
        ];
        [a, b, c]
    }

    /// The derivative of [`linear`](Self::linear) by the fraction.
    pub(super) fn rate(&self, share: f64) -> [[f64; 3]; 3] {
        let (sine, cosine) = (share * self.arc).sin_cos();
        let [from, beyond] = [&self.from, &self.beyond];
        let at: Quaternion = std::array::from_fn(|k| cosine * from[k] + sine * beyond[k]);
        let change: Quaternion = std::array::from_fn(|k| self.arc * (cosine * beyond[k] - sine * from[k]));
        let stretch = self.stretch_at(share);
        let growth: Stretch = match self.is_rigid {
            true => [0.0; 6],
            false => std::array::from_fn(|k| self.stretch[1][k] - self.stretch[0][k]),
        };
        let [turned, grown] = [times(&axes_rate(&at, &change), &stretch), times(&axes(&at), &growth)];
        std::array::from_fn(|c| std::array::from_fn(|k| turned[c][k] + grown[c][k]))
    }

    /// The stretch before the rotation.
    #[inline(always)]
    fn stretch_at(&self, share: f64) -> Stretch {
        let [from, to] = &self.stretch;
        if self.is_rigid {
            return *from;
        }
        let mix = |k: usize| (1.0 - share) * from[k] + share * to[k];
        [mix(0), mix(1), mix(2), mix(3), mix(4), mix(5)]
    }

    /// In how many steps a box follows it, and by how much at most a point of the box leaves the straight line within one.
    pub(super) fn steps(&self, object: &Box64) -> (f64, f64) {
        let (angle, [reach, growth]) = (self.angle(), self.reach(object));
        let count = (angle / STEP).ceil().max(1.0);
        let acceleration = angle * angle * reach + 2.0 * angle * growth;
        (count, acceleration / (8.0 * count * count))
    }

    /// The greatest distance of a box's corners from the centre of rotation, and their greatest motion by
    /// stretching.
    fn reach(&self, object: &Box64) -> [f64; 2] {
        let mut most = [0.0_f64; 2];
        for corner in 0..8 {
            let [x, y, z]: [f64; 3] =
                std::array::from_fn(|k| if corner >> k & 1 == 0 { object.min[k] } else { object.max[k] });
            let apply = |&[ax, bx, by, cx, cy, cz]: &Stretch| -> [f64; 3] {
                [ax * x + bx * y + cx * z, by * y + cy * z, cz * z]
            };
            let [from, to] = [apply(&self.stretch[0]), apply(&self.stretch[1])];
            let by: [f64; 3] = std::array::from_fn(|k| to[k] - from[k]);
            most[0] = most[0].max(length(&from)).max(length(&to));
            most[1] = most[1].max(length(&by));
        }
        most
    }
}

/// Whether two stretches differ only by the rounding of the decomposition.
fn is_same(a: &Stretch, b: &Stretch) -> bool {
    let size = a.iter().chain(b).fold(0.0_f64, |most, x| most.max(x.abs()));
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-14 * size)
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A rotation, and the stretch before it. `None` if the columns are in one plane or not finite.
fn decompose(columns: &Columns) -> Option<Parts> {
    Exact::new(columns)?;
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let [a, b, c, translation] = *columns;
    let unit = |v: [f64; 3]| {
        let length = length(&v);
        v.map(|x| x / length)
    };
    let x = unit(a);
    // Twice is enough: the second subtraction removes the error of the first.
    let without_x = |v: [f64; 3]| -> [f64; 3] {
        let along = dot(v, x);
        std::array::from_fn(|k| v[k] - along * x[k])
    };
    let y = unit(without_x(without_x(b)));
    let z = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    let stretch = [dot(x, a), dot(x, b), dot(y, b), dot(x, c), dot(y, c), dot(z, c)];
    let rotation = quaternion([x, y, z]);
    let finite = rotation.iter().chain(&stretch).chain(&translation).all(|x| x.is_finite());
    finite.then_some((rotation, stretch))
}

/// The unit quaternion, the real part last, of a rotation with these columns. Source: Shepperd, 1978: by the
/// greatest part.
fn quaternion([x, y, z]: [[f64; 3]; 3]) -> Quaternion {
    let trace = x[0] + y[1] + z[2];
    let greatest = trace.max(x[0]).max(y[1]).max(z[2]);
    let q = if greatest == trace {
        [y[2] - z[1], z[0] - x[2], x[1] - y[0], 1.0 + trace]
    } else if greatest == x[0] {
        [1.0 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2], y[2] - z[1]]
    } else if greatest == y[1] {
        [y[0] + x[1], 1.0 + y[1] - x[0] - z[2], z[1] + y[2], z[0] - x[2]]
    } else {
        [z[0] + x[2], z[1] + y[2], 1.0 + z[2] - x[0] - y[1], x[1] - y[0]]
    };
    let length = length(&q);
    q.map(|x| x / length)
}

/// The columns of a rotation.
#[inline(always)]
fn axes(&[x, y, z, w]: &Quaternion) -> [[f64; 3]; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// The derivative of [`axes`] for a quaternion with this derivative.
fn axes_rate(&[x, y, z, w]: &Quaternion, &[dx, dy, dz, dw]: &Quaternion) -> [[f64; 3]; 3] {
    let both = |a: f64, b: f64, da: f64, db: f64| 2.0 * (da * b + a * db);
    let [xx, yy, zz] = [4.0 * x * dx, 4.0 * y * dy, 4.0 * z * dz];
    let [xy, xz, yz] = [both(x, y, dx, dy), both(x, z, dx, dz), both(y, z, dy, dz)];
    let [xw, yw, zw] = [both(x, w, dx, dw), both(y, w, dy, dw), both(z, w, dz, dw)];
    [[-yy - zz, xy + zw, xz - yw], [xy - zw, -xx - zz, yz + xw], [xz + yw, yz - xw, -xx - yy]]
}

/// Columns after a stretch.
fn times([x, y, z]: &[[f64; 3]; 3], &[ax, bx, by, cx, cy, cz]: &Stretch) -> [[f64; 3]; 3] {
    let sum = |a: f64, b: f64, c: f64| std::array::from_fn(|k| x[k] * a + y[k] * b + z[k] * c);
    [sum(ax, 0.0, 0.0), sum(bx, by, 0.0), sum(cx, cy, cz)]
}
