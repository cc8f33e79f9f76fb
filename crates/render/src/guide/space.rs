// SPDX-License-Identifier: GPL-3.0-or-later
//! The map: for each orientation of surfaces a tree over space, whose leaves are cells with a directional tree each.
//! Source: [MGN17], section 3.1.
//! Tests: crates/render/tests/guide.rs.

use glam::Vec3;

use super::directions::Trees;
use crate::space_tree::SpaceTree;

/// The distribution of a part of space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// The root of its directional tree.
    pub(super) root: u32,
    /// The share of directions that are chosen by it, in [0, 1).
    pub(super) share: f32,
}

/// Where light comes from, place by place.
#[derive(Clone, Debug, Default)]
pub(crate) struct Guide {
    pub(super) tree: SpaceTree,
    pub(super) cells: Vec<Cell>,
    pub(super) trees: Trees,
    /// The second moment of light with it over that without, as held-out samples of the pilot tell.
    pub(super) moment: f32,
}

impl Guide {
    /// The cell at a point of an orientation, if it guides there.
    pub(super) fn cell(&self, p: Vec3, class: u8) -> Option<&Cell> {
        let cell = self.tree.cell(p, class)?;
        self.cells.get(cell as usize).filter(|cell| cell.share > 0.0)
    }

    /// A unit direction by two numbers in [0, 1).
    pub(super) fn sample(&self, root: u32, u: [f32; 2]) -> Vec3 {
        self.trees.sample(root, u)
    }

    /// Its density per solid angle.
    pub(super) fn pdf(&self, root: u32, dir: Vec3) -> f32 {
        self.trees.pdf(root, dir)
    }

    /// How many cells it has, and nodes of directional trees.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.cells.len(), self.trees.len()]
    }

    /// Bytes of memory.
    pub(crate) fn bytes(&self) -> usize {
        self.trees.bytes() + self.cells.len() * size_of::<Cell>() + self.tree.bytes()
    }

    /// The second moment of light with it over that without, as held-out samples tell: below 1 if it helps.
    pub(crate) fn moment(&self) -> f32 {
        self.moment
    }
}
