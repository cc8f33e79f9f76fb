// SPDX-License-Identifier: GPL-3.0-or-later
//! A wide BVH without its primitives. Source: [WBB08]; compact nodes after [YKL17].
//! Space: that of the primitives. Invariant: no node is deeper than [`DEEPEST`]; nodes are of one form.
//! Tests: `build::tests`.

use std::sync::Arc;

use gnurt_accel_core::{Aabb, Memory};
use gnurt_simd::prefer_huge_pages;

use crate::compact::{Children, CompactNode, CompactNodes};
use crate::node::{Child, Node8, WIDTH};

/// No node is of this depth or a greater one; the root has depth 0.
pub(crate) const DEEPEST: usize = 52;

/// A tree without its primitives.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tree {
    /// The root comes first; without primitives there is none. Children come after their parents.
    pub(crate) nodes: Vec<Node8>,
    /// The nodes of a compact tree, which has no others.
    pub(crate) compact: Vec<CompactNode>,
    /// The children of these, node by node. Trees over the same triangles in other poses may share it.
    pub(crate) children: Arc<Vec<Children>>,
    /// Numbers of the primitives, leaf block by leaf block, eight to each; padded with `INVALID_ID`.
    pub(crate) blocks: Vec<[u32; WIDTH]>,
    /// Box around everything.
    pub(crate) bounds: Aabb,
}

impl Tree {
    /// Without nodes.
    pub(crate) fn new(bounds: Aabb) -> Self {
        Self { nodes: Vec::new(), compact: Vec::new(), children: Arc::default(), blocks: Vec::new(), bounds }
    }

    /// Of nodes and of the numbers in blocks.
    pub(crate) fn memory_bytes(&self) -> usize {
        self.node_bytes() + size_of_val(&self.blocks[..])
    }

    /// Of nodes.
    pub(crate) fn node_bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.compact[..]) + size_of_val(&self.children[..])
    }

    /// Converts the nodes to the requested form.
    pub(crate) fn settle(&mut self, memory: Memory) {
        if memory == Memory::Compact {
            let nodes = std::mem::take(&mut self.nodes);
            self.compact = Vec::with_capacity(nodes.len());
            prefer_huge_pages(&self.compact);
            self.compact.extend(nodes.iter().map(CompactNode::new));
            self.children = Arc::new(nodes.iter().map(|node| *node.children()).collect());
        }
    }

    /// Whether its nodes are the small ones.
    pub(crate) fn is_compact(&self) -> bool {
        !self.compact.is_empty()
    }

    /// The greatest coordinate of any plane.
    pub(crate) fn greatest(&self) -> f32 {
        let greatest = self.bounds.greatest();
        if self.is_compact() { CompactNode::widened(greatest) } else { greatest }
    }

    /// How many nodes there are.
    pub(crate) fn count(&self) -> usize {
        self.nodes.len() + self.compact.len()
    }

    /// The child at `lane` of node `index`, and its box.
    pub(crate) fn child(&self, index: usize, lane: usize) -> (Child, Aabb) {
        match self.nodes.get(index) {
            Some(node) => (node.child(lane), node.bounds(lane)),
            None => {
                let (node, children) = self.compact_node(index);
                (Child::at(children, lane), node.bounds(lane))
            }
        }
    }

    /// All nodes of a compact tree.
    #[inline(always)]
    pub(crate) fn compact_nodes(&self) -> CompactNodes<'_> {
        CompactNodes { boxes: &self.compact, children: &self.children }
    }

    /// A node of a compact tree, for callers that have tried the others.
    #[inline]
    pub(crate) fn compact_node(&self, index: usize) -> (&CompactNode, &Children) {
        match self.compact.get(index).zip(self.children.get(index)) {
            Some(node) => node,
            None => panic!("a tree of {} nodes is damaged: it refers to node {index}", self.count()),
        }
    }
}
