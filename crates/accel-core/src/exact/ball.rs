// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether a point lies in a ball, decided without rounding. Tests: `tests/surfaces/inside.rs`.

use super::number::{Formula, Number, V3, dot, minus, of, sign};

/// The square of the distance from the centre, less that of the radius.
struct Beyond {
    point: [f64; 3],
    center: [f64; 3],
    radius: f64,
}

impl Formula for Beyond {
    fn value<N: Number>(&self) -> Option<N> {
        let from: V3<N> = minus(&of(self.point), &of(self.center))?;
        let radius = N::new(self.radius);
        dot(&from, &from)?.minus(&radius.times(&radius)?)
    }
}

/// -1 inside, 0 on the sphere, 1 outside.
pub fn side_of_sphere(point: [f64; 3], center: [f32; 3], radius: f32) -> i8 {
    let (center, radius) = (center.map(f64::from), f64::from(radius));
    let [x, y, z] = [0, 1, 2].map(|k| point[k] - center[k]);
    let (square, of_radius) = (x * x + y * y + z * z, radius * radius);
    if (square - of_radius).abs() > 1e-14 * (square + of_radius) {
        return if square > of_radius { 1 } else { -1 };
    }
    sign(&Beyond { point, center, radius })
}
