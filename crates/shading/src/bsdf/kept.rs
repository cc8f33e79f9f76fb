// SPDX-License-Identifier: GPL-3.0-or-later
//! Lobes of points seen from one direction each, as they are kept to be asked about many others: at the ends of shadow rays to
//! and from virtual lights.
//! Invariant: the bits of [`Seen::eval_pdf`]. Tests: `tests` of `bsdf`, over all models; many_lights/lanes.rs of `render`.

use glam::Vec3;

use super::Bsdf;
use super::lobe::Kind;
use super::lobes::MOST;
use super::seen::Seen;
use super::seen_lobe::SeenLobe;
use super::seen_sum::Sum;
use crate::lanes::LANES;
use crate::real::{Real, Vector};

/// Sixteen points' lobes, each seen from one direction, as they are kept to be asked about many others.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    normal: [Row; 3],
    lobes: Vec<SeenLobe<Row>>,
    /// Whether they need more than [`Sum::add_plain`].
    is_rich: bool,
}

/// A number of sixteen points.
type Row = [f32; LANES];

impl Kept {
    /// Sixteen points or fewer, each seen from a unit direction.
    #[must_use]
    pub fn new<'a>(points: impl Iterator<Item = (&'a Bsdf, Vec3)>) -> Self {
        let mut kept = Self::default();
        for (i, (bsdf, wo)) in points.enumerate().take(LANES) {
            let seen = bsdf.seen(wo);
            for (row, x) in kept.normal.iter_mut().zip(bsdf.normal().to_array()) {
                row[i] = x;
            }
            for (k, lobe) in seen.lobes().enumerate() {
                if k == kept.lobes.len() {
                    kept.lobes.push(SeenLobe::none([0.0; LANES]));
                }
                kept.lobes[k].put(i, lobe);
                kept.is_rich |= !lobe.is_plain();
            }
        }
        kept
    }

    /// [`Seen::eval_pdf`] for the points from `first` on.
    #[inline(always)]
    pub fn eval_pdf<R: Real>(&self, first: usize, wi: Vector<R>) -> (Vector<R>, R) {
        let [x, y, z] = &self.normal;
        let mut sum = Sum::new(Vector::load(wi.x, [x, y, z], first), wi);
        for (k, lobe) in self.lobes.iter().take(MOST).enumerate() {
            if self.is_rich {
                let mut here = lobe.map(
                    wi.x.all(0.0),
                    #[inline(always)]
                    |row| wi.x.load(row, first),
                );
                for under in &mut here.under {
                    *under >>= first;
                }
                sum.add(k, &here, wi);
            } else {
                let here = lobe.map(
                    wi.x.all(0.0),
                    #[inline(always)]
                    |row| wi.x.load(row, first),
                );
                sum.add_plain(&here, wi);
            }
        }
        (sum.value, sum.pdf)
    }
}

impl Seen<f32> {
    /// [`Seen::eval_pdf`] of one point for many directions.
    #[inline(always)]
    pub fn eval_pdf_all<R: Real>(&self, wi: Vector<R>) -> (Vector<R>, R) {
        let mut sum = Sum::new(Vector::all(wi.x, self.normal.into()), wi);
        for (k, lobe) in self.lobes.iter().enumerate() {
            let Some(lobe) = lobe else { break };
            if lobe.is_plain() {
                let all = lobe.map(
                    wi.x.all(0.0),
                    #[inline(always)]
                    |&x| wi.x.all(x),
                );
                sum.add_plain(&all, wi);
                continue;
            }
            sum.add(k, &lobe.for_all(wi.x), wi);
        }
        (sum.value, sum.pdf)
    }
}

impl SeenLobe<f32> {
    /// That of many points that are as the one.
    #[inline(always)]
    pub(super) fn for_all<R: Real>(&self, like: R) -> SeenLobe<R> {
        let mut all = self.map(
            like.all(0.0),
            #[inline(always)]
            |&x| like.all(x),
        );
        for under in &mut all.under {
            *under = if *under & 1 != 0 { u32::MAX } else { 0 };
        }
        all
    }

    /// Whether [`Sum::add_plain`] knows it: nothing, or Lambert's reflector, neither above nor below another lobe.
    fn is_plain(&self) -> bool {
        let diffuse = Kind::None.bit() | Kind::Diffuse.bit();
        let is_lambert = self.alpha == 0.0 && !self.loses_light();
        self.kinds & !diffuse == 0 && is_lambert && !self.covers && self.under_any == 0
    }
}

impl<Q> SeenLobe<Q> {
    /// The same with other numbers. Rare ones are only copied where there are some: elsewhere they are `zero`, as they are here.
    #[inline(always)]
    fn map<R: Copy>(&self, zero: R, mut f: impl FnMut(&Q) -> R) -> SeenLobe<R> {
        let Self { kinds, covers, under, under_any, rare, .. } = *self;
        let mut to = SeenLobe { kinds, covers, under, under_any, rare, ..SeenLobe::none(zero) };
        to.each_with(
            self,
            #[inline(always)]
            |to, from| *to = f(from),
        );
        to
    }
}

impl SeenLobe<Row> {
    /// Writes point `i`.
    fn put(&mut self, i: usize, lobe: &SeenLobe<f32>) {
        self.rare |= lobe.rare;
        self.kinds |= lobe.kinds;
        self.under_any |= lobe.under_any;
        self.covers |= lobe.covers;
        self.each_with(lobe, |row, &x| row[i] = x);
        for (under, from) in self.under.iter_mut().zip(lobe.under) {
            *under |= (from & 1) << i;
        }
    }
}
