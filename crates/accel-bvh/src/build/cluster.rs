// SPDX-License-Identifier: GPL-3.0-or-later
//! The fast way: along a space-filling curve the lower levels of a tree are a matter of comparing bits; only the levels
//! above clusters are built by the heuristic.
//! Source: [PL10] section 3. Differs: clusters are cut by numbers of references, and the last few of a cluster are divided
//! into full blocks. Cost: O(n) but for the clusters. Six tenths of the time of a medium build, and rays are a fifth slower.
//! Invariant: as for any build. Proof: `tests::sorted_and_cut`, `super::tests`.

use super::binary::Careful;
use super::binary_node::{BinaryNode, Cluster};
use super::costs::{Costs, inner_costs, leaf_costs};
use super::reference::{Lanes, Part, Reference};
use super::task_pool::TaskPool;
use crate::node::WIDTH;
use crate::primitives::Primitives;

/// From this depth on the tree over the clusters is divided by number alone.
const BY_NUMBER: usize = 48;

/// Most references of a cluster.
const CLUSTER: usize = 128;

/// So many references, or fewer, are divided into whole blocks.
const FEW: usize = 32;

/// Clusters that are built by one thread.
const GROUP: usize = 16;

/// Bits of a Morton code, and how many of them are sorted by at a time.
const BITS: u32 = 30;
const DIGIT: u32 = 10;

/// The nodes of some clusters, one after the other.
struct Group {
    nodes: Vec<BinaryNode>,
    /// Where each cluster's nodes end, and what they cost.
    ends: Vec<(usize, Costs)>,
}

/// A tree over `references`, which `root` describes.
pub(super) fn build(
    primitives: &impl Primitives,
    tasks: TaskPool,
    references: &[Reference],
    root: &Part,
) -> Vec<BinaryNode> {
    // Codes, and those before they are sorted.
    let bytes = references.len() * 2 * size_of::<u64>();
    if !tasks.watch.take(bytes) {
        return Vec::new();
    }
    let Clusters { codes, borders } = Clusters::new(tasks, references, root);
    let groups = grow(tasks, references, &codes, &borders);
    let mut clusters = Vec::with_capacity(borders.len());
    let mut tops = Vec::with_capacity(borders.len());
    for Group { nodes, ends } in &groups {
        let mut start = 0;
        for &(end, costs) in ends {
            tops.push(Reference::new(clusters.len() as u32, &nodes[end - 1].bounds.bounds()));
            clusters.push(Cluster { nodes: &nodes[start..end], costs });
            start = end;
        }
    }
    let root = tasks.around(&tops);
    let nodes = Careful::over(&clusters, primitives, tasks, &root, BY_NUMBER).build(&mut tops, root);
    tasks.watch.give(bytes);
    nodes
}

/// Builds cluster by cluster; `borders` count from the first of all `codes`.
fn grow(tasks: TaskPool, references: &[Reference], codes: &[u64], borders: &[usize]) -> Vec<Group> {
    if tasks.parallel && borders.len() > GROUP {
        let middle = borders.len() / 2;
        let (mut groups, mut others) = tasks.both(
            || grow(tasks, references, codes, &borders[..=middle]),
            || grow(tasks, references, codes, &borders[middle..]),
        );
        groups.append(&mut others);
        return groups;
    }
    let inside = borders[borders.len() - 1] - borders[0];
    let mut group = Group { nodes: Vec::with_capacity(inside / 2), ends: Vec::with_capacity(borders.len()) };
    for border in borders.windows(2) {
        if !tasks.watch.go_on() {
            break;
        }
        let grown = halve(tasks, references, &codes[border[0]..border[1]], BITS, &mut group.nodes);
        group.ends.push((group.nodes.len(), grown.costs));
    }
    tasks.watch.advance(inside);
    tasks.watch.grow(size_of_val(&group.nodes[..]));
    vec![group]
}

/// What was built below a node.
struct Grown {
    size: usize,
    bounds: Lanes,
    costs: Costs,
}

/// Divides by the first bit of the codes that differs among many references, by number among few; of the codes the lowest
/// `bits` may differ.
fn halve(
    tasks: TaskPool,
    references: &[Reference],
    codes: &[u64],
    bits: u32,
    nodes: &mut Vec<BinaryNode>,
) -> Grown {
    let count = codes.len();
    if count <= WIDTH {
        let mut along = [Reference::ZERO; WIDTH];
        for (reference, &code) in along.iter_mut().zip(codes) {
            *reference = references[code as u32 as usize];
        }
        let along = &along[..count];
        let bounds = along.iter().fold(Lanes::EMPTY, |all, reference| all.union(reference));
        nodes.push(BinaryNode::leaf(bounds, along));
        return Grown { size: 1, bounds, costs: leaf_costs(bounds.half_area(tasks.scale)) };
    }
    let differing = (codes[0] ^ codes[count - 1]) >> 32;
    let bits = bits.min(64 - differing.leading_zeros());
    let middle = if count <= FEW || bits == 0 {
        (count / 2).next_multiple_of(WIDTH)
    } else {
        codes.partition_point(|code| code >> (32 + bits - 1) & 1 == 0)
    };
    let bits = bits.saturating_sub(1);
    let left = halve(tasks, references, &codes[..middle], bits, nodes);
    let right = halve(tasks, references, &codes[middle..], bits, nodes);
    let bounds = left.bounds.union(&right.bounds);
    let (costs, shares) = inner_costs(bounds.half_area(tasks.scale), &left.costs, &right.costs);
    nodes.push(BinaryNode::inner(bounds, [right.size as u32 + 1, 1], shares));
    Grown { size: left.size + right.size + 1, bounds, costs }
}

/// Codes of references along the curve, and where clusters of them start and end.
struct Clusters {
    codes: Vec<u64>,
    borders: Vec<usize>,
}

impl Clusters {
    /// Of all that `root` describes.
    fn new(tasks: TaskPool, references: &[Reference], root: &Part) -> Self {
        let order = sorted(codes(tasks, references, root));
        let mut borders = vec![0];
        let mut waiting = vec![(0, order.len(), BITS)];
        while let Some((start, end, bits)) = waiting.pop() {
            if end - start <= CLUSTER {
                borders.push(end);
            } else if bits == 0 {
                // One cell holds too many.
                borders.extend((start + CLUSTER..end).step_by(CLUSTER));
                borders.push(end);
            } else {
                let bit = 1 << (32 + bits - 1);
                let middle = start + order[start..end].partition_point(|entry| entry & bit == 0);
                let halves = [(middle, end, bits - 1), (start, middle, bits - 1)];
                waiting.extend(halves.into_iter().filter(|(start, end, _)| start < end));
            }
        }
        Self { codes: order, borders }
    }
}

/// Morton codes of the middles in the upper half, places in `references` in the lower one.
fn codes(tasks: TaskPool, references: &[Reference], root: &Part) -> Vec<u64> {
    let cells = (1 << (BITS / 3)) as f32 * 0.9999;
    let per_unit = [0, 1, 2].map(|axis| {
        let per_unit = cells / root.middles.side(axis);
        if per_unit.is_finite() { per_unit } else { 0.0 }
    });
    let code = |place: usize| {
        let (reference, mut code) = (&references[place], 0);
        for (axis, per_unit) in per_unit.iter().enumerate() {
            let middle = reference.0[axis + 4] - reference.0[axis];
            let cell = (middle + root.middles.0[axis]) * per_unit;
            code |= spread(cell as u32 & 1023) << axis;
        }
        u64::from(code) << 32 | place as u64
    };
    let mut codes = Vec::new();
    tasks.extend(&mut codes, references.len(), code);
    codes
}

/// Puts two zeros between the ten bits of a number.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Sorts by the codes; equal ones stay in order.
fn sorted(mut entries: Vec<u64>) -> Vec<u64> {
    let mut other = vec![0; entries.len()];
    for digit in 0..BITS / DIGIT {
        let bucket = |entry: u64| (entry >> (32 + digit * DIGIT)) as usize & ((1 << DIGIT) - 1);
        let mut starts = [0u32; 1 << DIGIT];
        entries.iter().for_each(|&entry| starts[bucket(entry)] += 1);
        let mut end = 0;
        for start in &mut starts {
            (*start, end) = (end, end + *start);
        }
        for &entry in &entries {
            let at = &mut starts[bucket(entry)];
            other[*at as usize] = entry;
            *at += 1;
        }
        std::mem::swap(&mut entries, &mut other);
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_accel_core::Aabb;

    #[test]
    fn sorted_and_cut() {
        assert_eq!(spread(0b11_1111_1111), 0x0924_9249, "every third bit");
        let mut random = gnurt_testkit::Random::new(1);
        let mut boxes: Vec<Aabb> = (0..5000).map(|_| Aabb::around(&[random.point()])).collect();
        boxes.extend_from_within(0..1);
        boxes.extend([boxes[0]; 200]);
        let all = boxes.iter().enumerate();
        let references: Vec<Reference> = all.map(|(i, bounds)| Reference::new(i as u32, bounds)).collect();
        let watch = gnurt_accel_core::control::Watch::new(&());
        let tasks = TaskPool { parallel: false, level: gnurt_simd::Level::best(), scale: 1.0, watch: &watch };
        let root = tasks.around(&references);
        let codes = codes(tasks, &references, &root);
        let mut expected = codes.clone();
        expected.sort_unstable();
        assert_eq!(sorted(codes), expected, "as the standard library sorts");
        let Clusters { codes, borders } = Clusters::new(tasks, &references, &root);
        assert_eq!((borders[0], borders[borders.len() - 1]), (0, codes.len()), "all are in clusters");
        assert!(
            borders.windows(2).all(|b| b[0] < b[1] && b[1] - b[0] <= CLUSTER),
            "none is empty or too large"
        );
        let mut numbers: Vec<u32> =
            codes.iter().map(|&code| references[code as u32 as usize].number()).collect();
        numbers.sort_unstable();
        assert!(numbers.iter().enumerate().all(|(i, &number)| number as usize == i), "each is there once");
    }
}
