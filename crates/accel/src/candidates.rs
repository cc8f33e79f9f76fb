// SPDX-License-Identifier: GPL-3.0-or-later
//! Lists of all hits of a ray, from hits that are passed to a callback one by one. Filters and the collection
//! of all hits serve the purpose of Embree's filter functions.
//! Tests: `tests/filters.rs`, `tests/all_hits.rs`.

use crate::Hit;

/// Whether `hit` is to be preferred to `best`: nearer, or of the lower primitive at the same `t`.
pub(crate) fn is_better(hit: &Hit, best: Option<&Hit>) -> bool {
    best.is_none_or(|best| (hit.t, hit.primitive()) < (best.t, best.primitive()))
}

/// Hits in the order of `t`, then of primitives, each one once, at most `most` of them.
pub(crate) struct Sorted<'a> {
    hits: &'a mut Vec<Hit>,
    most: usize,
    t_far: f32,
}

impl<'a> Sorted<'a> {
    /// Empties `hits` and fills it.
    pub(crate) fn new(hits: &'a mut Vec<Hit>, most: usize, t_far: f32) -> Self {
        hits.clear();
        Self { hits, most, t_far }
    }

    /// Takes a hit and returns the remaining extent of the ray.
    pub(crate) fn take(&mut self, hit: Hit) -> f32 {
        // Without a bound a plain list is sorted in the end: far cheaper where there are thousands.
        if self.most == usize::MAX {
            self.hits.push(hit);
            return self.t_far;
        }
        let start = self.hits.partition_point(|other| hit.t - other.t > nearness(hit.t));
        let close = self.hits[start..].iter().take_while(|other| other.t - hit.t <= nearness(hit.t));
        let twin = close.into_iter().position(|other| is_same(other, &hit)).map(|i| start + i);
        if twin.is_none_or(|twin| is_better(&hit, Some(&self.hits[twin]))) {
            twin.map(|twin| self.hits.remove(twin));
            let at = self.hits.partition_point(|other| is_better(other, Some(&hit)));
            self.hits.insert(at, hit);
            self.hits.truncate(self.most);
        }
        match self.hits.last() {
            Some(last) if self.hits.len() == self.most => last.t,
            _ if self.most == 0 => f32::NEG_INFINITY,
            _ => self.t_far,
        }
    }

    /// Sorts the elements that are still unsorted.
    pub(crate) fn finish(self) {
        if self.most != usize::MAX {
            return;
        }
        let hits = self.hits;
        hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive().cmp(&b.primitive())));
        let mut retained = 0;
        for i in 0..hits.len() {
            let hit = hits[i];
            let near = hits[..retained].iter().rev().take_while(|other| hit.t - other.t <= nearness(hit.t));
            if !near.into_iter().any(|other| is_same(other, &hit)) {
                hits[retained] = hit;
                retained += 1;
            }
        }
        hits.truncate(retained);
    }
}

/// The greatest difference of two parameters that rounding may cause.
fn nearness(t: f32) -> f32 {
    t.abs() * (4.0 * f32::EPSILON)
}

/// Whether two hits are one: a primitive that was met in several leaves, or a quad met on the diagonal of its two
/// halves.
fn is_same(a: &Hit, b: &Hit) -> bool {
    let near = |a: f32, b: f32| (a - b).abs() <= 1e-5;
    a.primitive() == b.primitive() && (a.t - b.t).abs() <= nearness(a.t) && near(a.u, b.u) && near(a.v, b.v)
}
