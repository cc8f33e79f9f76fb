// SPDX-License-Identifier: GPL-3.0-or-later
//! The fast builder: leaf blocks and the lowest nodes come from a curve through all primitives, without a
//! binary tree; only the levels above these nodes are built by the heuristic.
//! Source: [PL10] section 3 for the lower levels ([`Curve`]), [Wald07] for the upper ones. Cost: O(n), for the heuristic sees a
//! fiftieth of the primitives.
//! In: a curve, and the boxes of its blocks. Out: nodes; a leaf is a block of the curve.
//! Invariant: as for any build. Tests: `super::tests`.

use gnurt_accel_core::{Aabb, BuildError};

use super::binary::Careful;
use super::binary_node::{BinaryNode, Cluster};
use super::collapse::collapse;
use super::costs::{leaf_costs, made_costs};
use super::curve::Curve;
use super::reference::{Lanes, Reference};
use super::task_pool::TaskPool;
use crate::node::{Child, Node8, WIDTH};
use crate::tree::{DEEPEST, Tree};

/// From this depth on the tree over the clusters is divided by number only,
const BY_NUMBER: usize = 48;

/// and from this one where it became too deep: 2^27 blocks are reached after as many levels, and below them is a node.
const BY_NUMBER_WHEN_DEEP: usize = DEEPEST - 28;

/// Clusters are not split.
const NOTHING: &[Aabb] = &[];

/// The part of a tree that exists before the heuristic starts.
struct Made {
    nodes: Vec<Node8>,
    clusters: Vec<Cluster>,
    /// A reference to each cluster.
    references: Vec<Reference>,
}

/// The tree over the blocks of a curve, whose boxes are `boxes`; without the blocks themselves.
pub(super) fn over_curve(tasks: TaskPool, curve: &Curve, boxes: &[Lanes]) -> Result<Tree, BuildError> {
    let root = tasks.around(boxes);
    let tasks = tasks.scaled_to(&root);
    let Made { nodes, clusters, references } = lowest(tasks, curve, boxes);
    let bytes = size_of_val(&nodes[..]) + size_of_val(&clusters[..]) + size_of_val(&references[..]);
    // Binary nodes are two to each cluster, and there twice for a while.
    let bytes = bytes + 4 * size_of::<BinaryNode>() * clusters.len();
    tasks.watch.take(bytes);
    tasks.watch.result()?;
    let root = tasks.around(&references);
    let above = |by_number| {
        let mut references = references.clone();
        let binary = Careful::over(&clusters, &NOTHING, tasks, &root, by_number).build(&mut references, root);
        // A stopped build gives no tree.
        if tasks.watch.go_on() { collapse(&binary, &nodes, tasks) } else { None }
    };
    let tree = above(BY_NUMBER).or_else(|| above(BY_NUMBER_WHEN_DEEP));
    tasks.watch.give(bytes);
    tasks.watch.result()?;
    Ok(tree.expect("halving so early cannot lead deeper"))
}

/// The nodes over clusters.
fn lowest(tasks: TaskPool, curve: &Curve, boxes: &[Lanes]) -> Made {
    let count = curve.clusters.len();
    let mut made = Made {
        nodes: Vec::with_capacity(count),
        clusters: Vec::with_capacity(count),
        references: Vec::with_capacity(count),
    };
    let mut first = 0;
    for (number, &blocks) in (0..).zip(&curve.clusters) {
        let boxes = &boxes[first..first + usize::from(blocks)];
        let (child, bounds, costs) = match boxes {
            [only] => (Child::leaf(first, 1), *only, leaf_costs(only.half_area(tasks.scale))),
            _ => {
                let child = Child::node(made.nodes.len());
                let (node, bounds, below) = node_over(boxes, first, tasks.scale);
                made.nodes.push(node);
                (child, bounds, made_costs(bounds.half_area(tasks.scale), below))
            }
        };
        made.clusters.push(Cluster { child, costs });
        made.references.push(bounds.numbered(number));
        first += boxes.len();
    }
    made
}

/// A node over leaves of one block each, the first of which is block `first`: large ones are last, so that
/// rays without an order visit them first. Its box, and the surfaces of the leaves together.
fn node_over(boxes: &[Lanes], first: usize, scale: f32) -> (Node8, Lanes, f32) {
    let mut order = [(0.0, 0); WIDTH];
    let (mut whole, mut below) = (Lanes::EMPTY, 0.0);
    for (index, bounds) in boxes.iter().enumerate() {
        let area = bounds.half_area(scale);
        order[index] = (area, index);
        below += area;
        whole = whole.union(bounds);
    }
    let order = &mut order[..boxes.len()];
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut node = Node8::EMPTY;
    for (index, &(_, block)) in order.iter().enumerate() {
        node.set(index, &boxes[block].bounds(), Child::leaf(first + block, 1));
    }
    (node, whole, below)
}
