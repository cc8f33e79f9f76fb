// SPDX-License-Identifier: GPL-3.0-or-later
//! What a scene can be asked about surfaces, one by one and for many at once: crossings, sides and signed distances, nearest points and
//! primitives, overlaps. Source: original; docs/queries.md. Space: world.
//! Proof: `tests/surfaces/crossings.rs`, `tests/surfaces/inside.rs`, `tests/surfaces/overlaps.rs`.

use super::types::SceneTree;
use crate::crossings::{self, Crossed};
use crate::inside::{self, Side};
use crate::lists::{Lists, answer_each};
use crate::{AnyRay, Hit, PointHit, PrimitiveId, Query, Threads};

/// Questions about surfaces. Answers to many at once are those to each, whatever threads there are.
impl SceneTree {
    /// See [`ObjectTree::crossings`](crate::ObjectTree::crossings).
    #[must_use]
    pub fn crossings(&self, ray: &impl AnyRay) -> u32 {
        self.crossings_with(&Query::default(), ray)
    }

    /// See [`ObjectTree::crossings_with`](crate::ObjectTree::crossings_with).
    #[must_use]
    pub fn crossings_with(&self, query: &Query, ray: &impl AnyRay) -> u32 {
        crossings::count(self.target(), query, ray, &mut Crossed::default())
    }

    /// See [`ObjectTree::crossings_batch`](crate::ObjectTree::crossings_batch).
    pub fn crossings_batch<R: AnyRay + Sync>(
        &self,
        query: &Query,
        rays: &[R],
        threads: Threads,
        counts: &mut Vec<u32>,
    ) {
        let count = |crossed: &mut Crossed, ray: &R| crossings::count(self.target(), query, ray, crossed);
        answer_each(threads, rays, counts, Crossed::default, count);
    }

    /// See [`ObjectTree::crossing_hits`](crate::ObjectTree::crossing_hits).
    pub fn crossing_hits(&self, query: &Query, ray: &impl AnyRay, hits: &mut Vec<Hit>) {
        crossings::list(self.target(), query, ray, hits);
    }

    /// See [`ObjectTree::side`](crate::ObjectTree::side).
    #[must_use]
    pub fn side(&self, point: [f64; 3]) -> Side {
        self.side_with(&Query::default(), point)
    }

    /// See [`ObjectTree::side_with`](crate::ObjectTree::side_with).
    #[must_use]
    pub fn side_with(&self, query: &Query, point: [f64; 3]) -> Side {
        inside::side(self.target(), query.mask, point, &mut Crossed::default())
    }

    /// See [`ObjectTree::side_batch`](crate::ObjectTree::side_batch).
    pub fn side_batch(&self, query: &Query, points: &[[f64; 3]], threads: Threads, sides: &mut Vec<Side>) {
        let side =
            |crossed: &mut Crossed, point: &_| inside::side(self.target(), query.mask, *point, crossed);
        answer_each(threads, points, sides, Crossed::default, side);
    }

    /// See [`ObjectTree::contains`](crate::ObjectTree::contains).
    #[must_use]
    pub fn contains(&self, point: [f64; 3]) -> bool {
        self.side(point) != Side::Outside
    }

    /// See [`ObjectTree::contains_batch`](crate::ObjectTree::contains_batch).
    pub fn contains_batch(
        &self,
        query: &Query,
        points: &[[f64; 3]],
        threads: Threads,
        contained: &mut Vec<bool>,
    ) {
        let contains = |crossed: &mut Crossed, point: &_| {
            inside::side(self.target(), query.mask, *point, crossed) != Side::Outside
        };
        answer_each(threads, points, contained, Crossed::default, contains);
    }

    /// See [`ObjectTree::occupancy`](crate::ObjectTree::occupancy).
    #[must_use]
    pub fn occupancy(&self, point: [f64; 3]) -> f32 {
        f32::from(u8::from(self.contains(point)))
    }

    /// See [`ObjectTree::occupancy_batch`](crate::ObjectTree::occupancy_batch).
    pub fn occupancy_batch(
        &self,
        query: &Query,
        points: &[[f64; 3]],
        threads: Threads,
        occupied: &mut Vec<f32>,
    ) {
        let occupancy = |crossed: &mut Crossed, point: &_| {
            let side = inside::side(self.target(), query.mask, *point, crossed);
            f32::from(u8::from(side != Side::Outside))
        };
        answer_each(threads, points, occupied, Crossed::default, occupancy);
    }

    /// See [`ObjectTree::signed_distance`](crate::ObjectTree::signed_distance).
    #[must_use]
    pub fn signed_distance(&self, point: [f64; 3]) -> f64 {
        self.signed_distance_with(&Query::default(), point)
    }

    /// See [`ObjectTree::signed_distance_with`](crate::ObjectTree::signed_distance_with).
    #[must_use]
    pub fn signed_distance_with(&self, query: &Query, point: [f64; 3]) -> f64 {
        self.target().signed_distance(query, point, &mut Crossed::default())
    }

    /// See [`ObjectTree::signed_distance_batch`](crate::ObjectTree::signed_distance_batch).
    pub fn signed_distance_batch(
        &self,
        query: &Query,
        points: &[[f64; 3]],
        threads: Threads,
        distances: &mut Vec<f64>,
    ) {
        let distance =
            |crossed: &mut Crossed, point: &_| self.target().signed_distance(query, *point, crossed);
        answer_each(threads, points, distances, Crossed::default, distance);
    }

    /// See [`ObjectTree::closest_points`](crate::ObjectTree::closest_points).
    pub fn closest_points(
        &self,
        query: &Query,
        points: &[[f64; 3]],
        radius: f64,
        threads: Threads,
        hits: &mut Vec<Option<PointHit>>,
    ) {
        let nearest = |_: &mut (), point: &_| self.target().closest_point(query, *point, radius);
        answer_each(threads, points, hits, || (), nearest);
    }

    /// See [`ObjectTree::nearest_primitives`](crate::ObjectTree::nearest_primitives).
    pub fn nearest_primitives(
        &self,
        query: &Query,
        point: [f64; 3],
        radius: f64,
        n: usize,
        hits: &mut Vec<PointHit>,
    ) {
        self.target().nearest_primitives(query, point, radius, n, hits);
    }

    /// See [`ObjectTree::nearest_primitives_batch`](crate::ObjectTree::nearest_primitives_batch).
    pub fn nearest_primitives_batch(
        &self,
        query: &Query,
        points: &[[f64; 3]],
        radius: f64,
        n: usize,
        threads: Threads,
        hits: &mut Lists<PointHit>,
    ) {
        let nearest = |point: &_, hits: &mut _| self.nearest_primitives(query, *point, radius, n, hits);
        hits.answer_each(threads, points, nearest);
    }

    /// See [`ObjectTree::visit_near`](crate::ObjectTree::visit_near).
    pub fn visit_near(
        &self,
        query: &Query,
        point: [f64; 3],
        radius: f64,
        mut visit: impl FnMut(&PointHit) -> f64,
    ) {
        self.target().visit_near(query, point, radius, &mut visit);
    }

    /// See [`ObjectTree::touching_box`](crate::ObjectTree::touching_box).
    pub fn touching_box(&self, query: &Query, min: [f64; 3], max: [f64; 3], ids: &mut Vec<PrimitiveId>) {
        self.target().touching_box(query, min, max, ids);
    }

    /// See [`ObjectTree::touching_box_batch`](crate::ObjectTree::touching_box_batch).
    pub fn touching_box_batch(
        &self,
        query: &Query,
        boxes: &[[[f64; 3]; 2]],
        threads: Threads,
        ids: &mut Lists<PrimitiveId>,
    ) {
        let touching = |[min, max]: &[[f64; 3]; 2], ids: &mut _| {
            self.touching_box(query, *min, *max, ids);
        };
        ids.answer_each(threads, boxes, touching);
    }

    /// See [`ObjectTree::touching_ball`](crate::ObjectTree::touching_ball).
    pub fn touching_ball(&self, query: &Query, center: [f64; 3], radius: f64, ids: &mut Vec<PrimitiveId>) {
        self.target().touching_ball(query, center, radius, ids);
    }

    /// See [`ObjectTree::touching_ball_batch`](crate::ObjectTree::touching_ball_batch).
    pub fn touching_ball_batch(
        &self,
        query: &Query,
        balls: &[([f64; 3], f64)],
        threads: Threads,
        ids: &mut Lists<PrimitiveId>,
    ) {
        let touching = |ball: &([f64; 3], f64), ids: &mut _| {
            self.touching_ball(query, ball.0, ball.1, ids);
        };
        ids.answer_each(threads, balls, touching);
    }
}
