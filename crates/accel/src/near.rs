// SPDX-License-Identifier: GPL-3.0-or-later
//! Several nearest primitives of a point, and all that touch a sphere around it.
//! Trees are searched as for the nearest point (`point/mod.rs`). Space: that of the queried tree.
//! Invariant: a primitive that comes several times, from several leaves or as two halves of a quad, is there once, at its
//! least distance. Tests: `tests/surfaces/overlaps.rs`.

use gnurt_accel_core::point::{Near, NearestPoint};

use crate::target::Target;
use crate::{PointHit, PrimitiveId, Query};

/// The nearest primitives so far, nearest first.
struct Several<'a> {
    radius: f64,
    most: usize,
    found: Vec<(PrimitiveId, Near)>,
    named: &'a dyn Fn(u32, u32) -> PrimitiveId,
}

impl<'a> Several<'a> {
    /// At most `most`, which is not 0, no farther than `radius`; `named` converts slot and number to ids.
    fn new(radius: f64, most: usize, named: &'a dyn Fn(u32, u32) -> PrimitiveId) -> Self {
        Self { radius, most, found: Vec::new(), named }
    }
}

impl NearestPoint for Several<'_> {
    fn distance(&self) -> f64 {
        match self.found.last() {
            Some((_, last)) if self.found.len() == self.most => last.distance,
            _ => self.radius,
        }
    }

    fn offer(&mut self, offset: [f64; 3], uv: [f64; 2], number: u32, slot: u32) {
        let near = Near::new(offset, uv, number, slot);
        if near.distance.is_nan() || near.distance > self.distance() {
            return;
        }
        let id = (self.named)(slot, number);
        let is_before = |id: PrimitiveId, other: &(PrimitiveId, Near)| {
            (near.distance, id, number) < (other.1.distance, other.0, other.1.number)
        };
        if let Some(known) = self.found.iter().position(|(known, _)| *known == id) {
            if !is_before(id, &self.found[known]) {
                return;
            }
            self.found.remove(known);
        }
        let at = self.found.partition_point(|other| !is_before(id, other));
        self.found.insert(at, (id, near));
        self.found.truncate(self.most);
    }
}

/// All primitives within a distance, by slot and number.
struct Within {
    radius: f64,
    found: Vec<(u32, u32)>,
}

impl Within {
    fn new(radius: f64) -> Self {
        Self { radius, found: Vec::new() }
    }
}

impl NearestPoint for Within {
    fn distance(&self) -> f64 {
        self.radius
    }

    fn offer(&mut self, offset: [f64; 3], uv: [f64; 2], number: u32, slot: u32) {
        if Near::new(offset, uv, number, slot).distance <= self.radius {
            self.found.push((slot, number));
        }
    }
}

/// Visits near primitives; the visitor sets the radius.
struct Visited<'a> {
    target: Target<'a>,
    point: [f64; 3],
    radius: f64,
    visit: &'a mut dyn FnMut(&PointHit) -> f64,
}

impl NearestPoint for Visited<'_> {
    fn distance(&self) -> f64 {
        self.radius
    }

    fn offer(&mut self, offset: [f64; 3], uv: [f64; 2], number: u32, slot: u32) {
        let near = Near::new(offset, uv, number, slot);
        if near.distance <= self.radius {
            let hit = near.hit(self.point, |nearest| self.target.hit(nearest));
            self.radius = self.radius.min((self.visit)(&hit));
        }
    }
}

/// Primitives by slot and number, each once, in the order of their ids.
pub(crate) fn name_all(target: Target, found: &[(u32, u32)], ids: &mut Vec<PrimitiveId>) {
    ids.clear();
    ids.extend(found.iter().map(|&(slot, number)| target.named(slot, number)));
    ids.sort_unstable();
    ids.dedup();
}

impl Target<'_> {
    /// The `n` nearest primitives within `radius`.
    pub(crate) fn nearest_primitives(
        self,
        query: &Query,
        point: [f64; 3],
        radius: f64,
        n: usize,
        hits: &mut Vec<PointHit>,
    ) {
        hits.clear();
        if n == 0 {
            return;
        }
        let named = |slot, number| self.named(slot, number);
        let mut several = Several::new(radius, n, &named);
        self.near(query, point, &mut several);
        hits.extend(several.found.iter().map(|(_, near)| near.hit(point, |nearest| self.hit(nearest))));
    }

    /// All primitives within `radius`.
    pub(crate) fn touching_sphere(
        self,
        query: &Query,
        center: [f64; 3],
        radius: f64,
        ids: &mut Vec<PrimitiveId>,
    ) {
        let mut within = Within::new(radius);
        self.near(query, center, &mut within);
        name_all(self, &within.found, ids);
    }

    /// Shows primitives near a point.
    pub(crate) fn visit_near(
        self,
        query: &Query,
        point: [f64; 3],
        radius: f64,
        visit: &mut dyn FnMut(&PointHit) -> f64,
    ) {
        let mut visited = Visited { target: self, point, radius, visit };
        self.near(query, point, &mut visited);
    }
}
