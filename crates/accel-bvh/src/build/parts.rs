// SPDX-License-Identifier: GPL-3.0-or-later
//! Adjacent boxes in parts of limited size, with a tree for each part: the pieces of a top tree, of which an
//! edit rebuilds few. The binned heuristic [Wald07] makes the parts from the whole downwards.
//! Invariant: each box is in one part; independent of threads. Tests: `boxes::build::tests`.

use gnurt_accel_core::control::Watch;
use gnurt_accel_core::{Aabb, BuildError, Quality, Threads};
use gnurt_simd::Level;

use super::binary::{Careful, Workspace};
use super::collapse::collapse;
use super::reference::{Part, Reference};
use super::reinsert::{THOROUGH, reinsert};
use super::task_pool::TaskPool;
use super::{BY_NUMBER, BY_NUMBER_WHEN_DEEP, all_references};
use crate::tree::Tree;

/// More boxes than this are divided by several threads. Tests have small scenes.
const PIECE: usize = if cfg!(test) { 1 << 9 } else { 1 << 12 };

/// How boxes are parted.
#[derive(Clone, Copy)]
pub(crate) struct PartOptions {
    /// Most boxes of a part.
    pub(crate) most: usize,
    pub(crate) quality: Quality,
}

/// The trees of all parts, made into something by `make`; empty boxes are in none. Numbers are indices of
/// `boxes`.
///
/// # Errors
/// That `watch` stopped it.
pub(crate) fn build_parts<T: Send>(
    boxes: &[Aabb],
    options: PartOptions,
    threads: Threads,
    watch: &Watch,
    make: impl Fn(Tree) -> T + Sync,
) -> Result<Vec<T>, BuildError> {
    threads.run(|parallel| {
        let bytes = size_of::<Reference>() * boxes.len();
        watch.take(bytes);
        watch.result()?;
        let mut references = all_references(&boxes, parallel);
        references.retain(|reference| !reference.bounds().is_empty());
        watch.start(references.len());
        let tasks = TaskPool { parallel, level: Level::best(), scale: 1.0, watch };
        let root = tasks.around(&references);
        let tasks = tasks.scaled_to(&root);
        let parting = Parting {
            careful: Careful::new(&boxes, tasks, &root, BY_NUMBER),
            single: Careful::new(&boxes, TaskPool { parallel: false, ..tasks }, &root, BY_NUMBER_WHEN_DEEP),
            options,
            make: &make,
        };
        let mut parts = Vec::new();
        if !references.is_empty() {
            parting.part(&mut references, root, 0, &mut Workspace::new(), &mut parts);
        }
        watch.give(bytes);
        watch.result()?;
        Ok(parts)
    })
}

struct Parting<'a, M> {
    careful: Careful<'a>,
    single: Careful<'a>,
    options: PartOptions,
    make: &'a M,
}

impl<T: Send, M: Fn(Tree) -> T + Sync> Parting<'_, M> {
    /// Divides `references`, all of `part`, until parts are small enough.
    fn part(
        &self,
        references: &mut [Reference],
        part: Part,
        depth: usize,
        workspace: &mut Workspace,
        parts: &mut Vec<T>,
    ) {
        let tasks = self.careful.tasks;
        let count = part.count();
        if count <= self.options.most {
            parts.extend(self.tree(references, part).map(self.make));
            tasks.watch.advance(count);
            return;
        }
        let large = count > PIECE;
        if large && !tasks.watch.go_on() {
            return;
        }
        let [left, right] = self.careful.divide(references, &part, depth, workspace);
        let (left_references, right_references) = references.split_at_mut(right.start);
        let right = Part { start: 0, end: right.count(), ..right };
        if tasks.parallel && large {
            let mut split_off = Vec::new();
            tasks.both(
                || self.part(left_references, left, depth + 1, workspace, parts),
                || self.part(right_references, right, depth + 1, &mut Workspace::new(), &mut split_off),
            );
            parts.append(&mut split_off);
        } else {
            self.part(left_references, left, depth + 1, workspace, parts);
            self.part(right_references, right, depth + 1, workspace, parts);
        }
    }

    /// The tree of a part.
    fn tree(&self, references: &mut [Reference], part: Part) -> Option<Tree> {
        let mut nodes = self.single.build(references, part);
        if self.options.quality == Quality::High {
            reinsert(&mut nodes, THOROUGH, self.single.tasks);
        }
        collapse(&nodes, &[], self.single.tasks)
    }
}
