// SPDX-License-Identifier: GPL-3.0-or-later
//! Properties of every tree, for any input.

use super::*;
use crate::node::Child;
use gnurt_accel_core::INVALID_ID;
use gnurt_testkit::Random;

/// Of few enough primitives.
fn build(primitives: &impl Primitives, quality: Quality, threads: Threads) -> Tree {
    super::build(primitives, quality, threads).expect("few enough")
}

/// Corners of triangles.
struct Corners(Vec<[[f32; 3]; 3]>);

impl Primitives for Corners {
    fn count(&self) -> usize {
        self.0.len()
    }
    fn bounds(&self, number: usize) -> Aabb {
        Aabb::around(&self.0[number])
    }
    fn split(&self, number: usize, cell: &Aabb, axis: usize, at: f32) -> Option<[Option<Aabb>; 2]> {
        Some(gnurt_accel_core::clip::split_boxes(&self.0[number], cell, axis, at))
    }
}

fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    (0..3).all(|k| outer.min[k] <= inner.min[k] && outer.max[k] >= inner.max[k])
}

/// Visits the whole tree: boxes enclose their subtrees, each primitive is in one leaf, nodes and blocks are
/// all used once, children come after parents.
fn check(boxes: &[Aabb], tree: &Tree) {
    if boxes.is_empty() {
        assert_eq!((tree.nodes.len(), tree.blocks.len()), (0, 0), "nothing is built over nothing");
        return;
    }
    let mut visited = vec![0; boxes.len()];
    let mut used = vec![0; tree.blocks.len()];
    let mut nodes = 1;
    let mut waiting = vec![(0, tree.bounds, 0)];
    while let Some((at, bounds, depth)) = waiting.pop() {
        assert!(depth < DEEPEST, "{depth} is not too deep");
        let node = &tree.nodes[at];
        for lane in 0..WIDTH {
            let (inner, child) = (node.bounds(lane), node.child(lane));
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
                    visited[number as usize] += 1;
                    assert!(holds(&inner, &boxes[number as usize]), "the leaf {inner:?} holds {number}");
                }
            }
        }
    }
    assert_eq!(nodes, tree.nodes.len(), "all nodes are reached once");
    assert!(used.iter().all(|&times| times == 1), "all blocks are in one leaf");
    assert!(visited.iter().all(|&times| times == 1), "all primitives are in one leaf");
}

fn check_all(boxes: Vec<Aabb>) -> Tree {
    let boxes = &boxes[..];
    for quality in [Quality::Fast, Quality::High, Quality::Medium] {
        let tree = build(&boxes, quality, Threads::Single);
        check(boxes, &tree);
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

/// Stops after this number of calls.
struct Patience(std::sync::atomic::AtomicU32);

impl gnurt_accel_core::control::BuildControl for Patience {
    fn keep_going(&self) -> bool {
        self.0.fetch_sub(1, std::sync::atomic::Ordering::Relaxed) > 1
    }
}

#[test]
fn what_is_stopped_is_no_tree() {
    let all = random_boxes(&mut Random::new(7), 20_000, 0.01);
    // Large enough that several threads would build the tree over clusters, too.
    for (quality, boxes) in [(Quality::Fast, &all[..]), (Quality::Medium, &all[..3000])] {
        let mut stopped = 0;
        for no in 1.. {
            let control = Patience(no.into());
            let watch = Watch::new(&control);
            match try_build(&boxes, Vec::new(), quality, Threads::Single, &watch) {
                Ok(tree) => {
                    check(boxes, &tree);
                    break;
                }
                Err(error) => assert_eq!(error, BuildError::Cancelled, "{quality:?}, asked {no} times"),
            }
            stopped += 1;
        }
        assert!(stopped > 4, "{quality:?} is asked more than {stopped} times");
    }
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
    // Each box is a bit larger than its predecessor: a split takes few from one end.
    let nested = (0..3000).map(|i| 1.05f32.powi(i % 800) * 1e-10);
    check_all(nested.map(|x| Aabb { min: [-x; 3], max: [x; 3] }).collect());
    let row = (0..2000).map(|i| 2.0f32.powi(i % 200 - 100));
    check_all(row.map(|x| Aabb { min: [x, 0.0, 0.0], max: [1.5 * x, x, x] }).collect());
}

/// Long triangles in all directions, which need spatial splits.
fn needles(random: &mut Random, count: usize) -> Corners {
    let mut needle = || {
        let (from, to, by) = (random.point(), random.point(), random.point());
        [from, to, [0, 1, 2].map(|k| from[k] + 0.02 * by[k])]
    };
    Corners((0..count).map(|_| needle()).collect())
}

#[test]
fn parts_cover_the_whole() {
    let mut random = Random::new(3);
    let triangles = needles(&mut random, 2000);
    let tree = build(&triangles, Quality::High, Threads::Single);
    // All boxes that a triangle is seen in: those of leaves, as far as the boxes above reach.
    let mut visited: Vec<Vec<Aabb>> = vec![Vec::new(); triangles.count()];
    let mut waiting = vec![(0, tree.bounds)];
    let shared = |a: &Aabb, b: &Aabb| Aabb {
        min: [0, 1, 2].map(|k| a.min[k].max(b.min[k])),
        max: [0, 1, 2].map(|k| a.max[k].min(b.max[k])),
    };
    while let Some((at, bounds)) = waiting.pop() {
        let node = &tree.nodes[at];
        for lane in (0..WIDTH).filter(|&lane| !node.bounds(lane).is_empty()) {
            let (inner, child) = (shared(&bounds, &node.bounds(lane)), node.child(lane));
            assert!(!inner.is_empty(), "{:?} meets {bounds:?}", node.bounds(lane));
            if !child.is_leaf() {
                waiting.push((child.index(), inner));
            }
            for &number in child.blocks().flat_map(|block| &tree.blocks[block]) {
                if number != INVALID_ID {
                    visited[number as usize].push(inner);
                }
            }
        }
    }
    let references: usize = visited.iter().map(Vec::len).sum();
    assert!(references > 2100 && references <= 4000, "{references} parts: some are cut, within the budget");
    for (number, [a, b, c]) in triangles.0.iter().enumerate() {
        for _ in 0..50 {
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let point = [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
            let near = |bounds: &Aabb| {
                (0..3).all(|k| point[k] >= bounds.min[k] - 5e-7 && point[k] <= bounds.max[k] + 5e-7)
            };
            assert!(
                visited[number].iter().any(near),
                "{point:?} of {number} is in one of {:?}",
                visited[number]
            );
        }
    }
}

/// Expected steps and blocks of a ray, by areas.
fn cost(tree: &Tree) -> f64 {
    let children = |node: &Node8| -> f64 { (0..WIDTH).map(|lane| node.bounds(lane).half_area()).sum() };
    tree.nodes.iter().map(children).sum::<f64>() / tree.bounds.half_area()
}

#[test]
fn care_pays() {
    let mut random = Random::new(4);
    let mut triangles = needles(&mut random, 100);
    let mut small = || {
        let at = random.point();
        [[0.02, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.02]].map(|by| [0, 1, 2].map(|k| at[k] + by[k]))
    };
    triangles.0.extend((0..4000).map(|_| small()));
    let [medium, high] =
        [Quality::Medium, Quality::High].map(|quality| cost(&build(&triangles, quality, Threads::Single)));
    assert!(high < 0.9 * medium, "{high} is well below {medium}");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads start");
    let same =
        [Threads::Single, Threads::Pool(&pool)].map(|threads| build(&triangles, Quality::High, threads));
    assert!(same[0] == same[1], "threads build the same tree");
}

#[test]
fn halves_are_as_good_as_thirds() {
    // The heuristic finds the two clusters, for any sizes.
    let mut boxes = random_boxes(&mut Random::new(5), 300, 0.1);
    for bounds in &mut boxes[..100] {
        bounds.min[0] += 50.0;
        bounds.max[0] += 50.0;
    }
    let tree = check_all(boxes);
    let far = (0..WIDTH).filter(|&lane| tree.nodes[0].bounds(lane).min[0] > 40.0).count();
    let near = (0..WIDTH).filter(|&lane| tree.nodes[0].bounds(lane).max[0] < 10.0).count();
    assert_eq!(near + far, WIDTH, "no child of the root holds some of both");
}

/// Least cost of a node in this many slots of a wide node, by trying everything; nodes as in `binary`.
fn least_cost(nodes: &[BinaryNode], at: usize, slots: usize) -> f64 {
    let node = &nodes[at];
    let area = node.bounds.bounds().half_area();
    if node.count > 0 {
        return area;
    }
    let [left, right] = node.children(at);
    let opened = |slots: usize| {
        let shared =
            |on_left: usize| least_cost(nodes, left, on_left) + least_cost(nodes, right, slots - on_left);
        (1..slots).map(shared).fold(f64::INFINITY, f64::min)
    };
    (area + opened(WIDTH)).min(opened(slots))
}

#[test]
fn no_other_collapse_is_cheaper() {
    let mut random = Random::new(6);
    for count in [9, 20, 35, 50] {
        let boxes = random_boxes(&mut random, count, 0.3);
        let boxes = &boxes[..];
        let mut references = all_references(&boxes, false);
        let watch = gnurt_accel_core::control::Watch::new(&());
        let tasks = TaskPool { parallel: false, level: Level::best(), scale: 1.0, watch: &watch };
        let root = tasks.around(&references);
        let nodes = Careful::new(&boxes, tasks, &root, 64).build(&mut references, root);
        let tree = collapse(&nodes, &[], tasks).expect("it is not deep");
        let found = (cost(&tree) + 1.0) * tree.bounds.half_area();
        let least = least_cost(&nodes, nodes.len() - 1, 1);
        assert!((found - least).abs() < 1e-5 * least, "{found} is the least of all, {least}");
    }
}

#[test]
fn more_blocks_than_leaves_can_number_are_refused() {
    let boxes = |count: usize| -> Vec<Aabb> {
        let mut random = Random::new(9);
        (0..count).map(|_| Aabb::around(&[random.point()])).collect()
    };
    let most = Child::MOST_NUMBERS as u64;
    // Eight to a block, but blocks are seldom full.
    let error = super::build(&&boxes(8 * Child::MOST_NUMBERS + 1)[..], Quality::Fast, Threads::Single);
    let Err(BuildError::TooManyBlocks { blocks, most: reported }) = error else {
        panic!("{error:?} is no refusal")
    };
    assert!(blocks > most && reported == most, "{blocks} of {reported}");
    assert!(
        super::build(&&boxes(Child::MOST_NUMBERS)[..], Quality::Fast, Threads::Single).is_ok(),
        "these fit"
    );
}
