// SPDX-License-Identifier: GPL-3.0-or-later
//! Common answers of objects and scenes: the bodies of their methods (`queries/`).
//! Tests: `tests/brute_force.rs`, `tests/all_hits.rs`, `tests/filters.rs`, `tests/masks.rs`.

use gnurt_accel_bvh::BvhIndex;
use gnurt_accel_core::nearest::Nearest;
use gnurt_accel_core::point::{ClosestPoint, NearestPoint, Probe};
use gnurt_accel_core::traversal::{RayKind, RayTraversal};

use crate::candidates::{Sorted, is_better};
use crate::engine::Engine;
use crate::target::Target;
use crate::{AnyRay, Counters, Hit, ObjectTree, PointHit, Query, Ray};

/// A single ray of a query.
#[derive(Clone, Copy)]
pub(crate) struct One<'a> {
    query: &'a Query,
    ray: &'a Ray,
    /// The ray's origin in double precision, where that is known.
    origin: Option<&'a [f64; 3]>,
}

/// A hit, and the corners of its triangle where they are known.
type HitWithCorners = (Hit, Option<[[f32; 3]; 3]>);

impl One<'_> {
    /// The closest hit in the only tree of an object; `None` if it has to be asked by the long way.
    #[inline(always)]
    fn straight_closest(self, tree: &BvhIndex) -> Option<Nearest> {
        let mut nearest = Nearest::none(self.ray.t_far);
        Engine::at(self.query.level).bvh.closest(tree, self.ray, &mut nearest).then_some(nearest)
    }

    /// Whether there is a hit; see [`straight_closest`](Self::straight_closest).
    #[inline(always)]
    fn straight_any(self, tree: &BvhIndex) -> Option<bool> {
        let mut nearest = Nearest::none(self.ray.t_far);
        Engine::at(self.query.level).bvh.any(tree, self.ray, &mut nearest).then(|| nearest.is_hit())
    }
}

impl<'a> Target<'a> {
    /// Improves the result. Inlined into its three callers, each of which has a constant kind: single rays
    /// are short.
    #[inline(always)]
    fn trace(self, One { query, ray, origin }: One, mut kind: RayKind, nearest: &mut Nearest) {
        // Copied only if necessary: a value that was just stored in parts cannot be loaded in lanes for a
        // while.
        let (masked, mask) = (&mut None, ray.mask & query.mask);
        let ray = match mask == ray.mask {
            true => ray,
            false => masked.insert(Ray { mask, ..*ray }),
        };
        if ray.is_sound() {
            let counters = &mut Counters::default();
            let traversal = &mut RayTraversal { ray, origin, kind: kind.again(), slot: 0, nearest, counters };
            self.ray(Engine::at(query.level), traversal);
        }
    }

    /// The tree that a ray can enter directly, as most single rays do, and its object: the target has no other.
    #[inline(always)]
    fn only_tree(self, One { query, ray, .. }: One) -> Option<(&'a ObjectTree, &'a BvhIndex)> {
        match self {
            Self::Object(object) => Some((object, object.only_tree(ray.mask & query.mask)?)),
            Self::Scene(_) => None,
        }
    }

    #[inline(never)]
    fn closest_of(self, one: One) -> Option<Hit> {
        let mut nearest = Nearest::none(one.ray.t_far);
        self.trace(one, RayKind::Closest, &mut nearest);
        if !nearest.is_hit() {
            return None;
        }
        // Each goes directly into the answer: the CPU would wait for a copy of a value that was written in
        // parts.
        match self {
            Self::Object(object) => Some(object.resolve(&nearest, 0, 0)),
            Self::Scene(scene) => Some(scene.resolve(&nearest)),
        }
    }

    /// The same with the corners of the triangle, where its object has but one tree, which is of triangles.
    #[inline(never)]
    fn closest_with_corners_of(self, one: One) -> Option<HitWithCorners> {
        let mut nearest = Nearest::none(one.ray.t_far);
        self.trace(one, RayKind::Closest, &mut nearest);
        if !nearest.is_hit() {
            return None;
        }
        Some(match self {
            Self::Object(object) => (object.resolve(&nearest, 0, 0), object.corners_met(&nearest)),
            Self::Scene(scene) => (scene.resolve(&nearest), scene.corners_met(&nearest)),
        })
    }

    #[inline(never)]
    fn any_of(self, one: One) -> bool {
        let mut nearest = Nearest::none(one.ray.t_far);
        self.trace(one, RayKind::Any, &mut nearest);
        nearest.is_hit()
    }

    /// Shows all hits to `judge`, in any order; it answers with how far the ray is still of interest.
    fn candidates(self, one: One, judge: &mut dyn FnMut(Hit) -> f32) {
        let mut nearest = Nearest::none(one.ray.t_far);
        self.trace(one, RayKind::Each(&mut |found| judge(self.hit(found))), &mut nearest);
    }

    /// The closest hit; inlined as [`closest_directly`](Self::closest_directly) is.
    #[inline(always)]
    pub(crate) fn closest(self, query: &Query, ray: &impl AnyRay) -> Option<Hit> {
        let (rounded, origin) = (ray.rounded(), ray.origin64());
        let one = One { query, ray: &rounded, origin: origin.as_ref() };
        if let Some((object, tree)) = self.only_tree(one)
            && let Some(nearest) = one.straight_closest(tree)
        {
            return nearest.is_hit().then(|| object.resolve(&nearest, 0, 0));
        }
        self.closest_of(one)
    }

    /// The same with the corners of the triangle.
    #[inline]
    pub(crate) fn closest_with_corners(self, query: &Query, ray: &impl AnyRay) -> Option<HitWithCorners> {
        self.closest_with_corners_of(One { query, ray: &ray.rounded(), origin: ray.origin64().as_ref() })
    }

    /// The same if the ray can enter an only tree directly; else `None`. Inlined into the caller: there a call more is a tenth of
    /// the time of a ray that misses. Apart from other ways, with which its result would go through memory.
    #[inline(always)]
    pub(crate) fn closest_directly(self, query: &Query, ray: &impl AnyRay) -> Option<Option<HitWithCorners>> {
        let (rounded, origin) = (ray.rounded(), ray.origin64());
        let one = One { query, ray: &rounded, origin: origin.as_ref() };
        let (object, tree) = self.only_tree(one)?;
        let nearest = one.straight_closest(tree)?;
        let corners = || tree.corners_of_place(nearest.place);
        Some(nearest.is_hit().then(|| (object.resolve(&nearest, 0, 0), corners())))
    }

    /// Whether there is a hit; inlined as [`closest_directly`](Self::closest_directly) is.
    #[inline(always)]
    pub(crate) fn any(self, query: &Query, ray: &impl AnyRay) -> bool {
        let (rounded, origin) = (ray.rounded(), ray.origin64());
        let one = One { query, ray: &rounded, origin: origin.as_ref() };
        match self.only_tree(one).and_then(|(_, tree)| one.straight_any(tree)) {
            Some(is_hit) => is_hit,
            None => self.any_of(one),
        }
    }

    /// The closest hit that `accept` lets pass.
    pub(crate) fn closest_filtered(
        self,
        query: &Query,
        ray: &impl AnyRay,
        mut accept: impl FnMut(&Ray, &Hit) -> bool,
    ) -> Option<Hit> {
        let (narrowed, origin) = (ray.rounded(), ray.origin64());
        let mut best: Option<Hit> = None;
        self.candidates(One { query, ray: &narrowed, origin: origin.as_ref() }, &mut |hit| {
            if is_better(&hit, best.as_ref()) && accept(&narrowed, &hit) {
                best = Some(hit);
            }
            best.map_or(narrowed.t_far, |best| best.t)
        });
        best
    }

    /// Whether there is a hit that `accept` lets pass.
    pub(crate) fn any_filtered(
        self,
        query: &Query,
        ray: &impl AnyRay,
        mut accept: impl FnMut(&Ray, &Hit) -> bool,
    ) -> bool {
        let (narrowed, origin) = (ray.rounded(), ray.origin64());
        let mut found = false;
        self.candidates(One { query, ray: &narrowed, origin: origin.as_ref() }, &mut |hit| {
            found = found || accept(&narrowed, &hit);
            if found { f32::NEG_INFINITY } else { narrowed.t_far }
        });
        found
    }

    /// The first `n` hits in order.
    pub(crate) fn first_hits(self, query: &Query, ray: &impl AnyRay, n: usize, hits: &mut Vec<Hit>) {
        let (narrowed, origin) = (ray.rounded(), ray.origin64());
        let mut sorted = Sorted::new(hits, n, narrowed.t_far);
        if n > 0 {
            let one = One { query, ray: &narrowed, origin: origin.as_ref() };
            self.candidates(one, &mut |hit| sorted.take(hit));
            sorted.finish();
        }
    }

    /// The nearest point of a surface.
    pub(crate) fn closest_point(self, query: &Query, point: [f64; 3], radius: f64) -> Option<PointHit> {
        let mut nearest = ClosestPoint::within(radius);
        self.near(query, point, &mut nearest);
        nearest.hit(point, |nearest| self.hit(nearest))
    }

    /// Offers points of primitives near `point`, the nearest of each; none near NaN.
    pub(crate) fn near(self, query: &Query, point: [f64; 3], nearest: &mut dyn NearestPoint) {
        if point.iter().all(|x| x.is_finite()) && !nearest.distance().is_nan() {
            self.point(Engine::at(query.level), &Probe::new(point, query.mask), nearest);
        }
    }
}
