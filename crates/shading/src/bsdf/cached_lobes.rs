// SPDX-License-Identifier: GPL-3.0-or-later
//! Lobes of points prepared for one direction each, stored for evaluation in many others: at the ends of
//! shadow rays to and from virtual lights.
//! Invariant: the bits of [`Prepared::eval_pdf`]. Tests: `tests` of `bsdf`, over all models; many_lights/lanes.rs of `render`.

use glam::Vec3;

use super::Bsdf;
use super::lobe::Kind;
use super::lobes::MOST;
use super::prepared::Prepared;
use super::prepared_lobe::PreparedLobe;
use super::prepared_sum::Sum;
use crate::lanes::LANES;
use crate::real::{Real, Vector};

/// Sixteen points' lobes, each prepared for one direction, stored for evaluation in many others.
#[derive(Clone, Debug, Default)]
pub struct CachedLobes {
    normal: [Row; 3],
    lobes: Vec<PreparedLobe<Row>>,
    /// Whether they need more than [`Sum::add_plain`].
    is_rich: bool,
}

/// A number of sixteen points.
type Row = [f32; LANES];

impl CachedLobes {
    /// Sixteen points or fewer, each seen from a unit direction.
    #[must_use]
    pub fn new<'a>(points: impl Iterator<Item = (&'a Bsdf, Vec3)>) -> Self {
        let mut cached = Self::default();
        for (i, (bsdf, wo)) in points.enumerate().take(LANES) {
            let prepared = bsdf.prepared(wo);
            for (row, x) in cached.normal.iter_mut().zip(bsdf.normal().to_array()) {
                row[i] = x;
            }
            for (k, lobe) in prepared.lobes().enumerate() {
                if k == cached.lobes.len() {
                    cached.lobes.push(PreparedLobe::none([0.0; LANES]));
                }
                cached.lobes[k].put(i, lobe);
                cached.is_rich |= !lobe.is_plain();
            }
        }
        cached
    }

    /// [`Prepared::eval_pdf`] for the points from `first` on.
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
                for layers_above in &mut here.layers_above {
                    *layers_above >>= first;
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

impl Prepared<f32> {
    /// [`Prepared::eval_pdf`] of one point for many directions.
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

impl PreparedLobe<f32> {
    /// The lobe of many equal points.
    #[inline(always)]
    pub(super) fn for_all<R: Real>(&self, like: R) -> PreparedLobe<R> {
        let mut all = self.map(
            like.all(0.0),
            #[inline(always)]
            |&x| like.all(x),
        );
        for layers_above in &mut all.layers_above {
            *layers_above = if *layers_above & 1 != 0 { u32::MAX } else { 0 };
        }
        all
    }

    /// Whether [`Sum::add_plain`] supports it: nothing, or Lambert's reflector, neither above nor below
    /// another lobe.
    fn is_plain(&self) -> bool {
        let diffuse = Kind::None.bit() | Kind::Diffuse.bit();
        let is_lambert = self.alpha == 0.0 && !self.loses_light();
        self.kinds & !diffuse == 0 && is_lambert && !self.covers && self.any_layer_above == 0
    }
}

impl<Q> PreparedLobe<Q> {
    /// The same with other numbers. Rare ones are only copied where there are some: elsewhere they are `zero`, as they are here.
    #[inline(always)]
    fn map<R: Copy>(&self, zero: R, mut f: impl FnMut(&Q) -> R) -> PreparedLobe<R> {
        let Self { kinds, covers, layers_above, any_layer_above, rare, .. } = *self;
        let mut to =
            PreparedLobe { kinds, covers, layers_above, any_layer_above, rare, ..PreparedLobe::none(zero) };
        to.each_with(
            self,
            #[inline(always)]
            |to, from| *to = f(from),
        );
        to
    }
}

impl PreparedLobe<Row> {
    /// Writes point `i`.
    fn put(&mut self, i: usize, lobe: &PreparedLobe<f32>) {
        self.rare |= lobe.rare;
        self.kinds |= lobe.kinds;
        self.any_layer_above |= lobe.any_layer_above;
        self.covers |= lobe.covers;
        self.each_with(lobe, |row, &x| row[i] = x);
        for (layers_above, from) in self.layers_above.iter_mut().zip(lobe.layers_above) {
            *layers_above |= (from & 1) << i;
        }
    }
}
