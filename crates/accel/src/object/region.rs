// SPDX-License-Identifier: GPL-3.0-or-later
//! The primitives of an object that may meet a region. Tests: `tests/surfaces/crossings.rs`, `tests/surfaces/overlaps.rs`.

use gnurt_accel_core::exact::Place;
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::region::Region;

use super::{Index, ObjectTree};
use crate::surfaces::Seen;

impl ObjectTree {
    /// Shows them; the object is at `place` and has this slot.
    pub(crate) fn show_at(
        &self,
        region: &Region,
        mask: u32,
        slot: u32,
        place: Option<&Place>,
        visit: &mut dyn FnMut(&Seen),
    ) {
        for part in self.parts.iter().filter(|part| part.mask & mask != 0) {
            let sieve = region.sieve(part.index.bounds().greatest());
            let visit = &mut |number: u32, primitive: Primitive| {
                visit(&Seen { slot, number, primitive, place, region });
            };
            match &part.index {
                Index::Kd(index) => index.sift(&sieve, visit),
                Index::Interval(index) => index.sift(&sieve, visit),
                Index::Grid(index) => index.sift(&sieve, visit),
                Index::Bvh(index) => index.sift(&sieve, visit),
                Index::Moving(index) => index.first().sift(&sieve, visit),
                Index::Spheres(index) => index.sift(&sieve, visit),
                Index::User(index) => index.sift(&sieve, visit),
            }
        }
    }
}
