// SPDX-License-Identifier: GPL-3.0-or-later
//! Plane events: where along an axis a triangle's box starts, ends or lies flat.
//! Source: [WH06] section 4.2. Differs: an event is one 64-bit number whose order is the order of the sweep, so
//! sorting and merging compare integers and an event takes 8 bytes.
//! Invariant: bits 63..32 order like the position, 31..30 are the kind (end < flat < start), 29..0 the triangle's
//! number in its node. Tests: `tests::order_is_position_then_kind`.

use gnurt_accel_core::Aabb;

/// The event of a triangle's box at a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    End,
    Flat,
    Start,
}

/// An event; see the head of this file for its bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Event(u64);

const PRIM_BITS: u32 = 30;
const PRIM_MASK: u64 = (1 << PRIM_BITS) - 1;

impl Event {
    #[inline]
    pub(crate) fn new(at: f32, kind: Kind, prim: u32) -> Self {
        Self(u64::from(Self::position_of(at)) << 32 | (kind as u64) << PRIM_BITS | u64::from(prim))
    }

    /// Equal for equal positions, ordered like them.
    #[inline(always)]
    pub(crate) fn position_of(at: f32) -> u32 {
        // The addition of zero converts -0.0 to 0.0, so that equal positions have equal bits.
        let bits = (at + 0.0).to_bits();
        if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
    }

    #[inline(always)]
    pub(crate) fn position(self) -> u32 {
        (self.0 >> 32) as u32
    }

    #[inline(always)]
    pub(crate) fn at(self) -> f32 {
        let ordered = self.position();
        let not_negative = (ordered as i32 >> 31) as u32;
        f32::from_bits(ordered ^ (!not_negative | 1 << 31))
    }

    #[inline(always)]
    pub(crate) fn kind(self) -> Kind {
        match self.0 >> PRIM_BITS & 3 {
            0 => Kind::End,
            1 => Kind::Flat,
            _ => Kind::Start,
        }
    }

    /// 1 where a box ends, 0 where one starts; not for flat ones.
    #[inline(always)]
    pub(crate) fn ends(self) -> i32 {
        1 - (self.0 >> (PRIM_BITS + 1) & 1) as i32
    }

    #[inline(always)]
    pub(crate) fn is_flat(self) -> bool {
        self.0 >> PRIM_BITS & 1 == 1
    }

    #[inline(always)]
    pub(crate) fn prim(self) -> usize {
        (self.0 & PRIM_MASK) as usize
    }

    /// The same event of another triangle.
    #[inline(always)]
    pub(crate) fn renumbered(self, prim: u32) -> Self {
        Self(self.0 & !PRIM_MASK | u64::from(prim))
    }
}

/// Appends the events of a box along `axis`: one where it is flat, else two.
#[inline]
pub(crate) fn push_events(events: &mut Vec<Event>, bounds: &Aabb, axis: usize, prim: u32) {
    let (low, high) = (bounds.min[axis], bounds.max[axis]);
    if low == high {
        events.push(Event::new(low, Kind::Flat, prim));
    } else {
        events.push(Event::new(low, Kind::Start, prim));
        events.push(Event::new(high, Kind::End, prim));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_position_then_kind() {
        let ascending = [-3e18f32, -1.5, -1e-42, 0.0, 1e-42, 0.25, 7.0, 1e18];
        for pair in ascending.windows(2) {
            let later = Event::new(pair[1], Kind::End, 0);
            assert!(Event::new(pair[0], Kind::Start, 9) < later, "{} comes before {}", pair[0], pair[1]);
            assert_eq!(later.at(), pair[1], "the position comes back");
        }
        let [end, flat, start] = [Kind::End, Kind::Flat, Kind::Start].map(|kind| Event::new(2.0, kind, 5));
        assert!(end < flat && flat < start, "boxes end before others start");
        assert_eq!((flat.kind(), flat.prim(), flat.renumbered(8).prim()), (Kind::Flat, 5, 8), "fields");
        assert_eq!(Event::new(-0.0, Kind::End, 1), Event::new(0.0, Kind::End, 1), "there is one zero");
    }
}
