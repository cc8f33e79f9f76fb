// SPDX-License-Identifier: GPL-3.0-or-later
//! Joins the runs that `tobj` returns into one mesh per material.
//! Source: original. Runs of one material are appended; vertices that are alike in all their values are then welded, so
//! that cutting a file into runs leaves no copies. Memory: each run is freed as soon as it was appended.
//! Proof: `tests/obj.rs::{groups_become_one_mesh_per_material, runs_are_welded}`.

use std::collections::HashMap;
use std::path::Path;

use crate::id::MaterialId;
use crate::io::clean::clean;
use crate::io::{Oddity, Warnings, polygon};
use crate::mesh::Mesh;
use crate::scene::Scene;

/// One mesh in the making per material.
pub(super) struct Assembler {
    parts: Vec<Part>,
}

#[derive(Default)]
struct Part {
    mesh: Mesh,
    runs: usize,
}

impl Assembler {
    pub(super) fn new(materials: usize) -> Self {
        Self { parts: (0..materials).map(|_| Part::default()).collect() }
    }

    /// Takes exactly the memory that `models` will need.
    pub(super) fn reserve(&mut self, models: &[tobj::Model]) {
        let mut needed = vec![[0; 2]; self.parts.len()];
        for model in models {
            if let Some([vertices, faces]) = needed.get_mut(material_of(model)) {
                *vertices += model.mesh.positions.len() / 3;
                *faces += triangles(&model.mesh);
            }
        }
        for (part, [vertices, faces]) in self.parts.iter_mut().zip(needed) {
            part.mesh.positions.reserve_exact(vertices);
            part.mesh.indices.reserve_exact(faces);
        }
    }

    /// Appends a run; its name is the number of its material.
    pub(super) fn add(&mut self, model: tobj::Model) {
        let Some(part) = self.parts.get_mut(material_of(&model)) else {
            return;
        };
        part.runs += 1;
        append(&mut part.mesh, &model.mesh);
    }

    /// The meshes that have triangles, cleaned.
    pub(super) fn finish(
        self,
        materials: &[MaterialId],
        scene: &Scene,
        path: &Path,
        warnings: &mut Warnings,
    ) -> Vec<Mesh> {
        let mut meshes = Vec::new();
        for (part, &material) in self.parts.into_iter().zip(materials) {
            let mut mesh = part.mesh;
            mesh.material = material;
            mesh.name.clone_from(&scene.material(material).name);
            if part.runs > 1 {
                weld(&mut mesh);
            }
            clean(&mut mesh, path, warnings);
            if !mesh.indices.is_empty() {
                meshes.push(mesh);
            }
        }
        let vertices = meshes.iter().map(|m| m.positions.len()).max().unwrap_or(0);
        if vertices > u32::MAX as usize {
            // Indices of 32 bits end here; no file of a size that fits today's disks comfortably gets so far.
            warnings.note(Oddity::NotShown, path, None, "more than 2^32 vertices");
            meshes.retain(|m| m.positions.len() <= u32::MAX as usize);
        }
        meshes
    }
}

fn material_of(model: &tobj::Model) -> usize {
    model.name.parse().unwrap_or(0)
}

fn triangles(mesh: &tobj::Mesh) -> usize {
    match &mesh.face_arities[..] {
        [] => mesh.indices.len() / 3,
        arities => arities.iter().map(|&n| (n as usize).saturating_sub(2)).sum(),
    }
}

fn append(mesh: &mut Mesh, run: &tobj::Mesh) {
    let base = mesh.positions.len();
    mesh.positions.extend(run.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
    let normals = run.normals.chunks_exact(3).map(|n| [n[0], n[1], n[2]]);
    let texcoords = run.texcoords.chunks_exact(2).map(|t| [t[0], t[1]]);
    let colors = run.vertex_color.chunks_exact(3).map(|c| [c[0], c[1], c[2], 1.0]);
    let count = mesh.positions.len();
    extend_or_fill(&mut mesh.normals, normals, base, count, [0.0; 3]);
    extend_or_fill(&mut mesh.texcoords, texcoords, base, count, [0.0; 2]);
    extend_or_fill(&mut mesh.colors, colors, base, count, [1.0; 4]);
    append_faces(mesh, run, base as u32);
}

/// Appends `values`, which may be none, to those of the `base` vertices before, which may have none: whoever has none
/// gets `nothing`, unless all have none.
fn extend_or_fill<T: Copy>(
    to: &mut Vec<T>,
    values: impl ExactSizeIterator<Item = T>,
    base: usize,
    count: usize,
    nothing: T,
) {
    if values.len() == 0 && to.is_empty() {
        return;
    }
    to.resize(base, nothing);
    to.extend(values);
    to.resize(count, nothing);
}

fn append_faces(mesh: &mut Mesh, run: &tobj::Mesh, base: u32) {
    if run.face_arities.is_empty() {
        mesh.indices.extend(run.indices.chunks_exact(3).map(|t| [base + t[0], base + t[1], base + t[2]]));
        return;
    }
    let (mut corners, mut cut) = (Vec::new(), Vec::new());
    let mut rest = &run.indices[..];
    for &arity in &run.face_arities {
        let (face, after) = rest.split_at(arity as usize);
        rest = after;
        corners.clear();
        corners.extend(face.iter().map(|&i| mesh.positions[(base + i) as usize]));
        cut.clear();
        polygon::triangulate(&corners, &mut cut);
        mesh.indices.extend(cut.iter().map(|t| t.map(|k| base + face[k])));
    }
}

/// Makes one vertex of those that are alike in every bit of every value.
fn weld(mesh: &mut Mesh) {
    let mut first: HashMap<[u32; 12], u32> = HashMap::with_capacity(mesh.positions.len());
    let new_index: Vec<u32> = (0..mesh.positions.len())
        .map(|i| {
            let next = first.len() as u32;
            *first.entry(bits(mesh, i)).or_insert(next)
        })
        .collect();
    drop(first);
    for i in mesh.indices.iter_mut().flatten() {
        *i = new_index[*i as usize];
    }
    keep_first(&mut mesh.positions, &new_index);
    keep_first(&mut mesh.normals, &new_index);
    keep_first(&mut mesh.texcoords, &new_index);
    keep_first(&mut mesh.colors, &new_index);
}

/// All values of a vertex as bits: 3 + 3 + 2 + 4 of them.
fn bits(mesh: &Mesh, i: usize) -> [u32; 12] {
    let mut bits = [0; 12];
    let normal = mesh.normals.get(i).into_iter().flatten();
    let texcoord = mesh.texcoords.get(i).into_iter().flatten();
    let color = mesh.colors.get(i).into_iter().flatten();
    for (slot, x) in bits.iter_mut().zip(mesh.positions[i].iter().chain(normal).chain(texcoord).chain(color))
    {
        *slot = x.to_bits();
    }
    bits
}

/// Keeps the values whose new index is the next one: those of the first vertex of each kind.
fn keep_first<T>(values: &mut Vec<T>, new_index: &[u32]) {
    let mut at = new_index.iter();
    let mut next = 0;
    values.retain(|_| {
        let first = at.next() == Some(&next);
        next += u32::from(first);
        first
    });
}
