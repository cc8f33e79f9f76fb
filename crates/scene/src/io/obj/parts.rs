// SPDX-License-Identifier: GPL-3.0-or-later
//! The faces of an OBJ file by their materials: one mesh for each material that has any.
//! A vertex of a mesh is a corner (position, texture coordinate, normal); corners that are alike are one
//! vertex, numbered in the order of their first faces. Cost: a lookup for each corner. Colours of
//! vertices are sRGB-encoded, as Blender and MeshLab write them.
//! Tests: `tests/obj.rs::{groups_become_one_mesh_per_material, corners_that_are_alike_are_one_vertex}`.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use gnurt_image::srgb;

use crate::id::MaterialId;
use crate::io::clean::clean_by;
use crate::io::corner_numbers::CornerNumbers;
use crate::io::polygon::Cutter;
use crate::io::threads::for_each;
use crate::io::{Oddity, Warnings};
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Represents a missing texture coordinate or normal.
pub(super) const NONE: u32 = u32::MAX;

/// Indices of a corner's position, texture coordinate and normal in the lists, from 0.
pub(super) type Corner = [u32; 3];

/// The elements listed by `v`, `vt` and `vn` statements.
#[derive(Default)]
pub(super) struct Lists {
    pub(super) positions: Vec<[f32; 3]>,
    /// One for each position, or none; sRGB-encoded.
    pub(super) colors: Vec<[f32; 3]>,
    pub(super) texcoords: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
}

impl Lists {
    pub(super) fn memory_bytes(&self) -> usize {
        12 * (self.positions.capacity() + self.colors.capacity() + self.normals.capacity())
            + 8 * self.texcoords.capacity()
    }
}

/// The faces of one material.
#[derive(Default)]
struct Part {
    /// The corner that each vertex is.
    vertices: Vec<Corner>,
    triangles: Vec<[u32; 3]>,
}

impl Part {
    #[inline]
    fn memory_bytes(&self) -> usize {
        size_of::<Corner>() * (self.vertices.capacity() + self.triangles.capacity())
    }

    /// The vertex of a corner; a new one is added.
    #[inline]
    fn number(&mut self, vertices: &mut CornerNumbers<3>, material: usize, corner: Corner) -> u32 {
        let next = self.vertices.len() as u32;
        let [position, texcoord, normal] = corner;
        let vertex = vertices.number(position, [material as u32, texcoord, normal], next);
        if vertex == next {
            self.vertices.push(corner);
        }
        vertex
    }
}

/// The faces of all materials.
#[derive(Default)]
pub(super) struct Parts {
    /// By the materials' numbers.
    parts: Vec<Part>,
    /// Vertices by position, part, texture coordinate and normal.
    vertices: CornerNumbers<3>,
    /// The vertices of one face.
    ring: Vec<u32>,
    bytes: usize,
}

impl Parts {
    /// About as many bytes as are held.
    pub(super) fn memory_bytes(&self) -> usize {
        self.bytes + self.parts.capacity() * size_of::<Part>() + self.vertices.memory_bytes()
    }

    /// Makes room for the faces of a material.
    #[inline]
    fn make_room(&mut self, material: usize, lists: &Lists) {
        if self.parts.len() <= material {
            self.parts.resize_with(material + 1, Part::default);
        }
        self.vertices.extend(lists.positions.len());
    }

    /// Adds a face of three corners.
    #[inline]
    pub(super) fn add_triangle(&mut self, material: usize, corners: [Corner; 3], lists: &Lists) {
        self.make_room(material, lists);
        let part = &mut self.parts[material];
        let before = part.memory_bytes();
        let triangle = corners.map(|corner| part.number(&mut self.vertices, material, corner));
        part.triangles.push(triangle);
        self.bytes += part.memory_bytes() - before;
    }

    /// Adds a face of at least three corners, cut into triangles.
    pub(super) fn add_face(
        &mut self,
        material: usize,
        corners: &[Corner],
        lists: &Lists,
        cutter: &mut Cutter,
    ) {
        self.make_room(material, lists);
        let part = &mut self.parts[material];
        let before = part.memory_bytes();
        self.ring.clear();
        self.ring.extend(corners.iter().map(|&corner| part.number(&mut self.vertices, material, corner)));
        let ring = &self.ring;
        let position = |k: usize| lists.positions[corners[k][0] as usize];
        cutter.cut(ring.len(), position, |triangle| part.triangles.push(triangle.map(|k| ring[k])));
        self.bytes += part.memory_bytes() - before;
    }

    /// The meshes that have triangles, cleaned; `materials` are those of the scene by their numbers.
    pub(super) fn into_meshes(
        self,
        lists: &Lists,
        materials: &[MaterialId],
        scene: &Scene,
        (path, threads): (&Path, usize),
        warnings: &mut Warnings,
    ) -> Vec<Mesh> {
        let Self { parts, vertices, .. } = self;
        drop(vertices);
        let jobs: Vec<_> = parts.into_iter().zip(materials).map(|job| Mutex::new(Some(job))).collect();
        let made: Vec<Mutex<Option<(Mesh, Warnings)>>> = jobs.iter().map(|_| Mutex::default()).collect();
        for_each(threads, jobs.len(), &|i| {
            let Some((part, &material)) = jobs[i].lock().unwrap_or_else(PoisonError::into_inner).take()
            else {
                return;
            };
            let mut warnings = Warnings::default();
            let mut mesh = Mesh::default();
            if part.vertices.len() > u32::MAX as usize {
                // Indices of 32 bits end here; no file of a size that fits today's disks comfortably gets so far.
                warnings.note(Oddity::NotShown, path, None, "more than 2^32 vertices of one material");
            } else {
                mesh = part.into_mesh(lists);
                mesh.material = material;
                mesh.name.clone_from(&scene.material(material).name);
                clean_by(&mut mesh, path, &mut warnings, if jobs.len() == 1 { threads } else { 1 });
            }
            *made[i].lock().unwrap_or_else(PoisonError::into_inner) = Some((mesh, warnings));
        });
        let made =
            made.into_iter().filter_map(|made| made.into_inner().unwrap_or_else(PoisonError::into_inner));
        let meshes = made.map(|(mesh, more)| {
            warnings.append(more);
            mesh
        });
        meshes.filter(|mesh| !mesh.indices.is_empty()).collect()
    }
}

impl Part {
    fn into_mesh(self, lists: &Lists) -> Mesh {
        let vertices = &self.vertices;
        let mut mesh = Mesh {
            positions: vertices.iter().map(|c| lists.positions[c[0] as usize]).collect(),
            ..Mesh::default()
        };
        // A vertex without the attribute, among others with it, gets zeros, which mean no value.
        if vertices.iter().any(|c| c[1] != NONE) {
            let texcoord = |c: &Corner| lists.texcoords.get(c[1] as usize).copied().unwrap_or_default();
            mesh.texcoords = vertices.iter().map(texcoord).collect();
        }
        if vertices.iter().any(|c| c[2] != NONE) {
            let normal = |c: &Corner| lists.normals.get(c[2] as usize).copied().unwrap_or_default();
            mesh.normals = vertices.iter().map(normal).collect();
        }
        if !lists.colors.is_empty() {
            let color = |c: &Corner| {
                let [r, g, b] = lists.colors[c[0] as usize].map(srgb::decode);
                [r, g, b, 1.0]
            };
            mesh.colors = vertices.iter().map(color).collect();
        }
        mesh.indices = self.triangles;
        mesh.indices.shrink_to_fit();
        mesh
    }
}
