// SPDX-License-Identifier: GPL-3.0-or-later
//! SAH kd-tree construction by sweeping sorted plane events, in O(n log n).
//! Source: [WH06] section 4.3; greedy cost [MB90]. Differs: triangles are numbered anew in every node, so that
//! events stay 8 bytes, the classification array stays as small as the node, and subtrees share nothing.
//! In: screened triangles, object space. Out: [`KdTree`]; children of a node lie next to each other, followed by all
//! that is below the left one, then all below the right one, whoever built them.
//! Cost: events are sorted once; a node's are filtered and merged. At most two generations of a path are alive.
//! Invariant: the tree does not depend on the threads; its leaves hold at most `reference_budget` times n references,
//! shared out to subtrees by their size. Proof: `tests/kd_build.rs`.

use super::DEEPEST;
use super::clip::split_boxes;
use super::event::{Event, Kind, push_events};
use super::node::{EMPTY_LEAF, KdTree, Node};
use super::sah::{Costs, Plane, Side, best_plane};
use crate::geometry::Screened;
use crate::{Aabb, BuildOptions, Threads};

/// Nodes of fewer triangles are not worth another thread.
const WORTH_A_THREAD: usize = 2048;

/// A node still to be built.
struct Task {
    bounds: Aabb,
    /// Sorted, per axis; triangles by their place in `prims`.
    events: [Vec<Event>; 3],
    /// Numbers of the triangles in the object.
    prims: Vec<u32>,
    depth: usize,
    /// Most references that the leaves below may hold.
    budget: usize,
}

/// What was built below one node: nodes and items with indices of their own.
struct Subtree {
    nodes: Vec<Node>,
    items: Vec<u32>,
}

struct Builder<'a> {
    screened: &'a Screened<'a>,
    costs: Costs,
    max_depth: usize,
    parallel: bool,
}

impl KdTree {
    /// Builds over the good triangles of `screened`.
    pub(crate) fn build(screened: &Screened, options: &BuildOptions, threads: Threads) -> Self {
        let costs = Costs {
            triangle: f64::from(options.triangle_cost.max(0.0)),
            empty_factor: f64::from(options.empty_factor.clamp(0.0, 1.0)),
        };
        let max_depth = (options.max_depth as usize).min(DEEPEST - 1);
        let parallel = matches!(threads, Threads::Pool(_));
        let builder = Builder { screened, costs, max_depth, parallel };
        match threads {
            Threads::Single => builder.run(options),
            Threads::Pool(pool) => pool.install(|| builder.run(options)),
        }
    }
}

impl Builder<'_> {
    fn run(&self, options: &BuildOptions) -> KdTree {
        let n = self.screened.good.len();
        let budget = (f64::from(options.reference_budget.max(1.0)) * n as f64) as usize;
        let bounds = self.screened.bounds;
        let mut tree = Subtree { nodes: vec![EMPTY_LEAF], items: vec![0] };
        if n > 0 {
            let task = Task {
                bounds,
                events: self.root_events(),
                prims: self.screened.good.clone(),
                depth: 0,
                budget,
            };
            self.grow(task, &mut tree, 0);
        }
        tree.nodes.shrink_to_fit();
        tree.items.shrink_to_fit();
        KdTree { nodes: tree.nodes, items: tree.items, bounds }
    }

    /// All triangles' events, sorted.
    fn root_events(&self) -> [Vec<Event>; 3] {
        let sorted = |axis: usize| {
            let mut events = Vec::with_capacity(2 * self.screened.good.len());
            for (i, &number) in self.screened.good.iter().enumerate() {
                push_events(&mut events, &Aabb::around(&self.screened.corners(number)), axis, i as u32);
            }
            events.sort_unstable();
            events
        };
        let (x, (y, z)) = self.both(|| sorted(0), || self.both(|| sorted(1), || sorted(2)));
        [x, y, z]
    }

    /// Runs two jobs, at the same time where a pool was given.
    fn both<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        if self.parallel { rayon::join(a, b) } else { (a(), b()) }
    }

    /// Builds `task` into node `slot` of `tree`, and what is below it behind all that is there.
    fn grow(&self, task: Task, tree: &mut Subtree, slot: usize) {
        let (n, depth) = (task.prims.len(), task.depth);
        let plane = match self.plane_for(&task) {
            Some(plane) => plane,
            None => return tree.set_leaf(slot, &task.prims),
        };
        let (axis, at) = (plane.axis, plane.at);
        let [left, right] = match self.divide(task, plane) {
            Ok(children) => children,
            Err(prims) => return tree.set_leaf(slot, &prims),
        };

        let first = tree.nodes.len();
        tree.nodes[slot] = Node::inner(first as u32, axis, at);
        tree.nodes.extend([EMPTY_LEAF; 2]);
        if self.parallel && n >= WORTH_A_THREAD && depth < self.max_depth {
            let (left, right) = rayon::join(|| self.grow_apart(left), || self.grow_apart(right));
            tree.attach(first, left);
            tree.attach(first + 1, right);
        } else {
            self.grow(left, tree, first);
            self.grow(right, tree, first + 1);
        }
    }

    fn grow_apart(&self, task: Task) -> Subtree {
        let mut apart = Subtree { nodes: vec![EMPTY_LEAF], items: vec![0] };
        self.grow(task, &mut apart, 0);
        apart
    }

    /// The plane to divide at, or `None` where a leaf is cheaper.
    fn plane_for(&self, task: &Task) -> Option<Plane> {
        let n = task.prims.len();
        let as_leaf = self.costs.leaf(n);
        if task.depth >= self.max_depth || as_leaf <= self.costs.cheapest_split() {
            return None;
        }
        best_plane(&task.bounds, &task.events, n, &self.costs).filter(|plane| plane.cost < as_leaf)
    }

    /// The two children, or the triangles back where the budget forbids to divide.
    fn divide(&self, task: Task, plane: Plane) -> Result<[Task; 2], Vec<u32>> {
        let mut sides = classify(&task, plane);
        let pieces = self.cut_across(&task, plane, &mut sides);
        let new_numbers = renumber(&sides);
        let counts = new_numbers.counts;
        let references = counts[0] + counts[1];
        if references > task.budget {
            return Err(task.prims);
        }

        let mut children = task.bounds.split(plane.axis, plane.at).map(|bounds| Task {
            bounds,
            events: [const { Vec::new() }; 3],
            prims: Vec::new(),
            depth: task.depth + 1,
            budget: 0,
        });
        let spare = task.budget - references;
        children[0].budget =
            counts[0] + (spare as u128 * counts[0] as u128 / references.max(1) as u128) as usize;
        children[1].budget = task.budget - children[0].budget;
        for (side, child) in children.iter_mut().enumerate() {
            child.prims.reserve_exact(counts[side]);
            let here = (0..sides.len()).filter(|&i| sides[i] & BITS[side] != 0);
            child.prims.extend(here.map(|i| task.prims[i]));
        }

        // Axis by axis, so that the parent's events go as the children's come.
        for (axis, old) in task.events.into_iter().enumerate() {
            let [left, right] = split_events(old, axis, &sides, &pieces, &new_numbers);
            children[0].events[axis] = left;
            children[1].events[axis] = right;
        }
        Ok(children)
    }

    /// Cuts triangles that lie across the plane; `sides` learns where nothing is left of them.
    fn cut_across(&self, task: &Task, plane: Plane, sides: &mut [u8]) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for (i, side) in sides.iter_mut().enumerate().filter(|(_, side)| **side == BITS[0] | BITS[1]) {
            let corners = self.screened.corners(task.prims[i]);
            let boxes = split_boxes(&corners, &task.bounds, plane.axis, plane.at);
            *side = CUT;
            for (bit, bounds) in BITS.into_iter().zip(boxes) {
                if let Some(bounds) = bounds {
                    *side |= bit;
                    pieces.push(Piece { prim: i as u32, bit, bounds });
                }
            }
        }
        pieces
    }
}

/// Bits of a triangle's class: it is seen left, right; its old events are void.
const BITS: [u8; 2] = [1, 2];
const CUT: u8 = 4;

/// What one side sees of a triangle that lies across the plane.
struct Piece {
    prim: u32,
    bit: u8,
    bounds: Aabb,
}

/// Places of a node's triangles in its children, and how many there are.
struct NewNumbers {
    of: [Vec<u32>; 2],
    counts: [usize; 2],
}

/// For each triangle the sides that its box reaches.
fn classify(task: &Task, plane: Plane) -> Vec<u8> {
    let mut sides = vec![BITS[0] | BITS[1]; task.prims.len()];
    let [left, right] = BITS;
    let place = Event::new(plane.at, Kind::End, 0).place();
    for event in &task.events[plane.axis] {
        let side = &mut sides[event.prim()];
        match event.kind() {
            Kind::End if event.place() <= place => *side = left,
            Kind::Start if event.place() >= place => *side = right,
            Kind::Flat if event.place() < place => *side = left,
            Kind::Flat if event.place() > place => *side = right,
            Kind::Flat => *side = if plane.flat_side == Side::Left { left } else { right },
            Kind::End | Kind::Start => {}
        }
    }
    sides
}

/// New numbers keep the order of the old ones, so filtered events stay sorted.
fn renumber(sides: &[u8]) -> NewNumbers {
    let mut new = NewNumbers { of: [vec![0; sides.len()], vec![0; sides.len()]], counts: [0; 2] };
    for (i, &side) in sides.iter().enumerate() {
        for (half, bit) in BITS.into_iter().enumerate() {
            new.of[half][i] = new.counts[half] as u32;
            new.counts[half] += usize::from(side & bit != 0);
        }
    }
    new
}

/// The children's sorted events along `axis`: the old ones of uncut triangles, merged with those of the pieces.
fn split_events(
    old: Vec<Event>,
    axis: usize,
    sides: &[u8],
    pieces: &[Piece],
    new: &NewNumbers,
) -> [Vec<Event>; 2] {
    let mut fresh = [const { Vec::new() }; 2];
    for piece in pieces {
        let half = usize::from(piece.bit == BITS[1]);
        push_events(&mut fresh[half], &piece.bounds, axis, new.of[half][piece.prim as usize]);
    }
    fresh.iter_mut().for_each(|events| events.sort_unstable());

    let mut merged =
        [0, 1].map(|half| Vec::with_capacity((2 * new.counts[half]).min(old.len() + fresh[half].len())));
    let mut waiting = [0; 2];
    for event in old {
        let side = sides[event.prim()];
        if side & CUT != 0 {
            continue;
        }
        let half = usize::from(side == BITS[1]);
        let event = event.renumbered(new.of[half][event.prim()]);
        let (to, from, next) = (&mut merged[half], &fresh[half], &mut waiting[half]);
        while *next < from.len() && from[*next] < event {
            to.push(from[*next]);
            *next += 1;
        }
        to.push(event);
    }
    for half in 0..2 {
        merged[half].extend_from_slice(&fresh[half][waiting[half]..]);
    }
    merged
}

impl Subtree {
    fn set_leaf(&mut self, slot: usize, prims: &[u32]) {
        if prims.is_empty() {
            self.nodes[slot] = EMPTY_LEAF;
            return;
        }
        self.nodes[slot] = Node::leaf(self.items.len() as u32);
        self.items.push(prims.len() as u32);
        self.items.extend_from_slice(prims);
    }

    /// Puts a subtree's root into `slot` and the rest at the end; the empty leaf's list is there already.
    fn attach(&mut self, slot: usize, below: Self) {
        let (nodes, items) = (self.nodes.len() as u32 - 1, self.items.len() as u32 - 1);
        let mut moved = below.nodes.into_iter().map(|node| node.moved(nodes, items));
        self.nodes[slot] = moved.next().unwrap_or(EMPTY_LEAF);
        self.nodes.extend(moved);
        self.items.extend_from_slice(&below.items[1..]);
    }
}
