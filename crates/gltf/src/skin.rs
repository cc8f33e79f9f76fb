// SPDX-License-Identifier: GPL-3.0-or-later
//! The deformation of a primitive: morph targets and the joints of a skin, read from the file, and its pose
//! at rest.
//! Source: glTF 2.0 sections 3.7.2.2 (morph targets) and 3.7.3 (skins). All sets of joints count;
//! `animation/body.rs` defines the deformation.
//! Space: a skinned mesh comes out in world space, for its node's own transform does not count.
//! Tests: `tests/gltf.rs::{morph_weights_move_vertices, skins_follow_their_joints}`, `tests/animation.rs`.

use super::json::{Index, Target};
use super::primitive::PrimitiveReader;
use gnurt_scene::affine::Affine;
use gnurt_scene::animation::{
    Attachment, Bend, Deltas, Influences, Morph, Skin, add_morph, follow_joints, mirrored,
};
use gnurt_scene::io::{Error, Oddity, Warnings};
use gnurt_scene::mesh::Mesh;

/// How a node bends its mesh.
pub(super) struct Bending {
    rest: Bend,
    is_skinned: bool,
    /// Whether the deformation changes later.
    moves: bool,
}

/// The data that deforms a mesh at any time.
pub(super) struct Parts {
    /// The mesh as nothing bends it.
    pub(super) base: Mesh,
    pub(super) morphs: Vec<Morph>,
    pub(super) influences: Option<Influences>,
}

impl Bending {
    /// With these weights, and the joints of a skin with their matrices, at rest; `are_driven` = the weights change.
    pub(super) fn new(weights: &[f32], skin: Option<&(Skin, Vec<Affine>)>, are_driven: bool) -> Self {
        let bends = weights.iter().any(|&w| w != 0.0 && w.is_finite());
        let weights = if bends { weights.to_vec() } else { Vec::new() };
        let joints = skin.map(|(_, at_rest)| at_rest.clone()).unwrap_or_default();
        let stretches = skin.is_some_and(|(skin, _)| skin.stretches);
        let joint_moves = |(skin, _): &(Skin, _)| {
            skin.joints.iter().any(|joint| matches!(joint.attachment, Attachment::On(_)))
        };
        Self {
            rest: Bend { weights, joints, stretches },
            is_skinned: skin.is_some(),
            moves: are_driven || skin.is_some_and(joint_moves),
        }
    }

    /// Moves positions, normals and tangents of a primitive's mesh, which has no triangles yet, to the rest
    /// pose. Returns the data that deforms it later, if any, and the mirrored vertices, if any.
    pub(super) fn bend(
        &self,
        from: &PrimitiveReader<'_>,
        mesh: &mut Mesh,
        warnings: &mut Warnings,
    ) -> Result<(Option<Parts>, Option<Vec<bool>>), Error> {
        let base = match self.moves {
            true => {
                from.document.hold(mesh.memory_bytes(), from.location)?;
                Some(mesh.clone())
            }
            false => None,
        };
        let mut morphs = Vec::new();
        if self.moves {
            let count = from.primitive.targets.len();
            from.document.hold(size_of::<Morph>() * count, from.location)?;
            morphs.reserve_exact(count);
        }
        let weights = self.rest.weights.iter().copied();
        let weights: Box<dyn Iterator<Item = f32>> = match self.moves {
            true => Box::new(weights.chain(std::iter::repeat(0.0))),
            false => Box::new(weights),
        };
        for (target, weight) in from.primitive.targets.iter().zip(weights) {
            if !self.moves && (weight == 0.0 || !weight.is_finite()) {
                continue;
            }
            let before = from.document.budget().held();
            let morph = from.morph(target, mesh, warnings)?;
            add_morph(&morph, weight, mesh);
            match self.moves {
                true => morphs.push(morph),
                false => from.document.budget().settle(before),
            }
        }
        let influences =
            if self.is_skinned { from.influences(mesh, self.rest.joints.len(), warnings)? } else { None };
        let mut turned = None;
        if let Some(influences) = &influences {
            follow_joints(influences, &self.rest, mesh);
            turned = mirrored(influences, &self.rest);
        }
        Ok((base.map(|base| Parts { base, morphs, influences }), turned))
    }
}

impl Parts {
    /// For triangles of these corners: only those that can ever have an area, and their vertices. `None` if
    /// there are none.
    pub(super) fn with_triangles(mut self, mut triangles: Vec<[u32; 3]>) -> Option<Self> {
        let count = self.base.positions.len();
        let is_finite: Vec<bool> =
            self.base.positions.iter().map(|p| p.iter().all(|x| x.is_finite())).collect();
        triangles.retain(|&[a, b, c]| {
            a != b && b != c && c != a && [a, b, c].iter().all(|&i| is_finite[i as usize])
        });
        let mut used = vec![false; count];
        triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
        let retained: Vec<u32> = (0..count as u32).filter(|&i| used[i as usize]).collect();
        self.base.indices = triangles;
        if retained.len() < count {
            for morph in &mut self.morphs {
                for deltas in [&mut morph.positions, &mut morph.normals, &mut morph.tangents] {
                    *deltas = deltas.keep(&retained);
                }
            }
            self.influences = self.influences.map(|influences| influences.keep(&retained));
            self.base.drop_unused_vertices();
        }
        (!retained.is_empty()).then_some(self)
    }

    /// Bytes that it holds.
    pub(super) fn memory_bytes(&self) -> usize {
        let of = |m: &Morph| m.memory_bytes() + size_of::<Morph>();
        self.base.memory_bytes()
            + self.morphs.iter().map(of).sum::<usize>()
            + self.influences.as_ref().map_or(0, Influences::memory_bytes)
    }
}

impl PrimitiveReader<'_> {
    /// A morph target of a primitive whose mesh is `mesh`.
    fn morph(&self, target: &Target, mesh: &Mesh, warnings: &mut Warnings) -> Result<Morph, Error> {
        let mut deltas = |index: Option<Index>, count: usize| -> Result<Deltas, Error> {
            let Some(index) = index.filter(|_| count > 0) else { return Ok(Deltas::default()) };
            let before = self.document.budget().held();
            let values = self.floats::<3>(index)?;
            if values.len() != count {
                let detail =
                    format!("{}: a morph target of {} of {count} vertices", self.location, values.len());
                warnings.note(Oddity::BadAttribute, &self.document.path, None, detail);
                self.document.budget().settle(before);
                return Ok(Deltas::default());
            }
            Ok(Deltas::new(values))
        };
        Ok(Morph {
            positions: deltas(target.positions, mesh.positions.len())?,
            normals: deltas(target.normals, mesh.normals.len())?,
            tangents: deltas(target.tangents, mesh.tangents.len())?,
        })
    }

    /// The joints of each vertex, of a skin of `count`; `None` where the primitive names none.
    fn influences(
        &self,
        mesh: &Mesh,
        count: usize,
        warnings: &mut Warnings,
    ) -> Result<Option<Influences>, Error> {
        let (document, attributes) = (self.document, &self.primitive.attributes);
        let vertices = mesh.positions.len();
        let mut names = attributes.joints.clone();
        names.sort_by_key(|&(set, _)| set);
        let mut sets = Vec::new();
        for (set, joint_index) in names {
            let Some(&(_, weight_index)) = attributes.weights.iter().find(|(other, _)| *other == set) else {
                continue;
            };
            // The data read, and the data made of it.
            document.hold(vertices.saturating_mul(2 * 4 * size_of::<(u32, f32)>() + 4), self.location)?;
            let joints = self.joints(joint_index)?;
            let weights = self.floats::<4>(weight_index)?;
            if joints.len() != vertices || weights.len() != vertices {
                let (j, w) = (joints.len(), weights.len());
                let detail = format!("{}: {j} joints and {w} weights for {vertices} vertices", self.location);
                warnings.note(Oddity::BadAttribute, &document.path, None, detail);
                continue;
            }
            if let Some(i) = weights.iter().position(|of| of.iter().any(|w| !w.is_finite())) {
                let detail = format!("{}: vertex {i} has a joint weight that is not finite", self.location);
                warnings.note(Oddity::BadAttribute, &document.path, None, detail);
            }
            sets.push((joints, weights));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let mut influences = Influences::with_capacity(vertices);
        for i in 0..vertices {
            let of = |(joints, weights): &(Vec<[u32; 4]>, Vec<[f32; 4]>)| {
                joints[i].into_iter().zip(weights[i]).collect::<Vec<_>>()
            };
            influences.push(sets.iter().flat_map(of));
            if let Some(&(joint, _)) = influences.of(i).iter().find(|(joint, _)| *joint as usize >= count) {
                let problem = format!("vertex {i} uses joint {joint}, but the skin has {count} joints");
                return Err(document.error(self.location, problem, ""));
            }
        }
        Ok(Some(influences))
    }
}
