// SPDX-License-Identifier: GPL-3.0-or-later
//! A sphere of radius 1 around the origin, its poles on the z axis.
//! Tests: `tests::is_a_sphere`, tests/c/shapes.c.

use std::f64::consts::{PI, TAU};

use crate::grid::{cells, emit};
use crate::sink::{Sink, Vertex};

/// rtutSphere; nothing if an argument is out of range.
pub fn sphere(sink: &mut dyn Sink, slices: i32, stacks: i32) {
    scaled(sink, slices, stacks, 1.0);
}

/// A sphere of this radius.
pub(crate) fn scaled(sink: &mut dyn Sink, slices: i32, stacks: i32, radius: f64) {
    let (Some(slices), Some(stacks)) = (cells(slices, 3), cells(stacks, 2)) else { return };
    emit(sink, slices, stacks, |s, t| {
        // The seam and the poles are exact, so that the mesh is closed.
        let (longitude, latitude) = (TAU * if s == 1.0 { 0.0 } else { s }, PI * (t - 0.5));
        let ring = if t == 0.0 || t == 1.0 { 0.0 } else { latitude.cos() };
        let normal = [ring * longitude.cos(), ring * longitude.sin(), latitude.sin()];
        Vertex { position: normal.map(|x| radius * x), normal, texcoord: [s, t] }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sink::tests::Mesh;

    fn mesh(slices: i32, stacks: i32) -> Mesh {
        let mut mesh = Mesh::default();
        sphere(&mut mesh, slices, stacks);
        mesh
    }

    #[test]
    fn is_a_sphere() {
        for (slices, stacks) in [(3, 2), (4, 3), (32, 17)] {
            let mesh = mesh(slices, stacks);
            assert_eq!(mesh.triangles.len() as i32, 2 * slices * (stacks - 1), "{slices} x {stacks}");
            mesh.check_normals();
            mesh.check_closed();
        }
        let volume = mesh(200, 100).volume();
        assert!((volume / (4.0 / 3.0 * PI) - 1.0).abs() < 1e-3, "that of a ball, not {volume}");
    }

    #[test]
    fn bad_numbers_give_nothing() {
        for (slices, stacks) in [(2, 8), (8, 1), (-5, 8), (8, i32::MAX), (i32::MIN, i32::MIN)] {
            assert!(mesh(slices, stacks).triangles.is_empty(), "{slices} x {stacks}");
        }
    }
}
