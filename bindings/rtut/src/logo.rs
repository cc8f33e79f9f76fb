// SPDX-License-Identifier: GPL-3.0-or-later
//! The logo without letters: a triangle, the traced primitive, as a ring around a ball, as in pictures of it.
//! Space: within radius 1 of the origin, seen along -z. Tests: `tests::is_closed`.

use std::f64::consts::FRAC_PI_2;

use crate::sink::{Mode, Sink, Vertex};
use crate::sphere;

/// Circumscribed radii of the ring's two triangles; the inner triangle's inscribed circle has half its radius.
const RADII: [f64; 2] = [0.98, 0.68];
/// Half the thickness of the ring.
const HALF: f64 = 0.12;
/// Radius of the ball.
const BALL: f64 = 0.3;

/// rtutLogo.
pub fn logo(sink: &mut dyn Sink) {
    let corner = |ring: usize, k: i32| {
        let (sin, cos) = (FRAC_PI_2 + f64::from(k % 3) * std::f64::consts::TAU / 3.0).sin_cos();
        [RADII[ring] * cos, RADII[ring] * sin]
    };
    let quad = |sink: &mut dyn Sink, corners: [[f64; 3]; 4], normal: [f64; 3]| {
        let texcoords = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        for (position, texcoord) in corners.into_iter().zip(texcoords) {
            sink.vertex(Vertex { position, normal, texcoord });
        }
    };
    sink.begin(Mode::Quads);
    for side in 0..3 {
        let [[ax, ay], [bx, by]] = [corner(0, side), corner(0, side + 1)];
        let [[cx, cy], [dx, dy]] = [corner(1, side), corner(1, side + 1)];
        // Outwards across this side: half-way between its corners' directions.
        let (sin, cos) = (FRAC_PI_2 + (f64::from(side) + 0.5) * std::f64::consts::TAU / 3.0).sin_cos();
        let (front, back) = (HALF, -HALF);
        quad(sink, [[ax, ay, front], [bx, by, front], [dx, dy, front], [cx, cy, front]], [0.0, 0.0, 1.0]);
        quad(sink, [[bx, by, back], [ax, ay, back], [cx, cy, back], [dx, dy, back]], [0.0, 0.0, -1.0]);
        quad(sink, [[ax, ay, back], [bx, by, back], [bx, by, front], [ax, ay, front]], [cos, sin, 0.0]);
        quad(sink, [[dx, dy, back], [cx, cy, back], [cx, cy, front], [dx, dy, front]], [-cos, -sin, 0.0]);
    }
    sink.end();
    sphere::scaled(sink, 48, 24, BALL);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sink::tests::Mesh;

    #[test]
    fn is_closed() {
        let mut mesh = Mesh::default();
        logo(&mut mesh);
        assert_eq!(mesh.triangles.len(), 24 + 2 * 48 * 23, "ring and ball");
        mesh.check_normals();
        mesh.check_closed();
        let ring = 3.0 * 3.0_f64.sqrt() / 4.0 * (RADII[0].powi(2) - RADII[1].powi(2)) * 2.0 * HALF;
        let ball = 4.0 / 3.0 * std::f64::consts::PI * BALL.powi(3);
        assert!((mesh.volume() / (ring + ball) - 1.0).abs() < 0.02, "outside is outside: {}", mesh.volume());
        let far = mesh.triangles.iter().flatten().map(|v| v.position.iter().map(|x| x * x).sum::<f64>());
        assert!(far.fold(0.0, f64::max) <= 1.0, "within radius 1");
    }
}
