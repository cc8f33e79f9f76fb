// SPDX-License-Identifier: GPL-3.0-or-later
//! The contents of a scene in double precision: meshes, and instances of other scenes.
//! Invariant: leaves are counted depth first, a scene's own meshes first: [`DoubleScene::path`] leads back.
//! Tests: `tests/doubles.rs`.

use std::fmt;
use std::sync::Arc;

use gnurt_accel_bvh::{DoubleBoxes, DoubleIndex};
use gnurt_accel_core::exact::Triangle;
use gnurt_accel_core::{BadPrimitives, BuildError, BuildOptions, INVALID_ID, Threads, TreeStats};

use super::space::{Map, NotInvertible};
use crate::DEEPEST_SCENE;

/// Triangles.
#[derive(Clone, Copy, Debug)]
pub struct DoubleMesh<'a> {
    /// Corners.
    pub positions: &'a [[f64; 3]],
    /// Rows of `positions`, three for each triangle.
    pub indices: &'a [[u32; 3]],
    /// Rays and points with a bit of it see the mesh.
    pub mask: u32,
}

impl<'a> DoubleMesh<'a> {
    /// Seen by all.
    #[must_use]
    pub fn new(positions: &'a [[f64; 3]], indices: &'a [[u32; 3]]) -> Self {
        Self { positions, indices, mask: u32::MAX }
    }
}

/// Another scene, transformed.
#[derive(Clone, Debug)]
pub struct DoubleInstance {
    /// Its contents.
    pub shown: Arc<DoubleScene>,
    /// Images of the axes, then of the origin.
    pub placement: [[f64; 3]; 4],
    /// Rays and points with a bit of it see the instance.
    pub mask: u32,
}

/// An instance in a scene.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub(super) shown: Arc<DoubleScene>,
    pub(super) map: Map,
    pub(super) mask: u32,
    /// The number of its first leaf.
    pub(super) first_leaf: u32,
}

/// The reason why a scene cannot be built.
#[derive(Clone, Debug, PartialEq)]
pub enum DoubleError {
    /// Of the meshes.
    Build(BuildError),
    /// The transform of an instance is not finite, or flattens space.
    Singular(usize),
    /// Scenes are nested more than [`DEEPEST_SCENE`] levels deep.
    TooDeep,
    /// More than [`MOST_TRIANGLES`](crate::MOST_TRIANGLES) in one scene.
    TooManyTriangles(u64),
    /// More objects than 32-bit numbers.
    TooManyLeaves,
}

impl fmt::Display for DoubleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Build(error) => error.fmt(f),
            Self::Singular(i) => write!(f, "instance {i}: its transform is singular or not finite"),
            Self::TooDeep => write!(f, "scenes are nested more than {DEEPEST_SCENE} levels deep"),
            Self::TooManyTriangles(count) => {
                write!(f, "{count} triangles: a scene has at most {}", crate::MOST_TRIANGLES)
            }
            Self::TooManyLeaves => write!(f, "too many instances of instances"),
        }
    }
}

impl std::error::Error for DoubleError {}

impl From<BuildError> for DoubleError {
    fn from(error: BuildError) -> Self {
        Self::Build(error)
    }
}

/// Meshes and instances of other scenes, in double precision.
#[derive(Clone, Debug)]
pub struct DoubleScene {
    pub(super) index: DoubleIndex,
    /// The first number of each mesh, and one more than the last number.
    pub(super) starts: Vec<u32>,
    pub(super) masks: Vec<u32>,
    /// Bits of all masks.
    pub(super) all_masks: u32,
    pub(super) boxes: DoubleBoxes,
    pub(super) instances: Vec<Placed>,
    bad: BadPrimitives,
    leaves: u32,
    levels: u32,
    bounds: [[f64; 3]; 2],
}

impl DoubleScene {
    /// Over meshes, whose numbers are geometry ids, and instances. Triangles with a bad index, without area, or with a
    /// corner that is not finite are left out and [counted](Self::bad).
    ///
    /// # Errors
    /// See [`DoubleError`].
    pub fn build(
        meshes: &[DoubleMesh],
        instances: &[DoubleInstance],
        options: &BuildOptions,
        threads: Threads,
    ) -> Result<Self, DoubleError> {
        let (mut starts, mut total) = (vec![0], 0u64);
        for mesh in meshes {
            total += mesh.indices.len() as u64;
            starts.push(u32::try_from(total).unwrap_or(u32::MAX));
        }
        if total > crate::MOST_TRIANGLES as u64 {
            return Err(DoubleError::TooManyTriangles(total));
        }
        let corners = |number: u32| {
            let mesh = starts.partition_point(|&start| start <= number) - 1;
            let row = meshes[mesh].indices[(number - starts[mesh]) as usize];
            row.map(|i| meshes[mesh].positions.get(i as usize).copied())
        };
        let (mut good, mut bad) = (Vec::with_capacity(total as usize), BadPrimitives::default());
        for number in 0..total as u32 {
            let [Some(a), Some(b), Some(c)] = corners(number) else {
                bad.bad_index += 1;
                continue;
            };
            let mut all = [a, b, c].into_iter().flatten();
            if all.clone().any(f64::is_nan) {
                bad.nan += 1;
            } else if all.any(f64::is_infinite) {
                bad.infinite += 1;
            } else if Triangle::of_doubles([a, b, c], None).is_flat() {
                bad.zero_area += 1;
            } else {
                good.push(number);
            }
        }
        let sound = |number: u32| corners(number).map(Option::unwrap_or_default);
        let index = DoubleIndex::build(&good, sound, options, threads)?;
        let mut placed = Vec::with_capacity(instances.len());
        let (mut leaves, mut levels) = (1u32, 0);
        let mut around = Vec::with_capacity(instances.len());
        for (i, DoubleInstance { shown, placement, mask }) in instances.iter().enumerate() {
            let map = Map::new(placement).map_err(|NotInvertible| DoubleError::Singular(i))?;
            around.push(map.around(&shown.bounds));
            placed.push(Placed { shown: Arc::clone(shown), map, mask: *mask, first_leaf: leaves });
            leaves = leaves.checked_add(shown.leaves).ok_or(DoubleError::TooManyLeaves)?;
            levels = levels.max(shown.levels + 1);
        }
        if levels > DEEPEST_SCENE {
            return Err(DoubleError::TooDeep);
        }
        let boxes = DoubleBoxes::build(&around, options, threads)?;
        let ([a, b], [c, d]) = (index.bounds(), boxes.bounds());
        let bounds = [[0, 1, 2].map(|k: usize| a[k].min(c[k])), [0, 1, 2].map(|k: usize| b[k].max(d[k]))];
        let masks: Vec<u32> = meshes.iter().map(|mesh| mesh.mask).collect();
        let all_masks = masks.iter().fold(u32::MAX, |all, mask| all & mask);
        Ok(Self { index, starts, masks, all_masks, boxes, instances: placed, bad, leaves, levels, bounds })
    }

    /// The box around all: least and greatest coordinates; from +inf to -inf where there is nothing.
    #[must_use]
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        self.bounds
    }

    /// Triangles that were left out.
    #[must_use]
    pub fn bad(&self) -> BadPrimitives {
        self.bad
    }

    /// Levels of instances; 0 without any.
    #[must_use]
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Of its own triangles.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.index.stats()
    }

    /// Bytes of its own trees.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        let [own, boxes] = [self.index.stats(), self.boxes.stats()];
        own.tree_bytes + own.primitive_bytes + boxes.tree_bytes + boxes.primitive_bytes
    }

    /// The mesh of a number, and the triangle in it.
    pub(super) fn ids(&self, number: u32) -> [u32; 2] {
        let mesh = self.starts.partition_point(|&start| start <= number) - 1;
        [mesh as u32, number - self.starts[mesh]]
    }

    /// The same of a number in a leaf.
    pub(super) fn ids_in(&self, leaf: u32, number: u32) -> [u32; 2] {
        let (mut scene, mut leaf) = (self, leaf);
        while leaf > 0 {
            let placed = &scene.instances[scene.placed_at(leaf)];
            leaf -= placed.first_leaf;
            scene = &placed.shown;
        }
        scene.ids(number)
    }

    /// Whether a mask sees all meshes, and there is nothing else.
    pub(super) fn shows_all(&self, mask: u32) -> bool {
        self.instances.is_empty() && self.all_masks & mask != 0
    }

    /// The index of the instance that holds a leaf, which is not 0.
    pub(super) fn placed_at(&self, leaf: u32) -> usize {
        self.instances.partition_point(|placed| placed.first_leaf <= leaf) - 1
    }

    /// Numbers of the instances on the way to a leaf, outermost first; none of a leaf that is not there.
    #[must_use]
    pub fn path(&self, leaf_id: u32) -> Vec<u32> {
        let (mut path, mut scene, mut leaf) = (Vec::new(), self, leaf_id);
        while leaf > 0 && leaf < scene.leaves {
            let at = scene.placed_at(leaf);
            path.push(at as u32);
            leaf -= scene.instances[at].first_leaf;
            scene = &scene.instances[at].shown;
        }
        path
    }

    /// The unit normal of a triangle by the right-hand rule; zeros where there is none.
    #[must_use]
    pub fn normal(&self, leaf_id: u32, geom_id: u32, prim_id: u32) -> [f64; 3] {
        let none = [0.0; 3];
        let (mut scene, mut maps) = (self, Vec::new());
        for at in self.path(leaf_id) {
            let placed = &scene.instances[at as usize];
            maps.push(&placed.map);
            scene = &placed.shown;
        }
        let number = scene.starts.get(geom_id as usize).and_then(|start| start.checked_add(prim_id));
        let corners =
            number.filter(|&number| number != INVALID_ID).and_then(|number| scene.index.corners(number));
        let Some(corners) = corners else { return none };
        let [a, b, c] = maps.iter().rev().fold(corners, |corners, map| corners.map(|at| map.outwards(at)));
        let (u, v) = ([0, 1, 2].map(|k: usize| b[k] - a[k]), [0, 1, 2].map(|k: usize| c[k] - a[k]));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let size = n[0].abs().max(n[1].abs()).max(n[2].abs());
        let n = n.map(|x| x / size);
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        if length.is_finite() { n.map(|x| x / length) } else { none }
    }
}
