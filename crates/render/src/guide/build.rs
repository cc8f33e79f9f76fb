// SPDX-License-Identifier: GPL-3.0-or-later
//! A map from the vertices of a pilot's paths. Cells are built by many threads, and joined in their order.
//! Source: as the module. Space: world. Tests: crates/render/tests/guide.rs.

use gnurt_accel::threads;

use super::directions::{Sample, Trees};
use super::recorder::Vertex;
use super::share::{self, HeldOut, SHARES};
use super::space::{CLASSES, Cell, Guide, Node};

/// A cell is divided if it has more vertices.
const MOST: usize = 1000;
/// A cell with fewer does not guide.
const FEWEST: usize = 64;

/// No cell has more than this share of the sum that judges the map: one stray bright path is no verdict.
const LOUDEST: f64 = 0.02;

/// A vertex and the weight of its light: one over the picture's radiance where its path begins.
pub(crate) type Weighted<'a> = (&'a Vertex, f32);

/// Builds a map on the threads of the pool that is installed; `learns`: whether to find out where and how much it is good
/// for.
pub(crate) fn build(vertices: &[Weighted], learns: bool) -> Guide {
    let mut guide = Guide { moment: 1.0, ..Guide::default() };
    let mut cells: Vec<Vec<u32>> = Vec::new();
    for class in 0..CLASSES {
        let of_class = (0..vertices.len() as u32)
            .filter(|&i| usize::from(vertices[i as usize].0.class) == class)
            .collect::<Vec<_>>();
        if !of_class.is_empty() {
            guide.roots[class] = Some(guide.nodes.len() as u32);
            guide.nodes.push(Node::Cell(0));
            let at = guide.nodes.len() - 1;
            divide(&mut guide.nodes, at, vertices, of_class, &mut cells);
        }
    }
    let make = |_: &mut (), n: usize| fill(vertices, &cells[n], learns);
    let filled: Vec<Filled> = threads::map_with(true, cells.len(), || (), make);
    let all: f64 = filled.iter().map(|cell| cell.moments[0]).sum();
    let mut sums = [0.0_f64; 2];
    for Filled { trees, root, share, moments } in filled {
        let offset = guide.trees.append(trees);
        guide.cells.push(Cell { root: root.map_or(u32::MAX, |root| root + offset), share });
        if moments[0] > 0.0 {
            let weight = moments[0].min(LOUDEST * all);
            sums = [sums[0] + weight, sums[1] + weight * (moments[1] / moments[0])];
        }
    }
    if sums[0] > 0.0 {
        guide.moment = (sums[1] / sums[0]) as f32;
    }
    guide
}

/// Divides vertices between cells, at the median along the longest side of their box.
fn divide(
    nodes: &mut Vec<Node>,
    at: usize,
    vertices: &[Weighted],
    mut numbers: Vec<u32>,
    cells: &mut Vec<Vec<u32>>,
) {
    let p = |i: u32| vertices[i as usize].0.p;
    let (low, high) = numbers
        .iter()
        .fold((p(numbers[0]), p(numbers[0])), |(low, high), &i| (low.min(p(i)), high.max(p(i))));
    let sides = high - low;
    let axis = if sides.x >= sides.y && sides.x >= sides.z { 0 } else { 1 + usize::from(sides.z > sides.y) };
    if numbers.len() > MOST && sides[axis] > 0.0 {
        let middle = numbers.len() / 2;
        numbers.select_nth_unstable_by(middle, |&a, &b| p(a)[axis].total_cmp(&p(b)[axis]).then(a.cmp(&b)));
        let plane = p(numbers[middle])[axis];
        let (mut below, mut above): (Vec<u32>, Vec<u32>) = numbers.iter().partition(|&&i| p(i)[axis] < plane);
        if !below.is_empty() && !above.is_empty() {
            below.sort_unstable();
            above.sort_unstable();
            let children = nodes.len();
            nodes[at] = Node::Split { axis: axis as u8, at: plane, children: children as u32 };
            nodes.extend([Node::Cell(0); 2]);
            divide(nodes, children, vertices, below, cells);
            divide(nodes, children + 1, vertices, above, cells);
            return;
        }
    }
    numbers.sort_unstable();
    nodes[at] = Node::Cell(cells.len() as u32);
    cells.push(numbers);
}

/// A cell that is built.
struct Filled {
    trees: Trees,
    root: Option<u32>,
    share: f32,
    /// Without and with the guide.
    moments: [f64; 2],
}

/// Builds a cell; the share of its tree is one half unless it is to be learned.
fn fill(vertices: &[Weighted], numbers: &[u32], learns: bool) -> Filled {
    let of_cell = || numbers.iter().map(|&i| &vertices[i as usize]);
    let build = |of: &dyn Fn(usize) -> bool| {
        let mut trees = Trees::default();
        let lit = of_cell().enumerate().filter(|&(i, _)| of(i)).filter_map(|(_, (vertex, _))| {
            let light = vertex.light / vertex.throughput;
            light.is_finite().then(|| Sample::new(vertex.dir, light))
        });
        let root = trees.build(&mut lit.collect::<Vec<_>>());
        (trees, root)
    };
    if numbers.len() < FEWEST {
        let (trees, moments) = (Trees::default(), share::moments(of_cell().map(|one| held_out(one, None))));
        return Filled { trees, root: None, share: 0.0, moments: [moments[0]; 2] };
    }
    let (trees, root) = build(&|_| true);
    if !learns || root.is_none() {
        return Filled { trees, root, share: if root.is_some() { 0.5 } else { 0.0 }, moments: [0.0; 2] };
    }
    let mut moments = [0.0; SHARES.len()];
    // Each half tells how good a tree of the other half is.
    for half in 0..2 {
        let (trees, root) = build(&|i| i % 2 != half);
        let of_half = of_cell().enumerate().filter(|&(i, _)| i % 2 == half);
        let of_half = of_half.map(|(_, one)| held_out(one, root.map(|root| trees.pdf(root, one.0.dir))));
        moments.iter_mut().zip(share::moments(of_half)).for_each(|(sum, moment)| *sum += moment);
    }
    let best = share::best(&moments);
    Filled { trees, root, share: SHARES[best], moments: [moments[0], moments[best]] }
}

/// What a vertex tells of a tree that has this density in its direction, or of none.
fn held_out(&(vertex, weight): &Weighted, of_tree: Option<f32>) -> HeldOut {
    HeldOut {
        pdf: vertex.pdf,
        of_lobes: vertex.pdf_of_lobes,
        of_tree: of_tree.unwrap_or(0.0),
        guidable: if of_tree.is_some() { vertex.guidable } else { 0.0 },
        square: (vertex.light * weight).powi(2),
    }
}
