// SPDX-License-Identifier: GPL-3.0-or-later
//! The tree of a grid: a table of upper nodes of 32 x 32 x 32 lower nodes of 16 x 16 x 16 leaves of 8 x 8 x 8 voxels.
//! Where a node has no child it has one value for all voxels of the child's position.
//! Source: [Mus13]; the format of OpenVDB's files. Space: index (a voxel's coordinates are whole numbers).
//! Invariant: a child's number is that of a node or leaf that is there.
//! Tests: `tests/volumes.rs`.

use std::collections::HashMap;

use super::bytes::{Bytes, corrupt, hold};
use super::values::{Format, Mask, Value, Values};
use crate::{Budget, Error};

/// The binary logarithm of the voxels along an edge of a leaf, a lower node and an upper node.
const LEAF: u32 = 3;
const LOWER: u32 = 7;
const UPPER: u32 = 12;
/// Voxels along an edge of a leaf.
pub(super) const LEAF_SIZE: i32 = 1 << LEAF;
const NO_CHILD: u32 = u32::MAX;

/// Voxels of a grid.
pub(super) struct Tree {
    channels: usize,
    background: Value,
    top: HashMap<[i32; 3], Top>,
    upper: Vec<Node>,
    lower: Vec<Node>,
    leaves: Vec<Values>,
    /// The first active voxel and the last one along each axis; none where no voxel is active.
    pub(super) active: Option<[[i32; 3]; 2]>,
}

#[derive(Clone, Copy)]
enum Top {
    Value(Value),
    Node(u32),
}

/// A node that is no leaf.
struct Node {
    /// The child at each position, or none.
    children: Box<[u32]>,
    values: Values,
}

/// The index in a node of 2^`outer` voxels along an edge where a child of 2^`inner` voxels has a voxel.
fn child_index(voxel: [i32; 3], outer: u32, inner: u32) -> usize {
    let along = |k: usize| (voxel[k] & ((1 << outer) - 1)) as usize >> inner;
    let log = outer - inner;
    along(0) << (2 * log) | along(1) << log | along(2)
}

/// The first voxel of a child; the inverse.
fn corner(first: [i32; 3], child_index: usize, outer: u32, inner: u32) -> [i32; 3] {
    let log = outer - inner;
    let along = |shift: u32| ((child_index >> shift & ((1 << log) - 1)) << inner) as i32;
    let strides = [along(2 * log), along(log), along(0)];
    std::array::from_fn(|k| first[k].wrapping_add(strides[k]))
}

/// The input of a tree.
pub(super) struct Reader<'a, 'b> {
    pub(super) bytes: &'b mut Bytes<'a>,
    pub(super) budget: &'b Budget,
    pub(super) format: Format,
}

impl Reader<'_, '_> {
    /// Where something in the table lies.
    fn key(&mut self) -> Result<[i32; 3], Error> {
        // A table is at most half empty.
        hold(self.budget, 2 * size_of::<([i32; 3], Top)>())?;
        let [x, y, z] = [self.bytes.i32()?, self.bytes.i32()?, self.bytes.i32()?];
        Ok(aligned([x, y, z], UPPER))
    }

    /// The children and values of a node; active ones without a child go to `active`.
    fn node(
        &mut self,
        background: Value,
        [outer, inner]: [u32; 2],
        mut active: impl FnMut(usize),
    ) -> Result<(Mask, Node), Error> {
        let cells = 1 << (3 * (outer - inner));
        let children = Mask::read(self.bytes, cells)?;
        let values = Mask::read(self.bytes, cells)?;
        values.cells().filter(|&child_index| !children.has(child_index)).for_each(&mut active);
        let values = Values::read(self.bytes, self.budget, (&self.format, background), (cells, &values))?;
        hold(self.budget, cells * size_of::<u32>())?;
        Ok((children, Node { children: vec![NO_CHILD; cells].into(), values }))
    }
}

/// The first voxel of the node that contains a voxel and has 2^`log` voxels along an edge.
fn aligned(voxel: [i32; 3], log: u32) -> [i32; 3] {
    voxel.map(|x| x & !((1 << log) - 1))
}

impl Tree {
    /// Reads how the tree is built, then its leaves.
    pub(super) fn read(reader: &mut Reader<'_, '_>) -> Result<Self, Error> {
        if reader.bytes.u32()? != 1 {
            return Err(corrupt("a tree with more than one list of values"));
        }
        let background = reader.format.value(reader.bytes)?;
        let [tiles, nodes] = [reader.bytes.u32()?, reader.bytes.u32()?];
        let mut tree = Self {
            channels: reader.format.channels,
            background,
            top: HashMap::new(),
            upper: Vec::new(),
            lower: Vec::new(),
            leaves: Vec::new(),
            active: None,
        };
        for _ in 0..tiles {
            let first = reader.key()?;
            let value = reader.format.value(reader.bytes)?;
            if reader.bytes.u8()? != 0 {
                tree.activate(first, [(1 << UPPER) - 1; 3]);
            }
            tree.top.insert(first, Top::Value(value));
        }
        let mut leaves = 0;
        for _ in 0..nodes {
            let first = reader.key()?;
            let node = tree.read_upper(reader, first, &mut leaves)?;
            tree.top.insert(first, Top::Node(tree.upper.len() as u32));
            tree.upper.push(node);
        }
        for _ in 0..leaves {
            let mask = Mask::read(reader.bytes, 512)?;
            let kind = (&reader.format, background);
            hold(reader.budget, size_of::<Values>())?;
            tree.leaves.push(Values::read(reader.bytes, reader.budget, kind, (512, &mask))?);
        }
        Ok(tree)
    }

    fn read_upper(
        &mut self,
        reader: &mut Reader<'_, '_>,
        first: [i32; 3],
        leaves: &mut u32,
    ) -> Result<Node, Error> {
        let tile = |child_index| corner(first, child_index, UPPER, LOWER);
        let (children, mut node) = reader.node(self.background, [UPPER, LOWER], |child_index| {
            self.activate(tile(child_index), [(1 << LOWER) - 1; 3]);
        })?;
        for child_index in children.cells() {
            let lower = self.read_lower(reader, tile(child_index), leaves)?;
            node.children[child_index] = self.lower.len() as u32;
            self.lower.push(lower);
        }
        Ok(node)
    }

    fn read_lower(
        &mut self,
        reader: &mut Reader<'_, '_>,
        first: [i32; 3],
        leaves: &mut u32,
    ) -> Result<Node, Error> {
        let tile = |child_index| corner(first, child_index, LOWER, LEAF);
        let (children, mut node) = reader.node(self.background, [LOWER, LEAF], |child_index| {
            self.activate(tile(child_index), [LEAF_SIZE - 1; 3]);
        })?;
        for child_index in children.cells() {
            let mask = Mask::read(reader.bytes, 512)?;
            self.activate_leaf(tile(child_index), &mask);
            node.children[child_index] = *leaves;
            *leaves += 1;
        }
        Ok(node)
    }

    /// Adds a box of voxels, of extent `size` along each axis, to the active bounds.
    fn activate(&mut self, first: [i32; 3], size: [i32; 3]) {
        let last = [0, 1, 2].map(|k| first[k].saturating_add(size[k]));
        let [lower, upper] = self.active.unwrap_or([first, last]);
        self.active =
            Some([[0, 1, 2].map(|k| lower[k].min(first[k])), [0, 1, 2].map(|k| upper[k].max(last[k]))]);
    }

    /// Takes the active voxels of a leaf, whose words are planes of one x and their bytes rows of one y.
    fn activate_leaf(&mut self, first: [i32; 3], mask: &Mask) {
        let planes = mask.mask_bits();
        let all = planes.iter().fold(0, |all, bits| all | bits);
        if all == 0 {
            return;
        }
        let columns = all.to_le_bytes().iter().fold(0, |all, row| all | row);
        let x = [planes.iter().position(|&plane| plane != 0), planes.iter().rposition(|&plane| plane != 0)];
        let [x0, x1] = x.map(|x| x.unwrap_or_default() as i32);
        let [y0, y1] = [all.trailing_zeros() / 8, (63 - all.leading_zeros()) / 8].map(|y| y as i32);
        let [z0, z1] = [columns.trailing_zeros(), 7 - columns.leading_zeros()].map(|z| z as i32);
        let corner = [first[0] + x0, first[1] + y0, first[2] + z0];
        self.activate(corner, [x1 - x0, y1 - y0, z1 - z0]);
    }

    /// The value of a voxel.
    pub(super) fn get(&self, voxel: [i32; 3]) -> Value {
        let upper = match self.top.get(&aligned(voxel, UPPER)) {
            None => return self.background,
            Some(Top::Value(value)) => return *value,
            Some(Top::Node(number)) => &self.upper[*number as usize],
        };
        let at = child_index(voxel, UPPER, LOWER);
        if upper.children[at] == NO_CHILD {
            return upper.values.get(at, self.channels);
        }
        let lower = &self.lower[upper.children[at] as usize];
        let at = child_index(voxel, LOWER, LEAF);
        if lower.children[at] == NO_CHILD {
            return lower.values.get(at, self.channels);
        }
        self.leaves[lower.children[at] as usize].get(child_index(voxel, LEAF, 0), self.channels)
    }
}
