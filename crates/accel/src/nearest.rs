// SPDX-License-Identifier: GPL-3.0-or-later
//! What a ray that is being traced collects, and the best hit so far for closest-hit and any-hit queries.
//! Source: original.
//! Invariant: of hits at the same `t` the one with the lowest instance, then the lowest primitive wins, so that the
//! answer does not depend on the order of visits. Proof: `tests::ties_go_to_the_lowest`.

use std::marker::PhantomData;

use crate::INVALID_ID;
use crate::triangle::Meeting;

/// What a query wants.
pub(crate) trait Mode {
    /// Whether the first hit found ends the search.
    const ANY: bool;
}

/// The closest hit.
pub(crate) struct Closest;
/// Whether there is one.
pub(crate) struct AnyHit;

impl Mode for Closest {
    const ANY: bool = false;
}

impl Mode for AnyHit {
    const ANY: bool = true;
}

/// What a single ray gathers on its way. Searches are compiled once for each: [`Best`] of either mode, and
/// [`Candidates`](crate::candidates::Candidates) for all that a callback decides.
pub(crate) trait Collect {
    /// Whether the first offer ends the search, so that its order does not matter.
    const ANY: bool;
    /// Whether an offer can end the search.
    const CAN_END: bool;
    /// Nothing beyond it is of interest; negative infinity ends the search.
    fn reach(&self) -> f32;
    /// Takes a meeting at `t <= reach()`, in `[t_near, t_far]` of the ray.
    fn offer(&mut self, meeting: Meeting, number: u32, slot: u32);
    /// Runs a search whose parameters have to be multiplied with `scale`, a power of two, to be those of the ray.
    fn scaled(&mut self, scale: f32, search: impl FnOnce(&mut Self));

    /// Whether nothing more is wanted.
    #[inline(always)]
    fn is_done(&self) -> bool {
        Self::CAN_END && self.reach() == f32::NEG_INFINITY
    }
}

/// Hands what it is offered on to another collector, through a pointer: for searches that spend their time elsewhere,
/// so that they are compiled once for all collectors.
pub(crate) struct Relay<'a> {
    take: &'a mut dyn FnMut(Meeting, u32, u32) -> f32,
    reach: f32,
}

impl Relay<'_> {
    /// Runs `search` with a relay to `collect`.
    #[inline(always)]
    pub(crate) fn run<C: Collect>(collect: &mut C, search: impl FnOnce(&mut Relay)) {
        let reach = collect.reach();
        let mut take = |meeting: Meeting, number: u32, slot: u32| {
            collect.offer(meeting, number, slot);
            collect.reach()
        };
        search(&mut Relay { take: &mut take, reach });
    }
}

impl Collect for Relay<'_> {
    const ANY: bool = false;
    const CAN_END: bool = true;

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.reach
    }

    fn offer(&mut self, meeting: Meeting, number: u32, slot: u32) {
        self.reach = (self.take)(meeting, number, slot);
    }

    fn scaled(&mut self, _: f32, _: impl FnOnce(&mut Self)) {
        unreachable!("rays are scaled before there is a relay");
    }
}

/// The best hit so far, or any.
pub(crate) struct Best<M: Mode>(pub(crate) Nearest, PhantomData<M>);

impl<M: Mode> Best<M> {
    #[inline(always)]
    pub(crate) fn new(nearest: Nearest) -> Self {
        Self(nearest, PhantomData)
    }
}

impl<M: Mode> Collect for Best<M> {
    const ANY: bool = M::ANY;
    const CAN_END: bool = M::ANY;

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.0.t
    }

    #[inline(always)]
    fn offer(&mut self, meeting: Meeting, number: u32, slot: u32) {
        self.0.offer::<M>(meeting, number, slot);
    }

    fn scaled(&mut self, scale: f32, search: impl FnOnce(&mut Self)) {
        let before = self.0;
        self.0.t /= scale;
        search(self);
        let found = self.0;
        // What was not improved keeps its bits, even where the scaled parameter left the range of floats.
        if (found.slot, found.number) == (before.slot, before.number) {
            self.0 = before;
        } else if !M::ANY {
            self.0.t *= scale;
        }
    }
}

/// A hit by numbers, or how far the ray reaches while nothing was hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// Ends the search beyond it; negative infinity after any hit was found.
    pub(crate) t: f32,
    pub(crate) u: f32,
    pub(crate) v: f32,
    /// Primitive in its object, [`INVALID_ID`] for none.
    pub(crate) number: u32,
    /// The object's place among all objects of the scene.
    pub(crate) slot: u32,
}

impl Nearest {
    #[inline(always)]
    pub(crate) fn none(t_far: f32) -> Self {
        Self { t: t_far, u: 0.0, v: 0.0, number: INVALID_ID, slot: INVALID_ID }
    }

    #[inline(always)]
    pub(crate) fn is_hit(&self) -> bool {
        self.number != INVALID_ID
    }

    /// Takes a meeting at `t <= self.t` if it is better.
    #[inline(always)]
    pub(crate) fn offer<M: Mode>(&mut self, meeting: Meeting, number: u32, slot: u32) {
        let Meeting { t, u, v } = meeting;
        if M::ANY {
            *self = Self { t: f32::NEG_INFINITY, u, v, number, slot };
        } else if t < self.t || (t == self.t && (slot, number) < (self.slot, self.number)) {
            *self = Self { t, u, v, number, slot };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ties_go_to_the_lowest() {
        let offers = [(2.0, 5, 1), (1.0, 7, 1), (1.0, 3, 1), (1.0, 9, 0), (1.5, 0, 0)];
        let mut forwards = Nearest::none(f32::INFINITY);
        let mut backwards = forwards;
        let offer = |best: &mut Nearest, (t, number, slot): (f32, u32, u32)| {
            if t <= best.t {
                best.offer::<Closest>(Meeting { t, u: 0.0, v: 0.0 }, number, slot);
            }
        };
        offers.iter().for_each(|&o| offer(&mut forwards, o));
        offers.iter().rev().for_each(|&o| offer(&mut backwards, o));
        assert_eq!(forwards, backwards, "the order does not matter");
        assert_eq!((forwards.slot, forwards.number), (0, 9), "lowest instance first");
    }
}
