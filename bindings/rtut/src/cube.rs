// SPDX-License-Identifier: GPL-3.0-or-later
//! A cube of edge 2 around the origin. Tests: `tests::is_a_cube`, tests/c/shapes.c.

use crate::sink::{Mode, Sink, Vertex};

/// rtutCube.
pub fn cube(sink: &mut dyn Sink) {
    sink.begin(Mode::Quads);
    for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
        let mut normal = [0.0; 3];
        normal[axis] = side;
        // Right and up of the face as its viewer sees it: right x up = normal.
        let (right, up) = ((axis + 1) % 3, (axis + 2) % 3);
        for [s, t] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            let mut position = normal;
            position[right] = side * (2.0 * s - 1.0);
            position[up] = 2.0 * t - 1.0;
            sink.vertex(Vertex { position, normal, texcoord: [s, t] });
        }
    }
    sink.end();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sink::tests::Mesh;

    #[test]
    fn is_a_cube() {
        let mut mesh = Mesh::default();
        cube(&mut mesh);
        assert_eq!(mesh.triangles.len(), 12, "two for each face");
        mesh.check_normals();
        mesh.check_closed();
        assert!((mesh.volume() - 8.0).abs() < 1e-12, "edge 2: {}", mesh.volume());
    }
}
