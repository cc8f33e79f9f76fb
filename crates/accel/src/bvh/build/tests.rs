// SPDX-License-Identifier: GPL-3.0-or-later
//! What must hold of every tree, whatever it is built over.
//! Source: original.

use super::*;
use crate::INVALID_ID;
use crate::bvh::Child;
use gnurt_testkit::Random;

struct Boxes(Vec<Aabb>);

impl Primitives for Boxes {
    fn count(&self) -> usize {
        self.0.len()
    }
    fn bounds(&self, number: usize) -> Aabb {
        self.0[number]
    }
    fn split(&self, _: usize, _: &Aabb, _: usize, _: f32) -> Option<[Option<Aabb>; 2]> {
        None
    }
}

fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    (0..3).all(|k| outer.min[k] <= inner.min[k] && outer.max[k] >= inner.max[k])
}

/// Walks the whole tree: boxes hold what is below, each primitive is in one leaf, nodes and blocks are all used once,
/// children come after parents.
fn check(boxes: &[Aabb], tree: &Tree) {
    if boxes.is_empty() {
        assert_eq!((tree.nodes.len(), tree.blocks.len()), (0, 0), "nothing is built over nothing");
        return;
    }
    let mut seen = vec![0; boxes.len()];
    let mut used = vec![0; tree.blocks.len()];
    let mut nodes = 1;
    let mut waiting = vec![(0, tree.bounds, 0)];
    while let Some((at, bounds, depth)) = waiting.pop() {
        assert!(depth < DEEPEST, "{depth} is not too deep");
        let node = &tree.nodes[at];
        for place in 0..WIDTH {
            let (inner, child) = (node.bounds(place), node.child(place));
            if inner.is_empty() {
                assert_eq!(child, Child::NONE, "nothing is in an empty box");
                continue;
            }
            assert!(holds(&bounds, &inner), "{bounds:?} holds {inner:?}");
            if !child.is_leaf() {
                assert!(child.index() > at, "children come after their parents");
                nodes += 1;
                waiting.push((child.index(), inner, depth + 1));
                continue;
            }
            assert!(!child.blocks().is_empty(), "a leaf holds something");
            for block in child.blocks() {
                used[block] += 1;
                for &number in tree.blocks[block].iter().filter(|&&number| number != INVALID_ID) {
                    seen[number as usize] += 1;
                    assert!(holds(&inner, &boxes[number as usize]), "the leaf {inner:?} holds {number}");
                }
            }
        }
    }
    assert_eq!(nodes, tree.nodes.len(), "all nodes are reached once");
    assert!(used.iter().all(|&times| times == 1), "all blocks are in one leaf");
    assert!(seen.iter().all(|&times| times == 1), "all primitives are in one leaf");
}

fn check_all(boxes: Vec<Aabb>) -> Tree {
    let boxes = Boxes(boxes);
    for quality in [Quality::Fast, Quality::High, Quality::Medium] {
        let tree = build(&boxes, quality, Threads::Single);
        check(&boxes.0, &tree);
        for threads in [1, 2, 4] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
            let same = build(&boxes, quality, Threads::Pool(&pool));
            assert!(same == tree, "{threads} threads build the same tree at {quality:?}");
        }
    }
    build(&boxes, Quality::Medium, Threads::Single)
}

fn random_boxes(random: &mut Random, count: usize, size: f32) -> Vec<Aabb> {
    let mut around = || {
        let (at, to) = (random.point(), random.point());
        Aabb::around(&[at, [0, 1, 2].map(|k| at[k] + size * to[k])])
    };
    (0..count).map(|_| around()).collect()
}

#[test]
fn random_boxes_are_all_found() {
    let mut random = Random::new(1);
    for count in [0, 1, 2, 7, 8, 9, 16, 17, 100, 1000] {
        for size in [0.0, 0.01, 1.0] {
            check_all(random_boxes(&mut random, count, size));
        }
    }
    let tree = check_all(random_boxes(&mut random, 20_000, 0.02));
    assert!(tree.blocks.len() < 20_000 / 4, "{} blocks are at least half full", tree.blocks.len());
}

#[test]
fn equal_boxes_share_leaves() {
    let unit = Aabb { min: [0.0; 3], max: [1.0; 3] };
    for count in [1, 8, 9, 120, 121, 5000] {
        let tree = check_all(vec![unit; count]);
        assert!(tree.blocks.len() <= count.div_ceil(WIDTH) + 1, "blocks are full, not {}", tree.blocks.len());
    }
}

#[test]
fn flat_and_huge_and_tiny_boxes() {
    let mut random = Random::new(2);
    for size in [1e-38, 1e-30, 1e-10, 1e18, 1e30] {
        let mut boxes = random_boxes(&mut random, 1000, 0.1);
        for bounds in &mut boxes {
            bounds.min = bounds.min.map(|x| x * size);
            bounds.max = bounds.max.map(|x| x * size);
        }
        check_all(boxes.clone());
        for bounds in &mut boxes {
            bounds.min[1] = size;
            bounds.max[1] = size;
        }
        check_all(boxes);
    }
}

#[test]
fn piles_stay_shallow() {
    // Each box is a bit larger than the one before: a split takes few from one end.
    let nested = (0..3000).map(|i| 1.05f32.powi(i % 800) * 1e-10);
    check_all(nested.map(|x| Aabb { min: [-x; 3], max: [x; 3] }).collect());
    let row = (0..2000).map(|i| 2.0f32.powi(i % 200 - 100));
    check_all(row.map(|x| Aabb { min: [x, 0.0, 0.0], max: [1.5 * x, x, x] }).collect());
}
