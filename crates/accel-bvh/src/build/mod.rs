// SPDX-License-Identifier: GPL-3.0-or-later
//! Building a wide BVH by the surface area heuristic.
//! Source: binned heuristic [Wald07], improved by reinsertion [MB18], made into nodes of the least cost [YKL17]. With time to
//! spare the same with spatial splits [SFD09]; the cheaper of both trees is taken, since either may be: splits that are
//! good at the top of a tree leave less to gain below. With no time at all: `fast`.
//! In: boxes of primitives. Out: [`Tree`]. Cost: O(n log n).
//! Invariant: every primitive is in at least one leaf whose box, and that of all nodes above, holds (its part of) it;
//! the tree does not depend on the number of threads. Tests: `tests`.

mod binary;
mod binary_node;
mod bins;
mod collapse;
mod costs;
mod curve;
mod fast;
mod partition;
pub(crate) mod parts;
mod radix;
mod reference;
mod reinsert;
mod spatial;
mod stages;
mod task_pool;
#[cfg(test)]
mod tests;

use crate::node::{Child, Node8, WIDTH};
use crate::primitives::Primitives;
use crate::tree::{DEEPEST, Tree};
use binary::Careful;
use binary_node::BinaryNode;
use collapse::collapse;
use curve::Curve;
pub(crate) use curve::Middle;
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::threads::extend;
use gnurt_accel_core::{Aabb, BuildError, INVALID_ID, Quality, Threads};
use gnurt_simd::Level;
pub(crate) use reference::{Lanes, Reference};
use reinsert::{QUICK, THOROUGH, reinsert};
use stages::Stages;
use task_pool::TaskPool;

/// From this depth on a binary tree is divided by number only.
const BY_NUMBER: usize = 64;

/// As above, where the wide tree became too deep: with 2^30 primitives halves of halves reach blocks after 28 more levels.
const BY_NUMBER_WHEN_DEEP: usize = DEEPEST - 28;

/// A tree with spatial splits must be cheaper by this factor, because it is larger.
const WORTH_PARTS: f32 = 0.99;

/// Builds over all primitives, uncontrolled.
///
/// # Errors
/// That there are too many.
pub(crate) fn build(
    primitives: &dyn Primitives,
    quality: Quality,
    threads: Threads,
) -> Result<Tree, BuildError> {
    try_build(primitives, Vec::new(), quality, threads, &Watch::new(&()))
}

/// The same under control; with references where they are there already, which are counted from here on. The
/// tree's memory stays counted.
pub(crate) fn try_build(
    primitives: &dyn Primitives,
    references: Vec<Reference>,
    quality: Quality,
    threads: Threads,
    watch: &Watch,
) -> Result<Tree, BuildError> {
    threads.run(|parallel| build_with(primitives, references, quality, parallel, watch))
}

fn build_with(
    primitives: &dyn Primitives,
    given: Vec<Reference>,
    quality: Quality,
    parallel: bool,
    watch: &Watch,
) -> Result<Tree, BuildError> {
    let count = primitives.count();
    if count == 0 {
        return Ok(Tree::new(Aabb::EMPTY));
    }
    if quality == Quality::Fast {
        return build_fast(primitives, parallel, watch);
    }
    // Primitives that cannot be split have no parts.
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
    let mut references = if given.is_empty() { all_references(primitives, parallel) } else { given };
    let tasks = TaskPool { parallel, level: Level::best(), scale: 1.0, watch };
    let root = tasks.around(&references);
    let tasks = tasks.scaled_to(&root);
    let careful = Careful::new(primitives, tasks, &root, BY_NUMBER);
    let mut nodes = careful.build(&mut references, root);
    watch.grown();
    stages.end();
    if try_parts {
        hold(size_of::<Reference>() * with_parts + size_of_val(&nodes[..]))?;
        references.resize(with_parts, Reference::ZERO);
    } else {
        references = Vec::new();
        hold(size_of_val(&nodes[..]))?;
    }
    let cost = reinsert(&mut nodes, QUICK, tasks);
    stages.end();
    if try_parts {
        let mut others = careful.build(&mut references, root);
        watch.grown();
        stages.end();
        drop(references);
        hold(size_of_val(&nodes[..]) + size_of_val(&others[..]))?;
        if reinsert(&mut others, QUICK, tasks) < WORTH_PARTS * cost {
            nodes = others;
        }
        stages.end();
        hold(size_of_val(&nodes[..]))?;
    }
    if quality == Quality::High {
        reinsert(&mut nodes, THOROUGH, tasks);
    }
    if let Some(tree) = collapsed(&nodes, tasks)? {
        hold(0)?;
        return Ok(tree);
    }
    // A strange scene. A flat tree is not fast, but it is one.
    drop(nodes);
    let mut references = all_references(primitives, parallel);
    let nodes = Careful::new(primitives, tasks, &root, BY_NUMBER_WHEN_DEEP).build(&mut references, root);
    let tree = collapsed(&nodes, tasks)?;
    hold(0)?;
    Ok(tree.expect("halving so early cannot lead deeper"))
}

/// The wide tree, where it is not too deep; it is counted.
fn collapsed(nodes: &[BinaryNode], tasks: TaskPool) -> Result<Option<Tree>, BuildError> {
    let watch = tasks.watch;
    let blocks = nodes.iter().filter(|node| node.is_leaf()).count();
    within_numbers(blocks)?;
    // Every second node is a leaf, and a node holds at least four of them on average; all is there twice for a while.
    let mut held = 0;
    watch.recount(&mut held, nodes.len() * (size_of::<[u32; WIDTH]>() + size_of::<Node8>() / 4));
    watch.result()?;
    let tree = collapse(nodes, &[], tasks);
    watch.recount(&mut held, tree.as_ref().map_or(0, Tree::memory_bytes));
    watch.result()?;
    Ok(tree)
}

fn build_fast(primitives: &dyn Primitives, parallel: bool, watch: &Watch) -> Result<Tree, BuildError> {
    let count = primitives.count();
    let middle = |number: usize| Middle::of(&primitives.bounds(number), number as u32);
    let mut middles = Vec::new();
    extend(parallel, &mut middles, count, middle);
    let around = |block: &[u32; WIDTH]| {
        let numbers = block.iter().filter(|&&number| number != INVALID_ID);
        let bounds = numbers.map(|&number| primitives.bounds(number as usize));
        Lanes::new(0, &bounds.fold(Aabb::EMPTY, |all, one| all.union(&one)))
    };
    let make = |blocks: &[[u32; WIDTH]]| {
        let mut boxes = Vec::new();
        extend(parallel, &mut boxes, blocks.len(), |i| around(&blocks[i]));
        Ok((boxes, ()))
    };
    Ok(build_along_curve(middles, make, parallel, watch)?.0)
}

/// The fast builder; `make` converts all leaf blocks, and returns their boxes.
///
/// # Errors
/// That `watch` stopped it, or that there are too many blocks.
pub(crate) fn build_along_curve<T>(
    middles: Vec<Middle>,
    make: impl FnOnce(&[[u32; WIDTH]]) -> Result<(Vec<Lanes>, T), BuildError>,
    parallel: bool,
    watch: &Watch,
) -> Result<(Tree, T), BuildError> {
    let tasks = TaskPool { parallel, level: Level::best(), scale: 1.0, watch };
    let mut held = 0;
    let mut hold = |bytes| {
        watch.recount(&mut held, bytes);
        watch.result()
    };
    let count = middles.len();
    watch.start(count);
    // Codes, and those before they are sorted.
    let of_middles = size_of_val(&middles[..]);
    hold(of_middles + 2 * size_of::<u64>() * middles.len())?;
    let mut curve = Curve::through(tasks, &middles);
    drop(middles);
    let blocks = curve.blocks.len();
    watch.result()?;
    within_numbers(blocks)?;
    hold((size_of::<[u32; WIDTH]>() + size_of::<Lanes>()) * blocks)?;
    let (boxes, made) = make(&curve.blocks)?;
    watch.advance_to(count);
    let mut tree = fast::over_curve(tasks, &curve, &boxes)?;
    tree.blocks = std::mem::take(&mut curve.blocks);
    hold(tree.memory_bytes())?;
    Ok((tree, made))
}

/// Whether leaves can number this many blocks.
fn within_numbers(blocks: usize) -> Result<(), BuildError> {
    if blocks > Child::MOST_NUMBERS {
        let (blocks, most) = (blocks as u64, Child::MOST_NUMBERS as u64);
        return Err(BuildError::TooManyBlocks { blocks, most });
    }
    Ok(())
}

fn all_references(primitives: &dyn Primitives, parallel: bool) -> Vec<Reference> {
    let number_and_box = |number: usize| Reference::new(number as u32, &primitives.bounds(number));
    let mut references = Vec::new();
    extend(parallel, &mut references, primitives.count(), number_and_box);
    references
}
