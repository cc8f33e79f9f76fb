// SPDX-License-Identifier: GPL-3.0-or-later
//! The best hit so far, for closest-hit and any-hit queries, and which of two is the better one.
//! Invariant: of hits at the same `t` the one with the lowest instance, then the lowest primitive wins, so that the
//! answer does not depend on the order of visits. Only [`Nearest::offer`] and [`closer`] implement that.
//! Tests: `tests::{ties_go_to_the_lowest, lanes_choose_alike}`.

use gnurt_simd::{Simd, SimdFloat, prelude::*};

use crate::hit::INVALID_ID;
use crate::triangle::TriangleHit;

/// The kind of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The closest hit.
    Closest,
    /// Whether there is one: the first hit found ends the search, and `t` becomes negative infinity.
    Any,
}

/// The same for code compiled once for each.
pub trait Mode {
    /// Whether the first hit found ends the search.
    const ANY: bool;
}

/// The closest hit.
pub struct Closest;
/// Whether there is one.
pub struct AnyHit;

impl Mode for Closest {
    const ANY: bool = false;
}

impl Mode for AnyHit {
    const ANY: bool = true;
}

/// A hit by numbers, or how far the ray reaches while nothing was hit.
///
/// The order of the fields is such that nothing makes one load of two that were stored one by one: the CPU would wait for that until
/// they are in its cache.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Nearest {
    /// Ends the search beyond it; negative infinity after any hit was found.
    pub t: f32,
    /// Primitive in its object, [`INVALID_ID`] for none.
    pub number: u32,
    pub u: f32,
    /// The object's index among all objects of the scene.
    pub slot: u32,
    pub v: f32,
    /// The triangle's leaf block times eight, and its lane, where the search tells; else [`NOWHERE`].
    pub place: u32,
}

/// No place.
pub const NOWHERE: u32 = u32::MAX;

impl Nearest {
    #[inline(always)]
    pub fn none(t_far: f32) -> Self {
        Self { t: t_far, u: 0.0, v: 0.0, number: INVALID_ID, slot: INVALID_ID, place: NOWHERE }
    }

    #[inline(always)]
    pub fn is_hit(&self) -> bool {
        self.number != INVALID_ID
    }

    /// Takes a hit at `t <= self.t` if it is better.
    #[inline(always)]
    pub fn offer<M: Mode>(&mut self, triangle_hit: TriangleHit, number: u32, slot: u32) {
        self.offer_at::<M>(triangle_hit, number, slot, NOWHERE);
    }

    /// The same of a triangle in a leaf block.
    #[inline(always)]
    pub fn offer_at<M: Mode>(&mut self, triangle_hit: TriangleHit, number: u32, slot: u32, place: u32) {
        let TriangleHit { t, u, v } = triangle_hit;
        if M::ANY {
            *self = Self { t: f32::NEG_INFINITY, u, v, number, slot, place };
        } else if t < self.t || (t == self.t && (slot, number) < (self.slot, self.number)) {
            *self = Self { t, u, v, number, slot, place };
        }
    }
}

/// In lanes: whether a hit at `t` on `number` of `slot` is to be preferred to the old one.
#[inline(always)]
pub fn closer<S: Simd, F, U>(
    [t, old_t]: [F; 2],
    [slot, old_slot]: [U; 2],
    [number, old_number]: [U; 2],
) -> F::Mask
where
    F: SimdFloat<S, Element = f32>,
    U: SimdInt<S, Element = u32, Mask = F::Mask>,
{
    let lower = slot.simd_lt(old_slot) | (slot.simd_eq(old_slot) & number.simd_lt(old_number));
    t.simd_lt(old_t) | (t.simd_eq(old_t) & lower)
}

#[cfg(test)]
mod tests {
    use gnurt_simd::{Level, dispatch, f32x8, prelude::*, u32x8};

    use super::*;

    #[test]
    fn lanes_choose_alike() {
        let hits =
            [(1.0, 1, 5), (1.0, 1, 4), (1.0, 0, 9), (2.0, 0, 0), (f32::INFINITY, INVALID_ID, INVALID_ID)];
        for (t, slot, number) in hits {
            for (old_t, old_slot, old_number) in hits {
                let mut best = Nearest { number: old_number, slot: old_slot, ..Nearest::none(old_t) };
                best.offer::<Closest>(TriangleHit { t, u: 0.0, v: 0.0 }, number, slot);
                let taken = (best.t, best.slot, best.number) != (old_t, old_slot, old_number);
                for level in Level::available() {
                    let lanes = dispatch!(level, simd => closer(
                        [f32x8::splat(simd, t), f32x8::splat(simd, old_t)],
                        [u32x8::splat(simd, slot), u32x8::splat(simd, old_slot)],
                        [u32x8::splat(simd, number), u32x8::splat(simd, old_number)],
                    ).any_true());
                    assert_eq!(
                        lanes, taken,
                        "{t} {slot} {number} after {old_t} {old_slot} {old_number} at {level}"
                    );
                }
            }
        }
    }

    #[test]
    fn ties_go_to_the_lowest() {
        let offers = [(2.0, 5, 1), (1.0, 7, 1), (1.0, 3, 1), (1.0, 9, 0), (1.5, 0, 0)];
        let mut forwards = Nearest::none(f32::INFINITY);
        let mut backwards = forwards;
        let offer = |best: &mut Nearest, (t, number, slot): (f32, u32, u32)| {
            if t <= best.t {
                best.offer::<Closest>(TriangleHit { t, u: 0.0, v: 0.0 }, number, slot);
            }
        };
        offers.iter().for_each(|&o| offer(&mut forwards, o));
        offers.iter().rev().for_each(|&o| offer(&mut backwards, o));
        assert_eq!(forwards, backwards, "the order does not matter");
        assert_eq!((forwards.slot, forwards.number), (0, 9), "lowest instance first");
    }
}
