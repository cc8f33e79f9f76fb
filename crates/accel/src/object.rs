// SPDX-License-Identifier: GPL-3.0-or-later
//! The trees over one object's geometry, ready for rays: shared through `Arc`, refitted only by a sole owner.
//! As in Embree, a tree for each kind of primitive, searched in succession up to the best hit so far. Space:
//! object; `inst_id` is 0 in all hits.
//! Invariant: primitives are numbered through all geometries, so the best hit does not depend on the order of
//! trees.
//! Tests: `tests/brute_force.rs`, `tests/mixed.rs`.

mod build;
mod corners;
mod kind;
mod locations;
mod posed;
mod refit;
mod region;
mod snapshot;
mod store;

use std::sync::OnceLock;

use gnurt_accel_bvh::{BlockIndex, BvhIndex, MotionIndex, MovingUserIndex};
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::geometry::Numbering;
use gnurt_accel_core::nearest::Nearest;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::traversal::{RayTraversal, TileTraversal};
use kind::{Group, Kind, Times};
use locations::Locations;

use crate::coherent::by_direction_class;
use crate::engine::Engine;
use crate::research::ResearchIndex;
use crate::{Aabb, BadPrimitives, Hit, TreeStats};

/// This number of geometries or fewer are compared with each hit, sixteen hits at a time.
const FEW: usize = 64;

/// Trees over an object's geometries.
#[derive(Clone, Debug)]
pub struct ObjectTree {
    /// None of them empty.
    parts: Vec<Part>,
    /// By geometry; `None` where a tree that was loaded holds nothing of it.
    groups: Vec<Option<Group>>,
    numbering: Numbering,
    bad: BadPrimitives,
    bounds: Aabb,
    stats: TreeStats,
    /// Locations of primitives by number, computed at first use.
    locations: OnceLock<Locations>,
}

/// A tree over all primitives of one kind, mask and range of times.
#[derive(Clone, Debug)]
struct Part {
    mask: u32,
    times: Times,
    index: Index,
}

/// The kind of tree. To add a structure is to add a line here and in the matches below; a primitive needs none.
#[derive(Clone, Debug)]
enum Index {
    Research(ResearchIndex),
    Bvh(BvhIndex),
    /// Triangles that move while the shutter is open.
    Moving(MotionIndex),
    /// User geometry that does, and all other primitives that do.
    MovingUser(MovingUserIndex),
    /// All that is not a triangle: the list of its kinds is `blocks.rs` of `gnurt-accel-bvh`.
    Blocks(BlockIndex),
}

/// Runs an expression for the tree of any kind, where all have a method of the same name.
macro_rules! each {
    ($index:expr, $tree:ident => $body:expr) => {
        match $index {
            Index::Research($tree) => $body,
            Index::Bvh($tree) => $body,
            Index::Moving($tree) => $body,
            Index::MovingUser($tree) => $body,
            Index::Blocks($tree) => $body,
        }
    };
}

impl ObjectTree {
    /// Box around everything, object space; [`Aabb::EMPTY`] without anything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Primitives dropped at the build.
    #[must_use]
    pub fn bad_primitives(&self) -> BadPrimitives {
        self.bad
    }

    /// Size and shape of the trees, added up.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.stats
    }

    /// Whether two objects have the same trees, node for node.
    #[must_use]
    pub fn same_tree(&self, other: &Self) -> bool {
        let same = |(a, b): (&Part, &Part)| {
            (a.mask, a.times) == (b.mask, b.times)
                && match (&a.index, &b.index) {
                    (Index::Research(a), Index::Research(b)) => a == b,
                    (Index::Bvh(a), Index::Bvh(b)) => a == b,
                    (Index::Moving(a), Index::Moving(b)) => a == b,
                    (Index::MovingUser(a), Index::MovingUser(b)) => a.same_tree(b),
                    (Index::Blocks(a), Index::Blocks(b)) => a.same_tree(b),
                    _ => false,
                }
        };
        self.parts.len() == other.parts.len() && self.parts.iter().zip(&other.parts).all(same)
    }

    /// Improves the ray's result; the ray is valid.
    #[inline(always)]
    pub(crate) fn ray(&self, engine: &Engine, traversal: &mut RayTraversal) {
        if !traversal.ray.is_regular() {
            return self.ray_scaled(engine, traversal);
        }
        for part in &self.parts {
            if part.mask & traversal.ray.mask != 0 && !traversal.is_over() {
                part.ray(engine, traversal);
            }
        }
    }

    /// For directions so long or short that their inverse is of no use.
    #[cold]
    #[inline(never)]
    fn ray_scaled(&self, engine: &Engine, traversal: &mut RayTraversal) {
        let (scaled, scale) = traversal.ray.within(traversal.ray.t_near, traversal.reach()).regular();
        if scaled.is_regular() {
            traversal.scaled(&scaled, scale, |traversal| {
                for part in self.parts.iter().filter(|part| part.mask & traversal.ray.mask != 0) {
                    if !traversal.is_over() {
                        part.ray(engine, traversal);
                    }
                }
            });
        }
    }

    /// Improves the results of a tile's active rays, all of them valid. Rays of different directions are
    /// separated first, unless all of them are `incoherent`.
    pub(crate) fn tile(&self, engine: &Engine, traversal: &mut TileTraversal, incoherent: bool) {
        if self.parts.is_empty() || traversal.active == 0 {
            return;
        }
        if incoherent || !engine.has_tiles() {
            return self.incoherent(engine, traversal);
        }
        let single = by_direction_class(engine, traversal, &mut |direction_class, traversal| {
            self.coherent(engine, direction_class, traversal)
        });
        if single != 0 {
            self.incoherent(engine, &mut traversal.only(single));
        }
    }

    /// For rays that have nothing in common.
    fn incoherent(&self, engine: &Engine, traversal: &mut TileTraversal) {
        let mut single = traversal.active;
        if let [Part { index: Index::Bvh(index), mask, .. }] = &self.parts[..]
            && engine.has_tiles()
        {
            let direction_classes = engine.tiles.direction_classes(traversal.rays);
            let regular = traversal.active & direction_classes.regular;
            single &= !regular;
            if mask & traversal.rays.mask != 0 && regular != 0 {
                engine.bvh.incoherent(index, &direction_classes, &mut traversal.only(regular));
            }
        }
        if let [Part { index: Index::Blocks(index), mask, .. }] = &self.parts[..]
            && engine.has_tiles()
            && mask & traversal.rays.mask != 0
        {
            let regular = traversal.active & engine.tiles.direction_classes(traversal.rays).regular;
            if regular != 0 && engine.bvh.blocks_tile(index, &mut traversal.only(regular)) {
                single &= !regular;
            }
        }
        traversal.only(single).one_by_one(|traversal| self.ray(engine, traversal));
    }

    /// For a tile's first rays, all of them active and of one direction class.
    fn coherent(&self, engine: &Engine, direction_class: DirectionClass, traversal: &mut TileTraversal) {
        for part in self.parts.iter().filter(|part| part.mask & traversal.rays.mask != 0) {
            let has_kernel = match &part.index {
                Index::Research(index) => engine.research.tile(index, direction_class, traversal),
                Index::Bvh(index) => engine.bvh.tile(index, direction_class, traversal),
                Index::Moving(_) | Index::MovingUser(_) | Index::Blocks(_) => false,
            };
            if !has_kernel {
                traversal.one_by_one(|traversal| part.ray(engine, traversal));
            }
        }
    }

    /// Improves the nearest point.
    pub(crate) fn nearest(&self, engine: &Engine, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        let is_near = |part: &&Part| part.mask & probe.mask != 0 && part.times.local(0.0).is_some();
        for part in self.parts.iter().filter(is_near) {
            match &part.index {
                Index::Research(index) => index.nearest(probe, slot, nearest),
                Index::Bvh(index) => engine.bvh.point(index, probe, slot, nearest),
                Index::Moving(index) => engine.bvh.point(index.first(), probe, slot, nearest),
                Index::MovingUser(index) => engine.bvh.moving_user_point(index, probe, slot, nearest),
                Index::Blocks(index) => engine.bvh.blocks_point(index, probe, slot, nearest),
            }
        }
    }

    /// Its tree, where it has but one, over triangles that `mask` sees.
    #[inline(always)]
    pub(crate) fn only_tree(&self, mask: u32) -> Option<&BvhIndex> {
        match &self.parts[..] {
            [Part { index: Index::Bvh(index), mask: own, .. }] if own & mask != 0 => Some(index),
            _ => None,
        }
    }

    /// The corners of the triangle that was hit, where there is but one tree, which is of triangles.
    #[inline(always)]
    pub(crate) fn corners_met(&self, nearest: &Nearest) -> Option<[[f32; 3]; 3]> {
        match &self.parts[..] {
            [Part { index: Index::Bvh(index), .. }] => index.corners_of_place(nearest.place),
            _ => None,
        }
    }

    /// The first number of each geometry but the first, where they are few and none is of quads: then a hit's ids are found in
    /// lanes.
    pub(crate) fn few_starts(&self) -> Option<&[u32]> {
        match &self.numbering.starts[..] {
            [_, starts @ .., _] if starts.len() < FEW && !self.numbering.quads.contains(&true) => {
                Some(starts)
            }
            _ => None,
        }
    }

    /// Ids of a hit in this object.
    #[inline(always)]
    pub(crate) fn resolve(&self, nearest: &Nearest, inst_id: u32, leaf_id: u32) -> Hit {
        let Nearest { t, u, v, number, .. } = *nearest;
        let located = self.numbering.locate(number);
        // The second half of a quad has its vertices 2, 3 and 1.
        let (u, v) = if located.second_half { (1.0 - u, 1.0 - v) } else { (u, v) };
        Hit { t, u, v, prim_id: located.prim_id, geom_id: located.geom_id, inst_id, leaf_id }
    }
}

impl Part {
    /// Its geometry.
    fn group(&self) -> Group {
        let kind = match &self.index {
            Index::Research(_) | Index::Bvh(_) => Kind::Surfaces,
            Index::Moving(index) => Kind::Moving(index.keys()),
            Index::MovingUser(index) => Kind::MovingUser(index.keys()),
            Index::Blocks(index) => Kind::Blocks(index.sort()),
        };
        (kind, self.mask, self.times)
    }

    /// Improves the ray's result; the ray is valid and regular.
    #[inline(always)]
    fn ray(&self, engine: &Engine, traversal: &mut RayTraversal) {
        if self.times.differ() {
            self.ray_within(engine, traversal);
        } else {
            self.index.ray(engine, traversal);
        }
    }

    /// The same where keys are not those of the open shutter.
    #[cold]
    fn ray_within(&self, engine: &Engine, traversal: &mut RayTraversal) {
        if let Some(time) = self.times.local(traversal.ray.time) {
            let (ray, origin, slot) = (traversal.ray.with_time(time), traversal.origin, traversal.slot);
            self.index.ray(engine, &mut traversal.inside(&ray, origin, slot));
        }
    }
}

impl Index {
    fn bounds(&self) -> Aabb {
        each!(self, index => index.bounds())
    }

    fn stats(&self) -> TreeStats {
        each!(self, index => index.stats())
    }

    /// Improves the ray's result; the ray is valid and regular.
    #[inline(always)]
    fn ray(&self, engine: &Engine, traversal: &mut RayTraversal) {
        match self {
            Self::Research(index) => engine.research.ray(index, traversal),
            Self::Bvh(index) => engine.bvh.ray(index, traversal),
            Self::Moving(index) => engine.bvh.moving(index, traversal),
            Self::MovingUser(index) => engine.bvh.moving_user(index, traversal),
            Self::Blocks(index) => engine.bvh.blocks(index, traversal),
        }
    }
}
