// SPDX-License-Identifier: GPL-3.0-or-later
//! A binary tree, built with care: by the cheaper of dividing references and dividing space, node by node.
//! Source: [SFD09] section 4.3 for when space is tried; binned as in [Wald07].
//! In: references with room for second parts behind them. Out: [`Knot`]s, children before their parents.
//! Invariant: subtrees get room by their numbers of references, so that threads do not matter.
//! Proof: `super::tests`.

use gnurt_simd::dispatch;

use super::Primitives;
use super::bins::{Bins, bin};
use super::grow::halfway;
use super::partition::{Buffer, partition};
use super::reference::{Lanes, Part, Reference};
use super::spatial::{Slabs, cut};
use super::top::{Crew, SUBTREE};
use crate::INVALID_ID;
use crate::bvh::WIDTH;

/// From this depth on references are divided by number alone.
const BY_NUMBER: usize = 64;

/// Space is divided only where the children would overlap by more than this share of the root's area,
const LEAST_OVERLAP: f32 = 1e-5;

/// and by more than this share of their parent's.
const LEAST_OWN_OVERLAP: f32 = 0.05;

/// A node of a binary tree. The right child comes right before it, the left child before all that is below the right.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    pub(super) bounds: Lanes,
    /// In a leaf the numbers of primitives; else the first is the number of knots on the right.
    pub(super) numbers: [u32; WIDTH],
    /// Primitives of a leaf; 0 if it is none.
    pub(super) count: u32,
}

/// Memory that is used again and again.
struct Workspace {
    bins: Bins,
    slabs: Slabs,
    buffer: Buffer,
    right: Vec<Reference>,
}

/// What is built over, by whom.
pub(super) struct Careful<'a, P> {
    pub(super) primitives: &'a P,
    pub(super) crew: Crew,
    /// Overlaps of children below this are good enough.
    pub(super) least_overlap: f32,
}

impl<'a, P: Primitives> Careful<'a, P> {
    pub(super) fn new(primitives: &'a P, crew: Crew, root: &Part) -> Self {
        Self { primitives, crew, least_overlap: LEAST_OVERLAP * root.bounds.half_area(crew.scale) }
    }

    /// The tree over the references of `root`, which are the first of `references`.
    pub(super) fn build(&self, references: &mut [Reference], root: Part) -> Vec<Knot> {
        let mut knots = Vec::new();
        self.subtree(references, root, 0, &mut Workspace::new(), &mut knots);
        knots
    }

    fn subtree(
        &self,
        references: &mut [Reference],
        part: Part,
        depth: usize,
        workspace: &mut Workspace,
        knots: &mut Vec<Knot>,
    ) {
        let count = part.count();
        if count <= WIDTH {
            return knots.push(Knot::leaf(part.bounds, &references[..count]));
        }
        let [left, right] = self.divide(references, &part, depth, workspace);
        let (left_room, right_room) = references.split_at_mut(right.start);
        let right = Part { start: 0, end: right.count(), ..right };
        let size = if count > SUBTREE {
            let alone = |references, part| {
                let mut knots = Vec::new();
                self.subtree(references, part, depth + 1, &mut Workspace::new(), &mut knots);
                knots
            };
            let (mut a, mut b) = self.crew.both(|| alone(left_room, left), || alone(right_room, right));
            let size = b.len();
            knots.append(&mut a);
            knots.append(&mut b);
            size
        } else {
            self.subtree(left_room, left, depth + 1, workspace, knots);
            let before = knots.len();
            self.subtree(right_room, right, depth + 1, workspace, knots);
            knots.len() - before
        };
        knots.push(Knot::inner(part.bounds, size));
    }

    /// Cuts `part`, the first of `references`, in two; the second starts where its room does.
    fn divide(
        &self,
        references: &mut [Reference],
        part: &Part,
        depth: usize,
        workspace: &mut Workspace,
    ) -> [Part; 2] {
        let Crew { level, scale, .. } = self.crew;
        let count = part.count();
        let room = references.len();
        let Workspace { bins, slabs, buffer, right } = workspace;
        let inside = &mut references[..count];
        let share = |left: usize, right: usize| (room - left - right) * left / (left + right);
        let around = |references: &[Reference], start: usize, end: usize| dispatch!(level, simd => Part::around(simd, references, start, end));
        let found = if depth < BY_NUMBER {
            dispatch!(level, simd => {
                let mapping = bin(simd, inside, part, bins);
                bins.best_split(simd, scale).map(|split| (mapping, split, bins.sides(simd, &split)))
            })
        } else {
            None
        };
        let Some((mapping, split, bounds)) = found else {
            let left = halfway(count);
            let start = left + share(left, count - left);
            references.copy_within(left..count, start);
            return [around(references, 0, left), around(references, start, start + count - left)];
        };
        let least = self.least_overlap.max(LEAST_OWN_OVERLAP * part.bounds.half_area(scale));
        if room > count && overlap(&bounds, scale) > least {
            let plane = dispatch!(level, simd => slabs.best_plane(simd, inside, &part.bounds, scale));
            if let Some(plane) = plane.filter(|plane| plane.cost < split.cost) {
                let left = cut(self.primitives, inside, &plane, room - count, right);
                if left > 0 && !right.is_empty() {
                    let start = left + share(left, right.len());
                    references[start..start + right.len()].copy_from_slice(right);
                    return [around(references, 0, left), around(references, start, start + right.len())];
                }
                // Everything ended up on one side: nothing was cut, only moved.
                let inside = &mut references[..count];
                if left == 0 {
                    inside.copy_from_slice(right);
                }
            }
        }
        let inside = &mut references[..count];
        let parted = dispatch!(level, simd => partition(simd, inside, &mapping, &split, buffer));
        let left = parted.left;
        let start = left + share(left, count - left);
        references.copy_within(left..count, start);
        let [left_bounds, right_bounds] = bounds;
        [
            Part { start: 0, end: left, bounds: left_bounds, middles: parted.middles[0] },
            Part { start, end: start + count - left, bounds: right_bounds, middles: parted.middles[1] },
        ]
    }
}

impl Workspace {
    fn new() -> Self {
        Self { bins: Bins::EMPTY, slabs: Slabs::EMPTY, buffer: Buffer::EMPTY, right: Vec::new() }
    }
}

impl Knot {
    /// Parts of one primitive count as one.
    fn leaf(bounds: Lanes, references: &[Reference]) -> Self {
        let mut knot = Self { bounds, numbers: [INVALID_ID; WIDTH], count: 0 };
        for number in references.iter().map(Reference::number) {
            if !knot.numbers.contains(&number) {
                knot.numbers[knot.count as usize] = number;
                knot.count += 1;
            }
        }
        knot
    }

    fn inner(bounds: Lanes, right: usize) -> Self {
        let mut numbers = [INVALID_ID; WIDTH];
        numbers[0] = right as u32;
        Self { bounds, numbers, count: 0 }
    }
}

/// Half the surface of what two boxes share; zero where they do not meet.
fn overlap([a, b]: &[Lanes; 2], scale: f32) -> f32 {
    let mut shared = *a;
    shared.0.iter_mut().zip(b.0).for_each(|(a, b)| *a = a.min(b));
    if (0..3).any(|axis| shared.side(axis) < 0.0) { 0.0 } else { shared.half_area(scale) }
}
