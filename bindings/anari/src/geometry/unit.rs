// SPDX-License-Identifier: GPL-3.0-or-later
//! Unit shapes that placements put where spheres, cylinders and ends of tubes are, fine enough that their outlines look round.
//! A sphere is an icosahedron divided five times: 20,480 triangles, at most 0.0004 radii inside of the sphere. A cylinder has 128 sides:
//! at most 0.0003 radii inside. Space: the sphere has radius 1 around the origin, the cylinder radius 1 from z = 0 to 1.
//! Tests: `tests`.

use std::collections::HashMap;
use std::f32::consts::TAU;
use std::sync::{Arc, LazyLock};

use glam::Vec3;
use gnurt::scene::Mesh;

const DIVISIONS: usize = 5;
const SIDES: u32 = 128;

/// The unit sphere.
pub(crate) fn sphere() -> Arc<Mesh> {
    static SPHERE: LazyLock<Arc<Mesh>> = LazyLock::new(|| Arc::new(divided(DIVISIONS)));
    SPHERE.clone()
}

fn divided(times: usize) -> Mesh {
    let g = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let corners = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ];
    let mut points: Vec<Vec3> = corners.iter().map(|&p| Vec3::from(p).normalize()).collect();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..times {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                (points.len() - 1) as u32
            })
        };
        let four = |[a, b, c]: [u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(four).collect();
    }
    let positions: Vec<[f32; 3]> = points.iter().map(|p| p.to_array()).collect();
    Mesh { normals: positions.clone(), positions, indices: triangles, ..Mesh::default() }
}

/// The unit cylinder with a closed first and second end.
pub(crate) fn cylinder(caps: [bool; 2]) -> Arc<Mesh> {
    static CYLINDERS: [LazyLock<Arc<Mesh>>; 4] = [
        LazyLock::new(|| Arc::new(tube([false, false]))),
        LazyLock::new(|| Arc::new(tube([true, false]))),
        LazyLock::new(|| Arc::new(tube([false, true]))),
        LazyLock::new(|| Arc::new(tube([true, true]))),
    ];
    CYLINDERS[usize::from(caps[0]) + 2 * usize::from(caps[1])].clone()
}

fn tube(caps: [bool; 2]) -> Mesh {
    let mut mesh = Mesh::default();
    frustum(&mut mesh, [Vec3::ZERO, Vec3::Z], [1.0, 1.0], SIDES, caps);
    mesh
}

/// Sides of a disc: at most 0.00002 radii inside of the circle.
const DISC_SIDES: u32 = 512;

/// The unit disc around the origin, whose normal is z.
pub(crate) fn disc() -> Arc<Mesh> {
    static DISC: LazyLock<Arc<Mesh>> = LazyLock::new(|| {
        let mut positions = vec![[0.0; 3]];
        positions.extend((0..DISC_SIDES).map(|side| {
            let (sin, cos) = (side as f32 / DISC_SIDES as f32 * TAU).sin_cos();
            [cos, sin, 0.0]
        }));
        let indices = (0..DISC_SIDES).map(|side| [0, 1 + side, 1 + (side + 1) % DISC_SIDES]).collect();
        Arc::new(Mesh { positions, indices, ..Mesh::default() })
    });
    DISC.clone()
}

/// Appends a cone, cut or pointed, between two places with these radii; ends of radius 0 are points. Vertices come in rings: those of the
/// first end, of the second, then of the discs. Says for each new vertex at which end it lies.
pub(crate) fn frustum(
    mesh: &mut Mesh,
    [a, b]: [Vec3; 2],
    radii: [f32; 2],
    sides: u32,
    caps: [bool; 2],
) -> Vec<usize> {
    let axis = b - a;
    let Some(along) = axis.try_normalize() else { return Vec::new() };
    let (x, y) = along.any_orthonormal_pair();
    // Steeper where the radius changes.
    let slope = (radii[0] - radii[1]) / axis.length();
    let round = |side: u32| {
        let (sin, cos) = (side as f32 / sides as f32 * TAU).sin_cos();
        x * cos + y * sin
    };
    let first = mesh.positions.len() as u32;
    let mut ends = Vec::new();
    let mut put = |mesh: &mut Mesh, p: Vec3, n: Vec3, end: usize| {
        mesh.positions.push(p.to_array());
        mesh.normals.push(n.to_array());
        ends.push(end);
    };
    for (end, centre) in [a, b].into_iter().enumerate() {
        for side in 0..sides {
            let out = round(side);
            put(mesh, centre + out * radii[end], (out + along * slope).normalize_or(out), end);
        }
    }
    for side in 0..sides {
        let next = (side + 1) % sides;
        let [a, b, c, d] = [side, next, sides + next, sides + side].map(|vertex| first + vertex);
        if radii[0] > 0.0 {
            mesh.indices.push([a, b, c]);
        }
        if radii[1] > 0.0 {
            mesh.indices.push([a, c, d]);
        }
    }
    for (end, centre) in [a, b].into_iter().enumerate() {
        if !caps[end] || radii[end] <= 0.0 {
            continue;
        }
        let normal = if end == 0 { -along } else { along };
        let middle = mesh.positions.len() as u32;
        put(mesh, centre, normal, end);
        (0..sides).for_each(|side| put(mesh, centre + round(side) * radii[end], normal, end));
        for side in 0..sides {
            let [here, next] = [side, (side + 1) % sides].map(|vertex| middle + 1 + vertex);
            mesh.indices.push(if end == 0 { [middle, next, here] } else { [middle, here, next] });
        }
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mesh: &Mesh) -> f32 {
        let point = |i: u32| Vec3::from(mesh.positions[i as usize]);
        mesh.indices
            .iter()
            .map(|&[a, b, c]| (point(b) - point(a)).cross(point(c) - point(a)).length() / 2.0)
            .sum()
    }

    #[test]
    fn shapes_have_their_areas_and_look_outwards() {
        let pi = std::f32::consts::PI;
        assert!((area(&sphere()) / (4.0 * pi) - 1.0).abs() < 2e-3, "sphere {}", area(&sphere()));
        for (caps, expected) in [([false; 2], 2.0), ([true, false], 3.0), ([true; 2], 4.0)] {
            let found = area(&cylinder(caps)) / pi;
            assert!((found / expected - 1.0).abs() < 2e-3, "cylinder {caps:?}: {found}");
        }
        for mesh in [sphere(), cylinder([true; 2])] {
            for &[a, b, c] in &mesh.indices {
                let [a, b, c] = [a, b, c].map(|i| Vec3::from(mesh.positions[i as usize]));
                let out =
                    (a + b + c) / 3.0 - if mesh.positions.len() > 2000 { Vec3::ZERO } else { Vec3::Z * 0.5 };
                assert!((b - a).cross(c - a).dot(out) > 0.0, "a triangle looks inwards");
            }
        }
        let round = sphere();
        let farthest = round.indices.iter().map(|t| {
            let middle = t.iter().map(|&i| Vec3::from(round.positions[i as usize])).sum::<Vec3>() / 3.0;
            1.0 - middle.length()
        });
        assert!(farthest.fold(0.0, f32::max) < 4.5e-4, "close to the sphere");
    }

    #[test]
    fn cones_have_their_areas() {
        let mut mesh = Mesh::default();
        let ends = frustum(&mut mesh, [Vec3::ZERO, Vec3::new(0.0, 4.0, 0.0)], [3.0, 0.0], 512, [true; 2]);
        assert_eq!(ends.len(), mesh.positions.len(), "one for each vertex");
        let expected = std::f32::consts::PI * (3.0 * 5.0 + 9.0);
        assert!((area(&mesh) / expected - 1.0).abs() < 1e-3, "side and base: {}", area(&mesh));
    }
}
