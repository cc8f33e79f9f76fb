// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray, or a tile of them, through the top tree and into objects and scenes.
//! Source: [WBS03a] for the two levels; nearer boxes first, boxes beyond the best hit skipped.
//! Space: world until an instance is entered. Proof: `tests/instances.rs`, `tests/brute_force.rs` (`ask`).

use gnurt_simd::Simd;

use super::SceneTree;
use super::instance::{Placed, Shape};
use crate::bvh::{Beam, Child, NodeRay, Slopes};
use crate::nearest::{Best, Collect, Mode};
use crate::packet::Heading;
use crate::tile::{NearestTile, RayTile, TILE, all};
use crate::{Counters, Ray};

/// Fewer rays of one heading go one by one.
const WORTH_A_TILE: u32 = 8;

/// One ray in a scene's space.
#[derive(Clone, Copy)]
pub(super) struct Seeker<'a> {
    pub(super) ray: &'a Ray,
    /// Its origin in double precision, where that is known.
    pub(super) origin: Option<&'a [f64; 3]>,
    /// The number of the scene's first object in the whole.
    pub(super) first_leaf: u32,
}

impl SceneTree {
    /// Offers what the ray meets; it is sound. A function of its own, since scenes may hold scenes.
    #[inline(never)]
    pub(super) fn search<S: Simd, C: Collect>(
        &self,
        simd: S,
        seeker: Seeker,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        if let [_] = &self.placed[..] {
            return self.enter::<S, C>(simd, 0, seeker, collect, counters);
        }
        simd.vectorize(
            #[inline(always)]
            || self.search_top::<S, C>(simd, seeker, collect, counters),
        );
    }

    #[inline(always)]
    fn search_top<S: Simd, C: Collect>(
        &self,
        simd: S,
        seeker: Seeker,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        if self.placed.is_empty() {
            return;
        }
        let ray = seeker.ray;
        let regular = (Ray::SHORTEST..=Ray::LONGEST).contains(&ray.longest());
        // Boxes are met by the regular ray; what is compared are its parameters.
        let (scaled, scale) =
            if regular { (*ray, 1.0) } else { ray.within(ray.t_near, collect.reach()).regular() };
        // Scales are powers of two: their inverses are exact.
        let over_scale = 1.0 / scale;
        let top = &self.top;
        let for_nodes = NodeRay::new(simd, &top.relative(&scaled, seeker.origin), top.reach);
        let visited = top.tree.walk(
            simd,
            Child::node(0),
            &for_nodes,
            collect.reach() * over_scale,
            #[inline(always)]
            |blocks| {
                for block in &top.blocks[blocks] {
                    let (mut bits, _) = for_nodes.meet(simd, block, collect.reach() * over_scale);
                    while bits != 0 {
                        let place = block.child(bits.trailing_zeros() as usize).index();
                        bits &= bits - 1;
                        self.enter::<S, C>(simd, place, seeker, collect, counters);
                    }
                }
                collect.reach() * over_scale
            },
        );
        counters.nodes += u64::from(visited);
    }

    /// Into one instance.
    #[inline(always)]
    fn enter<S: Simd, C: Collect>(
        &self,
        simd: S,
        place: usize,
        seeker: Seeker,
        collect: &mut C,
        counters: &mut Counters,
    ) {
        let placed = &self.placed[place];
        if placed.mask & seeker.ray.mask == 0 {
            return;
        }
        let first_leaf = seeker.first_leaf + placed.first_leaf;
        let (inside, precise);
        let seeker = match (&placed.object_from_world, seeker.origin) {
            (None, _) => Seeker { first_leaf, ..seeker },
            (Some(map), None) => {
                inside = map.ray(seeker.ray);
                Seeker { ray: &inside, first_leaf, ..seeker }
            }
            (Some(_), Some(origin)) => {
                (inside, precise) = self.exact[place].ray(seeker.ray, origin);
                Seeker { ray: &inside, origin: Some(&precise), first_leaf }
            }
        };
        if placed.object_from_world.is_some() && !seeker.ray.is_sound() {
            return;
        }
        match &placed.shape {
            Shape::Object(object) => object.search::<S, C>(simd, seeker.ray, first_leaf, collect, counters),
            Shape::Scene(scene) => scene.search::<S, C>(simd, seeker, collect, counters),
        }
    }

    /// The same for the rays of a tile that are in `active`.
    #[inline(never)]
    pub(super) fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        first_leaf: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        if let [only] = &self.placed[..] {
            return only.search_tile::<S, M>(simd, rays, active, first_leaf, nearest, counters);
        }
        if self.placed.is_empty() || active == 0 {
            return;
        }
        simd.vectorize(
            #[inline(always)]
            || {
                let ways = rays.headings(simd);
                let mut alone = active & !ways.regular;
                let mut left = active & ways.regular;
                while left != 0 {
                    let (heading, bits) = ways.like(left.trailing_zeros() as usize, left);
                    left &= !bits;
                    if bits.count_ones() < WORTH_A_TILE {
                        alone |= bits;
                    } else if bits == u64::MAX {
                        self.sweep_top::<S, M>(simd, rays, TILE, heading, first_leaf, nearest, counters);
                    } else {
                        let (mut some, mut best) = (RayTile::EMPTY, NearestTile::EMPTY);
                        let count = rays.gather(nearest, bits, &mut some, &mut best);
                        self.sweep_top::<S, M>(simd, &some, count, heading, first_leaf, &mut best, counters);
                        nearest.scatter(bits, &best);
                    }
                }
                while alone != 0 {
                    let i = alone.trailing_zeros() as usize;
                    alone &= alone - 1;
                    let mut best = Best::<M>::new(nearest.get(i));
                    let ray = &rays.ray(i, best.reach());
                    self.search::<S, _>(simd, Seeker { ray, origin: None, first_leaf }, &mut best, counters);
                    nearest.set(i, &best.0);
                }
            },
        );
    }

    /// The first `count` rays have one heading.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "they are what a tile's way through a tree takes")]
    fn sweep_top<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        count: usize,
        heading: Heading,
        first_leaf: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        let top = &self.top;
        let mut slopes = Slopes::EMPTY;
        let (_, whole) = slopes.prepare(simd, rays, count, heading);
        let beam = Beam::new(&whole.relative_to(top.origin), heading, top.reach);
        let mut farthest = slopes.steps_ahead(simd, nearest, count);
        let visited = top.tree.sweep(
            simd,
            &beam,
            farthest,
            #[inline(always)]
            |blocks| {
                for block in &top.blocks[blocks] {
                    let (mut bits, _) = beam.meet(simd, block, farthest);
                    while bits != 0 {
                        let place = block.child(bits.trailing_zeros() as usize).index();
                        bits &= bits - 1;
                        let active = all(count) & nearest.looking(simd);
                        let placed = &self.placed[place];
                        placed.search_tile::<S, M>(simd, rays, active, first_leaf, nearest, counters);
                    }
                }
                farthest = slopes.steps_ahead(simd, nearest, count);
                farthest
            },
        );
        counters.nodes += u64::from(visited) * count as u64;
    }
}

impl Placed {
    #[inline(always)]
    fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        first_leaf: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        if self.mask & rays.mask == 0 {
            return;
        }
        let leaf = first_leaf + self.first_leaf;
        match &self.object_from_world {
            None => self.shape.search_tile::<S, M>(simd, rays, active, leaf, nearest, counters),
            Some(map) => {
                let mut inside = RayTile::EMPTY;
                map.tile(simd, rays, &mut inside);
                let active = active & inside.sound(simd, nearest);
                self.shape.search_tile::<S, M>(simd, &inside, active, leaf, nearest, counters);
            }
        }
    }
}

impl Shape {
    #[inline(always)]
    fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        leaf: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        match self {
            Self::Object(object) => object.search_tile::<S, M>(simd, rays, active, leaf, nearest, counters),
            Self::Scene(scene) => {
                scene.search_tile::<S, M>(simd, rays, active, leaf, nearest, counters);
            }
        }
    }
}
