// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray, or a tile of them, through the top tree and into objects and scenes.
//! Source: [WBS03a] for the two levels; nearer boxes first, boxes beyond the best hit skipped.
//! Space: world until an instance is entered. Proof: `tests/instances.rs`, `tests/brute_force.rs` (`ask`).

use gnurt_simd::Simd;

use super::SceneTree;
use super::instance::{Placed, Shape};
use crate::bvh::{Beam, Child, NodeRay, Slopes};
use crate::nearest::{Collect, Mode};
use crate::packet::Heading;
use crate::tile::{NearestTile, RayTile, all};
use crate::{Counters, Ray};

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

    /// The same for the rays of a tile that are in `active`; they may be `apart`.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "they are what a tile's way through a tree takes")]
    pub(super) fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        apart: bool,
        first_leaf: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        if let [only] = &self.placed[..] {
            return only.search_tile::<S, M>(simd, rays, active, apart, first_leaf, nearest, counters);
        }
        if self.placed.is_empty() || active == 0 {
            return;
        }
        simd.vectorize(
            #[inline(always)]
            || {
                let mut alone = active;
                if !apart {
                    alone = rays.part(
                        simd,
                        active,
                        nearest,
                        #[inline(always)]
                        |rays, count, heading, best| {
                            self.sweep_top::<S, M>(simd, rays, count, heading, first_leaf, best, counters);
                        },
                    );
                }
                nearest.one_by_one::<M>(
                    rays,
                    alone,
                    #[inline(always)]
                    |ray, best| {
                        self.search::<S, _>(simd, Seeker { ray, origin: None, first_leaf }, best, counters);
                    },
                );
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
        slopes.prepare(simd, rays, count, heading);
        let whole = slopes.all_ranges(simd, rays, count);
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
                        placed.search_tile::<S, M>(simd, rays, active, false, first_leaf, nearest, counters);
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
    #[expect(clippy::too_many_arguments, reason = "they are what a tile's way through a tree takes")]
    fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        apart: bool,
        first_leaf: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        if self.mask & rays.mask == 0 {
            return;
        }
        let leaf = first_leaf + self.first_leaf;
        match &self.object_from_world {
            None => self.shape.search_tile::<S, M>(simd, rays, active, apart, leaf, nearest, counters),
            Some(map) => {
                let mut inside = RayTile::EMPTY;
                map.tile(simd, rays, &mut inside);
                let active = active & inside.sound(simd, nearest);
                self.shape.search_tile::<S, M>(simd, &inside, active, apart, leaf, nearest, counters);
            }
        }
    }
}

impl Shape {
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "they are what a tile's way through a tree takes")]
    fn search_tile<S: Simd, M: Mode>(
        &self,
        simd: S,
        rays: &RayTile,
        active: u64,
        apart: bool,
        leaf: u32,
        nearest: &mut NearestTile,
        counters: &mut Counters,
    ) {
        match self {
            Self::Object(object) => {
                object.search_tile::<S, M>(simd, rays, active, apart, leaf, nearest, counters)
            }
            Self::Scene(scene) => {
                scene.search_tile::<S, M>(simd, rays, active, apart, leaf, nearest, counters);
            }
        }
    }
}
