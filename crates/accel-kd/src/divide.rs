// SPDX-License-Identifier: GPL-3.0-or-later
//! A node's parts of its triangles, and their division by a plane.
//! Source: [WH06] section 4.3. Differs: events are filtered in place, without a branch on their kinds.
//!
//! ```text
//! before    ... the parents' right children | this node's events
//! after     ... the parents' right children | the right child's events       aside: the left child's events
//! ```
//!
//! So a builder that descends to the left puts the left child on top and needs no memory of its own per node.
//! Invariant: triangles are renumbered in every node, in the order of their numbers in the parent, so that
//! filtered events stay sorted and arrays by number stay as small as the node. Tests: `tests/kd_build.rs`,
//! `naive::tests`.

use crate::event::{Event, Kind, push_events};
use crate::sah::{Plane, Side};
use gnurt_accel_core::Aabb;
use gnurt_accel_core::clip::split_boxes;
use gnurt_accel_core::valid_triangles::ValidTriangles;

/// Triangles in a row of nodes, each behind the other; the last is the current one.
#[derive(Default)]
pub(crate) struct Overlap {
    /// Sorted, per axis; triangles by their index among the node's `prims`.
    pub(crate) events: [Vec<Event>; 3],
    /// Numbers of the triangles in the object.
    pub(crate) prims: Vec<u32>,
}

/// Where a node starts in [`Overlap`]; it ends where all ends, or where the next one starts.
#[derive(Clone, Copy, Default)]
pub(crate) struct Start {
    pub(crate) events: [usize; 3],
    pub(crate) prims: usize,
}

/// Memory that is used again for every division.
#[derive(Default)]
pub(crate) struct Scratch {
    /// The left child after a division, up to `left_end`; later elements are undefined.
    left: Overlap,
    left_end: Start,
    sides: Vec<u8>,
    codes: Vec<Code>,
    pieces: Vec<Piece>,
    fresh: [Fresh; 3],
}

/// Events of pieces, of the left and of the right ones.
type Fresh = [Vec<Event>; 2];

/// The part on one side of a triangle that lies across the plane.
struct Piece {
    /// 0 left, 1 right.
    half: usize,
    /// Its number in that child.
    number: u32,
    bounds: Aabb,
}

/// Bits of a triangle's side: seen left, seen right.
const LEFT: u8 = 1;
const RIGHT: u8 = 2;

/// A triangle's number in its child; bits 31 and 30 mean right and left, and neither means cut.
#[derive(Clone, Copy)]
struct Code(u32);

impl Code {
    const CUT: Self = Self(0);
    const NUMBER: u32 = (1 << 30) - 1;

    #[inline(always)]
    fn new(side: u8, number: u32) -> Self {
        Self(u32::from(side) << 30 | number)
    }

    #[inline(always)]
    fn number(self) -> u32 {
        self.0 & Self::NUMBER
    }

    #[inline(always)]
    fn is_left(self) -> usize {
        (self.0 >> 30 & 1) as usize
    }

    #[inline(always)]
    fn is_right(self) -> usize {
        (self.0 >> 31) as usize
    }
}

impl Overlap {
    pub(crate) fn end(&self) -> Start {
        Start { events: [0, 1, 2].map(|axis| self.events[axis].len()), prims: self.prims.len() }
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        let events = self.events.iter().map(Vec::capacity).sum::<usize>();
        size_of::<Event>() * events + size_of::<u32>() * self.prims.capacity()
    }

    pub(crate) fn truncate(&mut self, end: Start) {
        for (events, end) in self.events.iter_mut().zip(end.events) {
            events.truncate(end);
        }
        self.prims.truncate(end.prims);
    }

    /// Finds the sides and new numbers of the triangles behind `start`, cutting those across the plane. Returns how
    /// many each child sees.
    pub(crate) fn classify(
        &self,
        start: Start,
        valid_triangles: &ValidTriangles,
        bounds: &Aabb,
        plane: &Plane,
        scratch: &mut Scratch,
    ) -> [usize; 2] {
        let Scratch { sides, codes, pieces, .. } = scratch;
        let prims = &self.prims[start.prims..];
        sides.clear();
        sides.resize(prims.len(), 0);
        mark_sides(&self.events[plane.axis][start.events[plane.axis]..], plane, sides);

        codes.clear();
        pieces.clear();
        let mut counts = [0u32; 2];
        for (&prim, side) in prims.iter().zip(sides.iter_mut()) {
            if *side == LEFT | RIGHT {
                codes.push(Code::CUT);
                *side = 0;
                let boxes = split_boxes(&valid_triangles.corners(prim), bounds, plane.axis, plane.at);
                for (half, bounds) in boxes.into_iter().enumerate() {
                    if let Some(bounds) = bounds {
                        pieces.push(Piece { half, number: counts[half], bounds });
                        *side |= [LEFT, RIGHT][half];
                        counts[half] += 1;
                    }
                }
            } else {
                codes.push(Code::new(*side, if *side == LEFT { counts[0] } else { counts[1] }));
                counts[0] += u32::from(*side & LEFT);
                counts[1] += u32::from(*side >> 1);
            }
        }
        counts.map(|count| count as usize)
    }

    /// Divides the elements behind `start` by the result of [`classify`](Self::classify): the right child's
    /// part stays, the left one's goes to `scratch.left`. `wide`: each axis by a separate thread.
    pub(crate) fn divide(&mut self, start: Start, scratch: &mut Scratch, wide: bool) {
        let Scratch { left, left_end, sides, codes, pieces, fresh } = scratch;
        left_end.prims = divide_prims(&mut self.prims, start.prims, &mut left.prims, sides);
        let [old_x, old_y, old_z] = &mut self.events;
        let [left_x, left_y, left_z] = &mut left.events;
        let [fresh_x, fresh_y, fresh_z] = fresh;
        let (codes, pieces) = (&codes[..], &pieces[..]);
        let mut x = || divide_events(0, old_x, start.events[0], left_x, codes, pieces, fresh_x);
        let mut y = || divide_events(1, old_y, start.events[1], left_y, codes, pieces, fresh_y);
        let mut z = || divide_events(2, old_z, start.events[2], left_z, codes, pieces, fresh_z);
        let (x, (y, z)) = if wide { rayon::join(x, || rayon::join(y, z)) } else { (x(), (y(), z())) };
        left_end.events = [x, y, z];
    }

    /// Puts the left child of the last division behind all.
    pub(crate) fn append_left(&mut self, scratch: &Scratch) {
        let Scratch { left, left_end, .. } = scratch;
        for axis in 0..3 {
            self.events[axis].extend_from_slice(&left.events[axis][..left_end.events[axis]]);
        }
        self.prims.extend_from_slice(&left.prims[..left_end.prims]);
    }
}

impl Scratch {
    /// Without the small arrays for triangles across a plane.
    pub(crate) fn memory_bytes(&self) -> usize {
        self.left.memory_bytes() + self.sides.capacity() + size_of::<Code>() * self.codes.capacity()
    }

    /// The left child of the last division by itself.
    pub(crate) fn into_left(mut self) -> Overlap {
        self.left.truncate(self.left_end);
        self.left
    }
}

/// For each triangle the sides that its box reaches. Every triangle has an event, so no old mark is left.
fn mark_sides(events: &[Event], plane: &Plane, sides: &mut [u8]) {
    // The plane's position among events: after ends there, before starts there.
    let first_right = match plane.flat_side {
        Side::Left => Event::new(plane.at, Kind::Start, 0),
        Side::Right => Event::new(plane.at, Kind::Flat, 0),
    };
    let (before, behind) = events.split_at(events.partition_point(|&event| event < first_right));
    // Forwards to the plane: a starting box may lie across, unless its end follows.
    for event in before {
        sides[event.prim()] = if event.kind() == Kind::Start { LEFT | RIGHT } else { LEFT };
    }
    // Backwards to the plane: an ending box may lie across, unless its start follows.
    for event in behind.iter().rev() {
        sides[event.prim()] = if event.kind() == Kind::End { LEFT | RIGHT } else { RIGHT };
    }
}

/// The children's triangles in the order of their new numbers, which is that of the old ones: the right child's stay,
/// the left child's go to the front of `lefts`. Returns how many those are.
fn divide_prims(prims: &mut Vec<u32>, start: usize, lefts: &mut Vec<u32>, sides: &[u8]) -> usize {
    let here = &mut prims[start..];
    if lefts.len() < here.len() {
        lefts.resize(here.len(), 0);
    }
    let (mut left, mut right) = (0, 0);
    for (i, &side) in sides.iter().enumerate() {
        let prim = here[i];
        (lefts[left], here[right]) = (prim, prim);
        left += usize::from(side & LEFT);
        right += usize::from(side >> 1);
    }
    prims.truncate(start + right);
    left
}

/// The events behind `start` along one axis: the right child's stay, the left child's go to the front of `lefts`.
/// Returns how many those are.
fn divide_events(
    axis: usize,
    events: &mut Vec<Event>,
    start: usize,
    lefts: &mut Vec<Event>,
    codes: &[Code],
    pieces: &[Piece],
    fresh: &mut Fresh,
) -> usize {
    let [mut left, mut right] = filter(&mut events[start..], lefts, codes);
    if !pieces.is_empty() {
        fresh.iter_mut().for_each(Vec::clear);
        for piece in pieces {
            push_events(&mut fresh[piece.half], &piece.bounds, axis, piece.number);
        }
        fresh.iter_mut().for_each(|events| events.sort_unstable());
        left = merge(lefts, 0, left, &fresh[0]);
        right = merge(events, start, right, &fresh[1]);
    }
    events.truncate(start + right);
    left
}

/// Parts the events of uncut triangles. Each is written to both sides, and counts where it belongs.
fn filter(here: &mut [Event], lefts: &mut Vec<Event>, codes: &[Code]) -> [usize; 2] {
    if lefts.len() < here.len() {
        lefts.resize(here.len(), Event::default());
    }
    let (mut left, mut right) = (0, 0);
    for i in 0..here.len() {
        let code = codes[here[i].prim()];
        let event = here[i].renumbered(code.number());
        (lefts[left], here[right]) = (event, event);
        left += code.is_left();
        right += code.is_right();
    }
    [left, right]
}

/// Merges sorted events into the `count` sorted ones at `start`, from the last to the first. Later elements
/// are overwritten. Returns their new number.
fn merge(events: &mut Vec<Event>, start: usize, count: usize, fresh: &[Event]) -> usize {
    let merged = count + fresh.len();
    if events.len() < start + merged {
        events.resize(start + merged, Event::default());
    }
    let here = &mut events[start..start + merged];
    let mut end = count;
    if count > 32 * fresh.len() {
        for (before, &event) in fresh.iter().enumerate().rev() {
            let at = here[..end].partition_point(|&old| old < event);
            here.copy_within(at..end, at + before + 1);
            here[at + before] = event;
            end = at;
        }
        return merged;
    }
    for (before, &event) in fresh.iter().enumerate().rev() {
        while end > 0 && here[end - 1] > event {
            here[end + before] = here[end - 1];
            end -= 1;
        }
        here[end + before] = event;
    }
    merged
}
