// SPDX-License-Identifier: GPL-3.0-or-later
//! The best hit so far of a ray that is being traced, for closest-hit and any-hit queries.
//! Source: original.
//! Invariant: of hits at the same `t` the one with the lowest instance, then the lowest triangle wins, so that the
//! answer does not depend on the order of visits. Proof: `tests::ties_go_to_the_lowest`.

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

/// A hit by numbers, or how far the ray reaches while nothing was hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// Ends the search beyond it; negative infinity after any hit was found.
    pub(crate) t: f32,
    pub(crate) u: f32,
    pub(crate) v: f32,
    /// Triangle in its object, [`INVALID_ID`] for none.
    pub(crate) number: u32,
    /// Place of the instance in its scene.
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
