// SPDX-License-Identifier: GPL-3.0-or-later
//! A map from the vertices of a pilot's paths. Cells are built by many threads, and joined in their order.
//! Source: as the module. Space: world. Tests: crates/render/tests/guide.rs.

use gnurt_accel::threads;

use super::directions::{Sample, Trees};
use super::recorder::Vertex;
use super::share::{self, HeldOut, SHARES};
use super::space::{Cell, Guide};
use crate::space_tree::SpaceTree;

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
    let points: Vec<_> = vertices.iter().map(|(vertex, _)| (vertex.p, vertex.class)).collect();
    let (tree, cells) = SpaceTree::build(&points, MOST);
    let mut guide = Guide { tree, moment: 1.0, ..Guide::default() };
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
