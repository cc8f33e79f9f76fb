// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF primitives as meshes.
//! Source: glTF 2.0 section 3.7. Triangles, strips and fans; points and lines are left out with a warning.
//! Space: that of the mesh; v is flipped upwards. Tests: `tests/gltf.rs`.

use super::accessor::{indices, packed_triangles};
use super::decoded::Decoded;
use super::document::Document;
use super::draco;
use super::json::{self, Index, Primitive};
use super::material::AddedMaterial;
use super::primitive::PrimitiveReader;
use super::skin::{Bending, Parts};
use super::variants::material_of;
use gnurt_scene::animation::reverse_mirrored;
use gnurt_scene::io::reader::{clean_attributes, clean_by, replace_bad};
use gnurt_scene::io::{Error, Oddity, Warnings};
use gnurt_scene::mesh::{Attribute, Mesh, Rate, TEXCOORD_1};
use gnurt_scene::tangents;
use gnurt_scene::texture::TexcoordSet;

/// Bytes of a mesh of the scene, without its arrays and its name.
const MESH_BYTES: usize = 512;

/// Bytes that a corner takes as an index and in triangles.
const CORNER_BYTES: usize = 4 + size_of::<[u32; 3]>();

/// How the vertices of a primitive make triangles.
#[derive(Clone, Copy)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

/// The meshes of all primitives of `from`, glTF mesh `index`, as `bending` deforms them at rest, with the
/// data that deforms them later.
pub(super) fn read(
    document: &Document<'_>,
    index: Index,
    from: &json::Mesh<'_>,
    bending: &Bending,
    materials: &[AddedMaterial],
    warnings: &mut Warnings,
) -> Result<Vec<(Mesh, Option<Parts>)>, Error> {
    let unnamed = || format!("mesh {}", index.0);
    let name = from.name.clone().unwrap_or_else(unnamed);
    let mut meshes = Vec::new();
    for k in 0..from.primitives.len() {
        let location = format!("meshes[{}].primitives[{k}]", index.0);
        let primitive: Primitive = document.get(&from.primitives, Index(k as u32), &location, "primitive")?;
        let before = document.budget().held();
        let decoded = draco::decode(document, &primitive, &location, warnings)?;
        let reader = PrimitiveReader { document, primitive: &primitive, location: &location, decoded };
        let read = reader.mesh(bending, materials, warnings)?;
        drop(reader);
        let Some((mut mesh, mut parts)) = read else {
            document.budget().settle(before);
            continue;
        };
        clean_by(&mut mesh, &document.path, warnings, document.access.threads());
        document.budget().settle(before);
        if let Some(parts) = &mut parts {
            document.hold(parts.memory_bytes() + name.len() + MESH_BYTES, &location)?;
            clean_attributes(&mut parts.base);
            parts.base.name.clone_from(&name);
        }
        // A triangle without area at rest may have one later.
        if !mesh.indices.is_empty() || parts.is_some() {
            document.hold(mesh.memory_bytes() + name.len() + MESH_BYTES, &location)?;
            mesh.name.clone_from(&name);
            meshes.push((mesh, parts));
        }
    }
    Ok(meshes)
}

impl PrimitiveReader<'_> {
    fn mesh(
        &self,
        bending: &Bending,
        materials: &[AddedMaterial],
        warnings: &mut Warnings,
    ) -> Result<Option<(Mesh, Option<Parts>)>, Error> {
        let path = &self.document.path;
        let mode = match self.primitive.mode {
            4 => Mode::Triangles,
            5 => Mode::Strip,
            6 => Mode::Fan,
            0 if self.primitive.extensions.splats.is_some() => {
                let detail = format!("{}: Gaussian splats (KHR_gaussian_splatting)", self.location);
                warnings.note(Oddity::NotShown, path, None, detail);
                return Ok(None);
            }
            0..=3 => {
                warnings.note(Oddity::PointsOrLines, path, None, self.location);
                return Ok(None);
            }
            _ => return Err(self.document.error(self.location, "unknown mode", "expected 0 to 6")),
        };
        let attributes = &self.primitive.attributes;
        let Some(positions) = attributes.positions else {
            warnings.note(Oddity::NotShown, path, None, format!("{}: no positions", self.location));
            return Ok(None);
        };
        let default = materials.len() - 1;
        let material = match material_of(self.primitive, self.document.variant) {
            Some(index) if index.value() < default => materials[index.value()],
            Some(index) => {
                let problem = format!("material {} does not exist", index.0);
                return Err(self.document.error(self.location, problem, ""));
            }
            None => materials[default],
        };
        let positions = self.floats::<3>(positions)?;
        let count = positions.len();
        let texcoords =
            |set: u32| attributes.texcoords.iter().find(|(n, _)| *n == set).map(|&(_, index)| index);
        let mut mesh = Mesh {
            positions,
            normals: self.optional::<3>(attributes.normals, count, warnings)?,
            texcoords: self.optional::<2>(texcoords(material.texcoord_set), count, warnings)?,
            tangents: self.tangents(material, count, warnings)?,
            colors: self.colors(count, warnings)?,
            material: material.id,
            ..Mesh::default()
        };
        for [_, v] in &mut mesh.texcoords {
            *v = 1.0 - *v;
        }
        let second = material.second_set.and_then(texcoords);
        let mut second = self.optional::<2>(second, count, warnings)?;
        let broken = replace_bad(&mut second, [0.0; 2]);
        warnings.note_many(Oddity::BadAttribute, broken, path, None, self.location);
        second.iter_mut().for_each(|[_, v]| *v = 1.0 - *v);
        let mut triangles = self.triangles(mode, count)?;
        if let Some(set) = material.tangents.filter(|_| mesh.tangents.is_empty()) {
            let held = self.document.budget().held();
            self.document
                .hold(gnurt_scene::io::reader::TANGENT_BYTES_PER_TRIANGLE * triangles.len(), self.location)?;
            mesh.indices = triangles;
            let is_second = set == TexcoordSet::Second;
            if is_second {
                std::mem::swap(&mut mesh.texcoords, &mut second);
            }
            mesh.tangents = tangents(&mesh);
            if is_second {
                std::mem::swap(&mut mesh.texcoords, &mut second);
            }
            self.document.budget().settle(held);
            self.document.hold(size_of_val(&mesh.tangents[..]), self.location)?;
            triangles = std::mem::take(&mut mesh.indices);
        }
        if !second.is_empty() {
            self.document.hold(size_of_val(&second[..]), self.location)?;
            mesh.attributes.push(Attribute {
                name: TEXCOORD_1.to_owned(),
                rate: Rate::Vertex,
                components: 2,
                data: second.into_flattened(),
            });
        }
        self.bent(bending, mesh, triangles, warnings)
    }

    /// The mesh and its triangles at rest, with the data that deforms them later.
    fn bent(
        &self,
        bending: &Bending,
        mut mesh: Mesh,
        triangles: Vec<[u32; 3]>,
        warnings: &mut Warnings,
    ) -> Result<Option<(Mesh, Option<Parts>)>, Error> {
        let count = mesh.positions.len();
        let (parts, mirrored) = bending.bend(self, &mut mesh, warnings)?;
        mesh.indices = triangles;
        let parts = match parts {
            Some(parts) => {
                self.document.hold(size_of_val(&mesh.indices[..]) + 6 * count, self.location)?;
                parts.with_triangles(mesh.indices.clone())
            }
            None => None,
        };
        if let Some(mirrored) = mirrored {
            reverse_mirrored(&mut mesh.indices, &mirrored);
        }
        mesh.drop_unused_vertices();
        Ok(Some((mesh, parts)))
    }

    /// An attribute that may be missing; one of a wrong length is left out with a warning.
    fn optional<const N: usize>(
        &self,
        index: Option<Index>,
        count: usize,
        warnings: &mut Warnings,
    ) -> Result<Vec<[f32; N]>, Error> {
        let Some(index) = index else {
            return Ok(Vec::new());
        };
        let values = self.floats::<N>(index)?;
        if values.len() != count {
            let detail = format!("{}: {} values for {count} vertices", self.location, values.len());
            warnings.note(Oddity::BadAttribute, &self.document.path, None, detail);
            return Ok(Vec::new());
        }
        Ok(values)
    }

    /// Tangents, where a normal map is to be read by them. Like the map's green, their fourth number refers
    /// to v upwards. Without normals they mean nothing.
    fn tangents(
        &self,
        material: AddedMaterial,
        count: usize,
        warnings: &mut Warnings,
    ) -> Result<Vec<[f32; 4]>, Error> {
        if material.tangents.is_none() || self.primitive.attributes.normals.is_none() {
            return Ok(Vec::new());
        }
        self.optional::<4>(self.primitive.attributes.tangents, count, warnings)
    }

    /// Colours with or without opacity; linear by definition.
    fn colors(&self, count: usize, warnings: &mut Warnings) -> Result<Vec<[f32; 4]>, Error> {
        let Some(index) = self.primitive.attributes.colors else {
            return Ok(Vec::new());
        };
        let has_opacity = match self.decoded.as_ref().and_then(|decoded| decoded.array(index)) {
            Some(array) => array.components == 4,
            None => {
                let accessor: json::Accessor<'_> =
                    self.document.get(&self.document.root.accessors, index, self.location, "accessor")?;
                &*accessor.shape == "VEC4"
            }
        };
        if has_opacity {
            return self.optional::<4>(Some(index), count, warnings);
        }
        let colors = self.optional::<3>(Some(index), count, warnings)?;
        self.document.hold(size_of::<[f32; 4]>() * colors.len(), self.location)?;
        Ok(colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
    }

    /// The triangles of a stream, whatever the mode: a strip was divided before it was compressed.
    fn decoded_triangles(&self, decoded: &Decoded, count: usize) -> Result<Vec<[u32; 3]>, Error> {
        if let Some(bad) = decoded.triangles.as_flattened().iter().find(|&&i| i as usize >= count) {
            let problem = format!("vertex index {bad} out of range; there are {count} vertices");
            return Err(self.document.error(self.location, problem, "write the file again"));
        }
        self.document.hold(CORNER_BYTES * 3 * decoded.triangles.len(), self.location)?;
        Ok(decoded.triangles.clone())
    }

    /// That indices of vertices are in range, unless they end a strip or fan.
    fn check_corners(&self, order: &[u32], count: usize, restart: Option<u32>) -> Result<(), Error> {
        // That one is bad is found sooner than the first one. Signed comparisons are those that all processors have.
        let limit = i32::try_from(count).unwrap_or(i32::MAX);
        let may_be_bad = order.iter().fold(false, |bad, &i| bad | (i as i32 >= limit) | ((i as i32) < 0));
        let bad = |i: &&u32| **i as usize >= count && Some(**i) != restart;
        if let Some(bad) = order.iter().filter(|_| may_be_bad).find(bad) {
            let remedy = if count == 0 {
                "there are no vertices".into()
            } else {
                format!("expected 0 to {}", count - 1)
            };
            return Err(self.document.error(
                self.location,
                format!("vertex index {bad} out of range"),
                &remedy,
            ));
        }
        Ok(())
    }

    fn triangles(&self, mode: Mode, count: usize) -> Result<Vec<[u32; 3]>, Error> {
        if let Some(decoded) = &self.decoded {
            return self.decoded_triangles(decoded, count);
        }
        if let (Mode::Triangles, false, Some(index)) =
            (mode, self.document.has_restarts, self.primitive.indices)
            && let Some(triangles) = packed_triangles(self.document, index, self.location)?
        {
            self.check_corners(triangles.as_flattened(), count, None)?;
            return Ok(triangles);
        }
        let (order, restart) = match self.primitive.indices {
            Some(index) => indices(self.document, index, self.location)?,
            None => {
                // Each vertex is the corner of up to three triangles.
                self.document.hold(CORNER_BYTES * count, self.location)?;
                ((0..u32::try_from(count).unwrap_or(u32::MAX)).collect(), u32::MAX)
            }
        };
        // Without the extension it is an index like others.
        let restart = Some(restart).filter(|_| self.document.has_restarts);
        self.check_corners(&order, count, restart)?;
        let runs = order.split(|&i| Some(i) == restart);
        Ok(match mode {
            Mode::Strip => {
                let turned = |(k, t): (usize, &[u32])| {
                    if k % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] }
                };
                runs.flat_map(|run| run.windows(3).enumerate().map(turned)).collect()
            }
            Mode::Fan => {
                let of_run =
                    |run: &[u32]| run.windows(2).skip(1).map(|e| [e[0], e[1], run[0]]).collect::<Vec<_>>();
                runs.flat_map(of_run).collect()
            }
            Mode::Triangles if restart.is_none() => order.as_chunks::<3>().0.to_vec(),
            Mode::Triangles => runs.flat_map(|run| run.chunks_exact(3).map(|t| [t[0], t[1], t[2]])).collect(),
        })
    }
}
