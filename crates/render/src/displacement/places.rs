// SPDX-License-Identifier: GPL-3.0-or-later
//! Vertices of an object by their positions, and the normals that those at one position share.
//! Space: object. Invariant: results do not depend on the number of threads. Tests: crates/render/tests/displacement.rs.

use std::sync::Arc;

use glam::Vec3;
use gnurt_scene::Mesh;
use rayon::prelude::*;

/// Normals of vertices at one position are averaged if the cosine between them is above this: others are at hard edges.
const SMOOTH: f32 = 0.999;

/// Positions are equal if they are when rounded to this part of the largest coordinate.
const ROUNDING: f64 = 1.0 / (1 << 22) as f64;

/// More vertices at one position than these are averaged without comparing each with each.
const MANY: usize = 64;

/// The vertices of some meshes, sorted by position. A vertex has a number among those of all meshes.
pub(super) struct Places {
    /// The number of the first vertex of each mesh, and the end.
    first: Vec<usize>,
    /// All vertices; those at one position follow each other.
    order: Vec<u32>,
    /// Where those of each position begin in `order`, and the end.
    begins: Vec<u32>,
}

impl Places {
    /// Of meshes with fewer than 2^32 vertices.
    pub(super) fn of(meshes: &[Arc<Mesh>]) -> Self {
        let mut first = vec![0];
        for mesh in meshes {
            first.push(first[first.len() - 1] + mesh.positions.len());
        }
        let positions = || meshes.iter().flat_map(|mesh| &mesh.positions);
        let most = positions().flatten().filter(|x| x.is_finite()).fold(0.0_f32, |most, x| most.max(x.abs()));
        // What is computed twice, as the ends of a circle, may differ by its rounding.
        let cell = f64::from(most.max(f32::MIN_POSITIVE)) * ROUNDING;
        let cell_of = |p: &[f32; 3]| p.map(|x| (f64::from(x) / cell).round() as i32);
        let mut keyed: Vec<([i32; 3], u32)> = positions().map(cell_of).zip(0u32..).collect();
        keyed.par_sort_unstable();
        let mut begins: Vec<u32> = Vec::new();
        let mut last = None;
        for (i, (cell, _)) in (0u32..).zip(&keyed) {
            if last != Some(cell) {
                begins.push(i);
                last = Some(cell);
            }
        }
        begins.push(keyed.len() as u32);
        Self { first, order: keyed.into_iter().map(|(_, vertex)| vertex).collect(), begins }
    }

    /// How many vertices there are.
    pub(super) fn vertices(&self) -> usize {
        self.order.len()
    }

    /// The numbers of a mesh's vertices.
    pub(super) fn of_mesh(&self, mesh: usize) -> std::ops::Range<usize> {
        self.first[mesh]..self.first[mesh + 1]
    }

    /// The vertices of each position, ascending.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.begins.windows(2).map(|ends| &self.order[ends[0] as usize..ends[1] as usize])
    }

    /// The mean direction of the vertices at each position, for each vertex; zero where there is none.
    pub(super) fn directions(&self, normals: &[Vec3]) -> Vec<Vec3> {
        let mut shared = vec![Vec3::ZERO; self.vertices()];
        for place in self.iter() {
            let sum: Vec3 = place.iter().map(|&i| normals[i as usize]).sum();
            let direction = sum.normalize_or_zero();
            place.iter().for_each(|&i| shared[i as usize] = direction);
        }
        shared
    }

    /// Normals after vertices have moved, for those in `touched`: sums of `now` over the vertices at a position whose normals
    /// were alike, on the sides that they were on. `old` are the unit normals before, zero without one, and `faces`
    /// the sums of the triangles' normals then.
    pub(super) fn smoothed(&self, old: &[Vec3], faces: &[Vec3], now: &[Vec3], touched: &[bool]) -> Vec<Vec3> {
        let side = |i: usize| if faces[i].dot(old[i]) < 0.0 { -now[i] } else { now[i] };
        let mut found = old.to_vec();
        for place in self.iter().filter(|place| place.iter().any(|&i| touched[i as usize])) {
            for &i in place {
                let i = i as usize;
                if old[i] == Vec3::ZERO {
                    continue;
                }
                let is_like = |j: usize| place.len() > MANY || old[j].dot(old[i]) > SMOOTH;
                let others =
                    place.iter().map(|&j| j as usize).filter(|&j| old[j] != Vec3::ZERO && is_like(j));
                found[i] = others.map(side).sum::<Vec3>().try_normalize().unwrap_or(old[i]);
            }
        }
        found
    }
}

/// Sums of the normals of the triangles around each vertex, weighted by their angles there.
pub(super) fn face_sums(positions: &[[f32; 3]], indices: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for corners in indices {
        let at = |k: usize| positions.get(corners[k % 3] as usize).map(|&p| Vec3::from(p));
        let (Some(a), Some(b), Some(c)) = (at(0), at(1), at(2)) else { continue };
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        for (k, p) in [a, b, c].into_iter().enumerate() {
            let [Some(next), Some(last)] = [at(k + 1), at(k + 2)] else { continue };
            let angle = (next - p).angle_between(last - p);
            if angle.is_finite() {
                sums[corners[k] as usize] += normal * angle;
            }
        }
    }
    sums
}

/// The unit normals of a mesh's vertices; sums of its triangles' where it is flat.
pub(super) fn own_normals(mesh: &Mesh) -> Vec<Vec3> {
    if mesh.normals.is_empty() {
        return face_sums(&mesh.positions, &mesh.indices);
    }
    mesh.normals.iter().map(|&n| Vec3::from(n).normalize_or_zero()).collect()
}
