// SPDX-License-Identifier: GPL-3.0-or-later
//! One ray, or a tile of them, through the top tree and into objects and scenes.
//! Source: [WBS03a] for the two levels; nearer boxes first, boxes beyond the best hit skipped.
//! Space: world until an instance is entered. Tests: `tests/instances.rs`, `tests/brute_force.rs` (`ask`).

use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::heading::Heading;
use gnurt_accel_core::tile::RayTile;
use gnurt_accel_core::trip::{RayTrip, TileTrip};

use super::instance::rounded;
use super::types::{At, Placed, SceneTree, Shape};
use crate::Ray;
use crate::engine::Engine;
use crate::together::{WORTH_A_TILE, by_heading};

/// Tiles go together through so many scenes in one another; what lies deeper is searched ray by ray, which takes less of the
/// stack.
const DEEPEST_TILE: u32 = 4;

impl SceneTree {
    /// Improves what the ray has found; it is sound. The trip's slot is the number of the scene's first object in the whole.
    pub(crate) fn ray(&self, engine: &Engine, trip: &mut RayTrip) {
        if let Some(only) = self.only {
            return self.enter(engine, only, trip);
        }
        if self.top.count() == 0 {
            return;
        }
        // Boxes are met by the regular ray; what is compared are its parameters.
        let (regular, scale) = if trip.ray.is_regular() {
            (*trip.ray, 1.0)
        } else {
            trip.ray.within(trip.ray.t_near, trip.reach()).regular()
        };
        let scaled = |t: f32| (f64::from(t) / scale) as f32;
        let ray = self.relative(&regular, trip.origin);
        let reach = scaled(trip.reach());
        let visited = engine.bvh.boxes(&self.top, &ray, reach, &mut |place| {
            self.enter(engine, place, trip);
            scaled(trip.reach())
        });
        trip.counters.nodes += u64::from(visited);
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

    /// Into one instance.
    fn enter(&self, engine: &Engine, place: usize, trip: &mut RayTrip) {
        let Some(placed) = self.placed(place).filter(|placed| placed.mask & trip.ray.mask != 0) else {
            return;
        };
        let slot = trip.slot + self.leaves.first(place);
        let (ray, origin) = (trip.ray, trip.origin);
        let At::Still { object_from_world, exact } = &placed.at else {
            return Self::enter_moving(engine, placed, slot, trip);
        };
        match (object_from_world, origin) {
            (None, _) => placed.shape.ray(engine, &mut trip.inside(ray, origin, slot)),
            (Some(map), None) => {
                let inside = map.ray(ray);
                if inside.is_sound() {
                    placed.shape.ray(engine, &mut trip.inside(&inside, None, slot));
                }
            }
            (Some(_), Some(origin)) => {
                let (inside, precise) = exact.stand().ray(ray, origin);
                if inside.is_sound() {
                    placed.shape.ray(engine, &mut trip.inside(&inside, Some(&precise), slot));
                }
            }
        }
    }

    /// Into one that moves: to where it is at the ray's moment, as if it stood there.
    #[inline(never)]
    fn enter_moving(engine: &Engine, placed: &Placed, slot: u32, trip: &mut RayTrip) {
        let (ray, origin) = (trip.ray, trip.origin);
        let Some(stand) = placed.stand(ray.time) else { return };
        match origin {
            None => {
                let Some(map) = rounded(&stand) else { return };
                let inside = map.ray(ray);
                if inside.is_sound() {
                    placed.shape.ray(engine, &mut trip.inside(&inside, None, slot));
                }
            }
            Some(origin) => {
                let (inside, precise) = stand.ray(ray, origin);
                if inside.is_sound() {
                    placed.shape.ray(engine, &mut trip.inside(&inside, Some(&precise), slot));
                }
            }
        }
    }

    /// Improves what a tile's active rays have found; they may be `apart`.
    pub(crate) fn tile(&self, engine: &Engine, trip: &mut TileTrip, apart: bool) {
        self.tile_at(engine, trip, apart, 1);
    }

    /// The same where this is scene number `depth` on the way down.
    fn tile_at(&self, engine: &Engine, trip: &mut TileTrip, apart: bool, depth: u32) {
        if self.top.count() == 0 || trip.active == 0 {
            return;
        }
        let alone = if depth > DEEPEST_TILE {
            trip.active
        } else if let Some(only) = self.only {
            return self.enter_tile(engine, only, trip, apart, depth);
        } else if apart || !engine.has_tiles() {
            trip.active
        } else {
            by_heading(engine, trip, &mut |heading, trip| self.together(engine, heading, trip, depth))
        };
        trip.only(alone).one_by_one(|trip| self.ray(engine, trip));
    }

    /// For a tile's first rays, all of them active and of one heading.
    fn together(&self, engine: &Engine, heading: Heading, trip: &mut TileTrip, depth: u32) {
        engine.bvh.boxes_tile(&self.top, heading, trip, &mut |place, trip| {
            self.enter_tile(engine, place, trip, false, depth);
        });
    }

    /// Into one instance.
    fn enter_tile(&self, engine: &Engine, place: usize, trip: &mut TileTrip, apart: bool, depth: u32) {
        let Some(placed) = self.placed(place).filter(|placed| placed.mask & trip.rays.mask != 0) else {
            return;
        };
        if trip.active.count_ones() < WORTH_A_TILE {
            return trip.one_by_one(|trip| self.enter(engine, place, trip));
        }
        let slot = trip.slot + self.leaves.first(place);
        let stopped;
        let object_from_world = match &placed.at {
            At::Still { object_from_world, .. } => object_from_world,
            // Where all rays are of one moment it stands still for them.
            At::Piece(..) | At::Path(_) => match only_moment(trip) {
                None => return trip.one_by_one(|trip| Self::enter_moving(engine, placed, slot, trip)),
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
                let (rays, active) = (trip.rays, trip.active);
                placed.shape.tile(engine, &mut trip.inside(rays, active, slot), apart, depth);
            }
            Some(map) => {
                let mut inside = RayTile::EMPTY;
                engine.tiles.carry(map, trip.rays, &mut inside);
                let active = trip.active & engine.tiles.sound(&inside, trip.nearest);
                placed.shape.tile(engine, &mut trip.inside(&inside, active, slot), apart, depth);
            }
        }
    }
}

/// The moment of all active rays of a tile, if they have the same one and are worth a tile.
fn only_moment(trip: &TileTrip) -> Option<f32> {
    let time = &trip.rays.time;
    if trip.active.count_ones() < WORTH_A_TILE {
        return None;
    }
    if !trip.rays.is_timed {
        return Some(0.0);
    }
    let first = time[trip.active.trailing_zeros() as usize % TILE];
    let (mut left, mut same) = (trip.active, true);
    while left != 0 && same {
        same = time[left.trailing_zeros() as usize % TILE] == first;
        left &= left - 1;
    }
    same.then_some(first)
}

impl Shape {
    #[inline]
    fn ray(&self, engine: &Engine, trip: &mut RayTrip) {
        match self {
            Self::Object(object) => object.ray(engine, trip),
            Self::Scene(scene) => scene.ray(engine, trip),
        }
    }

    fn tile(&self, engine: &Engine, trip: &mut TileTrip, apart: bool, depth: u32) {
        match self {
            Self::Object(object) => object.tile(engine, trip, apart),
            Self::Scene(scene) => scene.tile_at(engine, trip, apart, depth + 1),
        }
    }
}
