// SPDX-License-Identifier: GPL-3.0-or-later
//! A torus around the z axis. Tests: `tests::is_a_torus`, tests/c/shapes.c.

use std::f64::consts::TAU;

use crate::grid::{cells, emit};
use crate::sink::{Sink, Vertex};

/// rtutTorus: a tube of radius `tube` around a circle of radius `middle`; nothing if an argument is out of range.
pub fn torus(sink: &mut dyn Sink, [tube, middle]: [f64; 2], sides: i32, rings: i32) {
    let (Some(sides), Some(rings)) = (cells(sides, 3), cells(rings, 3)) else { return };
    if !(tube > 0.0 && middle > tube && middle.is_finite()) {
        return;
    }
    // The last column and row are the first: the mesh is closed.
    let angle = |x: f64| TAU * if x == 1.0 { 0.0 } else { x };
    emit(sink, rings, sides, |s, t| {
        let ((sin, cos), (rise, out)) = (angle(s).sin_cos(), angle(t).sin_cos());
        let radius = middle + tube * out;
        Vertex {
            position: [radius * cos, radius * sin, tube * rise],
            normal: [out * cos, out * sin, rise],
            texcoord: [s, t],
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sink::tests::Mesh;

    fn mesh(radii: [f64; 2], sides: i32, rings: i32) -> Mesh {
        let mut mesh = Mesh::default();
        torus(&mut mesh, radii, sides, rings);
        mesh
    }

    #[test]
    fn is_a_torus() {
        for (sides, rings) in [(3, 3), (12, 31)] {
            let mesh = mesh([0.5, 2.0], sides, rings);
            assert_eq!(mesh.triangles.len() as i32, 2 * sides * rings, "{sides} x {rings}");
            mesh.check_normals();
            mesh.check_closed();
        }
        let (volume, exact) = (mesh([0.5, 2.0], 100, 200).volume(), TAU * TAU * 0.25);
        assert!((volume / exact - 1.0).abs() < 2e-3, "{volume}, not {exact}");
    }

    #[test]
    fn bad_numbers_give_nothing() {
        for (radii, sides, rings) in [
            ([0.5, 2.0], 2, 9),
            ([0.5, 2.0], 9, 0),
            ([2.0, 0.5], 9, 9),
            ([0.0, 1.0], 9, 9),
            ([f64::NAN, 1.0], 9, 9),
        ] {
            assert!(mesh(radii, sides, rings).triangles.is_empty(), "{radii:?}, {sides} x {rings}");
        }
    }
}
