// SPDX-License-Identifier: GPL-3.0-or-later
//! Leaves out triangles that cannot be hit and numbers that are none, and counts them.
//! See docs/reference/cli.md. Space: object.
//! Invariant: afterwards every position is finite and every triangle has an area above zero (in double precision).
//! Tests: `tests::{drops_and_counts, keeps_what_is_good}`.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::threads::for_each;
use super::warnings::{Oddity, Warnings};
use crate::mesh::Mesh;
use crate::waste::has_area;

/// Triangles that a thread looks at, at a time.
const TRIANGLES: usize = 1 << 15;

/// Cleans a mesh that came from `path`. Its indices must be in range and its optional arrays empty or full.
pub fn clean(mesh: &mut Mesh, path: &Path, warnings: &mut Warnings) {
    clean_by(mesh, path, warnings, 1);
}

/// The same on up to this many threads.
pub fn clean_by(mesh: &mut Mesh, path: &Path, warnings: &mut Warnings, threads: usize) {
    let dropped = drop_triangles(mesh, path, warnings, threads);
    if dropped || !are_finite(mesh.positions.as_flattened()) {
        mesh.drop_unused_vertices();
    }
    let replaced = clean_attributes(mesh);
    warnings.note_many(Oddity::BadAttribute, replaced, path, None, in_mesh(mesh));
}

/// Replaces normals, texture coordinates, tangents and colours that are not finite; returns their number.
pub fn clean_attributes(mesh: &mut Mesh) -> u64 {
    replace_bad(&mut mesh.normals, [0.0; 3])
        + replace_bad(&mut mesh.texcoords, [0.0; 2])
        + replace_bad(&mut mesh.tangents, [0.0; 4])
        + replace_bad(&mut mesh.colors, [1.0; 4])
}

fn in_mesh(mesh: &Mesh) -> String {
    if mesh.name.is_empty() { String::new() } else { format!("in {}", mesh.name) }
}

/// Whether all values are finite. Without a branch for each value.
fn are_finite(values: &[f32]) -> bool {
    /// The exponent of infinity and of what is no number.
    const EXPONENT: u32 = f32::INFINITY.to_bits();
    let is_bad = |x: &f32| x.to_bits() & EXPONENT == EXPONENT;
    !values.chunks(4096).any(|chunk| chunk.iter().fold(false, |bad, x| bad | is_bad(x)))
}

/// Whether all triangles have an area.
fn have_areas(mesh: &Mesh, threads: usize) -> bool {
    let good = |triangle: &[u32; 3]| has_area(triangle.map(|i| mesh.positions[i as usize]));
    if threads == 1 || mesh.indices.len() < 2 * TRIANGLES {
        return mesh.indices.iter().all(good);
    }
    let are_good = AtomicBool::new(true);
    for_each(threads, mesh.indices.len().div_ceil(TRIANGLES), &|i| {
        let all = &mesh.indices[i * TRIANGLES..];
        if are_good.load(Ordering::Relaxed) && !all[..all.len().min(TRIANGLES)].iter().all(good) {
            are_good.store(false, Ordering::Relaxed);
        }
    });
    are_good.into_inner()
}

/// Drops triangles that are not finite or have no area; returns whether there was any.
fn drop_triangles(mesh: &mut Mesh, path: &Path, warnings: &mut Warnings, threads: usize) -> bool {
    let before = mesh.indices.len();
    let (mut not_finite, mut zero_area) = (0, 0);
    // Few meshes have bad triangles: looking is faster than moving.
    if have_areas(mesh, threads) {
        return false;
    }
    let positions = &mesh.positions;
    mesh.indices.retain(|triangle| {
        let corners = triangle.map(|i| positions[i as usize]);
        let finite = corners.as_flattened().iter().all(|x| x.is_finite());
        let keep = has_area(corners);
        not_finite += u64::from(!finite);
        zero_area += u64::from(finite && !keep);
        keep
    });
    warnings.note_many(Oddity::NotFiniteTriangle, not_finite, path, None, in_mesh(mesh));
    warnings.note_many(Oddity::ZeroAreaTriangle, zero_area, path, None, in_mesh(mesh));
    mesh.indices.len() != before
}

/// Replaces values with a component that is not finite; returns their number.
pub fn replace_bad<const N: usize>(values: &mut [[f32; N]], by: [f32; N]) -> u64 {
    if are_finite(values.as_flattened()) {
        return 0;
    }
    let mut replaced = 0;
    for value in values.iter_mut().filter(|v| !v.iter().all(|x| x.is_finite())) {
        *value = by;
        replaced += 1;
    }
    replaced
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drops_and_counts() {
        let mut mesh = Mesh {
            positions: vec![[0.0; 3], [f32::NAN; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]],
            normals: vec![[0.0, 0.0, f32::INFINITY], [0.0; 3], [0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]],
            indices: vec![[0, 1, 2], [0, 2, 3], [0, 2, 4], [0, 0, 3]],
            ..Mesh::default()
        };
        let mut warnings = Warnings::default();
        clean(&mut mesh, Path::new("t.ply"), &mut warnings);
        assert_eq!(mesh.indices, [[0, 1, 2]], "the good triangle, renumbered");
        assert_eq!(mesh.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "its corners");
        assert_eq!(mesh.normals, [[0.0; 3], [0.0, 0.0, 1.0], [0.0; 3]], "the infinite normal says nothing");
        assert_eq!(warnings.count(Oddity::NotFiniteTriangle), 1, "one NaN");
        assert_eq!(warnings.count(Oddity::ZeroAreaTriangle), 2, "one line, one point twice");
        assert_eq!(warnings.count(Oddity::BadAttribute), 1, "one normal");
    }

    #[test]
    fn keeps_what_is_good() {
        // A sliver far from the origin: its area underflows in single precision, not in double.
        let tiny = 1e-25;
        let mut mesh = Mesh {
            positions: vec![[0.0; 3], [tiny, 0.0, 0.0], [0.0, tiny, 0.0], [5.0; 3]],
            indices: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let before = mesh.clone();
        let mut warnings = Warnings::default();
        clean(&mut mesh, Path::new("t.ply"), &mut warnings);
        assert_eq!(mesh, before, "small is not degenerate, and a vertex nobody uses does no harm");
        assert!(warnings.is_empty(), "nothing to say");
    }
}
