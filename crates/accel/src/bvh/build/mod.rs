// SPDX-License-Identifier: GPL-3.0-or-later
//! Building a wide BVH by the surface area heuristic.
//! Source: binned heuristic [Wald07], improved by reinsertion [MB18], made into nodes of the least cost [YKL17]. With time to
//! spare the same with spatial splits [SFD09]; the cheaper of both trees is taken, since either may be: splits that are
//! good at the top of a tree leave less to gain below.
//! In: boxes of primitives. Out: [`Tree`]. Cost: O(n log n).
//! Invariant: every primitive is in at least one leaf whose box, and that of all nodes above, holds (its part of) it;
//! the tree does not depend on the number of threads. Proof: `tests`.

mod binary;
mod bins;
mod cluster;
mod collapse;
mod crew;
mod partition;
mod reference;
mod reinsert;
mod spatial;
mod stages;
#[cfg(test)]
mod tests;

use super::compact::CompactNode;
use super::node::{Child, Node8, WIDTH};
use crate::control::Watch;
use crate::options::extend;
use crate::{Aabb, BuildError, Memory, Quality, Threads};
use binary::{Careful, Knot};
pub(crate) use collapse::DEEPEST;
use collapse::collapse;
use crew::Crew;
use gnurt_simd::{Level, prefer_huge_pages};
use reference::Reference;
use reinsert::{QUICK, THOROUGH, reinsert};
use stages::Stages;

/// What a tree is built over: boxes, by numbers from 0 on.
pub(crate) trait Primitives: Sync {
    /// How many there are.
    fn count(&self) -> usize;
    /// The box of one.
    fn bounds(&self, number: usize) -> Aabb;
    /// Boxes of the parts of `number` within `cell` on both sides of a plane; `None` where it has no part. Those that
    /// cannot be split answer with `None` for the whole, as they do unless they say otherwise.
    fn split(&self, _number: usize, _cell: &Aabb, _axis: usize, _at: f32) -> Option<[Option<Aabb>; 2]> {
        None
    }
}

/// Boxes of what cannot be split.
impl Primitives for &[Aabb] {
    fn count(&self) -> usize {
        self.len()
    }

    fn bounds(&self, number: usize) -> Aabb {
        self[number]
    }
}

/// A tree without what it is built over.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tree {
    /// The root comes first; without primitives there is none. Children come after their parents.
    pub(crate) nodes: Vec<Node8>,
    /// The nodes of a compact tree, which has no others.
    pub(crate) compact: Vec<CompactNode>,
    /// Numbers of the primitives, leaf block by leaf block, eight to each; padded with `INVALID_ID`.
    pub(crate) blocks: Vec<[u32; WIDTH]>,
    /// Box around everything.
    pub(crate) bounds: Aabb,
}

/// From this depth on a binary tree is divided by number alone.
const BY_NUMBER: usize = 64;

/// As above, where the wide tree became too deep: with 2^30 primitives halves of halves reach blocks after 28 more levels.
const BY_NUMBER_WHEN_DEEP: usize = DEEPEST - 28;

/// A tree with parts of primitives has to be so much cheaper, since it is larger.
const WORTH_PARTS: f32 = 0.99;

/// Builds over all primitives.
pub(crate) fn build(primitives: &impl Primitives, quality: Quality, threads: Threads) -> Tree {
    try_build(primitives, quality, threads, &Watch::new(&())).expect("nobody stops it")
}

/// The same under control. What the tree takes stays counted.
pub(crate) fn try_build(
    primitives: &impl Primitives,
    quality: Quality,
    threads: Threads,
    watch: &Watch,
) -> Result<Tree, BuildError> {
    threads.run(|parallel| build_with(primitives, quality, parallel, watch))
}

fn build_with(
    primitives: &impl Primitives,
    quality: Quality,
    parallel: bool,
    watch: &Watch,
) -> Result<Tree, BuildError> {
    let count = primitives.count();
    if count == 0 {
        return Ok(Tree::new(Aabb::EMPTY));
    }
    // What cannot be split has no parts.
    let first = primitives.bounds(0);
    let middle = 0.5 * first.min[0] + 0.5 * first.max[0];
    let try_parts = quality == Quality::High && primitives.split(0, &first, 0, middle).is_some();
    let with_parts = count + count / 2;
    let mut stages = Stages::new(watch, quality, count, if try_parts { with_parts } else { 0 });
    let mut held = 0;
    let mut hold = |bytes| {
        watch.recount(&mut held, bytes);
        watch.result()
    };
    hold(size_of::<Reference>() * count)?;
    let mut references = all_references(primitives, parallel);
    let crew = Crew { parallel, level: Level::best(), scale: 1.0, watch };
    let root = crew.around(&references);
    let longest = root.bounds.bounds().extent().into_iter().fold(f64::from(f32::MIN_POSITIVE), f64::max);
    let crew = Crew { scale: (1.0 / longest) as f32, ..crew };
    let careful = Careful::new(primitives, crew, &root, BY_NUMBER);
    let mut knots = match quality {
        Quality::Fast => cluster::build(primitives, crew, &references, &root),
        _ => careful.build(&mut references, root),
    };
    watch.grown();
    stages.end();
    if try_parts {
        hold(size_of::<Reference>() * with_parts + size_of_val(&knots[..]))?;
        references.resize(with_parts, Reference::ZERO);
    } else {
        references = Vec::new();
        hold(size_of_val(&knots[..]))?;
    }
    let cost = if quality == Quality::Fast { 0.0 } else { reinsert(&mut knots, QUICK, crew) };
    stages.end();
    if try_parts {
        let mut others = careful.build(&mut references, root);
        watch.grown();
        stages.end();
        drop(references);
        hold(size_of_val(&knots[..]) + size_of_val(&others[..]))?;
        if reinsert(&mut others, QUICK, crew) < WORTH_PARTS * cost {
            knots = others;
        }
        stages.end();
        hold(size_of_val(&knots[..]))?;
    }
    if quality == Quality::High {
        reinsert(&mut knots, THOROUGH, crew);
    }
    if let Some(tree) = collapsed(&knots, crew)? {
        hold(0)?;
        return Ok(tree);
    }
    // A strange scene. A flat tree is not fast, but it is one.
    drop(knots);
    let mut references = all_references(primitives, parallel);
    let knots = Careful::new(primitives, crew, &root, BY_NUMBER_WHEN_DEEP).build(&mut references, root);
    let tree = collapsed(&knots, crew)?;
    hold(0)?;
    Ok(tree.expect("halving so early cannot lead deeper"))
}

/// The wide tree, where it is not too deep; it is counted.
fn collapsed(knots: &[Knot], crew: Crew) -> Result<Option<Tree>, BuildError> {
    let watch = crew.watch;
    // Every second knot is a leaf, and a node holds at least four of them on average; all is there twice for a while.
    let mut held = 0;
    watch.recount(&mut held, knots.len() * (size_of::<[u32; WIDTH]>() + size_of::<Node8>() / 4));
    watch.result()?;
    let tree = collapse(knots, crew);
    watch.recount(&mut held, tree.as_ref().map_or(0, Tree::memory_bytes));
    watch.result()?;
    Ok(tree)
}

impl Tree {
    /// Without nodes.
    pub(crate) fn new(bounds: Aabb) -> Self {
        Self { nodes: Vec::new(), compact: Vec::new(), blocks: Vec::new(), bounds }
    }

    /// Of nodes and of the numbers in blocks.
    pub(crate) fn memory_bytes(&self) -> usize {
        self.node_bytes() + size_of_val(&self.blocks[..])
    }

    /// Of nodes.
    pub(crate) fn node_bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.compact[..])
    }

    /// Brings the nodes into the form that is wanted.
    pub(crate) fn settle(&mut self, memory: Memory) {
        if memory == Memory::Compact {
            let nodes = std::mem::take(&mut self.nodes);
            self.compact = Vec::with_capacity(nodes.len());
            prefer_huge_pages(&self.compact);
            self.compact.extend(nodes.iter().map(CompactNode::new));
        }
    }

    /// Whether its nodes are the small ones.
    pub(crate) fn is_compact(&self) -> bool {
        !self.compact.is_empty()
    }

    /// The greatest coordinate of any plane.
    pub(crate) fn reach(&self) -> f32 {
        let reach = self.bounds.reach();
        if self.is_compact() { CompactNode::widened(reach) } else { reach }
    }

    /// How many nodes there are.
    pub(crate) fn count(&self) -> usize {
        self.nodes.len() + self.compact.len()
    }

    /// What hangs at `place` of node `index`, and its box.
    pub(crate) fn child(&self, index: usize, place: usize) -> (Child, Aabb) {
        match self.nodes.get(index) {
            Some(node) => (node.child(place), node.bounds(place)),
            None => (self.compact[index].child(place), self.compact[index].bounds(place)),
        }
    }
}

fn all_references(primitives: &impl Primitives, parallel: bool) -> Vec<Reference> {
    let number_and_box = |number: usize| Reference::new(number as u32, &primitives.bounds(number));
    let mut references = Vec::new();
    extend(parallel, &mut references, primitives.count(), number_and_box);
    references
}
