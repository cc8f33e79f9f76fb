// SPDX-License-Identifier: GPL-3.0-or-later
//! Trees over points of surfaces, one for each orientation, and of media, whose cells have about as many points each: for maps that
//! pilots learn.
//! Source: [MGN17], section 3.1. Differs: divided at the median of the longest side, which needs no refinement.
//! Space: world. Invariant: a tree depends on its points only. Tests: crates/render/tests/{guide,caustics}.rs.

use glam::Vec3;

/// Surfaces are told apart by the axis that is nearest to their normal, and its sign.
const CLASSES: usize = 7;
/// The class of points in media.
pub(crate) const IN_MEDIUM: u8 = 6;

/// A node over space: children are adjacent, or it is a cell.
#[derive(Clone, Copy, Debug)]
enum Node {
    Split { axis: u8, at: f32, children: u32 },
    Cell(u32),
}

/// A tree for each orientation.
#[derive(Clone, Debug, Default)]
pub(crate) struct SpaceTree {
    roots: [Option<u32>; CLASSES],
    nodes: Vec<Node>,
}

/// The orientation of a surface with this normal.
pub(crate) fn class_of(normal: Vec3) -> u8 {
    let size = normal.abs();
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + u8::from(size.z > size.y) };
    2 * axis + u8::from(normal[usize::from(axis)] < 0.0)
}

impl SpaceTree {
    /// Over points with their orientations, with no more than `most` in a cell unless they are at one place; and the numbers of
    /// the points of each cell.
    pub(crate) fn build(points: &[(Vec3, u8)], most: usize) -> (Self, Vec<Vec<u32>>) {
        let (mut tree, mut cells) = (Self::default(), Vec::new());
        for class in 0..CLASSES {
            let of_class = (0..points.len() as u32)
                .filter(|&i| usize::from(points[i as usize].1) == class)
                .collect::<Vec<_>>();
            if !of_class.is_empty() {
                tree.roots[class] = Some(tree.nodes.len() as u32);
                tree.nodes.push(Node::Cell(0));
                let at = tree.nodes.len() - 1;
                tree.divide(at, (points, most), of_class, &mut cells);
            }
        }
        (tree, cells)
    }

    /// The number of the cell at a point of an orientation, if there was one of that orientation.
    pub(crate) fn cell(&self, p: Vec3, class: u8) -> Option<u32> {
        let mut at = self.roots[usize::from(class)]?;
        loop {
            match self.nodes[at as usize] {
                Node::Split { axis, at: plane, children } => {
                    at = children + u32::from(p[usize::from(axis)] >= plane);
                }
                Node::Cell(cell) => return Some(cell),
            }
        }
    }

    /// Bytes of memory.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>()
    }

    /// Divides points between cells, at the median along the longest side of their box.
    fn divide(
        &mut self,
        at: usize,
        (points, most): (&[(Vec3, u8)], usize),
        mut numbers: Vec<u32>,
        cells: &mut Vec<Vec<u32>>,
    ) {
        let p = |i: u32| points[i as usize].0;
        let (low, high) = numbers
            .iter()
            .fold((p(numbers[0]), p(numbers[0])), |(low, high), &i| (low.min(p(i)), high.max(p(i))));
        let sides = high - low;
        let axis =
            if sides.x >= sides.y && sides.x >= sides.z { 0 } else { 1 + usize::from(sides.z > sides.y) };
        if numbers.len() > most && sides[axis] > 0.0 {
            let middle = numbers.len() / 2;
            numbers
                .select_nth_unstable_by(middle, |&a, &b| p(a)[axis].total_cmp(&p(b)[axis]).then(a.cmp(&b)));
            let plane = p(numbers[middle])[axis];
            let (mut below, mut above): (Vec<u32>, Vec<u32>) =
                numbers.iter().partition(|&&i| p(i)[axis] < plane);
            if !below.is_empty() && !above.is_empty() {
                below.sort_unstable();
                above.sort_unstable();
                let children = self.nodes.len();
                self.nodes[at] = Node::Split { axis: axis as u8, at: plane, children: children as u32 };
                self.nodes.extend([Node::Cell(0); 2]);
                self.divide(children, (points, most), below, cells);
                self.divide(children + 1, (points, most), above, cells);
                return;
            }
        }
        numbers.sort_unstable();
        self.nodes[at] = Node::Cell(cells.len() as u32);
        cells.push(numbers);
    }
}
