// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes bent by morph weights and skins, in the pose that the file itself shows.
//! Source: glTF 2.0 sections 3.7.2.2 (morph targets) and 3.7.3 (skins: linear blending of joint matrices).
//! Space: a skinned mesh comes out in world space, for its node's own transform does not count.
//! Proof: `tests/gltf.rs::{morph_weights_move_vertices, skins_follow_their_joints}`.

use std::collections::HashMap;

use super::accessor::{floats, joints};
use super::document::Document;
use super::json::{self, Index};
use super::primitive::PrimitiveReader;
use crate::affine::Affine;
use crate::io::Error;
use crate::mesh::Mesh;

/// How a node bends its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Pose {
    /// Weights of the morph targets; empty = none.
    weights: Vec<f32>,
    /// World-from-mesh matrices of the skin's joints; empty = no skin.
    joints: Vec<Affine>,
}

impl Pose {
    /// The pose of a node that shows `mesh`, whose joints stand at `world_from_joint`.
    pub(super) fn of(
        document: &Document<'_>,
        node: &json::Node,
        mesh: &json::Mesh<'_>,
        world_from_joint: &HashMap<Index, Affine>,
    ) -> Result<Self, Error> {
        let weights = node.weights.as_ref().unwrap_or(&mesh.weights);
        let moves = weights.iter().any(|&w| w != 0.0 && w.is_finite());
        let weights = if moves { weights.clone() } else { Vec::new() };
        let joints = match node.skin {
            Some(skin) => joint_matrices(document, skin, world_from_joint)?,
            None => Vec::new(),
        };
        Ok(Self { weights, joints })
    }

    /// Whether the mesh comes out in world space.
    pub(super) fn is_skinned(&self) -> bool {
        !self.joints.is_empty()
    }

    /// Moves positions, normals and tangents of a primitive's mesh.
    pub(super) fn bend(&self, from: &PrimitiveReader<'_>, mesh: &mut Mesh) -> Result<(), Error> {
        for (target, &weight) in from.primitive.targets.iter().zip(&self.weights) {
            for (index, values) in
                [(target.positions, &mut mesh.positions), (target.normals, &mut mesh.normals)]
            {
                let Some(index) = index.filter(|_| !values.is_empty() && weight.is_finite()) else {
                    continue;
                };
                let before = from.document.budget().held();
                for (value, delta) in values.iter_mut().zip(floats::<3>(from.document, index, from.place)?) {
                    *value = [0, 1, 2].map(|k| value[k] + weight * delta[k]);
                }
                from.document.budget().settle(before);
            }
            if let Some(index) = target.tangents.filter(|_| !mesh.tangents.is_empty() && weight.is_finite()) {
                let before = from.document.budget().held();
                let deltas = floats::<3>(from.document, index, from.place)?;
                for (tangent, delta) in mesh.tangents.iter_mut().zip(deltas) {
                    (0..3).for_each(|k| tangent[k] += weight * delta[k]);
                }
                from.document.budget().settle(before);
            }
        }
        if self.is_skinned() {
            self.skin(from, mesh)?;
        }
        Ok(())
    }

    fn skin(&self, from: &PrimitiveReader<'_>, mesh: &mut Mesh) -> Result<(), Error> {
        let (Some(joint_index), Some(weight_index)) =
            (from.primitive.attributes.joints, from.primitive.attributes.weights)
        else {
            return Ok(());
        };
        let joints = joints(from.document, joint_index, from.place)?;
        let weights = floats::<4>(from.document, weight_index, from.place)?;
        for (i, (joints, weights)) in joints.iter().zip(&weights).enumerate().take(mesh.positions.len()) {
            let world_from_mesh = self.blend(joints, weights);
            mesh.positions[i] = world_from_mesh.point(mesh.positions[i].map(f64::from)).map(|x| x as f32);
            if let Some(normal) = mesh.normals.get_mut(i) {
                // Joints turn and move; where one stretches unevenly the shading is off by that little.
                *normal = world_from_mesh.vector(normal.map(f64::from)).map(|x| x as f32);
            }
            if let Some([x, y, z, _]) = mesh.tangents.get_mut(i) {
                [*x, *y, *z] = world_from_mesh.vector([*x, *y, *z].map(f64::from)).map(|x| x as f32);
            }
        }
        Ok(())
    }

    /// The weighted sum of four joint matrices; joints that do not exist weigh nothing.
    fn blend(&self, joints: &[u32; 4], weights: &[f32; 4]) -> Affine {
        let mut sum = Affine { columns: [[0.0; 3]; 4] };
        let mut total = 0.0;
        for (&joint, &weight) in joints.iter().zip(weights) {
            let Some(matrix) = self.joints.get(joint as usize).filter(|_| weight > 0.0) else {
                continue;
            };
            total += f64::from(weight);
            for (to, from) in sum.columns.iter_mut().flatten().zip(matrix.columns.iter().flatten()) {
                *to += f64::from(weight) * from;
            }
        }
        if total > 0.0 {
            sum.columns.iter_mut().flatten().for_each(|x| *x /= total);
            sum
        } else {
            Affine::IDENTITY
        }
    }
}

/// Where the joints of all skins stand is asked for once, before anything is bent.
pub(super) fn joints_of_all_skins(document: &Document<'_>) -> Result<HashMap<Index, Affine>, Error> {
    let mut joints = HashMap::new();
    for k in 0..document.root.skins.len() {
        let place = format!("skins[{k}]");
        let skin: json::Skin = document.get(&document.root.skins, Index(k as u32), &place, "skin")?;
        for joint in skin.joints {
            if joints.insert(joint, Affine::IDENTITY).is_none() {
                // A table is up to half empty.
                document.hold(2 * size_of::<(Index, Affine)>(), &place)?;
            }
        }
    }
    Ok(joints)
}

fn joint_matrices(
    document: &Document<'_>,
    index: Index,
    world_from_joint: &HashMap<Index, Affine>,
) -> Result<Vec<Affine>, Error> {
    let place = format!("skins[{}]", index.0);
    let skin: json::Skin = document.get(&document.root.skins, index, &place, "skin")?;
    let bytes = size_of::<Affine>() * skin.joints.len();
    document.work(bytes, &place)?;
    document.hold(bytes, &place)?;
    let inverse_binds = match skin.inverse_bind_matrices {
        Some(accessor) => floats::<16>(document, accessor, &place)?,
        None => Vec::new(),
    };
    let matrix = |(k, joint): (usize, &Index)| {
        let world_from_joint = world_from_joint.get(joint).copied().unwrap_or_default();
        let joint_from_mesh = inverse_binds.get(k).map(|m| Affine::from_column_major(&m.map(f64::from)));
        world_from_joint * joint_from_mesh.unwrap_or_default()
    };
    Ok(skin.joints.iter().enumerate().map(matrix).collect())
}
