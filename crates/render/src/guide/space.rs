// SPDX-License-Identifier: GPL-3.0-or-later
//! The map: for each orientation of surfaces a tree over space, whose leaves are cells with a directional tree each.
//! Source: [MGN17], section 3.1. Differs: divided at the median of the longest side, which needs no refinement.
//! Tests: crates/render/tests/guide.rs.

use glam::Vec3;

use super::directions::Trees;

/// Surfaces are told apart by the axis that is nearest to their normal, and its sign.
pub(super) const CLASSES: usize = 6;

/// A node over space: children are adjacent, or it is a cell.
#[derive(Clone, Copy, Debug)]
pub(super) enum Node {
    Split { axis: u8, at: f32, children: u32 },
    Cell(u32),
}

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
    /// The root of each orientation.
    pub(super) roots: [Option<u32>; CLASSES],
    pub(super) nodes: Vec<Node>,
    pub(super) cells: Vec<Cell>,
    pub(super) trees: Trees,
    /// The second moment of light with it over that without, as held-out samples of the pilot tell.
    pub(super) moment: f32,
}

impl Guide {
    /// The cell at a point of an orientation, if it guides there.
    pub(super) fn cell(&self, p: Vec3, class: usize) -> Option<&Cell> {
        let mut at = self.roots[class]?;
        loop {
            match self.nodes[at as usize] {
                Node::Split { axis, at: plane, children } => {
                    at = children + u32::from(p[usize::from(axis)] >= plane);
                }
                Node::Cell(cell) => return self.cells.get(cell as usize).filter(|cell| cell.share > 0.0),
            }
        }
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
        self.trees.bytes() + self.cells.len() * size_of::<Cell>() + self.nodes.len() * size_of::<Node>()
    }

    /// The second moment of light with it over that without, as held-out samples tell: below 1 if it helps.
    pub(crate) fn moment(&self) -> f32 {
        self.moment
    }
}
