// SPDX-License-Identifier: GPL-3.0-or-later
//! Incoherent rays, many of them in flight at the same time. Group prefetching of \[CAGM04\], applied to
//! rays.
//!
//! A single ray waits for memory: its next node depends on the data that it has just read. Here [`AT_ONCE`]
//! rays are interleaved. In each round those at nodes are tested first, in succession without a branch
//! between them; then each chooses its next child, whose memory is prefetched; then those at leaves test
//! their triangles. A finished ray is replaced by the next one of the tile.
//! Invariant: each ray visits the nodes that it would visit singly, in that order. Tests: `tests`.

use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::collect::{BestOf, Collect};
use gnurt_accel_core::direction_class::DirectionClasses;
use gnurt_accel_core::nearest::Kind;
use gnurt_accel_core::traversal::TileTraversal;
use gnurt_simd::{Simd, StackBuffer, prelude::*};

use crate::index::BvhIndex;
use crate::leaves::prefetch_child;
use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::single_rays::SingleRays;
use crate::walk::{entry, last_first, nearest_first, next};

/// Rays in flight, a power of two.
const AT_ONCE: usize = 16;

/// The largest stack of one of them. The deepest trees need eight times as much, but sixteen such stacks
/// would fill half of a small thread's: a ray that may need more goes on singly.
const MOST_WAIT: usize = if cfg!(test) { 12 } else { 64 };

/// A pending visit: the ray, and its next child.
#[derive(Clone, Copy)]
struct Stop {
    who: u32,
    child: Child,
}

/// Stops that are made in one round.
struct Stops {
    all: [Stop; AT_ONCE],
    count: usize,
}

impl Stops {
    const NONE: Self = Self { all: [Stop { who: 0, child: Child::NONE }; AT_ONCE], count: 0 };

    #[inline(always)]
    fn get(&self, at: usize) -> Stop {
        self.all[at % AT_ONCE]
    }

    #[inline(always)]
    fn push(&mut self, stop: Stop) {
        self.all[self.count % AT_ONCE] = stop;
        self.count += 1;
    }
}

/// A tile's rays during the traversal of one object's tree.
pub(super) struct Interleaved<'a, S: Simd> {
    pub(super) simd: S,
    pub(super) index: &'a BvhIndex,
    pub(super) single_rays: SingleRays<'a>,
    pub(super) direction_classes: &'a DirectionClasses,
}

/// The state of the rays in flight.
struct InFlight {
    /// Rays of the tile that have not started.
    left: u64,
    /// The index of each in the tile.
    ray: [u32; AT_ONCE],
    rows: [[usize; 3]; AT_ONCE],
    waiting: [StackBuffer<u64, MOST_WAIT>; AT_ONCE],
    at_nodes: Stops,
    at_leaves: Stops,
}

impl<S: Simd> Interleaved<'_, S> {
    /// Improves the hits of a tile's active rays.
    #[inline(always)]
    pub(super) fn run(&self, traversal: &mut TileTraversal) {
        let Self { simd, index, single_rays, direction_classes } = self;
        let (simd, tree, leaves) = (*simd, &index.tree, &index.leaves);
        let mut in_flight = InFlight {
            left: traversal.active,
            ray: [0; AT_ONCE],
            rows: [[0; 3]; AT_ONCE],
            waiting: [const { StackBuffer::new() }; AT_ONCE],
            at_nodes: Stops::NONE,
            at_leaves: Stops::NONE,
        };
        for who in 0..AT_ONCE as u32 {
            self.start(&mut in_flight, who);
        }
        let mut met = [(0u32, [0.0f32; WIDTH]); AT_ONCE];
        while in_flight.at_nodes.count + in_flight.at_leaves.count != 0 {
            for at in 0..in_flight.at_nodes.count {
                let Stop { who, child } = in_flight.at_nodes.get(at);
                let who = who as usize % AT_ONCE;
                let i = in_flight.ray[who] as usize % TILE;
                let ray: NodeRay<S> = single_rays.for_nodes(simd, i, in_flight.rows[who]);
                let (bits, near) = ray.meet(simd, &tree.nodes[child.index()], traversal.nearest.t[i]);
                let met = &mut met[at % AT_ONCE];
                met.0 = bits;
                near.store_slice(&mut met.1);
            }
            let count = std::mem::take(&mut in_flight.at_nodes.count);
            traversal.counters.nodes += count as u64;
            for at in 0..count {
                let Stop { who, child } = in_flight.at_nodes.get(at);
                let (bits, near) = &met[at % AT_ONCE];
                if *bits == 0 {
                    self.go_on(&mut in_flight, who, traversal);
                } else {
                    let children = tree.nodes[child.index()].children();
                    let waiting = &mut in_flight.waiting[who as usize % AT_ONCE];
                    let child = if bits & (bits - 1) == 0 {
                        Child::at(children, bits.trailing_zeros() as usize)
                    } else {
                        waiting.resume(
                            #[inline(always)]
                            |waiting| match traversal.kind {
                                Kind::Any => last_first(
                                    *bits,
                                    children,
                                    #[inline(always)]
                                    |child| waiting.push(entry(0.0, child)),
                                ),
                                Kind::Closest => nearest_first(*bits, near, children, waiting),
                            },
                        )
                    };
                    self.visit(&mut in_flight, Stop { who, child }, traversal);
                }
            }
            let count = std::mem::take(&mut in_flight.at_leaves.count);
            traversal.counters.nodes += count as u64;
            for at in 0..count {
                let Stop { who, child } = in_flight.at_leaves.get(at);
                let i = in_flight.ray[who as usize % AT_ONCE] as usize % TILE;
                let for_blocks = single_rays.for_blocks(simd, i, direction_classes.of(i).longest_axis);
                let mut best = BestOf { nearest: traversal.nearest.get(i), kind: traversal.kind };
                for index in child.blocks() {
                    traversal.counters.triangles += WIDTH as u64;
                    leaves.blocks[index].meet(simd, &for_blocks, traversal.slot, &mut best);
                    if best.is_done() {
                        in_flight.waiting[who as usize % AT_ONCE].clear();
                        break;
                    }
                }
                traversal.nearest.set(i, &best.nearest);
                self.go_on(&mut in_flight, who, traversal);
            }
        }
    }

    /// Advances to the next entry of the stack that still counts; if there is none, another ray starts.
    #[inline(always)]
    fn go_on(&self, in_flight: &mut InFlight, who: u32, traversal: &mut TileTraversal) {
        let at = who as usize % AT_ONCE;
        let reach = traversal.nearest.t[in_flight.ray[at] as usize % TILE];
        let child = in_flight.waiting[at].resume(
            #[inline(always)]
            |waiting| next(waiting, reach),
        );
        match child {
            Some(child) => self.visit(in_flight, Stop { who, child }, traversal),
            None => self.start(in_flight, who),
        }
    }

    /// The next ray, if there is one.
    #[inline(always)]
    fn start(&self, in_flight: &mut InFlight, who: u32) {
        if in_flight.left == 0 {
            return;
        }
        let i = in_flight.left.trailing_zeros();
        in_flight.left &= in_flight.left - 1;
        let at = who as usize % AT_ONCE;
        in_flight.ray[at] = i;
        in_flight.rows[at] = self.direction_classes.of(i as usize).rows();
        self.note(in_flight, Stop { who, child: Child::node(0) });
    }

    /// The next step: a stop of the next round, or the rest of the traversal as a single ray.
    #[inline(always)]
    fn visit(&self, in_flight: &mut InFlight, stop: Stop, traversal: &mut TileTraversal) {
        // A node may leave seven children waiting.
        if in_flight.waiting[stop.who as usize % AT_ONCE].len() > MOST_WAIT - (WIDTH - 1)
            && !stop.child.is_leaf()
        {
            self.finish_single(in_flight, stop, traversal);
        } else {
            self.note(in_flight, stop);
        }
    }

    /// Notes the visit of the next round, and prefetches its memory.
    #[inline(always)]
    fn note(&self, in_flight: &mut InFlight, stop: Stop) {
        prefetch_child(&self.index.tree, &self.index.leaves, stop.child);
        if stop.child.is_leaf() {
            in_flight.at_leaves.push(stop);
        } else {
            in_flight.at_nodes.push(stop);
        }
    }

    /// All that a ray has before it, then the next one starts.
    #[cold]
    #[inline(never)]
    fn finish_single(
        &self,
        in_flight: &mut InFlight,
        Stop { who, child }: Stop,
        traversal: &mut TileTraversal,
    ) {
        let at = who as usize % AT_ONCE;
        let i = in_flight.ray[at] as usize % TILE;
        let mut ahead = Some(child);
        while let Some(child) = ahead {
            self.single_rays.walk(self.simd, self.index, child, &mut traversal.only(1 << i));
            ahead = in_flight.waiting[at].resume(|waiting| next(waiting, traversal.nearest.t[i]));
        }
        self.start(in_flight, who);
    }
}

#[cfg(test)]
mod tests {
    use gnurt_accel_core::bits::all;
    use gnurt_accel_core::collect::Best;
    use gnurt_accel_core::control::Watch;
    use gnurt_accel_core::geometry::Numbering;
    use gnurt_accel_core::nearest::{AnyHit, Closest};
    use gnurt_accel_core::surfaces::Surfaces;
    use gnurt_accel_core::tile::{NearestTile, RayTile};
    use gnurt_accel_core::tile_kernels::TileKernels;
    use gnurt_accel_core::traversal::RayTraversal;
    use gnurt_accel_core::{Counters, Memory, Quality, Ray, RayBatch, Threads, Triangles};
    use gnurt_simd::{Level, dispatch_wide};
    use gnurt_testkit::{Random, Soup};

    use super::*;
    use crate::screen::Screen;
    use crate::single_rays::PreparedTile;

    fn index_over(soup: &Soup) -> BvhIndex {
        let meshes = [Triangles { positions: &soup.positions, indices: &soup.indices }.into()];
        let surfaces = Surfaces::new(&meshes, &Numbering::new(&meshes), |_| true);
        let mut screen = Screen::over(surfaces, Quality::Medium, Threads::Single);
        BvhIndex::build(&mut screen, Quality::Medium, Memory::Fast, Threads::Single, &Watch::new(&()))
            .expect("there is memory")
    }

    fn tile_of(random: &mut Random) -> (RayTile, NearestTile) {
        let mut one = || Ray::new(random.point(), random.point()).within(0.0, random.between(0.1, 4.0));
        let rays: RayBatch = (0..TILE).map(|_| one()).collect();
        let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
        tile.load(&rays, 0, &mut nearest);
        (tile, nearest)
    }

    fn same_as_single<S: Simd>(simd: S, level: Level, index: &BvhIndex, seed: u64, kind: Kind) {
        for count in [64, 63, 17, 16, 1] {
            let (rays, found) = tile_of(&mut Random::new(seed + count as u64));
            let kernels = TileKernels::of(level.token());
            let active = kernels.sound(&rays, &found) & all(count) & !0b100;
            let (mut joint, mut single_rays) = (found, found);
            let (mut counted, mut expected) = (Counters::default(), Counters::default());
            let direction_classes = &kernels.direction_classes(&rays);
            let prepared = PreparedTile::new(simd, &rays, TILE, index.greatest);
            let interleaved = Interleaved {
                simd,
                index,
                single_rays: prepared.single_rays(&rays, direction_classes),
                direction_classes,
            };
            let traversal =
                |nearest, counters| TileTraversal { rays: &rays, active, kind, slot: 3, nearest, counters };
            interleaved.run(&mut traversal(&mut joint, &mut counted));
            traversal(&mut single_rays, &mut expected).one_by_one(|traversal| {
                let RayTraversal { ray, slot, nearest, counters, .. } = traversal;
                if kind == Kind::Any {
                    index.search(simd, ray, *slot, &mut Best::<AnyHit>::new(nearest), counters);
                } else {
                    index.search(simd, ray, *slot, &mut Best::<Closest>::new(nearest), counters);
                }
            });
            assert_eq!(counted, expected, "{count} rays visit the same");
            for i in 0..TILE {
                assert_eq!(joint.get(i), single_rays.get(i), "ray {i} of {count}");
            }
        }
    }

    #[test]
    fn interleaved_rays_visit_the_same_nodes() {
        for (seed, triangles) in [(1, 1), (2, 60), (3, 3000)] {
            let index = index_over(&Soup::random(seed, triangles, 0.4));
            for level in Level::available() {
                for kind in [Kind::Closest, Kind::Any] {
                    dispatch_wide!(level, simd => same_as_single(simd, level, &index, seed, kind), else ());
                }
            }
        }
    }

    #[test]
    fn only_waiting_rays_are_interleaved() {
        let (large, small) =
            (index_over(&Soup::random(4, 60_000, 0.1)), index_over(&Soup::random(4, 3000, 0.1)));
        assert!(
            large.waits_for_memory() && !small.waits_for_memory(),
            "a tree that the cache holds needs none"
        );
        let bounds = large.bounds();
        for level in Level::available() {
            let (mut rays, nearest) = tile_of(&mut Random::new(5));
            let sound = TileKernels::of(level.token()).sound(&rays, &nearest);
            dispatch_wide!(level, simd => {
                assert!(rays.origins_differ(simd, sound, &bounds), "places all over the scene");
                assert!(!rays.origins_differ(simd, 1, &bounds), "one ray has no neighbours");
                rays.org = rays.org.map(|axis| axis.map(|x| 0.05 * x));
                assert!(!rays.origins_differ(simd, sound, &bounds), "neighbours");
            }, else ());
        }
    }
}
