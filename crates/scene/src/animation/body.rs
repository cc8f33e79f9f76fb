// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes that bend: by weights of morph targets first, then by the joints of a skin.
//! Source: glTF 2.0 sections 3.7.2.2 and 3.7.3 (linear blending of joint matrices, weights divided by their sum).
//! Normals use the blended matrix if joints only rotate, move and scale evenly, and its cofactors if one of
//! the skin stretches, because normals do not stretch with the surface. Space: that of the mesh; a skinned
//! one comes out in world space. Cost: O(vertices (joints + targets)). Tests: `tests/animation.rs`,
//! `tests/gltf.rs::{morph_weights_move_vertices, skins_follow_their_joints}`.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::affine::Affine;
use crate::id::MeshId;
use crate::mesh::Mesh;

/// A mesh that bends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// The scene's mesh that shows it.
    pub mesh: MeshId,
    /// As it is before anything bends it.
    pub base: Arc<Mesh>,
    /// Displacements that the weights scale and add.
    pub morphs: Vec<Morph>,
    /// Which set of weights; a number of `Animation::weights`.
    pub weights: Option<u32>,
    /// Which joints move its vertices.
    pub influences: Option<Influences>,
    /// Which skin; a number of `Animation::skins`.
    pub skin: Option<u32>,
}

/// A morph target: the displacement at weight one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Morph {
    /// To positions.
    pub positions: Deltas,
    /// To normals.
    pub normals: Deltas,
    /// To the first three numbers of tangents.
    pub tangents: Deltas,
}

impl Morph {
    /// Bytes that its arrays hold.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.positions.memory_bytes() + self.normals.memory_bytes() + self.tangents.memory_bytes()
    }
}

/// Something added to some vertices.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Deltas {
    /// Which vertices; `None` = all in order.
    vertices: Option<Vec<u32>>,
    values: Vec<[f32; 3]>,
}

impl Deltas {
    /// One for each vertex; if most are zero only the others are stored.
    #[must_use]
    pub fn new(values: Vec<[f32; 3]>) -> Self {
        let moved = values.iter().filter(|v| **v != [0.0; 3]).count();
        // A vertex that is named takes a third more.
        if 4 * moved > 3 * values.len() {
            return Self { vertices: None, values };
        }
        let named = values.iter().zip(0..).filter(|(v, _)| **v != [0.0; 3]);
        let (values, vertices) = named.map(|(&value, i)| (value, i)).unzip();
        Self { vertices: Some(vertices), values }
    }

    /// Whether it adds nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// One for each of `count` vertices.
    #[must_use]
    pub fn to_vec(&self, count: usize) -> Vec<[f32; 3]> {
        let mut all = vec![[0.0; 3]; count];
        self.each(|vertex, value| {
            if let Some(to) = all.get_mut(vertex) {
                *to = value;
            }
        });
        all
    }

    /// Only for the vertices in `retained`, ascending.
    #[must_use]
    pub fn keep(&self, retained: &[u32]) -> Self {
        if self.is_empty() {
            return self.clone();
        }
        let at = |vertex: u32| match &self.vertices {
            None => self.values[vertex as usize],
            Some(vertices) => vertices.binary_search(&vertex).map_or([0.0; 3], |i| self.values[i]),
        };
        Self::new(retained.iter().map(|&vertex| at(vertex)).collect())
    }

    /// How many vertices there must be.
    pub(super) fn vertices(&self) -> usize {
        let named = |vertices: &Vec<u32>| vertices.iter().max().map_or(0, |&v| v as usize + 1);
        self.vertices.as_ref().map_or(self.values.len(), named)
    }

    fn each(&self, mut add: impl FnMut(usize, [f32; 3])) {
        match &self.vertices {
            None => self.values.iter().enumerate().for_each(|(i, &value)| add(i, value)),
            Some(vertices) => {
                vertices.iter().zip(&self.values).for_each(|(&i, &value)| add(i as usize, value))
            }
        }
    }

    fn memory_bytes(&self) -> usize {
        size_of_val(&self.values[..]) + self.vertices.as_ref().map_or(0, |v| size_of_val(&v[..]))
    }
}

/// Joints and weights of vertices; a vertex may have any number.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Influences {
    /// Where the joints of each vertex begin; one more at the end.
    starts: Vec<u32>,
    /// Joints, as indices of the skin, and their weights, above zero.
    joints: Vec<(u32, f32)>,
}

impl Influences {
    /// No vertices yet.
    #[must_use]
    pub fn with_capacity(vertices: usize) -> Self {
        let mut starts = Vec::with_capacity(vertices + 1);
        starts.push(0);
        Self { starts, joints: Vec::new() }
    }

    /// Adds a vertex; joints of no weight are left out. One without any joint stays where it is.
    pub fn push(&mut self, joints: impl IntoIterator<Item = (u32, f32)>) {
        self.joints.extend(joints.into_iter().filter(|&(_, weight)| weight > 0.0 && weight.is_finite()));
        self.starts.push(self.joints.len() as u32);
    }

    /// How many vertices it has.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Joints of a vertex, and their weights.
    #[must_use]
    pub fn of(&self, vertex: usize) -> &[(u32, f32)] {
        &self.joints[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// Only for the vertices in `retained`.
    pub fn keep(&self, retained: &[u32]) -> Self {
        let mut to = Self::with_capacity(retained.len());
        retained.iter().for_each(|&vertex| to.push(self.of(vertex as usize).iter().copied()));
        to
    }

    /// One more than the greatest joint.
    pub(super) fn joints(&self) -> u32 {
        self.joints.iter().map(|&(joint, _)| joint + 1).max().unwrap_or(0)
    }

    /// Bytes that it holds.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.joints[..])
    }
}

/// The deformation of a body at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bend {
    /// Weights of the morph targets.
    pub weights: Vec<f32>,
    /// World-from-mesh matrices of the skin's joints.
    pub joints: Vec<Affine>,
    /// Whether a joint stretches, at any time.
    pub stretches: bool,
}

impl Body {
    /// Writes the deformed positions, normals and tangents to `to`, which has the arrays of `base`, and its
    /// triangles, whose order of vertices mirrors reverse.
    pub fn bend(&self, how: &Bend, to: &mut Mesh) {
        to.positions.clone_from(&self.base.positions);
        to.normals.clone_from(&self.base.normals);
        to.tangents.clone_from(&self.base.tangents);
        for (morph, &weight) in self.morphs.iter().zip(&how.weights) {
            add_morph(morph, weight, to);
        }
        if let Some(influences) = self.influences.as_ref().filter(|_| self.skin.is_some()) {
            follow_joints(influences, how, to);
            to.indices.clone_from(&self.base.indices);
            if let Some(mirrored) = mirrored(influences, how) {
                reverse_mirrored(&mut to.indices, &mirrored);
            }
        }
    }

    /// Bytes in addition to its base.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.morphs.iter().map(Morph::memory_bytes).sum::<usize>()
            + self.influences.as_ref().map_or(0, Influences::memory_bytes)
            + size_of_val(&self.morphs[..])
    }
}

/// Adds a morph target times its weight; a weight that is not finite adds nothing.
pub fn add_morph(morph: &Morph, weight: f32, to: &mut Mesh) {
    if weight == 0.0 || !weight.is_finite() {
        return;
    }
    for (deltas, values) in [(&morph.positions, &mut to.positions), (&morph.normals, &mut to.normals)] {
        deltas.each(|i, delta| {
            if let Some(value) = values.get_mut(i) {
                *value = [0, 1, 2].map(|k| value[k] + weight * delta[k]);
            }
        });
    }
    morph.tangents.each(|i, delta| {
        if let Some(tangent) = to.tangents.get_mut(i) {
            (0..3).for_each(|k| tangent[k] += weight * delta[k]);
        }
    });
}

/// Moves every vertex by the mean of its joints.
pub fn follow_joints(influences: &Influences, how: &Bend, to: &mut Mesh) {
    for (i, position) in to.positions.iter_mut().enumerate().take(influences.vertices()) {
        let Some(world_from_mesh) = blend(influences.of(i), &how.joints) else { continue };
        *position = world_from_mesh.point(position.map(f64::from)).map(|x| x as f32);
        if let Some(normal) = to.normals.get_mut(i) {
            let turned = match how.stretches {
                false => world_from_mesh.vector(normal.map(f64::from)),
                true => normal_vector(&world_from_mesh, normal.map(f64::from)),
            };
            *normal = turned.map(|x| x as f32);
        }
        if let Some([x, y, z, _]) = to.tangents.get_mut(i) {
            [*x, *y, *z] = world_from_mesh.vector([*x, *y, *z].map(f64::from)).map(|x| x as f32);
        }
    }
}

/// Which vertices joints mirror; `None` where no joint does.
pub fn mirrored(influences: &Influences, how: &Bend) -> Option<Vec<bool>> {
    if !how.joints.iter().any(|joint| joint.determinant() < 0.0) {
        return None;
    }
    let is_mirrored =
        |i: usize| blend(influences.of(i), &how.joints).is_some_and(|joint| joint.determinant() < 0.0);
    Some((0..influences.vertices()).map(is_mirrored).collect())
}

/// Reverses triangles with more mirrored corners than others, so that their geometric normals stay on the
/// side of their corners' normals.
pub fn reverse_mirrored(triangles: &mut [[u32; 3]], mirrored: &[bool]) {
    let is_mirrored = |i: u32| mirrored.get(i as usize).copied().unwrap_or(false);
    for triangle in triangles {
        if triangle.iter().filter(|&&i| is_mirrored(i)).count() >= 2 {
            triangle.swap(1, 2);
        }
    }
}

/// The weighted mean of joint matrices; `None` without joints.
fn blend(influences: &[(u32, f32)], joints: &[Affine]) -> Option<Affine> {
    let mut sum = Affine { columns: [[0.0; 3]; 4] };
    let mut total = 0.0;
    for &(joint, weight) in influences {
        let Some(matrix) = joints.get(joint as usize) else { continue };
        total += f64::from(weight);
        for (to, from) in sum.columns.iter_mut().flatten().zip(matrix.columns.iter().flatten()) {
            *to += f64::from(weight) * from;
        }
    }
    if total == 0.0 {
        return None;
    }
    sum.columns.iter_mut().flatten().for_each(|x| *x /= total);
    Some(sum)
}

/// A normal of a surface that `m` moves: by the cofactors, on the side that it was on.
fn normal_vector(m: &Affine, n: [f64; 3]) -> [f64; 3] {
    let [a, b, c, _] = m.columns;
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let columns = [cross(b, c), cross(c, a), cross(a, b)];
    let side = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let v: [f64; 3] = std::array::from_fn(|k| side * (0..3).map(|j| columns[j][k] * n[j]).sum::<f64>());
    // Cofactors of small matrices are smaller still, and the result is single precision.
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { v.map(|x| x / length) } else { v }
}

/// Whether a transform scales some directions more than others, by more than its rounding.
#[must_use]
pub fn stretches(m: &Affine) -> bool {
    let [a, b, c, _] = m.columns;
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let lengths = [dot(a, a), dot(b, b), dot(c, c)];
    let most = lengths.iter().copied().fold(0.0, f64::max);
    let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let slant = [dot(a, b), dot(b, c), dot(c, a)].iter().map(|x| x.abs()).fold(0.0, f64::max);
    most - least > 2e-3 * most || slant > 1e-3 * most
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deltas_keep_what_is_not_zero() {
        let few = Deltas::new(vec![[0.0; 3], [1.0; 3], [0.0; 3], [2.0; 3]]);
        assert_eq!(few.vertices, Some(vec![1, 3]), "two of four");
        let retained = few.keep(&[0, 3]);
        assert_eq!((retained.vertices, retained.values), (Some(vec![1]), vec![[2.0; 3]]), "renumbered");
        let most = Deltas::new(vec![[1.0; 3]; 4]);
        assert_eq!(most.vertices, None, "all");
        assert_eq!(most.keep(&[2]).values, [[1.0; 3]], "one of them");
    }

    #[test]
    fn normals_stay_normal_to_what_is_stretched() {
        let stretch = Affine::scale([1.0, 4.0, 1.0]);
        // A surface along (1, -1, 0) with the normal (1, 1, 0).
        let along = stretch.vector([1.0, -1.0, 0.0]);
        let normal = normal_vector(&stretch, [1.0, 1.0, 0.0]);
        let dot: f64 = (0..3).map(|k| along[k] * normal[k]).sum();
        assert!(dot.abs() < 1e-12, "{normal:?} is not normal to {along:?}");
        let mirrored = normal_vector(&Affine::scale([-1.0, 1.0, 1.0]), [1.0, 1.0, 0.0]);
        assert!(mirrored[0] < 0.0 && mirrored[1] > 0.0, "a mirror turns the normal with it: {mirrored:?}");
        assert!(stretches(&stretch) && !stretches(&Affine::scale([3.0; 3])), "uneven, and even");
        let rotated = Affine::rotation([1.0, 2.0, 3.0], 0.7);
        assert!(!stretches(&rotated) && stretches(&(stretch * rotated)), "a turn does not, a slant does");
    }
}
