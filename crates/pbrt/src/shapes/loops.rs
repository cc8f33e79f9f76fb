// SPDX-License-Identifier: GPL-3.0-or-later
//! `loopsubdiv`: Loop's subdivision of triangles, then vertices moved to the limit surface.
//! Source: [PJH23]'s online chapter on subdivision; weights after Warren (3/16 at valence 3, else 3/(8 n)), borders as cubic splines.
//! Normals are means of those of the last triangles, by area. Invariant: an edge that more than two triangles share is a border.
//! Tests: `tests/shapes.rs`.

use std::collections::HashMap;

use gnurt_scene::Mesh;
use gnurt_scene::io::Error;

use super::reading::Reading;
use super::triangles::{corners, positions};
use crate::parameter::Parameters;
use crate::transform::{cross, double, single};

/// Levels that are done; more would be finer than pixels.
const MOST_LEVELS: i32 = 10;
/// Bytes for each triangle of a level, its edges and vertices among them.
const BYTES: usize = 300;

type Point = [f64; 3];

/// An edge: the corners opposite to it, how many triangles share it, and the vertex in its middle.
struct Edge {
    opposite: Point,
    triangles: u32,
    middle: u32,
}

/// Neighbours of a vertex: their sum and number; those along borders.
#[derive(Clone, Copy, Default)]
struct Ring {
    sum: Point,
    count: u32,
    border: Point,
    borders: u32,
}

fn add(a: &mut Point, b: Point) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

fn edges(points: &[Point], faces: &[[u32; 3]]) -> HashMap<(u32, u32), Edge> {
    let mut edges = HashMap::with_capacity(faces.len() * 3 / 2);
    for &[a, b, c] in faces {
        for (from, to, beyond) in [(a, b, c), (b, c, a), (c, a, b)] {
            let new = || Edge { opposite: [0.0; 3], triangles: 0, middle: 0 };
            let edge = edges.entry(key(from, to)).or_insert_with(new);
            add(&mut edge.opposite, points[beyond as usize]);
            edge.triangles += 1;
        }
    }
    edges
}

fn rings(points: &[Point], edges: &HashMap<(u32, u32), Edge>) -> Vec<Ring> {
    let mut rings = vec![Ring::default(); points.len()];
    for (&(a, b), edge) in edges {
        for (at, other) in [(a, b), (b, a)] {
            let ring = &mut rings[at as usize];
            add(&mut ring.sum, points[other as usize]);
            ring.count += 1;
            if edge.triangles != 2 {
                add(&mut ring.border, points[other as usize]);
                ring.borders += 1;
            }
        }
    }
    rings
}

/// A vertex moved towards its neighbours: `inner` of the valence for those within, `outer` for those on borders.
fn moved(p: Point, ring: &Ring, inner: impl Fn(f64) -> f64, outer: f64) -> Point {
    let (sum, count, weight) = match (ring.borders, ring.count) {
        (0, 0) => return p,
        (0, count) => (ring.sum, f64::from(count), inner(f64::from(count))),
        (2, _) => (ring.border, 2.0, outer),
        // Corners of a border stay.
        _ => return p,
    };
    [0, 1, 2].map(|k| (1.0 - count * weight) * p[k] + weight * sum[k])
}

fn beta(valence: f64) -> f64 {
    if valence == 3.0 { 3.0 / 16.0 } else { 3.0 / (8.0 * valence) }
}

fn divide(points: &mut Vec<Point>, faces: &mut Vec<[u32; 3]>) {
    let mut edges = edges(points, faces);
    let rings = rings(points, &edges);
    let old = points.clone();
    for (p, ring) in points.iter_mut().zip(&rings) {
        *p = moved(*p, ring, beta, 1.0 / 8.0);
    }
    // In the order of faces, so that the same file gives the same mesh.
    for &[a, b, c] in faces.iter() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let Some(edge) = edges.get_mut(&key(from, to)).filter(|edge| edge.middle == 0) else { continue };
            let [p, q] = [old[from as usize], old[to as usize]];
            let middle = [0, 1, 2].map(|k| match edge.triangles {
                2 => 0.375 * (p[k] + q[k]) + 0.125 * edge.opposite[k],
                _ => 0.5 * (p[k] + q[k]),
            });
            edge.middle = points.len() as u32;
            points.push(middle);
        }
    }
    let middle = |a: u32, b: u32| edges.get(&key(a, b)).map_or(a, |edge| edge.middle);
    *faces = faces
        .iter()
        .flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        })
        .collect();
}

pub(super) fn mesh(parameters: &Parameters, reading: &Reading) -> Result<Mesh, Error> {
    let location = &parameters.location;
    let given = positions(parameters, "loopsubdiv")?;
    let indices = corners(parameters, "indices", 3, given.len())?.ok_or_else(|| {
        location.error("a loopsubdiv has no \"integer indices\"", "give three for each triangle")
    })?;
    let levels = parameters.int("levels")?.unwrap_or(3).clamp(0, MOST_LEVELS) as u32;
    parameters.text("scheme")?;
    let mut faces: Vec<[u32; 3]> = indices.as_chunks().0.to_vec();
    let last = faces.len().saturating_mul(1 << (2 * levels));
    let bytes = last.saturating_mul(BYTES);
    reading.access.budget.hold(bytes).map_err(|e| location.excess(e))?;
    let mut points: Vec<Point> = given.iter().copied().map(double).collect();
    for _ in 0..levels {
        divide(&mut points, &mut faces);
    }
    let limits = rings(&points, &edges(&points, &faces));
    let gamma = |valence: f64| 1.0 / (valence + 3.0 / (8.0 * beta(valence)));
    let points: Vec<Point> =
        points.iter().zip(&limits).map(|(p, ring)| moved(*p, ring, gamma, 1.0 / 5.0)).collect();
    let mut normals = vec![[0.0; 3]; points.len()];
    for &face in &faces {
        let [a, b, c] = face.map(|i| points[i as usize]);
        let minus = |p: Point| [0, 1, 2].map(|k| p[k] - a[k]);
        let normal = cross(minus(b), minus(c));
        face.iter().for_each(|&i| add(&mut normals[i as usize], normal));
    }
    let mesh = Mesh {
        positions: points.into_iter().map(single).collect(),
        // Of any length, so large and small shapes have them alike.
        normals: normals.into_iter().map(|n| crate::transform::unit(n).map_or([0.0; 3], single)).collect(),
        indices: faces,
        ..Mesh::default()
    };
    reading.access.budget.release(bytes);
    Ok(mesh)
}
