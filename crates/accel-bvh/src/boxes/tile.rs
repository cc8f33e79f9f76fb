// SPDX-License-Identifier: GPL-3.0-or-later
//! A tile of rays through a top tree.
//! Source: [RSH05] for intervals, masks as in `tiles.rs`: where intervals leave [`MANY`] boxes or more, rays
//! are tested against each, sixteen to a step, and only those that hit it go on; a few remaining rays go on
//! singly ([BWW*12]). Where rays diverge at once, as after a bounce, their interval is the whole scene.
//! Space: that of the boxes. Tests: `tests/instances.rs` and `tests/counters.rs` of `gnurt-accel`, which run
//! at every level.

use gnurt_accel_core::beam::{Beam, Slopes};
use gnurt_accel_core::bits::{TILE, all, each};
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::nearest::Kind;
use gnurt_accel_core::tile::LANES;
use gnurt_accel_core::traversal::TileTraversal;
use gnurt_simd::{Simd, StackBuffer, prefetch, prelude::*};

use super::BoxIndex;
use super::met::{EnterMembers, Member};
use super::search::{Below, EnterBlock, search_treelet, search_upper};
use crate::node::{Child, Node8, WIDTH};
use crate::node_ray::NodeRay;
use crate::planes::{MovingMember, TilePlanes};
use crate::treelet::Treelet;
use crate::walk::farthest_first;

/// A stack entry: a child, the rays that may hit it, and the number of steps to the first possible hit.
#[derive(Clone, Copy)]
struct Entry {
    steps: f32,
    child: Child,
    rays: u64,
}

/// The size of the stack, which tests exceed. The deepest treelets need four times as much, but nested scenes
/// hold some of these each: without space, rays go on singly.
const MOST_WAIT: usize = if cfg!(test) { 12 } else { 64 };

/// Where a walk has come to.
enum Stop {
    /// A block, with many rays.
    Block(usize),
    /// A child, with rays that go on singly.
    SingleRays(Child),
}

/// Members of a whole block, by bits.
const ALL_LANES: u32 = (1 << WIDTH) - 1;

/// Where intervals leave this many boxes of a node, rays are tested one by one.
const MANY: u32 = 2;

/// This number of rays or fewer go on singly.
const FEW: u32 = 5;

impl BoxIndex {
    /// Enters the members that a tile's first rays, all of them active and of one direction class, may hit, with the traversal state of
    /// those rays that may hit it and are not finished. There are boxes.
    #[inline(always)]
    pub(crate) fn search_tile<S: Simd>(
        &self,
        simd: S,
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
        enter: &mut dyn EnterMembers,
    ) {
        let count = TILE - traversal.active.leading_zeros() as usize;
        let mut slopes = Slopes::EMPTY;
        slopes.prepare(simd, traversal.rays, count, direction_class);
        let whole = slopes.all_ranges(simd, traversal.rays, count);
        let whole = whole.relative_to(self.origin);
        let greatest = self.greatest_for(|| whole.away());
        let beam = Beam::new(&whole, direction_class, greatest);
        let farthest = slopes.steps_ahead(simd, traversal.nearest, count);
        let shot = &mut Shot {
            index: self,
            greatest,
            beam,
            slopes,
            count,
            direction_class,
            farthest,
            planes: None,
            visited: 0,
        };
        match &self.treelets[..] {
            [only] => tile_treelet(simd, (0, only), all(count), shot, traversal, enter),
            treelets => tile_upper(simd, &self.upper, treelets, shot, traversal, enter),
        }
        traversal.counters.nodes += shot.visited;
    }
}

/// A tile's rays during the traversal of boxes.
struct Shot<'a> {
    index: &'a BoxIndex,
    /// The coordinate that slack is for.
    greatest: f32,
    beam: Beam,
    slopes: Slopes,
    /// How many rays there are.
    count: usize,
    direction_class: DirectionClass,
    /// The greatest remaining extent of any ray, in steps.
    farthest: f32,
    /// Planes for each single ray, computed at first use. On the heap, because nested scenes share the stack.
    planes: Option<Box<TilePlanes>>,
    /// Nodes, once for each ray.
    visited: u64,
}

impl Shot<'_> {
    /// The rays by themselves.
    #[inline(always)]
    fn planes<S: Simd>(&mut self, simd: S, traversal: &TileTraversal) -> &TilePlanes {
        if self.planes.is_none() {
            self.planes = Some(self.prepared(simd, traversal));
        }
        self.planes.as_deref().unwrap_or(const { &TilePlanes::EMPTY })
    }

    #[cold]
    #[inline(never)]
    fn prepared<S: Simd>(&self, simd: S, traversal: &TileTraversal) -> Box<TilePlanes> {
        let BoxIndex { origin, .. } = *self.index;
        simd.vectorize(
            #[inline(always)]
            || Box::new(TilePlanes::of(simd, traversal.rays, self.count, origin, self.greatest)),
        )
    }

    /// Which boxes of a node the rays in `bits` may meet, each with its rays; and after how many steps the first of them may.
    #[inline(always)]
    fn meet<S: Simd>(
        &mut self,
        simd: S,
        node: &Node8,
        bits: u64,
        traversal: &TileTraversal,
        mut each: impl FnMut(usize, f32, u64),
    ) {
        let (mut places, near) = self.beam.meet(simd, &node.rows, self.farthest);
        let near = near.as_array();
        let mut masks = [bits; WIDTH];
        if places.count_ones() >= MANY {
            masks = [0; WIDTH];
            let (count, direction_class) = (self.count, self.direction_class);
            let planes = self.planes(simd, traversal);
            for at in (0..count).step_by(LANES) {
                if bits >> at & 0xffff != 0 {
                    let planes = planes.chunk(simd, direction_class, traversal.rays, traversal.nearest, at);
                    let mut left = places;
                    while left != 0 {
                        let member_index = left.trailing_zeros() as usize & (WIDTH - 1);
                        left &= left - 1;
                        masks[member_index] |= planes.meet(simd, node, member_index) << at;
                    }
                }
            }
        }
        while places != 0 {
            let member_index = places.trailing_zeros() as usize & (WIDTH - 1);
            places &= places - 1;
            if masks[member_index] & bits != 0 {
                each(member_index, near[member_index], masks[member_index] & bits);
            }
        }
    }

    /// The rays, each at its time, that may hit a moving member of a block.
    #[inline(never)]
    fn at_ray_times<S: Simd>(&mut self, simd: S, member: MovingMember, traversal: &TileTraversal) -> u64 {
        let (count, direction_class) = (self.count, self.direction_class);
        let planes = self.planes(simd, traversal);
        simd.vectorize(
            #[inline(always)]
            || {
                let chunks = (0..count).step_by(LANES);
                chunks.fold(0, |bits, at| {
                    bits | planes.meet_moving(
                        simd,
                        &member,
                        direction_class,
                        traversal.rays,
                        traversal.nearest,
                        at,
                    ) << at
                })
            },
        )
    }

    /// The unfinished rays; only any-hit rays finish early.
    #[inline(always)]
    fn looking<S: Simd>(&self, simd: S, traversal: &TileTraversal) -> u64 {
        if traversal.kind == Kind::Any { traversal.nearest.looking(simd) } else { u64::MAX }
    }

    /// After hits.
    #[inline(always)]
    fn update_reach<S: Simd>(&mut self, simd: S, traversal: &TileTraversal) {
        self.farthest = self.slopes.steps_ahead(simd, traversal.nearest, self.count);
    }

    /// Each ray in `bits` by itself: `search` is given the ray, its moment, where it ends, and what to call for the blocks of
    /// boxes that it meets, and answers with the number of nodes visited.
    #[inline(always)]
    fn go_singly<S: Simd>(
        &mut self,
        simd: S,
        bits: u64,
        traversal: &mut TileTraversal,
        enter: &mut dyn EnterMembers,
        mut search: impl FnMut(&NodeRay<S>, f32, f32, EnterBlock) -> u32,
    ) {
        let rows = self.direction_class.rows();
        let mut visited = 0;
        let planes = self.planes(simd, traversal);
        each(
            bits,
            #[inline(always)]
            |i| {
                let ray = planes.single_rays(simd, i, rows, traversal.rays.t_near[i % TILE]);
                let (time, reach) = (traversal.rays.time[i % TILE], traversal.nearest.t[i % TILE]);
                let traversal = &mut traversal.only(1 << i);
                visited += u64::from(search(&ray, time, reach, &mut |mut met| {
                    enter.announce(met.treelet, met.block, met.bits);
                    while let Some(member) = met.next(traversal.nearest.t[i % TILE]) {
                        enter.enter(member, traversal);
                    }
                    traversal.nearest.t[i % TILE]
                }));
            },
        );
        self.visited += visited;
        self.update_reach(simd, traversal);
    }
}

/// Traverses `nodes` with the rays in `bits`, and calls `stop` with those that reach a block, and with those
/// that go on singly; before that `ahead` with the waiting children.
#[expect(
    clippy::too_many_arguments,
    reason = "the state of a tile, and the actions at three points of the traversal"
)]
#[inline(always)]
fn walk_masks<'a, S: Simd>(
    simd: S,
    nodes: &[Node8],
    bits: u64,
    shot: &mut Shot<'a>,
    traversal: &mut TileTraversal,
    enter: &mut dyn EnterMembers,
    ahead: impl Fn(Child, &dyn EnterMembers),
    mut stop: impl FnMut(&mut Shot<'a>, Stop, u64, &mut TileTraversal, &mut dyn EnterMembers),
) {
    let mut buffer = StackBuffer::<Entry, MOST_WAIT>::new();
    let mut waiting = buffer.stack();
    waiting.push(Entry { steps: f32::NEG_INFINITY, child: Child::node(0), rays: bits });
    while let Some(Entry { steps, child, rays }) = waiting.pop() {
        let bits = rays & shot.looking(simd, traversal);
        if steps > shot.farthest || bits == 0 {
            continue;
        }
        if bits.count_ones() <= FEW || waiting.len() + WIDTH > MOST_WAIT {
            stop(shot, Stop::SingleRays(child), bits, traversal, enter);
            continue;
        }
        shot.visited += u64::from(bits.count_ones());
        if child.is_leaf() {
            for block in child.blocks() {
                stop(shot, Stop::Block(block), bits, traversal, enter);
            }
            continue;
        }
        let node = &nodes[child.index()];
        let mut pushed = 0;
        shot.meet(
            simd,
            node,
            bits,
            traversal,
            #[inline(always)]
            |member_index, steps, rays| {
                let child = node.child(member_index);
                prefetch(nodes, if child.is_leaf() { child.blocks().start } else { child.index() });
                ahead(child, enter);
                waiting.push(Entry { steps, child, rays });
                pushed += 1;
            },
        );
        farthest_first(waiting.top(pushed), |entry: &Entry| entry.steps);
    }
}

/// Calls `enter` with the members whose boxes the rays in `bits` may meet.
#[inline(never)]
fn tile_treelet<S: Simd>(
    simd: S,
    (number, treelet): (usize, &Treelet),
    bits: u64,
    shot: &mut Shot,
    traversal: &mut TileTraversal,
    enter: &mut dyn EnterMembers,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (nodes, first_block) = (treelet.nodes(), treelet.node_count());
            walk_masks(
                simd,
                nodes,
                bits,
                shot,
                traversal,
                enter,
                // Rays that have one direction class meet most members of a block.
                #[inline(always)]
                |child, enter| {
                    if child.is_leaf() {
                        enter.announce(number, child.blocks().start - first_block, ALL_LANES);
                    }
                },
                #[inline(always)]
                |shot, stop, bits, traversal, enter| match stop {
                    Stop::Block(at) => enter_block(simd, (number, treelet), at, bits, shot, traversal, enter),
                    Stop::SingleRays(child) => shot.go_singly(
                        simd,
                        bits,
                        traversal,
                        enter,
                        #[inline(always)]
                        |ray, time, reach, enter| {
                            search_treelet(simd, (number, treelet), child, ray, time, reach, enter).1
                        },
                    ),
                },
            );
        },
    );
}

/// A member of a block: its slot, the number of steps to the first possible hit, and the rays that may hit
/// it.
type Met = (usize, f32, u64);

/// The sort key of members, coarse enough that their order is independent of the level, which rounds
/// differently.
#[inline(always)]
fn rank(&(_, steps, _): &Met) -> u32 {
    steps.to_bits() >> 12
}

/// The members of one block, nearer ones first.
#[inline(always)]
fn enter_block<S: Simd>(
    simd: S,
    (number, treelet): (usize, &Treelet),
    at: usize,
    bits: u64,
    shot: &mut Shot,
    traversal: &mut TileTraversal,
    enter: &mut dyn EnterMembers,
) {
    let block = &treelet.nodes()[at];
    let (mut members, mut count): ([Met; WIDTH], usize) = ([(0, 0.0, 0); WIDTH], 0);
    let mut met = 0;
    shot.meet(
        simd,
        block,
        bits,
        traversal,
        #[inline(always)]
        |lane, steps, rays| {
            members[count & (WIDTH - 1)] = (lane, steps, rays);
            count += 1;
            met |= 1 << lane;
        },
    );
    let number_in_treelet = at - treelet.node_count();
    enter.announce(number, number_in_treelet, met);
    farthest_first(&mut members[..count], rank);
    for &(lane, steps, rays) in members[..count].iter().rev() {
        let mut rays = rays & traversal.nearest.looking(simd);
        if steps > shot.farthest {
            break;
        }
        if let Some(keys) = treelet.at_keys()
            && keys.moves(at, lane)
        {
            rays &= shot.at_ray_times(simd, MovingMember { keys, block: at, lane }, traversal);
        }
        if rays != 0 {
            let place = WIDTH * number_in_treelet + lane;
            let member = Member { treelet: number, place, index: block.child(lane).index() };
            enter.enter(member, &mut traversal.only(rays));
            shot.update_reach(simd, traversal);
        }
    }
}

/// The same through the upper treelet into those below.
#[inline(never)]
fn tile_upper<S: Simd>(
    simd: S,
    upper: &Treelet,
    treelets: &[Treelet],
    shot: &mut Shot,
    traversal: &mut TileTraversal,
    enter: &mut dyn EnterMembers,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (nodes, bits) = (upper.nodes(), all(shot.count));
            walk_masks(
                simd,
                nodes,
                bits,
                shot,
                traversal,
                enter,
                |_, _| {},
                #[inline(always)]
                |shot, stop, bits, traversal, enter| match stop {
                    Stop::Block(at) => {
                        let block = &nodes[at];
                        let (mut members, mut count): ([Met; WIDTH], usize) = ([(0, 0.0, 0); WIDTH], 0);
                        shot.meet(
                            simd,
                            block,
                            bits,
                            traversal,
                            #[inline(always)]
                            |lane, steps, rays| {
                                members[count & (WIDTH - 1)] = (block.child(lane).index(), steps, rays);
                                count += 1;
                            },
                        );
                        farthest_first(&mut members[..count], rank);
                        for &(number, _, rays) in members[..count].iter().rev() {
                            tile_treelet(simd, (number, &treelets[number]), rays, shot, traversal, enter);
                        }
                    }
                    Stop::SingleRays(child) => shot.go_singly(
                        simd,
                        bits,
                        traversal,
                        enter,
                        #[inline(always)]
                        |ray, time, reach, enter| {
                            search_upper(simd, upper, &Below { treelets, time }, child, ray, reach, enter)
                        },
                    ),
                },
            );
        },
    );
}
