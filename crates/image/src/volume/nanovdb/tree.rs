// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads the tree of a grid of NanoVDB: nodes anywhere in the grid's bytes, found by offsets from their parents.
//! Source: NanoVDB [Mus21]; original code. Space: index (a voxel's coordinates are whole numbers).
//! Invariant: no byte belongs to two nodes, so that a file cannot claim one node many times.
//! Tests: `tests/nano_volumes.rs`.

use std::collections::BTreeMap;

use super::layout::{GRID_BYTES, LEAF_FLAGS, LEAF_MASK, Layout, Leaves, MASKS, ROOT_PLACES, TREE_BYTES};
use crate::volume::bytes::{Bytes, corrupt, hold};
use crate::volume::tree::{LEAF, LEAF_VOXELS, LOWER, Node, Tree, UPPER, corner};
use crate::volume::values::{Mask, Value, Values};
use crate::{Budget, Error};

/// Most bytes of a number of a leaf's codes: 2^4 bits.
const MOST_LOG_BITS: u32 = 4;

/// The bytes of a grid.
pub(super) struct Reader<'a> {
    grid: &'a [u8],
    layout: Layout,
    budget: &'a Budget,
    /// First byte and end of each node that was read.
    taken: BTreeMap<usize, usize>,
}

/// A node that is no leaf.
struct Inner {
    /// Its first byte.
    start: usize,
    node: Node,
    /// Its children: their positions, and their offsets from its first byte.
    children: Vec<(usize, i64)>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(grid: &'a [u8], layout: Layout, budget: &'a Budget) -> Self {
        Self { grid, layout, budget, taken: BTreeMap::from([(0, GRID_BYTES + TREE_BYTES)]) }
    }

    /// The bytes from `offset` behind `from` on.
    fn part(&self, from: usize, offset: i64, bytes: usize) -> Result<(usize, &'a [u8]), Error> {
        let start = usize::try_from(offset).ok().and_then(|offset| from.checked_add(offset));
        let range = start.and_then(|start| Some(start..start.checked_add(bytes)?));
        let part = range.and_then(|range| Some((range.start, self.grid.get(range)?)));
        part.ok_or_else(|| corrupt(format!("a node at byte {offset} behind byte {from} is not in its grid")))
    }

    /// The same bytes as a node of their own.
    fn node_part(&mut self, from: usize, offset: i64, bytes: usize) -> Result<(usize, &'a [u8]), Error> {
        let (start, part) = self.part(from, offset, bytes)?;
        let end = start + bytes;
        if self.taken.range(..end).next_back().is_some_and(|(_, &other)| other > start) {
            return Err(corrupt(format!("two nodes share the bytes from {start} on")));
        }
        hold(self.budget, 4 * size_of::<usize>())?;
        self.taken.insert(start, end);
        Ok((start, part))
    }

    /// The tree, whose root is `offset` bytes behind the grid's head.
    pub(super) fn tree(mut self, offset: i64) -> Result<Tree, Error> {
        let layout = self.layout;
        let (_, head) = self.part(GRID_BYTES, offset, layout.root())?;
        let places = Bytes::new(&head[ROOT_PLACES..]).u32()? as usize;
        let bytes = places.checked_mul(layout.place()).and_then(|bytes| bytes.checked_add(layout.root()));
        let bytes = bytes.ok_or_else(|| corrupt("too many places of the root"))?;
        let (root, part) = self.node_part(GRID_BYTES, offset, bytes)?;
        let mut tree = Tree::new(layout.channels, self.value(part, layout.root_background()));
        for place in part[layout.root()..].chunks_exact(layout.place()) {
            Tree::hold_place(self.budget)?;
            let bytes = &mut Bytes::new(place);
            let [key, child] = [bytes.i64()? as u64, bytes.i64()? as u64];
            let first = [key >> 42, key >> 21, key].map(|part| (part as u32) << UPPER as i32);
            let first = first.map(|x| x as i32);
            if child == 0 {
                let is_active = bytes.u32()? != 0;
                tree.push_tile(first, self.value(place, layout.place_value()), is_active);
            } else {
                let node = self.upper(&mut tree, first, (root, child as i64))?;
                tree.push_upper(first, node);
            }
        }
        Ok(tree)
    }

    fn value(&self, part: &[u8], at: usize) -> Value {
        self.layout.number.value(&part[at..at + self.layout.value()])
    }

    /// A node that begins at the voxel `first`.
    fn node(
        &mut self,
        tree: &mut Tree,
        first: [i32; 3],
        (parent, offset): (usize, i64),
        [outer, inner]: [u32; 2],
    ) -> Result<Inner, Error> {
        let (layout, cells) = (self.layout, 1 << (3 * (outer - inner)));
        let (start, part) = self.node_part(parent, offset, layout.node(cells))?;
        let masks = &mut Bytes::new(&part[MASKS..]);
        let [active, children] = [Mask::read(masks, cells)?, Mask::read(masks, cells)?];
        tree.activate_tiles(first, [&active, &children], [outer, inner]);
        let entries = part[layout.table(cells)..].chunks_exact(layout.entry()).take(cells).enumerate();
        let mut offsets = Vec::with_capacity(children.count());
        let mut values = Vec::with_capacity(cells * layout.channels);
        // Where a child is, the value before it is repeated: equal ones take little memory.
        let mut value = tree.background;
        for (child_index, entry) in entries {
            if children.has(child_index) {
                offsets.push((child_index, Bytes::new(entry).i64()?));
            } else {
                value = self.value(entry, 0);
            }
            values.extend_from_slice(&value[..layout.channels]);
        }
        let values = Values::new(values, layout.channels, self.budget)?;
        Ok(Inner { start, node: Node::new(cells, values, self.budget)?, children: offsets })
    }

    fn upper(&mut self, tree: &mut Tree, first: [i32; 3], at: (usize, i64)) -> Result<Node, Error> {
        let Inner { start, mut node, children } = self.node(tree, first, at, [UPPER, LOWER])?;
        for (child_index, offset) in children {
            let lower = self.lower(tree, corner(first, child_index, UPPER, LOWER), (start, offset))?;
            node.set_child(child_index, tree.push_lower(lower));
        }
        Ok(node)
    }

    fn lower(&mut self, tree: &mut Tree, first: [i32; 3], at: (usize, i64)) -> Result<Node, Error> {
        let Inner { start, mut node, children } = self.node(tree, first, at, [LOWER, LEAF])?;
        for (child_index, offset) in children {
            let values = self.leaf(tree, corner(first, child_index, LOWER, LEAF), (start, offset))?;
            node.set_child(child_index, tree.push_leaf(self.budget, values)?);
        }
        Ok(node)
    }

    fn leaf(&mut self, tree: &mut Tree, first: [i32; 3], at: (usize, i64)) -> Result<Values, Error> {
        let (layout, table) = (self.layout, self.layout.leaf_table());
        let (_, head) = self.part(at.0, at.1, table)?;
        let log_bits = match layout.leaves {
            Leaves::Plain => None,
            Leaves::Codes { log_bits } => Some(log_bits),
            Leaves::OwnCodes => Some(u32::from(head[LEAF_FLAGS] >> 5)),
        };
        if log_bits.is_some_and(|log_bits| log_bits > MOST_LOG_BITS) {
            return Err(corrupt("a leaf with codes of more than 16 bits"));
        }
        let bytes = log_bits.map_or(LEAF_VOXELS * layout.value(), |log_bits| LEAF_VOXELS << log_bits >> 3);
        let (_, part) = self.node_part(at.0, at.1, table + bytes)?;
        let mask = Mask::read(&mut Bytes::new(&part[LEAF_MASK..]), LEAF_VOXELS)?;
        tree.activate_leaf(first, &mask);
        let stored = &part[table..];
        let values = match log_bits {
            None => stored.chunks_exact(layout.number.bytes()).map(|x| layout.number.read(x)).collect(),
            Some(log_bits) => {
                let range = &mut Bytes::new(&part[LEAF_MASK + LEAF_VOXELS / 8..]);
                let [smallest, quantum] = [f32::from_bits(range.u32()?), f32::from_bits(range.u32()?)];
                (0..LEAF_VOXELS).map(|i| code(stored, i, log_bits) * quantum + smallest).collect()
            }
        };
        Values::new(values, layout.channels, self.budget)
    }
}

/// Whole number `i` of a list of such, of 2^`log_bits` bits each.
fn code(list: &[u8], i: usize, log_bits: u32) -> f32 {
    if log_bits == 4 {
        return f32::from(u16::from_le_bytes([list[2 * i], list[2 * i + 1]]));
    }
    let bit = i << log_bits;
    let all = (1_u16 << (1 << log_bits)) - 1;
    f32::from(u16::from(list[bit / 8]) >> (bit % 8) & all)
}
