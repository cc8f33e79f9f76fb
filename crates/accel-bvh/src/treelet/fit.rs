// SPDX-License-Identifier: GPL-3.0-or-later
//! Boxes of a treelet's nodes after those of its members. Source: [WBS06]: children come after their parents, so that one pass from
//! the end refits. Space: that of the boxes. Tests: `treelet::tests`.

use crate::node::{Child, Node8, WIDTH};

/// Lanes of a node that have a child, and its index.
pub(super) fn below(node: &Node8) -> impl Iterator<Item = (usize, usize)> {
    let taken = (0..WIDTH).map(|lane| (lane, node.child(lane))).filter(|(_, child)| *child != Child::NONE);
    taken.map(|(lane, child)| (lane, if child.is_leaf() { child.blocks().start } else { child.index() }))
}

/// Makes the boxes of nodes the smallest again.
pub(super) fn refit(nodes: &mut [Node8], first_block: usize) {
    for at in (0..first_block).rev() {
        let mut node = nodes[at];
        for (lane, child) in below(&nodes[at]) {
            node.set(lane, &nodes[child].whole(), node.child(lane));
        }
        nodes[at] = node;
    }
}
