// SPDX-License-Identifier: GPL-3.0-or-later
//! The tree of a grid: a table of upper nodes of 32 x 32 x 32 lower nodes of 16 x 16 x 16 leaves of 8 x 8 x 8 voxels.
//! Where a node has no child it has one value for all voxels of the child's position.
//! Source: [Mus13]. OpenVDB and NanoVDB have the same trees. Space: index (a voxel's coordinates are whole numbers).
//! Invariant: a child's number is that of a node or leaf that is there once the tree is read.
//! Tests: `tests/volumes.rs`, `tests/nano_volumes.rs`.

use std::collections::HashMap;

use super::bytes::hold;
use super::values::{Mask, Value, Values};
use crate::{Budget, Error};

/// The binary logarithm of the voxels along an edge of a leaf, a lower node and an upper node.
pub(super) const LEAF: u32 = 3;
pub(super) const LOWER: u32 = 7;
pub(super) const UPPER: u32 = 12;
/// Voxels along an edge of a leaf.
pub(super) const LEAF_SIZE: i32 = 1 << LEAF;
/// Voxels of a leaf.
pub(super) const LEAF_VOXELS: usize = 1 << (3 * LEAF);
const NO_CHILD: u32 = u32::MAX;

/// Voxels of a grid.
pub(super) struct Tree {
    pub(super) channels: usize,
    pub(super) background: Value,
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
pub(super) struct Node {
    /// The child at each position, or none.
    children: Box<[u32]>,
    values: Values,
}

impl Node {
    /// A node without children.
    pub(super) fn new(cells: usize, values: Values, budget: &Budget) -> Result<Self, Error> {
        hold(budget, cells * size_of::<u32>())?;
        Ok(Self { children: vec![NO_CHILD; cells].into(), values })
    }

    pub(super) fn set_child(&mut self, child_index: usize, number: usize) {
        self.children[child_index] = number as u32;
    }
}

/// The index in a node of 2^`outer` voxels along an edge where a child of 2^`inner` voxels has a voxel.
fn child_index(voxel: [i32; 3], outer: u32, inner: u32) -> usize {
    let along = |k: usize| (voxel[k] & ((1 << outer) - 1)) as usize >> inner;
    let log = outer - inner;
    along(0) << (2 * log) | along(1) << log | along(2)
}

/// The first voxel of a child; the inverse.
pub(super) fn corner(first: [i32; 3], child_index: usize, outer: u32, inner: u32) -> [i32; 3] {
    let log = outer - inner;
    let along = |shift: u32| ((child_index >> shift & ((1 << log) - 1)) << inner) as i32;
    let strides = [along(2 * log), along(log), along(0)];
    std::array::from_fn(|k| first[k].wrapping_add(strides[k]))
}

/// The first voxel of the node that contains a voxel and has 2^`log` voxels along an edge.
pub(super) fn aligned(voxel: [i32; 3], log: u32) -> [i32; 3] {
    voxel.map(|x| x & !((1 << log) - 1))
}

impl Tree {
    pub(super) fn new(channels: usize, background: Value) -> Self {
        let (top, upper, lower, leaves) = (HashMap::new(), Vec::new(), Vec::new(), Vec::new());
        Self { channels, background, top, upper, lower, leaves, active: None }
    }

    /// Adds one value for all voxels of an upper node's position.
    pub(super) fn push_tile(&mut self, first: [i32; 3], value: Value, is_active: bool) {
        let first = aligned(first, UPPER);
        if is_active {
            self.activate(first, [(1 << UPPER) - 1; 3]);
        }
        self.top.insert(first, Top::Value(value));
    }

    /// Adds an upper node, which contains a voxel.
    pub(super) fn push_upper(&mut self, first: [i32; 3], node: Node) {
        self.top.insert(aligned(first, UPPER), Top::Node(self.upper.len() as u32));
        self.upper.push(node);
    }

    /// Adds a lower node; returns its number.
    pub(super) fn push_lower(&mut self, node: Node) -> usize {
        self.lower.push(node);
        self.lower.len() - 1
    }

    /// Adds a leaf; returns its number.
    pub(super) fn push_leaf(&mut self, budget: &Budget, values: Values) -> Result<usize, Error> {
        hold(budget, size_of::<Values>())?;
        self.leaves.push(values);
        Ok(self.leaves.len() - 1)
    }

    /// Holds the memory of one place of the table.
    pub(super) fn hold_place(budget: &Budget) -> Result<(), Error> {
        // A table is at most half empty.
        hold(budget, 2 * size_of::<([i32; 3], Top)>())
    }

    /// Adds the active positions of a node of 2^`outer` voxels along an edge that have no child.
    pub(super) fn activate_tiles(
        &mut self,
        first: [i32; 3],
        [values, children]: [&Mask; 2],
        [outer, inner]: [u32; 2],
    ) {
        for child_index in values.cells().filter(|&child_index| !children.has(child_index)) {
            self.activate(corner(first, child_index, outer, inner), [(1 << inner) - 1; 3]);
        }
    }

    /// Adds a box of voxels, of extent `size` along each axis, to the active bounds.
    pub(super) fn activate(&mut self, first: [i32; 3], size: [i32; 3]) {
        let last = [0, 1, 2].map(|k| first[k].saturating_add(size[k]));
        let [lower, upper] = self.active.unwrap_or([first, last]);
        self.active =
            Some([[0, 1, 2].map(|k| lower[k].min(first[k])), [0, 1, 2].map(|k| upper[k].max(last[k]))]);
    }

    /// Takes the active voxels of a leaf, whose words are planes of one x and their bytes rows of one y.
    pub(super) fn activate_leaf(&mut self, first: [i32; 3], mask: &Mask) {
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
        match self.top(voxel) {
            Ok(upper) => self.below(upper, voxel).0,
            Err(value) => value,
        }
    }

    /// Visits a row of voxels along x: values, and how many voxels in turn have each.
    pub(super) fn row(&self, [mut x, y, z]: [i32; 3], mut count: usize, mut visit: impl FnMut(Value, usize)) {
        // Voxels from x on to the end of an edge of 2^`log`.
        let to_end = |x: i32, log: u32| ((1 << log) - (x & ((1 << log) - 1))) as usize;
        while count > 0 {
            let top = self.top([x, y, z]);
            let end = count - to_end(x, UPPER).min(count);
            while count > end {
                let (value, log) = match top {
                    Ok(upper) => self.below(upper, [x, y, z]),
                    Err(value) => (value, UPPER),
                };
                let run = to_end(x, log).min(count - end);
                visit(value, run);
                x = x.wrapping_add(run as i32);
                count -= run;
            }
        }
    }

    /// The upper node that contains a voxel, or the one value of its position.
    fn top(&self, voxel: [i32; 3]) -> Result<&Node, Value> {
        match self.top.get(&aligned(voxel, UPPER)) {
            None => Err(self.background),
            Some(Top::Value(value)) => Err(*value),
            Some(Top::Node(number)) => Ok(&self.upper[*number as usize]),
        }
    }

    /// The value of a voxel in an upper node, and the binary logarithm of the edge of the block that has it.
    fn below(&self, upper: &Node, voxel: [i32; 3]) -> (Value, u32) {
        let at = child_index(voxel, UPPER, LOWER);
        if upper.children[at] == NO_CHILD {
            return (upper.values.get(at, self.channels), LOWER);
        }
        let lower = &self.lower[upper.children[at] as usize];
        let at = child_index(voxel, LOWER, LEAF);
        if lower.children[at] == NO_CHILD {
            return (lower.values.get(at, self.channels), LEAF);
        }
        let leaf = &self.leaves[lower.children[at] as usize];
        (leaf.get(child_index(voxel, LEAF, 0), self.channels), 0)
    }
}
