// SPDX-License-Identifier: GPL-3.0-or-later
//! Questions about surfaces, one by one and for many at once: crossings, sides and signed distances, nearest points and
//! primitives, overlaps. See docs/reference/queries.md. Space: the tree's.
//! Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/inside.rs`, `tests/surfaces/overlaps.rs`.

use crate::crossings::{self, Crossed};
use crate::inside::{self, Side};
use crate::lists::{Lists, answer_each};
use crate::{AnyRay, Hit, ObjectTree, PointHit, PrimitiveId, Query, SceneTree, Threads};

macro_rules! queries {
    ($Tree:ident) => {
        /// Questions about surfaces. Results of many queries at once equal those of each, on any threads.
        impl $Tree {
            /// Number of crossings of a ray with surfaces: even for every closed mesh if the ray begins and
            /// ends outside of it.
            ///
            /// The count is that of a line infinitesimally beside the ray, on a side that depends on its
            /// direction alone. So a ray through an edge or a vertex crosses the surface there once, for any
            /// number of triangles, whether they share corners, only positions, or belong to several
            /// geometries. Coincident sheets are crossed one by one. A ray that touches a surface at an edge
            /// or a vertex crosses it there twice or not at all. One in the plane of a triangle does not
            /// cross that. One through the rim of an open mesh crosses it once or not at all, and of two
            /// meshes that meet at their rims exactly one. Ends of the ray belong to it. Decisions are exact,
            /// far away and through instances, too; only spheres and user geometry are as good as their
            /// arithmetic, and trees of [projected](crate::TriangleTest::Projected) triangles as the corners
            /// that they keep.
            #[must_use]
            pub fn crossings(&self, ray: &impl AnyRay) -> u32 {
                self.crossings_with(&Query::default(), ray)
            }

            /// The same with a chosen mask.
            #[must_use]
            pub fn crossings_with(&self, query: &Query, ray: &impl AnyRay) -> u32 {
                crossings::count(self.target(), query, ray, &mut Crossed::default())
            }

            /// Crossings of many rays; `counts` is resized to them.
            pub fn crossings_batch<R: AnyRay + Sync>(
                &self,
                query: &Query,
                rays: &[R],
                threads: Threads,
                counts: &mut Vec<u32>,
            ) {
                let count =
                    |crossed: &mut Crossed, ray: &R| crossings::count(self.target(), query, ray, crossed);
                answer_each(threads, rays, counts, Crossed::default, count);
            }

            /// The crossings of [`crossings`](Self::crossings), in the order along the ray: of triangles that
            /// meet at an edge or a corner there is one, where [`all_hits`](Self::all_hits) has all of them.
            /// `hits` is emptied first. Distances are worked out in double precision, then rounded.
            pub fn crossing_hits(&self, query: &Query, ray: &impl AnyRay, hits: &mut Vec<Hit>) {
                crossings::list(self.target(), query, ray, hits);
            }

            /// The side of a point with respect to closed meshes: inside if a ray from there crosses an odd
            /// number of an object's triangles, or if it is in a sphere. The decision has no rounding, so it
            /// is right at any distance from the surface; for meshes with holes, which have no inside, it
            /// means little.
            #[must_use]
            pub fn side(&self, point: [f64; 3]) -> Side {
                self.side_with(&Query::default(), point)
            }

            /// The same with a chosen mask.
            #[must_use]
            pub fn side_with(&self, query: &Query, point: [f64; 3]) -> Side {
                inside::side(self.target(), query.mask, point, &mut Crossed::default())
            }

            /// Sides of many points; `sides` is resized to them.
            pub fn side_batch(
                &self,
                query: &Query,
                points: &[[f64; 3]],
                threads: Threads,
                sides: &mut Vec<Side>,
            ) {
                let side = |crossed: &mut Crossed, point: &_| {
                    inside::side(self.target(), query.mask, *point, crossed)
                };
                answer_each(threads, points, sides, Crossed::default, side);
            }

            /// Whether a closed mesh contains a point: in it or exactly on its surface. See [`side`](Self::side).
            #[must_use]
            pub fn contains(&self, point: [f64; 3]) -> bool {
                self.side(point) != Side::Outside
            }

            /// The same for many points; `contained` is resized to them.
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

            /// 1 where a closed mesh contains the point, 0 elsewhere.
            #[must_use]
            pub fn occupancy(&self, point: [f64; 3]) -> f32 {
                f32::from(u8::from(self.contains(point)))
            }

            /// The same for many points; `occupied` is resized to them.
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

            /// The distance to the nearest surface, negative inside of closed meshes ([`side`](Self::side)), 0 on them;
            /// infinite where there is no surface, NaN for points that are no points.
            #[must_use]
            pub fn signed_distance(&self, point: [f64; 3]) -> f64 {
                self.signed_distance_with(&Query::default(), point)
            }

            /// The same with a chosen instruction set and mask.
            #[must_use]
            pub fn signed_distance_with(&self, query: &Query, point: [f64; 3]) -> f64 {
                self.target().signed_distance(query, point, &mut Crossed::default())
            }

            /// The same for many points; `distances` is resized to them.
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

            /// The nearest points of a surface to many points, each no farther than `radius`; `hits` is resized to them.
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

            /// The `n` nearest primitives, or all within `radius` where those are fewer, nearest first; of each the point that
            /// is nearest. Of several at the same distance the lowest ids come first. `hits` is emptied first.
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

            /// The same for many points, a list each.
            pub fn nearest_primitives_batch(
                &self,
                query: &Query,
                points: &[[f64; 3]],
                radius: f64,
                n: usize,
                threads: Threads,
                hits: &mut Lists<PointHit>,
            ) {
                let nearest =
                    |point: &_, hits: &mut _| self.nearest_primitives(query, *point, radius, n, hits);
                hits.answer_each(threads, points, nearest);
            }

            /// Calls `visit` for primitives no farther than `radius` from `point`, in any order, some of them
            /// several times, with the nearest point of each. It returns the new radius, which may only
            /// decrease; at the end every primitive within the last radius has been visited. User geometry is
            /// included if it [answers](crate::UserGeometry::closest_point).
            pub fn visit_near(
                &self,
                query: &Query,
                point: [f64; 3],
                radius: f64,
                mut visit: impl FnMut(&PointHit) -> f64,
            ) {
                self.target().visit_near(query, point, radius, &mut visit);
            }

            /// All primitives that touch a box, its sides included, in the order of their ids; `ids` is emptied first.
            ///
            /// Only surfaces count: a box inside of a sphere or a mesh touches nothing. Primitives that touch
            /// the box from outside, up to rounding, are included. User geometry is tested by its boxes, and
            /// so are spheres in rotated or scaled instances.
            pub fn touching_box(
                &self,
                query: &Query,
                min: [f64; 3],
                max: [f64; 3],
                ids: &mut Vec<PrimitiveId>,
            ) {
                self.target().touching_box(query, min, max, ids);
            }

            /// The same for many boxes, least and greatest coordinates, a list each.
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

            /// All primitives with a point no farther than `radius` from `center`, in the order of their ids; `ids` is
            /// emptied first. User geometry is seen as far as it answers
            /// [`closest_point`](crate::UserGeometry::closest_point).
            pub fn touching_sphere(
                &self,
                query: &Query,
                center: [f64; 3],
                radius: f64,
                ids: &mut Vec<PrimitiveId>,
            ) {
                self.target().touching_sphere(query, center, radius, ids);
            }

            /// The same for many balls, centres and radii, a list each.
            pub fn touching_sphere_batch(
                &self,
                query: &Query,
                balls: &[([f64; 3], f64)],
                threads: Threads,
                ids: &mut Lists<PrimitiveId>,
            ) {
                let touching = |ball: &([f64; 3], f64), ids: &mut _| {
                    self.touching_sphere(query, ball.0, ball.1, ids);
                };
                ids.answer_each(threads, balls, touching);
            }
        }
    };
}

queries!(ObjectTree);
queries!(SceneTree);
