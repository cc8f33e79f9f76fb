// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays that have nothing in common, many of them on their way at the same time.
//! Source: original; group prefetching of \[CAGM04\], applied to rays.
//!
//! A ray by itself waits for memory: where it goes next depends on what it has just read. Here [`AT_ONCE`] rays take turns.
//! In each round those at nodes are tested first, one after the other without a branch between them; then each chooses its
//! next child, whose memory is asked for at once; then those at leaves test their triangles. Where a ray is done, the next
//! one of the tile takes its place.
//! Invariant: each ray visits what it would visit by itself, in that order. Proof: `tests`.

use gnurt_simd::{Simd, Stack, prelude::*};

use super::apart::Apart;
use super::leaves::{Leaves, ask_for};
use super::slab::NodeRay;
use super::walk::{Waiting, entry, lowest_first, nearest_first, next};
use super::{Boxes, Child, Tree, WIDTH};
use crate::Counters;
use crate::nearest::{Best, Collect, Mode};
use crate::tile::{NearestTile, RayTile, TILE};

/// Rays on their way at the same time, a power of two.
const AT_ONCE: usize = 16;

/// A place on a way: which of the rays under way it is, and what it visits next.
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

/// A tile's rays on their way through one object's tree.
pub(super) struct Turns<'a, S: Simd> {
    pub(super) simd: S,
    pub(super) tree: &'a Tree,
    pub(super) leaves: &'a Leaves,
    pub(super) rays: &'a RayTile,
    pub(super) apart: &'a Apart,
    pub(super) slot: u32,
}

/// What is known of the rays under way.
struct Under {
    /// Rays of the tile that have not started.
    left: u64,
    /// Each one's place in the tile.
    ray: [u32; AT_ONCE],
    rows: [[usize; 3]; AT_ONCE],
    waiting: [Waiting; AT_ONCE],
    at_nodes: Stops,
    at_leaves: Stops,
}

impl<S: Simd> Turns<'_, S> {
    /// Improves the hits of those of the tile's rays that are in `active`.
    #[inline(always)]
    pub(super) fn run<M: Mode>(&self, active: u64, nearest: &mut NearestTile, counters: &mut Counters) {
        let Self { simd, tree, leaves, rays, apart, slot } = *self;
        let mut under = Under {
            left: active,
            ray: [0; AT_ONCE],
            rows: [[0; 3]; AT_ONCE],
            waiting: [const { Stack::new() }; AT_ONCE],
            at_nodes: Stops::NONE,
            at_leaves: Stops::NONE,
        };
        for who in 0..AT_ONCE as u32 {
            self.start(&mut under, who);
        }
        let mut met = [(0u32, [0.0f32; WIDTH]); AT_ONCE];
        while under.at_nodes.count + under.at_leaves.count != 0 {
            for at in 0..under.at_nodes.count {
                let Stop { who, child } = under.at_nodes.get(at);
                let who = who as usize % AT_ONCE;
                let i = under.ray[who] as usize % TILE;
                let ray: NodeRay<S> = apart.for_nodes(simd, i, under.rows[who], rays.t_near[i]);
                let (bits, near) = ray.meet(simd, &tree.nodes[child.index()], nearest.t[i]);
                let met = &mut met[at % AT_ONCE];
                met.0 = bits;
                near.store_slice(&mut met.1);
            }
            let count = std::mem::take(&mut under.at_nodes.count);
            counters.nodes += count as u64;
            for at in 0..count {
                let Stop { who, child } = under.at_nodes.get(at);
                let (bits, near) = &met[at % AT_ONCE];
                if *bits == 0 {
                    self.go_on::<M>(&mut under, who, nearest);
                } else {
                    let children = tree.nodes[child.index()].children();
                    let waiting = &mut under.waiting[who as usize % AT_ONCE];
                    let child = if bits & (bits - 1) == 0 {
                        Child::at(children, bits.trailing_zeros() as usize)
                    } else if M::ANY {
                        lowest_first(
                            *bits,
                            children,
                            #[inline(always)]
                            |child| waiting.push(entry(0.0, child)),
                        )
                    } else {
                        nearest_first(*bits, near, children, waiting)
                    };
                    self.visit(&mut under, Stop { who, child });
                }
            }
            let count = std::mem::take(&mut under.at_leaves.count);
            counters.nodes += count as u64;
            for at in 0..count {
                let Stop { who, child } = under.at_leaves.get(at);
                let i = under.ray[who as usize % AT_ONCE] as usize % TILE;
                let for_blocks = apart.for_blocks(simd, i, rays.t_near[i]);
                let mut best = Best::<M>::new(nearest.get(i));
                for index in child.blocks() {
                    counters.triangles += WIDTH as u64;
                    leaves.block(simd, index, &mut None).meet(simd, &for_blocks, slot, &mut best);
                    if best.is_done() {
                        under.waiting[who as usize % AT_ONCE].clear();
                        break;
                    }
                }
                nearest.set(i, &best.0);
                self.go_on::<M>(&mut under, who, nearest);
            }
        }
    }

    /// To what waits and still counts; where there is nothing, another ray starts.
    #[inline(always)]
    fn go_on<M: Mode>(&self, under: &mut Under, who: u32, nearest: &NearestTile) {
        let at = who as usize % AT_ONCE;
        let reach = nearest.t[under.ray[at] as usize % TILE];
        match next(&mut under.waiting[at], reach) {
            Some(child) => self.visit(under, Stop { who, child }),
            None => self.start(under, who),
        }
    }

    /// The next ray, if there is one.
    #[inline(always)]
    fn start(&self, under: &mut Under, who: u32) {
        if under.left == 0 {
            return;
        }
        let i = under.left.trailing_zeros();
        under.left &= under.left - 1;
        let at = who as usize % AT_ONCE;
        under.ray[at] = i;
        under.rows[at] = self.apart.ways.of(i as usize).rows();
        self.visit(under, Stop { who, child: Child::node(0) });
    }

    /// Notes what is to be visited in the next round, and asks for its memory.
    #[inline(always)]
    fn visit(&self, under: &mut Under, stop: Stop) {
        ask_for(self.tree, self.leaves, stop.child);
        if stop.child.is_leaf() {
            under.at_leaves.push(stop);
        } else {
            under.at_nodes.push(stop);
        }
    }
}

#[cfg(test)]
mod tests {
    use gnurt_simd::{Level, dispatch_wide};
    use gnurt_testkit::{Random, Soup};

    use super::*;
    use crate::bvh::BvhIndex;
    use crate::control::Watch;
    use crate::geometry::Screened;
    use crate::nearest::{AnyHit, Closest};
    use crate::tile::all;
    use crate::{Memory, Quality, Ray, RayBatch, Threads, Triangles};

    fn index_over(soup: &Soup) -> BvhIndex {
        let meshes = [Triangles { positions: &soup.positions, indices: &soup.indices }];
        let screened = Screened::new(&meshes);
        BvhIndex::build(&screened, Quality::Medium, Memory::Fast, Threads::Single, &Watch::new(&()))
            .expect("there is memory")
    }

    fn tile_of<S: Simd>(simd: S, random: &mut Random) -> (RayTile, NearestTile, u64) {
        let mut one = || Ray::new(random.point(), random.point()).within(0.0, random.between(0.1, 4.0));
        let rays: RayBatch = (0..TILE).map(|_| one()).collect();
        let (mut tile, mut nearest) = (RayTile::EMPTY, NearestTile::EMPTY);
        let sound = tile.load(simd, &rays, 0, &mut nearest);
        (tile, nearest, sound)
    }

    fn same_as_alone<S: Simd, M: Mode>(simd: S, index: &BvhIndex, seed: u64) {
        let (tree, leaves) = index.parts();
        for count in [64, 63, 17, 16, 1] {
            let (rays, found, sound) = tile_of(simd, &mut Random::new(seed + count as u64));
            let active = sound & all(count) & !0b100;
            let (mut together, mut alone) = (found, found);
            let (mut counted, mut expected) = (Counters::default(), Counters::default());
            let apart = &Apart::new(simd, &rays, rays.headings(simd), TILE, tree.reach());
            Turns { simd, tree, leaves, rays: &rays, apart, slot: 3 }.run::<M>(
                active,
                &mut together,
                &mut counted,
            );
            alone.one_by_one::<M>(&rays, active, |ray, best| {
                index.search::<S, _>(simd, ray, 3, best, &mut expected);
            });
            assert_eq!(counted, expected, "{count} rays visit the same");
            for i in 0..TILE {
                assert_eq!(together.get(i), alone.get(i), "ray {i} of {count}");
            }
        }
    }

    #[test]
    fn rays_find_and_visit_what_they_do_alone() {
        for (seed, triangles) in [(1, 1), (2, 60), (3, 3000)] {
            let index = index_over(&Soup::random(seed, triangles, 0.4));
            for level in Level::available() {
                dispatch_wide!(level, simd => {
                    same_as_alone::<_, Closest>(simd, &index, seed);
                    same_as_alone::<_, AnyHit>(simd, &index, seed);
                }, else ());
            }
        }
    }

    #[test]
    fn only_rays_that_wait_take_turns() {
        let (large, small) =
            (index_over(&Soup::random(4, 60_000, 0.1)), index_over(&Soup::random(4, 3000, 0.1)));
        assert!(
            large.waits_for_memory() && !small.waits_for_memory(),
            "a tree that the cache holds needs none"
        );
        let bounds = large.bounds();
        for level in Level::available() {
            dispatch_wide!(level, simd => {
                let (mut rays, nearest, sound) = tile_of(simd, &mut Random::new(5));
                assert!(rays.start_apart(simd, sound, &bounds), "places all over the scene");
                assert!(!rays.start_apart(simd, 1, &bounds), "one ray has no neighbours");
                rays.org = rays.org.map(|axis| axis.map(|x| 0.05 * x));
                assert!(!rays.start_apart(simd, sound & rays.sound(simd, &nearest), &bounds), "neighbours");
            }, else ());
        }
    }
}
