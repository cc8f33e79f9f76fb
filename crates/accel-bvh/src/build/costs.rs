// SPDX-License-Identifier: GPL-3.0-or-later
//! Expected costs of nodes of eight children, made from a binary tree. Source: [YKL17] section 3.1: for each
//! node of the binary tree, from the leaves to the root, its least cost in a limited number of slots. Tests:
//! `super::tests`.

use crate::node::WIDTH;

/// Cost of a step through a node, in blocks.
const NODE: f32 = 1.0;

/// Least costs of a node's representation in at most 1, 2 ... 7 slots of a wide node; the first element is
/// not used.
pub(super) type Costs = [f32; WIDTH];

/// For each number of slots, the left child's; 0 if one slot less has the same cost. With 8 it is the node
/// made of the node itself that has them.
pub(super) type Shares = [u8; WIDTH + 1];

/// Costs of a leaf of one block, given half its surface.
pub(super) fn leaf_costs(area: f32) -> Costs {
    [area; WIDTH]
}

/// Costs of a wide node that was made before, given half its surface and the surfaces of its leaves.
pub(super) fn made_costs(area: f32, below: f32) -> Costs {
    [NODE * area + below; WIDTH]
}

/// Costs of a node with two children, given half its surface, and the division of its slots.
pub(super) fn inner_costs(area: f32, left: &Costs, right: &Costs) -> (Costs, Shares) {
    let (mut costs, mut shares) = ([f32::INFINITY; WIDTH], [0; WIDTH + 1]);
    for slots in (2..=WIDTH).rev() {
        let (mut least, mut on_left) = (f32::INFINITY, 1);
        for share in 1..slots {
            let cost = left[share] + right[slots - share];
            if cost < least {
                (least, on_left) = (cost, share);
            }
        }
        shares[slots] = on_left as u8;
        if slots < WIDTH {
            costs[slots] = least;
        } else {
            costs[1] = least + NODE * area;
        }
    }
    for slots in 2..WIDTH {
        if costs[slots - 1] <= costs[slots] {
            costs[slots] = costs[slots - 1];
            shares[slots] = 0;
        }
    }
    (costs, shares)
}
