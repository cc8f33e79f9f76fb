// SPDX-License-Identifier: GPL-3.0-or-later
//! Distances of visible surfaces from a point, from the description alone: every triangle is tested, so that
//! no tree is needed. Signs of the volumes that eye and edges span. Space: world; double precision. Triangles
//! that are not finite are invisible. Cost: triangles of visible instances times directions, of which there
//! are few.
//! Tests: `tests`.

use crate::scene::{Affine, Mesh, Scene};

type Point = [f64; 3];

/// Limit of visited objects, where very many are unfolded.
const MOST_MEASURED: usize = 1 << 20;

/// Distance to the nearest triangle in each direction (unit), infinite if there is none.
pub(super) fn distances(scene: &Scene, eye: Point, directions: &[Point]) -> Vec<f64> {
    let mut nearest = vec![f64::INFINITY; directions.len()];
    for found in scene.occurrences().take(MOST_MEASURED) {
        for mesh in found.object.meshes.iter().filter_map(|id| scene.meshes().get(id.index())) {
            see_mesh(mesh, &found.world_from_object, eye, directions, &mut nearest);
        }
    }
    nearest
}

fn see_mesh(mesh: &Mesh, to: &Affine, eye: Point, directions: &[Point], nearest: &mut [f64]) {
    let corner = |i: u32| mesh.positions.get(i as usize).map(|p| sub(to.point(p.map(f64::from)), eye));
    for &[a, b, c] in &mesh.indices {
        let (Some(a), Some(b), Some(c)) = (corner(a), corner(b), corner(c)) else { continue };
        let (e1, e2) = (sub(b, a), sub(c, a));
        let (normal, across) = (cross(e1, e2), dot(a, cross(e1, e2)));
        // Edges of the cone that the eye and the triangle span.
        let sides = [cross(b, c), cross(c, a), cross(a, b)];
        for (nearest, &direction) in nearest.iter_mut().zip(directions) {
            let t = across / dot(direction, normal);
            let inside = sides.map(|side| dot(side, direction) * across);
            // Comparisons with NaN are false: degenerate triangles are not seen.
            if t > 0.0 && t < *nearest && inside.iter().all(|&s| s >= 0.0) {
                *nearest = t;
            }
        }
    }
}

fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sees_the_nearest() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN; 3]],
            indices: vec![[0, 1, 2], [0, 1, 3], [0, 0, 1], [0, 1, 9]],
            ..Mesh::default()
        });
        let object = scene.add_object_of("triangle", vec![mesh]);
        for z in [-5.0, -3.0, 2.0] {
            scene.instantiate(object, Affine::translation([0.0, 0.0, z]));
        }
        let directions = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.6, 0.0, -0.8]];
        let measured = distances(&scene, [0.0; 3], &directions);
        assert_eq!(
            measured,
            [3.0, 2.0, f64::INFINITY, f64::INFINITY],
            "in front, behind, nothing, just beside"
        );
    }
}
