// SPDX-License-Identifier: GPL-3.0-or-later
//! A grid of numbers, with its name and its place.
//! Space: a grid has whole coordinates of voxels (index), which an affine map takes to the space of its file (world).
//! Tests: `tests/volumes.rs`, `tests/nano_volumes.rs`.

use std::sync::Arc;

use glam::DAffine3;

use super::bytes::corrupt;
use super::tree::{LEAF_SIZE, Tree};
use crate::Error;

/// Numbers at points of space: one or three at each.
#[derive(Clone)]
pub struct Grid {
    name: String,
    channels: usize,
    index_from_world: DAffine3,
    tree: Arc<Tree>,
}

impl std::fmt::Debug for Grid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Grid")
            .field("name", &self.name)
            .field("channels", &self.channels)
            .finish_non_exhaustive()
    }
}

impl Grid {
    /// A grid at a place of its file's world.
    pub(super) fn new(name: String, world_from_index: DAffine3, tree: Arc<Tree>) -> Result<Self, Error> {
        let index_from_world = world_from_index.inverse();
        if !index_from_world.is_finite() {
            return Err(corrupt(format!("the map of the grid \"{name}\" has no inverse")));
        }
        Ok(Self { name, channels: tree.channels, index_from_world, tree })
    }

    /// Its name with what tells it from others of the same name.
    pub(super) fn whole_name(&self) -> &str {
        &self.name
    }

    /// Its voxels.
    pub(super) fn tree(&self) -> Arc<Tree> {
        self.tree.clone()
    }

    /// Its name, which others of the file may have as well.
    #[must_use]
    pub fn name(&self) -> &str {
        // A sign that is none of a text parts a name from a number where there are several of the name.
        self.name.split('\u{1e}').next().unwrap_or_default()
    }

    /// Numbers of a voxel: 1 or 3.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// From the file's world to coordinates in which voxels lie at whole numbers.
    #[must_use]
    pub fn index_from_world(&self) -> DAffine3 {
        self.index_from_world
    }

    /// The numbers of a voxel; those beyond [`channels`](Self::channels) are 0. A voxel that was not stored
    /// has the background.
    #[must_use]
    #[inline]
    pub fn voxel(&self, at: [i32; 3]) -> [f32; 3] {
        self.tree.get(at)
    }

    /// Visits `count` voxels along x: values as of [`voxel`](Self::voxel), and how many voxels in turn have each. Blocks
    /// that were stored as one value take one visit.
    #[inline]
    pub fn row(&self, first: [i32; 3], count: usize, visit: impl FnMut([f32; 3], usize)) {
        self.tree.row(first, count, visit);
    }

    /// The first and the last active voxel along each axis; none where no voxel is active.
    #[must_use]
    pub fn active(&self) -> Option<[[i32; 3]; 2]> {
        self.tree.active
    }

    /// The same, rounded to whole leaves of the tree: the picture's size in other programs.
    #[must_use]
    pub fn window(&self) -> Option<[[i32; 3]; 2]> {
        let mask = LEAF_SIZE - 1;
        self.active().map(|[first, last]| [first.map(|x| x & !mask), last.map(|x| x | mask)])
    }
}
