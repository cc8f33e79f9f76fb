// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads the tree of a grid of OpenVDB: first the structure of all nodes, then the values of the leaves.
//! Source: [Mus13]; the format of OpenVDB's files. Space: index (a voxel's coordinates are whole numbers).
//! Invariant: a child's number is that of a node or leaf that is there.
//! Tests: `tests/volumes.rs`.

use super::lists::Format;
use crate::volume::bytes::{Bytes, corrupt};
use crate::volume::tree::{LEAF, LEAF_VOXELS, LOWER, Node, Tree, UPPER, aligned, corner};
use crate::volume::values::{Mask, Value};
use crate::{Budget, Error};

/// The input of a tree.
pub(super) struct Reader<'a, 'b> {
    pub(super) bytes: &'b mut Bytes<'a>,
    pub(super) budget: &'b Budget,
    pub(super) format: Format,
}

impl Reader<'_, '_> {
    /// Reads how the tree is built, then its leaves.
    pub(super) fn tree(&mut self) -> Result<Tree, Error> {
        if self.bytes.u32()? != 1 {
            return Err(corrupt("a tree with more than one list of values"));
        }
        let background = self.format.value(self.bytes)?;
        let [tiles, nodes] = [self.bytes.u32()?, self.bytes.u32()?];
        let mut tree = Tree::new(self.format.channels, background);
        for _ in 0..tiles {
            let first = self.key()?;
            let value = self.format.value(self.bytes)?;
            let is_active = self.bytes.u8()? != 0;
            tree.push_tile(first, value, is_active);
        }
        let mut leaves = 0;
        for _ in 0..nodes {
            let first = self.key()?;
            let node = self.upper(&mut tree, first, &mut leaves)?;
            tree.push_upper(first, node);
        }
        for _ in 0..leaves {
            let mask = Mask::read(self.bytes, LEAF_VOXELS)?;
            let values = self.format.values(self.bytes, self.budget, background, (LEAF_VOXELS, &mask))?;
            tree.push_leaf(self.budget, values)?;
        }
        Ok(tree)
    }

    /// Where something in the table lies.
    fn key(&mut self) -> Result<[i32; 3], Error> {
        Tree::hold_place(self.budget)?;
        let [x, y, z] = [self.bytes.i32()?, self.bytes.i32()?, self.bytes.i32()?];
        Ok(aligned([x, y, z], UPPER))
    }

    /// The children and values of a node that begins at `first`; active ones without a child are those of the tree, too.
    fn node(
        &mut self,
        tree: &mut Tree,
        first: [i32; 3],
        [outer, inner]: [u32; 2],
    ) -> Result<(Mask, Node), Error> {
        let cells = 1 << (3 * (outer - inner));
        let children = Mask::read(self.bytes, cells)?;
        let values = Mask::read(self.bytes, cells)?;
        tree.activate_tiles(first, [&values, &children], [outer, inner]);
        let background: Value = tree.background;
        let values = self.format.values(self.bytes, self.budget, background, (cells, &values))?;
        Ok((children, Node::new(cells, values, self.budget)?))
    }

    fn upper(&mut self, tree: &mut Tree, first: [i32; 3], leaves: &mut usize) -> Result<Node, Error> {
        let (children, mut node) = self.node(tree, first, [UPPER, LOWER])?;
        for child_index in children.cells() {
            let lower = self.lower(tree, corner(first, child_index, UPPER, LOWER), leaves)?;
            node.set_child(child_index, tree.push_lower(lower));
        }
        Ok(node)
    }

    fn lower(&mut self, tree: &mut Tree, first: [i32; 3], leaves: &mut usize) -> Result<Node, Error> {
        let (children, mut node) = self.node(tree, first, [LOWER, LEAF])?;
        for child_index in children.cells() {
            let mask = Mask::read(self.bytes, LEAF_VOXELS)?;
            tree.activate_leaf(corner(first, child_index, LOWER, LEAF), &mask);
            node.set_child(child_index, *leaves);
            *leaves += 1;
        }
        Ok(node)
    }
}
