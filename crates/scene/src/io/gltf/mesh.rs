// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF primitives as meshes.
//! Source: glTF 2.0 section 3.7. Triangles, strips and fans; points and lines are left out with a warning.
//! Space: that of the mesh; v is turned upwards. Proof: `tests/gltf.rs`.

use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{self, Index};

use super::accessor::{floats, integers};
use super::document::Document;
use super::material::AddedMaterial;
use super::skin::Pose;
use crate::io::clean::{clean, drop_unused_vertices};
use crate::io::{Error, Oddity, Warnings};
use crate::mesh::Mesh;

/// The meshes of all primitives of glTF mesh `index`, bent by `pose`.
pub(super) fn read(
    document: &Document,
    index: Index<json::Mesh>,
    pose: &Pose,
    materials: &[AddedMaterial],
    warnings: &mut Warnings,
) -> Result<Vec<Mesh>, Error> {
    let from = document.get(index, "nodes", "mesh")?;
    let name = from.name.clone().unwrap_or_else(|| format!("mesh {}", index.value()));
    let mut meshes = Vec::new();
    for (k, primitive) in from.primitives.iter().enumerate() {
        let place = format!("meshes[{}].primitives[{k}]", index.value());
        let reader = PrimitiveReader { document, primitive, place: &place };
        let Some(mut mesh) = reader.mesh(pose, materials, warnings)? else {
            continue;
        };
        mesh.name.clone_from(&name);
        clean(&mut mesh, &document.path, warnings);
        if !mesh.indices.is_empty() {
            meshes.push(mesh);
        }
    }
    Ok(meshes)
}

/// One primitive and where it stands.
pub(super) struct PrimitiveReader<'a> {
    pub(super) document: &'a Document,
    pub(super) primitive: &'a Primitive,
    pub(super) place: &'a str,
}

impl PrimitiveReader<'_> {
    /// The accessor of an attribute.
    pub(super) fn attribute(&self, semantic: Semantic) -> Option<Index<Accessor>> {
        self.primitive.attributes.get(&Checked::Valid(semantic)).copied()
    }

    fn mesh(
        &self,
        pose: &Pose,
        materials: &[AddedMaterial],
        warnings: &mut Warnings,
    ) -> Result<Option<Mesh>, Error> {
        let path = &self.document.path;
        let mode = match self.primitive.mode.as_ref() {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => *mode,
            Checked::Valid(_) => {
                warnings.note(Oddity::PointsOrLines, path, None, self.place);
                return Ok(None);
            }
            Checked::Invalid => {
                return Err(self.document.error(self.place, "unknown mode", "expected 0 to 6"));
            }
        };
        let Some(positions) = self.attribute(Semantic::Positions) else {
            warnings.note(Oddity::NotShown, path, None, format!("{}: no positions", self.place));
            return Ok(None);
        };
        let default = materials.len() - 1;
        let material = match self.primitive.material {
            Some(index) => {
                self.document.get(index, self.place, "material")?;
                materials[index.value()]
            }
            None => materials[default],
        };
        let positions = floats::<3>(self.document, positions, self.place)?;
        let count = positions.len();
        let mut mesh = Mesh {
            positions,
            normals: self.optional::<3>(Semantic::Normals, count, warnings)?,
            texcoords: self.optional::<2>(Semantic::TexCoords(material.texcoord_set), count, warnings)?,
            colors: self.colors(count, warnings)?,
            material: material.id,
            ..Mesh::default()
        };
        for [_, v] in &mut mesh.texcoords {
            *v = 1.0 - *v;
        }
        pose.bend(self, &mut mesh)?;
        mesh.indices = self.triangles(mode, count)?;
        drop_unused_vertices(&mut mesh);
        Ok(Some(mesh))
    }

    /// An attribute that may be missing; one of a wrong length is left out with a warning.
    fn optional<const N: usize>(
        &self,
        semantic: Semantic,
        count: usize,
        warnings: &mut Warnings,
    ) -> Result<Vec<[f32; N]>, Error> {
        let Some(index) = self.attribute(semantic) else {
            return Ok(Vec::new());
        };
        let values = floats::<N>(self.document, index, self.place)?;
        if values.len() != count {
            let detail = format!("{}: {} values for {count} vertices", self.place, values.len());
            warnings.note(Oddity::BadAttribute, &self.document.path, None, detail);
            return Ok(Vec::new());
        }
        Ok(values)
    }

    /// Colours with or without opacity; linear by definition.
    fn colors(&self, count: usize, warnings: &mut Warnings) -> Result<Vec<[f32; 4]>, Error> {
        let Some(index) = self.attribute(Semantic::Colors(0)) else {
            return Ok(Vec::new());
        };
        let accessor = self.document.get(index, self.place, "accessor")?;
        if accessor.type_ == Checked::Valid(json::accessor::Type::Vec4) {
            return self.optional::<4>(Semantic::Colors(0), count, warnings);
        }
        let colors = self.optional::<3>(Semantic::Colors(0), count, warnings)?;
        Ok(colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
    }

    fn triangles(&self, mode: Mode, count: usize) -> Result<Vec<[u32; 3]>, Error> {
        let order = match self.primitive.indices {
            Some(index) => integers(self.document, index, self.place)?,
            None => (0..u32::try_from(count).unwrap_or(u32::MAX)).collect(),
        };
        if let Some(bad) = order.iter().find(|&&i| i as usize >= count) {
            let remedy = if count == 0 {
                "there are no vertices".into()
            } else {
                format!("expected 0 to {}", count - 1)
            };
            return Err(self.document.error(self.place, format!("vertex index {bad} out of range"), &remedy));
        }
        Ok(match mode {
            Mode::TriangleStrip => {
                let turned = |(k, t): (usize, &[u32])| {
                    if k % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] }
                };
                order.windows(3).enumerate().map(turned).collect()
            }
            Mode::TriangleFan => order.windows(2).skip(1).map(|edge| [edge[0], edge[1], order[0]]).collect(),
            _ => order.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        })
    }
}
