// SPDX-License-Identifier: GPL-3.0-or-later
//! Traversal states: rays on their way through trees, and their best hits so far. One value goes from a query
//! through scenes and objects to the kernels; each level passes it on, or one made from it for an inner
//! space.
//! Space: that of the current tree.
//! Invariant: a state's `nearest` limits the distance of further hits, for any kind of query.
//! Tests: `tests::{scaled_rays_find_unscaled_hits, one_by_one_is_each}`, `tests/brute_force.rs` of `gnurt-accel`.

use gnurt_simd::Simd;

use crate::bits::each;
use crate::collect::Collect;
use crate::nearest::{AnyHit, Closest, Kind, NOWHERE, Nearest};
use crate::query::Counters;
use crate::ray::Ray;
use crate::tile::{NearestTile, RayTile};
use crate::triangle::TriangleHit;

/// The kind of one ray's query.
pub enum RayKind<'a> {
    /// The closest hit.
    Closest,
    /// Whether there is one.
    Any,
    /// All hits, in any order; the callback returns the remaining extent of the ray, and negative infinity
    /// ends it.
    Each(&'a mut dyn FnMut(&Nearest) -> f32),
}

/// The state of one ray.
pub struct RayTraversal<'a> {
    /// The ray, in the space of the tree that is entered.
    pub ray: &'a Ray,
    /// Its origin in double precision, where that is known.
    pub origin: Option<&'a [f64; 3]>,
    pub kind: RayKind<'a>,
    /// The index of the tree's object among all objects of the scene.
    pub slot: u32,
    /// The best hit so far; hits beyond its `t` do not count.
    pub nearest: &'a mut Nearest,
    pub counters: &'a mut Counters,
}

/// The state of up to 64 rays.
pub struct TileTraversal<'a> {
    /// The rays, in the space of the tree that is entered.
    pub rays: &'a RayTile,
    /// The unfinished ones, as bits.
    pub active: u64,
    pub kind: Kind,
    /// The index of the tree's object, or of the first object of the scene, among all objects.
    pub slot: u32,
    /// Their best hits so far.
    pub nearest: &'a mut NearestTile,
    pub counters: &'a mut Counters,
}

impl RayKind<'_> {
    /// The same, for a part of the traversal.
    #[inline(always)]
    pub fn again(&mut self) -> RayKind<'_> {
        match self {
            Self::Closest => RayKind::Closest,
            Self::Any => RayKind::Any,
            Self::Each(judge) => RayKind::Each(&mut **judge),
        }
    }
}

impl From<Kind> for RayKind<'_> {
    #[inline(always)]
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Closest => Self::Closest,
            Kind::Any => Self::Any,
        }
    }
}

impl RayTraversal<'_> {
    /// The state inside of an instance, where the ray is `ray`.
    #[inline(always)]
    pub fn inside<'b>(
        &'b mut self,
        ray: &'b Ray,
        origin: Option<&'b [f64; 3]>,
        slot: u32,
    ) -> RayTraversal<'b> {
        let kind = self.kind.again();
        RayTraversal { ray, origin, kind, slot, nearest: &mut *self.nearest, counters: &mut *self.counters }
    }

    /// Nothing beyond it is of interest.
    #[inline(always)]
    pub fn reach(&self) -> f32 {
        self.nearest.t
    }

    /// Whether the query is finished.
    #[inline(always)]
    pub fn is_over(&self) -> bool {
        !matches!(self.kind, RayKind::Closest) && self.nearest.t == f32::NEG_INFINITY
    }

    /// Runs a search whose parameters have to be multiplied with `scale`, a power of two, to be those of the ray.
    pub fn scaled(&mut self, ray: &Ray, scale: f64, search: impl FnOnce(&mut RayTraversal)) {
        let down = |t: f32| (f64::from(t) / scale) as f32;
        let up = |t: f32| (f64::from(t) * scale) as f32;
        let before = *self.nearest;
        let mut nearest = Nearest { t: down(before.t), ..before };
        let mut shown;
        let kind = match &mut self.kind {
            RayKind::Closest => RayKind::Closest,
            RayKind::Any => RayKind::Any,
            RayKind::Each(judge) => {
                shown = |found: &Nearest| down(judge(&Nearest { t: up(found.t), ..*found }));
                RayKind::Each(&mut shown)
            }
        };
        let (slot, counters) = (self.slot, &mut *self.counters);
        search(&mut RayTraversal { ray, origin: None, kind, slot, nearest: &mut nearest, counters });
        if let RayKind::Each(_) = self.kind {
            self.nearest.t = up(nearest.t);
        } else if (nearest.slot, nearest.number) != (before.slot, before.number) {
            // An unimproved hit keeps its bits, even if the scaled parameter left the range of floats.
            *self.nearest = Nearest { t: up(nearest.t), ..nearest };
        }
    }
}

/// For searches that are compiled once for all kinds: their offers go through one function.
impl Collect for RayTraversal<'_> {
    const ANY: bool = false;
    const CAN_END: bool = true;

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.nearest.t
    }

    #[inline(always)]
    fn needs_position(&self) -> bool {
        !matches!(self.kind, RayKind::Any)
    }

    #[cold]
    #[inline(never)]
    fn offer(&mut self, triangle_hit: TriangleHit, number: u32, slot: u32) {
        match &mut self.kind {
            RayKind::Closest => self.nearest.offer::<Closest>(triangle_hit, number, slot),
            RayKind::Any => self.nearest.offer::<AnyHit>(triangle_hit, number, slot),
            RayKind::Each(judge) => {
                let TriangleHit { t, u, v } = triangle_hit;
                self.nearest.t = judge(&Nearest { t, u, v, number, slot, place: NOWHERE });
            }
        }
    }
}

impl TileTraversal<'_> {
    /// The state of those rays that are in `active`.
    #[inline(always)]
    pub fn only(&mut self, active: u64) -> TileTraversal<'_> {
        let Self { rays, kind, slot, .. } = *self;
        TileTraversal { rays, active, kind, slot, nearest: &mut *self.nearest, counters: &mut *self.counters }
    }

    /// The state inside of an instance, where the rays are `rays`.
    #[inline(always)]
    pub fn inside<'b>(&'b mut self, rays: &'b RayTile, active: u64, slot: u32) -> TileTraversal<'b> {
        let kind = self.kind;
        TileTraversal { rays, active, kind, slot, nearest: &mut *self.nearest, counters: &mut *self.counters }
    }

    /// The state of copied rays, with hits of their own.
    #[inline(always)]
    pub fn of_copies<'b>(
        &'b mut self,
        rays: &'b RayTile,
        active: u64,
        nearest: &'b mut NearestTile,
    ) -> TileTraversal<'b> {
        let Self { kind, slot, .. } = *self;
        TileTraversal { rays, active, kind, slot, nearest, counters: &mut *self.counters }
    }

    /// [`one_by_one`](Self::one_by_one) for rays that have too little in common. A separate function, so that
    /// the search is compiled once more outside of the tile's traversal instead of into it.
    #[cold]
    #[inline(never)]
    pub fn one_by_one_outlined<S: Simd>(&mut self, simd: S, search: impl FnMut(&mut RayTraversal)) {
        simd.vectorize(
            #[inline(always)]
            || self.one_by_one(search),
        );
    }

    /// Each active and unfinished ray, one after the other.
    #[inline(always)]
    pub fn one_by_one(&mut self, mut search: impl FnMut(&mut RayTraversal)) {
        each(
            self.active,
            #[inline(always)]
            |i| {
                let mut nearest = self.nearest.get(i);
                if nearest.t > f32::NEG_INFINITY {
                    search(&mut RayTraversal {
                        ray: &self.rays.ray(i, nearest.t),
                        origin: None,
                        kind: self.kind.into(),
                        slot: self.slot,
                        nearest: &mut nearest,
                        counters: &mut *self.counters,
                    });
                    self.nearest.set(i, &nearest);
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hit::INVALID_ID;

    const MET: TriangleHit = TriangleHit { t: 2.0, u: 0.25, v: 0.5 };

    /// The result of a query of some kind if the search offers [`MET`], in parameters scaled by four.
    fn scaled(mut kind: RayKind, t_far: f32, offered: bool) -> Nearest {
        let (mut nearest, mut counters) = (Nearest::none(t_far), Counters::default());
        let ray = Ray::new([0.0; 3], [1.0; 3]);
        let mut traversal = RayTraversal {
            ray: &ray,
            origin: None,
            kind: kind.again(),
            slot: 3,
            nearest: &mut nearest,
            counters: &mut counters,
        };
        traversal.scaled(&ray, 4.0, |traversal| {
            if offered {
                traversal.offer(MET, 7, traversal.slot);
            }
        });
        nearest
    }

    #[test]
    fn scaled_rays_find_unscaled_hits() {
        let found = Nearest { u: 0.25, v: 0.5, number: 7, slot: 3, ..Nearest::none(8.0) };
        assert_eq!(scaled(RayKind::Closest, 9.0, true), found, "at four times the parameter");
        assert_eq!(scaled(RayKind::Any, 9.0, true).t, f32::NEG_INFINITY, "nothing more is wanted");
        let mut shown = Vec::new();
        let mut judge = |hit: &Nearest| {
            shown.push(*hit);
            6.0
        };
        assert_eq!(scaled(RayKind::Each(&mut judge), 9.0, true).t, 6.0, "the answer's reach");
        assert_eq!(shown, [found], "shown as it is");
        let far = f32::from_bits(0x0000_0003);
        assert_eq!(
            scaled(RayKind::Closest, far, false),
            Nearest::none(far),
            "what was not improved keeps its bits"
        );
    }

    #[test]
    fn one_by_one_is_each() {
        let (rays, mut nearest, mut counters) = (RayTile::EMPTY, NearestTile::EMPTY, Counters::default());
        nearest.t[5] = f32::NEG_INFINITY;
        let (kind, active) = (Kind::Any, 0b10_0110);
        let counters = &mut counters;
        let mut traversal =
            TileTraversal { rays: &rays, active, kind, slot: 1, nearest: &mut nearest, counters };
        traversal.one_by_one(|traversal| traversal.offer(MET, 7, traversal.slot));
        let hit: Vec<usize> = (0..64).filter(|&i| nearest.number[i] != INVALID_ID).collect();
        assert_eq!(hit, [1, 2], "those that are active and still look");
    }
}
