// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays in double precision: the closest hit, any hit, all hits.
//! Invariant: of hits at the same parameter the lowest leaf and number counts. Tests: `tests/doubles.rs`.

use std::cmp::Ordering;

use gnurt_accel_bvh::{DoubleIndex, LastMet, LineTile};
use gnurt_accel_core::bits::TILE;
use gnurt_accel_core::direction_class::DirectionClass;
use gnurt_accel_core::exact::{Corners, Line, Triangle};
use gnurt_accel_core::{INVALID_ID, Threads};
use gnurt_simd::Level;

use super::lines::{Candidate, along_path, search};
use super::scene::DoubleScene;
use crate::lists::{answer_by_shares, answer_each};

/// `org + t * dir` for `t` in `[t_near, t_far]`. A ray with a number that is not finite (but the far end), without a
/// direction or with an empty interval hits nothing; `t_near` below 0 counts as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleRay {
    /// Origin.
    pub org: [f64; 3],
    /// Direction, of any length but zero.
    pub dir: [f64; 3],
    /// The least parameter that counts.
    pub t_near: f64,
    /// The greatest one.
    pub t_far: f64,
    /// It sees meshes and instances with one of these bits.
    pub mask: u32,
}

/// A hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleHit {
    /// In multiples of the direction's length.
    pub t: f64,
    /// The weight of the second corner.
    pub u: f64,
    /// The weight of the third corner.
    pub v: f64,
    /// The triangle in its mesh.
    pub prim_id: u32,
    /// The mesh in its scene.
    pub geom_id: u32,
    /// The outermost instance; `INVALID_ID` of a mesh of the queried scene.
    pub inst_id: u32,
    /// For [`DoubleScene::path`].
    pub leaf_id: u32,
}

impl DoubleRay {
    /// From 0 to infinity, seeing all.
    #[must_use]
    pub fn new(org: [f64; 3], dir: [f64; 3]) -> Self {
        Self { org, dir, t_near: 0.0, t_far: f64::INFINITY, mask: u32::MAX }
    }

    /// Between other ends.
    #[must_use]
    pub fn within(self, t_near: f64, t_far: f64) -> Self {
        Self { t_near, t_far, ..self }
    }

    /// Its line, if it can hit anything.
    #[inline(always)]
    pub(super) fn line(&self) -> Option<Line> {
        // Zero times a number is zero, unless that is not finite.
        let zero = |[x, y, z]: [f64; 3]| 0.0 * x + 0.0 * y + 0.0 * z;
        let is_finite = zero(self.org) + zero(self.dir) == 0.0;
        let near = self.t_near.max(0.0);
        let is_valid = is_finite && self.dir != [0.0; 3] && near.is_finite() && near <= self.t_far;
        (is_valid && !self.t_near.is_nan()).then(|| Line::new(self.org, self.dir, near, self.t_far))
    }
}

/// A hit before it gets its ids.
#[derive(Clone, Copy)]
struct Found {
    at: [f64; 3],
    leaf: u32,
    /// Of the triangle in its scene.
    number: u32,
}

impl Found {
    fn order(&self, other: &Self) -> Ordering {
        self.at[0].total_cmp(&other.at[0]).then(self.key().cmp(&other.key()))
    }

    fn key(&self) -> (u32, u32) {
        (self.leaf, self.number)
    }

    fn hit(&self, scene: &DoubleScene) -> DoubleHit {
        let ([t, u, v], [geom_id, prim_id]) = (self.at, scene.ids_in(self.leaf, self.number));
        let inst_id = scene.outermost(self.leaf);
        DoubleHit { t, u, v, prim_id, geom_id, inst_id, leaf_id: self.leaf }
    }
}

impl DoubleScene {
    /// The outermost instance on the way to a leaf.
    pub(super) fn outermost(&self, leaf: u32) -> u32 {
        if leaf == 0 { INVALID_ID } else { self.placed_at(leaf) as u32 }
    }

    /// The closest hit.
    #[must_use]
    pub fn intersect(&self, ray: &DoubleRay) -> Option<DoubleHit> {
        let line = ray.line()?;
        if self.shows_all(ray.mask) {
            let (number, at) = self.index.closest(Level::best(), &line)?;
            return Some(Found { at, leaf: 0, number }.hit(self));
        }
        let mut best: Option<(Found, [[f64; 3]; 3])> = None;
        let reach = |best: &Option<(Found, _)>| {
            best.as_ref().map_or(line.far, |(best, _)| DoubleIndex::reach(best.at[0]))
        };
        search(self, &line, ray.mask, &mut |Candidate { triangle, is_certain, leaf, number }| {
            let corners = Corners::of(triangle);
            if let Some(t) = line.meets_before(&corners, reach(&best), is_certain) {
                let [u, v] = line.weights(&corners);
                let found = Found { at: [t, u, v], leaf, number };
                if best.as_ref().is_none_or(|best| self.order(&line, (found, &corners), best).is_lt()) {
                    best = Some((found, triangle.corners));
                }
            }
            reach(&best)
        });
        best.map(|(best, _)| best.hit(self))
    }

    /// The order of two hits; of the second one the corners are those in its leaf.
    fn order(&self, line: &Line, a: (Found, &Corners), (b, corners): &(Found, [[f64; 3]; 3])) -> Ordering {
        let mut order = Ordering::Equal;
        along_path(self, b.leaf, None, &mut |path| {
            let triangle = Triangle::of_doubles(*corners, path);
            order = line.order((a.0.at[0], a.1), (b.at[0], &Corners::of(&triangle)));
        });
        order.then(a.0.key().cmp(&b.key()))
    }

    /// Whether there is a hit.
    #[must_use]
    pub fn occluded(&self, ray: &DoubleRay) -> bool {
        self.occluded_after(ray, &mut LastMet::default())
    }

    /// The same of a batch's next ray.
    #[inline]
    fn occluded_after(&self, ray: &DoubleRay, last: &mut LastMet) -> bool {
        let Some(line) = ray.line() else { return false };
        if self.shows_all(ray.mask) {
            return self.index.is_met(Level::best(), &line, last);
        }
        let mut is_hit = false;
        search(self, &line, ray.mask, &mut |Candidate { triangle, is_certain, .. }| {
            is_hit = is_hit || line.is_blocked(&Corners::of(triangle), is_certain);
            if is_hit { f64::NEG_INFINITY } else { line.far }
        });
        is_hit
    }

    /// The first hits in order, at most `most`; on each triangle that the ray touches.
    pub fn first_hits(&self, ray: &DoubleRay, most: usize, hits: &mut Vec<DoubleHit>) {
        self.list(ray, most, hits, |line, candidate| line.meets(candidate.triangle));
    }

    /// The crossings that [`crossings`](Self::crossings) counts, in order.
    pub fn crossing_hits(&self, ray: &DoubleRay, hits: &mut Vec<DoubleHit>) {
        self.list(ray, usize::MAX, hits, |line, candidate| {
            line.crosses(candidate.triangle)?;
            // Where the line that was not moved passes beside it, the place is near an edge.
            let at = line.meets(candidate.triangle);
            Some(at.unwrap_or_else(|| line.intersection(candidate.triangle)))
        });
    }

    fn list(
        &self,
        ray: &DoubleRay,
        most: usize,
        hits: &mut Vec<DoubleHit>,
        judge: impl Fn(&Line, &Candidate) -> Option<[f64; 3]>,
    ) {
        hits.clear();
        let Some(line) = ray.line().filter(|_| most > 0) else { return };
        let mut found = Vec::new();
        search(self, &line, ray.mask, &mut |candidate| {
            let at = judge(&line, &candidate);
            found.extend(at.map(|at| Found { at, leaf: candidate.leaf, number: candidate.number }));
            line.far
        });
        found.sort_unstable_by(Found::order);
        hits.extend(found.iter().take(most).map(|found| found.hit(self)));
    }

    /// How often a ray goes through surfaces, exactly: an even number of times through a closed mesh from outside, wherever it
    /// meets edges and corners.
    #[must_use]
    pub fn crossings(&self, ray: &DoubleRay) -> u32 {
        let Some(line) = ray.line() else { return 0 };
        let mut count = 0;
        search(self, &line, ray.mask, &mut |candidate| {
            count += u32::from(line.crosses(candidate.triangle).is_some());
            line.far
        });
        count
    }

    /// [`intersect`](Self::intersect) of many rays. Those that go side by side, as a camera's do in tiles of 8 x 8, take least time.
    #[must_use]
    pub fn intersect_batch(&self, rays: &[DoubleRay], threads: Threads) -> Vec<Option<DoubleHit>> {
        answer_by_shares(threads, rays, |rays, hits| {
            let mut tile = LineTile::default();
            for rays in rays.chunks(TILE) {
                if !self.intersect_tile(rays, &mut tile, hits) {
                    hits.extend(rays.iter().map(|ray| self.intersect(ray)));
                }
            }
        })
    }

    /// The hits of 64 valid rays that see everything; `false`, and none, of others.
    fn intersect_tile(
        &self,
        rays: &[DoubleRay],
        tile: &mut LineTile,
        hits: &mut Vec<Option<DoubleHit>>,
    ) -> bool {
        let Ok(rays) = <&[DoubleRay; TILE]>::try_from(rays) else { return false };
        let mut lines = [Line::new([0.0; 3], [1.0; 3], 0.0, 0.0); TILE];
        for (line, ray) in lines.iter_mut().zip(rays) {
            let Some(valid) = ray.line().filter(|_| self.shows_all(ray.mask)) else { return false };
            *line = valid;
        }
        let class = DirectionClass::of_doubles(&rays[0].dir);
        let is_alike = rays.iter().all(|ray| DirectionClass::of_doubles(&ray.dir) == class);
        self.index.closest_of_tile(Level::best(), &lines, is_alike.then_some(class), tile, |found| {
            hits.push(found.map(|(number, at)| Found { at, leaf: 0, number }.hit(self)));
        });
        true
    }

    /// [`occluded`](Self::occluded) of many rays.
    #[must_use]
    pub fn occluded_batch(&self, rays: &[DoubleRay], threads: Threads) -> Vec<bool> {
        answer_after(rays, threads, |last, ray| self.occluded_after(ray, last))
    }

    /// [`crossings`](Self::crossings) of many rays.
    #[must_use]
    pub fn crossings_batch(&self, rays: &[DoubleRay], threads: Threads) -> Vec<u32> {
        each(rays, threads, |ray| self.crossings(ray))
    }
}

/// An answer to each ray, in order; each share of them has what its last ray met.
fn answer_after<B: Send>(
    rays: &[DoubleRay],
    threads: Threads,
    answer: impl Fn(&mut LastMet, &DoubleRay) -> B + Sync + Send,
) -> Vec<B> {
    let mut answers = Vec::new();
    answer_each(threads, rays, &mut answers, LastMet::default, answer);
    answers
}

/// An answer to each question, in order.
pub(super) fn each<A: Sync, B: Send>(
    all: &[A],
    threads: Threads,
    answer: impl Fn(&A) -> B + Sync + Send,
) -> Vec<B> {
    let mut answers = Vec::new();
    answer_each(threads, all, &mut answers, || (), |(), question| answer(question));
    answers
}
