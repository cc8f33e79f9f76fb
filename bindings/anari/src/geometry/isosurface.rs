// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces of equal value of a field, by tetrahedra: each cell of the grid is cut into six around a diagonal, and each of these holds at
//! most two triangles. Vertices are shared; their normals are the field's gradient, towards smaller values.
//! Differs from marching cubes by more triangles, and by the absence of a table and of holes. Tests: tests/shapes.rs.

use std::collections::HashMap;

use glam::Vec3;
use gnurt::scene::Mesh;

use super::data::{Geometry, Part, Primitives, Vertices};
use super::rates::Rates;
use crate::ffi_array::Array;
use crate::field::Field;
use crate::object::Snapshot;
use crate::types;

/// Corners of a cell's tetrahedra; bit k of a corner is its step along axis k.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// Triangles beyond which a surface is refused: 24 GiB of trees and arrays.
const MOST: usize = 100_000_000;

struct Surface<'f> {
    field: &'f Field,
    value: f32,
    mesh: Mesh,
    /// Vertices by the ends of their edges.
    known: HashMap<[usize; 2], u32>,
}

impl Surface<'_> {
    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.field.dims[0] * (y + self.field.dims[1] * z)
    }

    /// The vertex on the edge between two points of the grid.
    fn vertex(&mut self, a: [usize; 3], b: [usize; 3]) -> u32 {
        let (a, b) = if self.number(a) < self.number(b) { (a, b) } else { (b, a) };
        let key = [self.number(a), self.number(b)];
        if let Some(&vertex) = self.known.get(&key) {
            return vertex;
        }
        let [from, to] = [a, b].map(|at| self.field.voxel(at));
        let share = ((self.value - from) / (to - from)).clamp(0.0, 1.0);
        let position = |at: [usize; 3]| {
            Vec3::from_array(std::array::from_fn(|k| {
                self.field.origin[k] + self.field.spacing[k] * at[k] as f32
            }))
        };
        let p = position(a).lerp(position(b), share);
        let gradient = Vec3::from(self.field.gradient(a)).lerp(Vec3::from(self.field.gradient(b)), share);
        let vertex = self.mesh.positions.len() as u32;
        self.mesh.positions.push(p.to_array());
        self.mesh.normals.push((-gradient).normalize_or_zero().to_array());
        self.known.insert(key, vertex);
        vertex
    }

    /// A triangle that looks away from `inside`.
    fn triangle(&mut self, corners: [u32; 3], inside: Vec3) {
        let [a, b, c] = corners.map(|vertex| Vec3::from(self.mesh.positions[vertex as usize]));
        let [p, q, r] = corners;
        let outwards = (b - a).cross(c - a).dot(a - inside) >= 0.0;
        self.mesh.indices.push(if outwards { [p, q, r] } else { [p, r, q] });
    }

    fn tetrahedron(&mut self, corners: [[usize; 3]; 4]) {
        let is_in = |at: &[usize; 3]| self.field.voxel(*at) >= self.value;
        let (within, without): (Vec<_>, Vec<_>) = corners.into_iter().partition(is_in);
        if corners.iter().any(|&at| !self.field.voxel(at).is_finite())
            || within.is_empty()
            || without.is_empty()
        {
            return;
        }
        let position = |at: [usize; 3]| {
            Vec3::from_array(std::array::from_fn(|k| {
                self.field.origin[k] + self.field.spacing[k] * at[k] as f32
            }))
        };
        let inside = within.iter().map(|&at| position(at)).sum::<Vec3>() / within.len() as f32;
        match (&within[..], &without[..]) {
            (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => {
                let corners = [self.vertex(a, b), self.vertex(a, c), self.vertex(a, d)];
                self.triangle(corners, inside);
            }
            (&[a, b], &[c, d]) => {
                let [p, q, r, s] =
                    [self.vertex(a, c), self.vertex(a, d), self.vertex(b, d), self.vertex(b, c)];
                self.triangle([p, q, r], inside);
                self.triangle([p, r, s], inside);
            }
            _ => {}
        }
    }
}

/// The surfaces of all values.
pub(super) fn isosurface(now: &Snapshot, field: &Field) -> Result<(Geometry, Option<String>), String> {
    let list = now.object("isovalue", types::ARRAY1D).and_then(|array| Array::of(array)?.colors());
    let values: Vec<f32> = match (list, now.f32("isovalue")) {
        (Some(list), _) => list.into_iter().map(|value| value[0]).collect(),
        (None, Some(value)) => vec![value],
        _ => return Err("parameter 'isovalue': missing".into()),
    };
    let (mut all, mut primitives) = (Mesh::default(), Vec::new());
    for (number, &value) in values.iter().enumerate() {
        let mut surface = Surface { field, value, mesh: Mesh::default(), known: HashMap::new() };
        let cells = field.dims.map(|n| n.saturating_sub(1));
        for z in 0..cells[2] {
            for y in 0..cells[1] {
                for x in 0..cells[0] {
                    let corner = |bits: usize| [x + (bits & 1), y + (bits >> 1 & 1), z + (bits >> 2)];
                    TETRAHEDRA.iter().for_each(|corners| surface.tetrahedron(corners.map(corner)));
                }
            }
            if surface.mesh.indices.len() + all.indices.len() > MOST {
                return Err(format!("isovalue {value}: more than {MOST} triangles"));
            }
        }
        let first = all.positions.len() as u32;
        all.positions.append(&mut surface.mesh.positions);
        all.normals.append(&mut surface.mesh.normals);
        all.indices.extend(surface.mesh.indices.iter().map(|triangle| triangle.map(|vertex| first + vertex)));
        primitives.resize(all.indices.len(), number as u32);
    }
    let warning =
        all.indices.is_empty().then(|| "parameter 'isovalue': the field has no such value".to_owned());
    let parts = vec![Part::once(all, Primitives::Listed(primitives), Vertices::Nothing)];
    Ok((Geometry { parts, attributes: Rates::all(now), ids: Vec::new(), points: Vec::new() }, warning))
}
