// SPDX-License-Identifier: GPL-3.0-or-later
//! Fits a shared structure to a pose: corners are gathered, boxes follow from the leaves to the root.
//! Source: [WBS06] section 4. Space: object. Cost: O(n), each vertex, block and node once: blocks and
//! compact nodes by all threads, corners and the boxes of nodes by one.
//! Invariant: the untraceable triangles of the pose are those of the structure's build; otherwise it requests
//! a build.
//! Tests: `tests/poses.rs` of `gnurt-accel`.

use gnurt_accel_core::threads::{Pieces, map};
use std::sync::Arc;

use gnurt_accel_core::surfaces::Surfaces;
use gnurt_accel_core::{Aabb, BadPrimitives, RefitError, Threads};
use gnurt_simd::{Level, Simd, dispatch_two};
use rayon::prelude::*;

use super::leaves::PosedLeaves;
use super::structure::VertexBlock;
use crate::compact::{Children, CompactNode};
use crate::gather::are_certain;
use crate::index::BvhIndex;
use crate::leaves::Leaves;
use crate::node::{Child, Node8, WIDTH};
use crate::refit::{Refitted, Sum};
use crate::tree::Tree;

/// Blocks or nodes that one thread takes at a time. Tests have small scenes.
const PIECE: usize = if cfg!(test) { 1 << 2 } else { 1 << 9 };

impl BvhIndex {
    /// A tree that shares its structure with this one, and holds nothing until it is [refitted](Self::refit) to a pose.
    /// `surfaces` gives the vertices of triangles; it is read once.
    ///
    /// # Errors
    /// That triangles have other vertices than when it was built.
    pub fn without_pose(&self, surfaces: &Surfaces) -> Result<Self, RefitError> {
        let structure = match (&self.leaves.posed, self.structure.get()) {
            (Some(posed), _) => &posed.structure,
            (None, Some(structure)) => structure,
            (None, None) => {
                let structure = Arc::new(self.find_structure(surfaces)?);
                // A second thread takes the structure of the first.
                self.structure.get_or_init(|| structure)
            }
        };
        let tree = Tree { children: Arc::clone(&structure.children), ..Tree::new(Aabb::EMPTY) };
        let posed = PosedLeaves { structure: Arc::clone(structure), corners: Vec::new() };
        let leaves = Leaves { posed: Some(posed), ..Leaves::default() };
        Ok(Self { leaves, ..Self::of_tree(tree, structure.stats) })
    }

    /// Whether it is one of several poses of a structure.
    #[must_use]
    pub fn is_posed(&self) -> bool {
        self.leaves.posed.is_some()
    }

    /// Bytes shared with other poses, if it is one.
    #[must_use]
    pub fn shared_bytes(&self) -> u64 {
        self.leaves.posed.as_ref().map_or(0, |posed| posed.structure.memory_bytes() as u64)
    }

    /// Whether it is a pose, and has the corners of this geometry, bit for bit.
    #[must_use]
    pub fn is_pose_of(&self, surfaces: &Surfaces) -> bool {
        let Some(PosedLeaves { structure, corners }) = &self.leaves.posed else { return false };
        let same = |(corner, &[geometry, vertex]): (&[f32], &[u32; 2])| {
            let position = surfaces.positions(geometry as usize).get(vertex as usize);
            position.is_some_and(|p| p.iter().zip(corner).all(|(a, b)| a.to_bits() == b.to_bits()))
        };
        structure.has_topology_of(surfaces) && corners.chunks_exact(3).zip(&structure.sources).all(same)
    }

    /// Fits a tree that is a pose.
    pub(crate) fn refit_pose(
        &mut self,
        surfaces: &Surfaces,
        threads: Threads,
    ) -> Result<Refitted, RefitError> {
        let Self { leaves: Leaves { posed: Some(posed), .. }, tree, stats, cost, .. } = self else {
            return Err(RefitError::Structure);
        };
        let structure = Arc::clone(&posed.structure);
        if !structure.has_topology_of(surfaces) {
            return Err(RefitError::OtherGeometry);
        }
        let mut bad = BadPrimitives::default();
        for &number in &structure.strays {
            if surfaces.judge(number, &mut bad) {
                return Err(RefitError::OtherPrimitives);
            }
        }
        take_corners(&structure.sources, surfaces, &mut posed.corners)?;
        threads.run(|parallel| {
            let boxes = boxes_of_blocks(posed, surfaces, parallel)?;
            let (bounds, below) = boxes_of_nodes(&structure.children, &boxes);
            let node = |children: &Children| compact_node(children, &boxes, &bounds);
            tree.compact.clear();
            match parallel && structure.children.len() > PIECE {
                true => structure
                    .children
                    .par_iter()
                    .with_min_len(PIECE)
                    .map(node)
                    .collect_into_vec(&mut tree.compact),
                false => tree.compact.extend(structure.children.iter().map(node)),
            }
            tree.bounds = bounds.first().copied().unwrap_or(Aabb::EMPTY);
            *cost = below;
            Ok(())
        })?;
        stats.sah_cost = 1.0 + f64::from(*cost);
        self.greatest = self.tree.greatest();
        let primitives = structure.count - structure.strays.len() as u64;
        Ok(Refitted { bad, primitives, same_slots: true })
    }
}

/// Copies the corners of a pose.
fn take_corners(sources: &[[u32; 2]], surfaces: &Surfaces, corners: &mut Vec<f32>) -> Result<(), RefitError> {
    corners.clear();
    corners.reserve_exact(3 * sources.len() + 1);
    for same in sources.chunk_by(|a, b| a[0] == b[0]) {
        let positions = surfaces.positions(same[0][0] as usize);
        for &[_, vertex] in same {
            corners.extend(positions.get(vertex as usize).ok_or(RefitError::OtherPrimitives)?);
        }
    }
    corners.push(0.0);
    Ok(())
}

/// Boxes of all leaf blocks, all of whose triangles can be traced.
fn boxes_of_blocks(
    posed: &PosedLeaves,
    surfaces: &Surfaces,
    parallel: bool,
) -> Result<Vec<Aabb>, RefitError> {
    let level = Level::best();
    let blocks = posed.blocks();
    let mut boxes = vec![Aabb::EMPTY; blocks.len()];
    let piece = |(blocks, boxes): (&[VertexBlock], &mut [Aabb])| {
        let mut doubtful = Vec::new();
        dispatch_two!(level, simd => boxes_of_piece(simd, posed, blocks, boxes, &mut doubtful));
        // A quad's half counts with its quad, which is as a build decides it.
        let is_good = |&number: &u32| surfaces.judge(number, &mut BadPrimitives::default());
        let good = doubtful.iter().all(|&at: &usize| blocks[at].numbers.iter().all(is_good));
        if good { Ok(()) } else { Err(RefitError::OtherPrimitives) }
    };
    let in_pieces = Pieces::new(&mut boxes, PIECE);
    let fitted = map(parallel, in_pieces.count(), |i| {
        let boxes = &mut *in_pieces.lock(i);
        piece((&blocks[i * PIECE..i * PIECE + boxes.len()], boxes))
    });
    fitted.into_iter().collect::<Result<(), _>>()?;
    Ok(boxes)
}

/// Those of some blocks; notes which may have a triangle that cannot be traced.
#[inline(always)]
fn boxes_of_piece<S: Simd>(
    simd: S,
    posed: &PosedLeaves,
    blocks: &[VertexBlock],
    boxes: &mut [Aabb],
    doubtful: &mut Vec<usize>,
) {
    for (at, (block, bounds)) in blocks.iter().zip(boxes).enumerate() {
        let triangles = posed.gather(simd, block);
        *bounds = triangles.bounds();
        if !are_certain(simd, &triangles.rows(), bounds) {
            doubtful.push(at);
        }
    }
}

/// Boxes around each node's subtree, and the expected cost of a ray that hits the root.
fn boxes_of_nodes(nodes: &[Children], blocks: &[Aabb]) -> (Vec<Aabb>, f32) {
    let mut bounds = vec![Aabb::EMPTY; nodes.len()];
    let mut costs = vec![0.0; nodes.len()];
    for (at, children) in nodes.iter().enumerate().rev() {
        let mut sum = Sum::NONE;
        for lane in 0..WIDTH {
            let child = Child::at(children, lane);
            sum.add(child, &box_of(child, blocks, &bounds), |index| costs[index]);
        }
        (bounds[at], costs[at]) = (sum.whole, sum.cost());
    }
    (bounds, costs.first().copied().unwrap_or(0.0))
}

#[inline(always)]
fn box_of(child: Child, blocks: &[Aabb], nodes: &[Aabb]) -> Aabb {
    match child.is_leaf() {
        true => blocks[child.blocks()].iter().fold(Aabb::EMPTY, |all, one| all.union(one)),
        false => nodes[child.index()],
    }
}

fn compact_node(children: &Children, blocks: &[Aabb], nodes: &[Aabb]) -> CompactNode {
    let mut node = Node8::EMPTY;
    for lane in 0..WIDTH {
        let child = Child::at(children, lane);
        if child != Child::NONE {
            node.set(lane, &box_of(child, blocks, nodes), child);
        }
    }
    CompactNode::new(&node)
}
