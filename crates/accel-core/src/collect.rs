// SPDX-License-Identifier: GPL-3.0-or-later
//! Collectors of a ray's hits.
//! Tests: `traversal::tests`, `tests/brute_force.rs` of `gnurt-accel`.

use std::marker::PhantomData;

use crate::nearest::{AnyHit, Closest, Kind, Mode, Nearest};
use crate::triangle::TriangleHit;

/// The collector of a single ray's hits. Frequent searches are compiled once for each: [`Best`] of either
/// mode; a [`RayTraversal`](crate::traversal::RayTraversal) is one for everything.
pub trait Collect {
    /// Whether the first offer ends the search, so that its order does not matter.
    const ANY: bool;
    /// Whether an offer can end the search.
    const CAN_END: bool;
    /// Nothing beyond it is of interest; negative infinity ends the search.
    fn reach(&self) -> f32;
    /// Takes a hit at `t <= reach()`, in `[t_near, t_far]` of the ray.
    fn offer(&mut self, hit: TriangleHit, number: u32, slot: u32);

    /// The same of a triangle in a leaf block: see [`Nearest::place`].
    #[inline(always)]
    fn offer_at(&mut self, hit: TriangleHit, number: u32, slot: u32, _place: u32) {
        self.offer(hit, number, slot);
    }

    /// Whether the position of the hit matters, not only its existence.
    fn needs_position(&self) -> bool;

    /// Whether the query is finished.
    #[inline(always)]
    fn is_done(&self) -> bool {
        Self::CAN_END && self.reach() == f32::NEG_INFINITY
    }
}

/// The best hit so far, or any, updated in place: the CPU would wait for a copy of a value that was written
/// in parts.
pub struct Best<'a, M: Mode>(pub &'a mut Nearest, PhantomData<M>);

impl<'a, M: Mode> Best<'a, M> {
    #[inline(always)]
    pub fn new(nearest: &'a mut Nearest) -> Self {
        Self(nearest, PhantomData)
    }
}

impl<M: Mode> Collect for Best<'_, M> {
    const ANY: bool = M::ANY;
    const CAN_END: bool = M::ANY;

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.0.t
    }

    #[inline(always)]
    fn needs_position(&self) -> bool {
        !M::ANY
    }

    #[inline(always)]
    fn offer(&mut self, hit: TriangleHit, number: u32, slot: u32) {
        self.0.offer::<M>(hit, number, slot);
    }

    #[inline(always)]
    fn offer_at(&mut self, hit: TriangleHit, number: u32, slot: u32, place: u32) {
        self.0.offer_at::<M>(hit, number, slot, place);
    }
}

/// The best hit so far of one kind or the other, for searches that are compiled once for both.
pub struct BestOf {
    pub nearest: Nearest,
    pub kind: Kind,
}

impl Collect for BestOf {
    const ANY: bool = false;
    const CAN_END: bool = true;

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.nearest.t
    }

    #[inline(always)]
    fn needs_position(&self) -> bool {
        self.kind == Kind::Closest
    }

    #[inline(always)]
    fn offer(&mut self, hit: TriangleHit, number: u32, slot: u32) {
        match self.kind {
            Kind::Closest => self.nearest.offer::<Closest>(hit, number, slot),
            Kind::Any => self.nearest.offer::<AnyHit>(hit, number, slot),
        }
    }
}
