// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray, or a tile of them, through the top tree and into objects and scenes.
//! Source: [WBS03a] for the two levels; nearer boxes first, boxes beyond the best hit skipped.
//! Space: world until an instance is entered. Tests: `tests/instances.rs`, `tests/brute_force.rs` (`query`).

use gnurt_accel_bvh::{EnterMembers, Member};
use gnurt_accel_core::affine::ObjectFromWorld;
use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::blocks::WIDTH;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::tile::RayTile;
use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};

use super::instance::rounded;
use super::types::{At, PlacedInstance, SceneTree, Shape, TreeletEntries};
use crate::Ray;
use crate::coherent::{WORTH_A_TILE, by_direction_class};
use crate::engine::Engine;

/// Tiles pass together through this many levels of scenes; deeper levels are searched ray by ray, which takes
/// less of the stack.
const DEEPEST_TILE: u32 = 4;

impl SceneTree {
    /// Improves the ray's result; the ray is valid. The state's slot is the number of the scene's first
    /// object in the whole.
    pub(crate) fn ray(&self, engine: &Engine, traversal: &mut RayTraversal) {
        if let Some(only) = self.only {
            return self.enter_slot(engine, only, traversal);
        }
        if self.top.count() == 0 {
            return;
        }
        // Boxes are tested with the regular ray; comparisons use its parameters.
        let (regular, scale) = if traversal.ray.is_regular() {
            (*traversal.ray, 1.0)
        } else {
            traversal.ray.within(traversal.ray.t_near, traversal.reach()).regular()
        };
        let scaled = |t: f32| if scale == 1.0 { t } else { (f64::from(t) / scale) as f32 };
        let ray = self.relative(&regular, traversal.origin);
        let reach = scaled(traversal.reach());
        let visited = engine.bvh.boxes(&self.top, &ray, reach, &mut |mut met| {
            let entries = self.entries.of(met.treelet());
            met.places(|place| entries.prefetch(place));
            while let Some(Member { place, index, .. }) = met.next(scaled(traversal.reach())) {
                self.enter(engine, entries, place, index, traversal);
            }
            scaled(traversal.reach())
        });
        traversal.counters.nodes += u64::from(visited);
    }

    /// A ray, whose parameters stay, relative to the origin of the boxes.
    #[inline]
    fn relative(&self, ray: &Ray, origin: Option<&[f64; 3]>) -> Ray {
        let from = self.top.origin();
        let mut moved = *ray;
        for k in 0..3 {
            moved.org[k] = match origin {
                None => ray.org[k] - from[k],
                Some(precise) => (precise[k] - f64::from(from[k])) as f32,
            };
        }
        moved
    }

    /// Into one instance, which is at a place of a treelet.
    #[inline(always)]
    fn enter(
        &self,
        engine: &Engine,
        entries: &TreeletEntries,
        place: usize,
        index: usize,
        traversal: &mut RayTraversal,
    ) {
        let (Some((map, shown)), None) = (entries.get(place), traversal.origin) else {
            return self.enter_slot(engine, index, traversal);
        };
        if shown.mask & traversal.ray.mask == 0 {
            return;
        }
        let inside = map.ray(traversal.ray);
        if inside.is_sound() {
            let slot = traversal.slot + self.leaves.first(index);
            shown.shape.ray(engine, &mut traversal.inside(&inside, None, slot));
        }
    }

    /// Into one instance by its slot.
    #[inline(never)]
    fn enter_slot(&self, engine: &Engine, index: usize, traversal: &mut RayTraversal) {
        let Some(placed) = self.placed(index).filter(|placed| placed.mask & traversal.ray.mask != 0) else {
            return;
        };
        let slot = traversal.slot + self.leaves.first(index);
        let (ray, origin) = (traversal.ray, traversal.origin);
        let At::Still { object_from_world, exact } = &placed.at else {
            return Self::enter_moving(engine, placed, slot, traversal);
        };
        match (object_from_world, origin) {
            (None, _) => placed.shape.ray(engine, &mut traversal.inside(ray, origin, slot)),
            (Some(map), None) => {
                let inside = map.ray(ray);
                if inside.is_sound() {
                    placed.shape.ray(engine, &mut traversal.inside(&inside, None, slot));
                }
            }
            (Some(_), Some(origin)) => {
                let (inside, precise) = exact.stand().ray(ray, origin);
                if inside.is_sound() {
                    placed.shape.ray(engine, &mut traversal.inside(&inside, Some(&precise), slot));
                }
            }
        }
    }

    /// Into a moving one: at its transform at the ray's time.
    #[inline(never)]
    fn enter_moving(engine: &Engine, placed: &PlacedInstance, slot: u32, traversal: &mut RayTraversal) {
        let (ray, origin) = (traversal.ray, traversal.origin);
        let Some(stand) = placed.stand(ray.time) else { return };
        match origin {
            None => {
                let Some(map) = rounded(&stand) else { return };
                let inside = map.ray(ray);
                if inside.is_sound() {
                    placed.shape.ray(engine, &mut traversal.inside(&inside, None, slot));
                }
            }
            Some(origin) => {
                let (inside, precise) = stand.ray(ray, origin);
                if inside.is_sound() {
                    placed.shape.ray(engine, &mut traversal.inside(&inside, Some(&precise), slot));
                }
            }
        }
    }

    /// Improves the results of a tile's active rays; they may be `incoherent`.
    pub(crate) fn tile(&self, engine: &Engine, traversal: &mut TileTraversal, incoherent: bool) {
        self.tile_at(engine, traversal, incoherent, 1);
    }

    /// The same for a scene at nesting level `depth`.
    fn tile_at(&self, engine: &Engine, traversal: &mut TileTraversal, incoherent: bool, depth: u32) {
        if self.top.count() == 0 || traversal.active == 0 {
            return;
        }
        let single = if depth > DEEPEST_TILE {
            traversal.active
        } else if let Some(only) = self.only {
            return self.enter_slot_tile(engine, only, traversal, incoherent, depth);
        } else if incoherent || !engine.has_tiles() {
            traversal.active
        } else {
            by_direction_class(engine, traversal, &mut |direction_class, traversal| {
                self.coherent(engine, direction_class, traversal, depth)
            })
        };
        traversal.only(single).one_by_one(|traversal| self.ray(engine, traversal));
    }

    /// For a tile's first rays, all of them active and of one direction class.
    fn coherent(
        &self,
        engine: &Engine,
        direction_class: DirectionClass,
        traversal: &mut TileTraversal,
        depth: u32,
    ) {
        let mut enter = EnterTiles { scene: self, engine, depth };
        engine.bvh.boxes_tile(&self.top, direction_class, traversal, &mut enter);
    }

    /// Into one instance, which is at a place of a treelet.
    fn enter_tile(&self, engine: &Engine, member: Member, traversal: &mut TileTraversal, depth: u32) {
        let entries = self.entries.of(member.treelet);
        let Some((map, shown)) = entries.get(member.place) else {
            return self.enter_slot_tile(engine, member.index, traversal, false, depth);
        };
        if shown.mask & traversal.rays.mask == 0 {
            return;
        }
        if traversal.active.count_ones() < WORTH_A_TILE {
            return traversal
                .one_by_one(|traversal| self.enter(engine, entries, member.place, member.index, traversal));
        }
        let slot = traversal.slot + self.leaves.first(member.index);
        carry_tile(engine, map, &shown.shape, traversal, slot, false, depth);
    }

    /// Into one instance by its slot.
    fn enter_slot_tile(
        &self,
        engine: &Engine,
        index: usize,
        traversal: &mut TileTraversal,
        incoherent: bool,
        depth: u32,
    ) {
        let Some(placed) = self.placed(index).filter(|placed| placed.mask & traversal.rays.mask != 0) else {
            return;
        };
        if traversal.active.count_ones() < WORTH_A_TILE {
            return traversal.one_by_one(|traversal| self.enter_slot(engine, index, traversal));
        }
        let slot = traversal.slot + self.leaves.first(index);
        let stopped;
        let object_from_world = match &placed.at {
            At::Still { object_from_world, .. } => object_from_world,
            // If all rays have one time, the instance is static for them.
            At::Piece(..) | At::Path(_) => match only_interval(traversal) {
                None => {
                    return traversal
                        .one_by_one(|traversal| Self::enter_moving(engine, placed, slot, traversal));
                }
                Some(time) => {
                    stopped = placed.stand(time).and_then(|stand| rounded(&stand));
                    if stopped.is_none() {
                        return;
                    }
                    &stopped
                }
            },
        };
        match object_from_world {
            None => {
                let (rays, active) = (traversal.rays, traversal.active);
                placed.shape.tile(engine, &mut traversal.inside(rays, active, slot), incoherent, depth);
            }
            Some(map) => carry_tile(engine, map, &placed.shape, traversal, slot, incoherent, depth),
        }
    }
}

/// Members of a top tree on the way of a tile's rays, which have one direction class.
struct EnterTiles<'a> {
    scene: &'a SceneTree,
    engine: &'a Engine,
    depth: u32,
}

impl EnterMembers for EnterTiles<'_> {
    #[inline]
    fn announce(&self, treelet: usize, block: usize, mut bits: u32) {
        let entries = self.scene.entries.of(treelet);
        while bits != 0 {
            entries.prefetch(WIDTH * block + bits.trailing_zeros() as usize);
            bits &= bits - 1;
        }
    }

    #[inline]
    fn enter(&mut self, member: Member, traversal: &mut TileTraversal) {
        self.scene.enter_tile(self.engine, member, traversal, self.depth);
    }
}

/// A tile's active rays into what is shown behind a map.
fn carry_tile(
    engine: &Engine,
    map: &ObjectFromWorld,
    shape: &Shape,
    traversal: &mut TileTraversal,
    slot: u32,
    incoherent: bool,
    depth: u32,
) {
    let mut inside = RayTile::EMPTY;
    engine.tiles.carry(map, traversal.rays, &mut inside);
    let active = traversal.active & engine.tiles.sound(&inside, traversal.nearest);
    shape.tile(engine, &mut traversal.inside(&inside, active, slot), incoherent, depth);
}

/// The moment of all active rays of a tile, if they have the same one and are worth a tile.
fn only_interval(traversal: &TileTraversal) -> Option<f32> {
    let time = &traversal.rays.time;
    if traversal.active.count_ones() < WORTH_A_TILE {
        return None;
    }
    if !traversal.rays.is_timed {
        return Some(0.0);
    }
    let first = time[traversal.active.trailing_zeros() as usize % TILE];
    let (mut left, mut same) = (traversal.active, true);
    while left != 0 && same {
        same = time[left.trailing_zeros() as usize % TILE] == first;
        left &= left - 1;
    }
    same.then_some(first)
}

impl Shape {
    #[inline]
    fn ray(&self, engine: &Engine, traversal: &mut RayTraversal) {
        match self {
            Self::Object(object) => object.ray(engine, traversal),
            Self::Scene(scene) => scene.ray(engine, traversal),
        }
    }

    fn tile(&self, engine: &Engine, traversal: &mut TileTraversal, incoherent: bool, depth: u32) {
        match self {
            Self::Object(object) => object.tile(engine, traversal, incoherent),
            Self::Scene(scene) => scene.tile_at(engine, traversal, incoherent, depth + 1),
        }
    }
}
