// SPDX-License-Identifier: GPL-3.0-or-later
//! Properties of a tree after any moves, and the effect of a single move.

use super::super::binary::Careful;
use super::super::{all_references, collapse};
use super::*;
use gnurt_accel_core::Aabb;
use gnurt_accel_core::control::{BuildControl, Watch};
use gnurt_simd::Level;
use gnurt_testkit::Random;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Boxes of all sizes, which a binned build does not put well.
fn mixed_boxes(count: usize) -> Vec<Aabb> {
    let mut random = Random::new(7);
    let mut one = || {
        let (at, to, size) = (random.point(), random.point(), random.unit().powi(6));
        Aabb::around(&[at, [0, 1, 2].map(|k| at[k] + size * to[k])])
    };
    (0..count).map(|_| one()).collect()
}

/// Divided by number only from a depth on.
fn nodes_over(boxes: &[Aabb], by_number: usize, tasks: TaskPool) -> Vec<BinaryNode> {
    let mut references = all_references(&boxes, false);
    let root = tasks.around(&references);
    Careful::new(&boxes, tasks, &root, by_number).build(&mut references, root)
}

/// Areas of all nodes, and numbers of all primitives in order; also checks boxes and heights.
fn walk(nodes: &[BinaryNode], tasks: TaskPool) -> (f64, Vec<u32>) {
    let (mut sum, mut numbers, mut reached, mut deepest) = (0.0, Vec::new(), 0, 0);
    let mut waiting = vec![(nodes.len() - 1, 0)];
    while let Some((at, depth)) = waiting.pop() {
        let node = &nodes[at];
        reached += 1;
        assert!(reached <= nodes.len() && depth <= DEEPEST, "{reached} nodes, {depth} deep");
        deepest = deepest.max(depth);
        sum += node.bounds.bounds().half_area();
        if node.is_leaf() {
            numbers.extend_from_slice(&node.numbers[..node.count as usize]);
            continue;
        }
        let children = node.children(at);
        let around = children.map(|child| nodes[child].bounds.bounds());
        assert_eq!(node.bounds.bounds(), around[0].union(&around[1]), "boxes fit at {at}");
        waiting.extend(children.map(|child| (child, depth + 1)));
    }
    assert_eq!(reached, nodes.len(), "all nodes are reached");
    let tree = MovableTree::new(nodes, tasks);
    assert_eq!(tree.movable(tree.root).height as usize, deepest, "the longest way is known");
    numbers.sort_unstable();
    (sum, numbers)
}

fn with_pool<R>(job: impl FnOnce(TaskPool) -> R) -> R {
    let watch = Watch::new(&());
    job(TaskPool { parallel: false, level: Level::best(), scale: 1.0, watch: &watch })
}

#[test]
fn every_round_makes_it_cheaper() {
    with_pool(|tasks| {
        for count in [1, 8, 9, 17, 40, 300, 3000] {
            let boxes = mixed_boxes(count);
            let mut nodes = nodes_over(&boxes, 2, tasks);
            let (first, numbers) = walk(&nodes, tasks);
            let mut before = first;
            for _ in 0..4 {
                let cost = reinsert(&mut nodes, &[1.0], tasks);
                let (after, same) = walk(&nodes, tasks);
                assert_eq!(numbers, same, "all {count} are still there");
                assert!(after <= before * (1.0 + 1e-12), "{after} after {before}");
                before = after;
                // The cost that is returned is that of the wide tree; floats add up to it.
                let tree = collapse::collapse(&nodes, &[], tasks).expect("it is not deep");
                let children = |node: &crate::node::Node8| -> f64 {
                    (0..crate::node::WIDTH).map(|lane| node.bounds(lane).half_area()).sum()
                };
                let wide: f64 = tree.nodes.iter().map(children).sum();
                let wide = if nodes.len() > 1 { wide + tree.bounds.half_area() } else { wide };
                assert!((f64::from(cost) - wide).abs() < 1e-4 * wide, "{cost} is {wide}");
            }
            assert!(count < 300 || before < 0.95 * first, "{before} is well below {first}");
        }
    });
}

#[test]
fn searches_find_the_best() {
    with_pool(|tasks| {
        let boxes = mixed_boxes(400);
        let nodes = nodes_over(&boxes, 64, tasks);
        let tree = MovableTree::new(&nodes, tasks);
        let count = nodes.len() as u32;
        let total = |tree: &MovableTree| -> f64 {
            tree.movables.iter().map(|movable| tree.exact_area(&movable.bounds)).sum()
        };
        let before = total(&tree);
        let nodes: Vec<u32> = (0..count).filter(|&at| tree.may_move(at)).collect();
        for level in Level::available() {
            let tree = MovableTree {
                tasks: TaskPool { level, ..tasks },
                ..MovableTree::new(&self::nodes_over(&boxes, 64, tasks), tasks)
            };
            let found = tree.search(&nodes);
            for &node in nodes.iter().step_by(7) {
                // Every position, by moving there.
                let mut least = before;
                for target in 0..count {
                    let mut moved = MovableTree { movables: tree.movables.clone(), ..tree };
                    moved.try_move(node, target);
                    least = least.min(total(&moved));
                }
                let gain = found.iter().find(|found| found.node == node).map_or(0.0, |found| found.gain);
                let (gain, most) = (f64::from(gain), before - least);
                assert!((gain - most).abs() < 1e-5, "{node} gains {gain}, {most} at most, at {level}");
            }
        }
    });
}

#[test]
fn threads_do_not_matter() {
    let boxes = mixed_boxes(5000);
    let watch = Watch::new(&());
    let single = TaskPool { parallel: false, level: Level::best(), scale: 1.0, watch: &watch };
    let first = nodes_over(&boxes, 64, single);
    let run = |parallel: bool| {
        let mut nodes = first.clone();
        let cost = reinsert(&mut nodes, THOROUGH, TaskPool { parallel, ..single });
        let links: Vec<_> = nodes.iter().map(|node| (node.bounds, node.numbers, node.shares)).collect();
        (cost, links)
    };
    let one = run(false);
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        assert!(pool.install(|| run(true)) == one, "{threads} threads make the same tree");
    }
}

/// Records progress, and stops at the `no`th call; 0 for never.
#[derive(Default)]
struct Notes {
    reported: Mutex<Vec<f32>>,
    requests: AtomicUsize,
    no: usize,
}

impl BuildControl for Notes {
    fn keep_going(&self) -> bool {
        self.requests.fetch_add(1, Relaxed) + 1 != self.no
    }

    fn progress(&self, done: f32) {
        self.reported.lock().expect("nobody panics").push(done);
    }
}

#[test]
fn progress_is_reported_and_cancelling_ends_it() {
    let boxes = mixed_boxes(2000);
    let nodes = with_pool(|tasks| nodes_over(&boxes, 64, tasks));
    let run = |no| {
        let notes = Notes { no, ..Notes::default() };
        let watch = Watch::new(&notes);
        watch.start(steps(nodes.len(), THOROUGH));
        let tasks = TaskPool { parallel: false, level: Level::best(), scale: 1.0, watch: &watch };
        let mut moved = nodes.clone();
        reinsert(&mut moved, THOROUGH, tasks);
        walk(&moved, tasks);
        let (reported, requests) =
            (notes.reported.into_inner().expect("nobody panics"), notes.requests.into_inner());
        (reported, requests, moved.iter().map(|node| node.bounds).collect::<Vec<_>>())
    };
    let (reported, requests, moved) = run(0);
    let pieces = nodes.len() / PIECE / 2;
    assert!(reported.is_sorted() && reported.len() > pieces, "{} times: {reported:?}", reported.len());
    assert!(reported.last().is_some_and(|&last| (0.7..=0.85).contains(&last)), "all of it: {reported:?}");
    // Searches of the first round; then its moves, which keep the tree's contents.
    let searches = (0.5 * nodes.len() as f32) as usize / PIECE;
    for no in [1, searches / 2, searches + 2, requests] {
        let (less, until, other) = run(no);
        assert_eq!(until, no, "it is not asked again");
        assert!(less.len() < reported.len(), "told {} times when it ends at {no} of {requests}", less.len());
        assert!(no == requests || other != moved, "{no} of {requests}: not all was done");
    }
}
