// SPDX-License-Identifier: GPL-3.0-or-later
//! Lobes of points seen from one direction each, as they are kept to be asked about many others: at the ends of shadow rays to
//! and from virtual lights.
//! Source: original. Invariant: the bits of [`Seen::eval_pdf`]. Proof: many_lights/lanes.rs of `render`.

use glam::Vec3;

use super::Bsdf;
use super::lobe::Kind;
use super::lobes::MOST;
use super::lobes_at::Rarities;
use super::seen::Seen;
use super::seen_lobe::{PlainLobe, SeenLobe, Sum};
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
                    kept.lobes.push(SeenLobe::none(0.0).map(|_| [0.0; LANES], 0));
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
                let lobe = lobe.map(
                    #[inline(always)]
                    |row| wi.x.load(row, first),
                    first,
                );
                sum.add(k, &lobe, wi);
            } else {
                let lobe = lobe.plain(
                    #[inline(always)]
                    |row| wi.x.load(row, first),
                );
                sum.add_plain(&lobe, wi);
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
                let all = lobe.plain(
                    #[inline(always)]
                    |&x| wi.x.all(x),
                );
                sum.add_plain(&all, wi);
                continue;
            }
            let mut all = lobe.map(
                #[inline(always)]
                |&x| wi.x.all(x),
                0,
            );
            // All points are as the one.
            all.under = std::array::from_fn(|j| if lobe.under[j] & 1 != 0 { u32::MAX } else { 0 });
            sum.add(k, &all, wi);
        }
        (sum.value, sum.pdf)
    }
}

impl SeenLobe<f32> {
    /// Whether [`Sum::add_plain`] knows it: nothing, or Lambert's reflector, neither above nor below another lobe.
    fn is_plain(&self) -> bool {
        let diffuse = Kind::None.bit() | Kind::Diffuse.bit();
        let is_lambert = self.alpha == 0.0 && !self.loses_light();
        self.kinds & !diffuse == 0 && is_lambert && !self.covers && self.under_any == 0
    }
}

impl<Q> SeenLobe<Q> {
    /// What [`Sum::add_plain`] asks for, as other numbers.
    #[inline(always)]
    fn plain<R: Copy>(&self, f: impl Fn(&Q) -> R + Copy) -> PlainLobe<R> {
        PlainLobe {
            kind: f(&self.kind),
            normal: self.normal.each(f),
            weight: self.weight.each(f),
            a: self.a.each(f),
            chance: f(&self.chance),
        }
    }

    /// The same with other numbers, of the points from `first` on.
    #[inline(always)]
    fn map<R: Copy>(&self, f: impl Fn(&Q) -> R + Copy, first: usize) -> SeenLobe<R> {
        let mut under = self.under;
        for under in &mut under {
            *under >>= first;
        }
        SeenLobe {
            kind: f(&self.kind),
            kinds: self.kinds,
            normal: self.normal.each(f),
            wo: self.wo.each(f),
            cos: f(&self.cos),
            weight: self.weight.each(f),
            left: self.left.each(f),
            a: self.a.each(f),
            b: self.b.each(f),
            c: self.c.each(f),
            more: self.more.each(f),
            alpha: f(&self.alpha),
            eta: f(&self.eta),
            hidden: f(&self.hidden),
            lost: f(&self.lost),
            chance: f(&self.chance),
            share_of_more: f(&self.share_of_more),
            cover: f(&self.cover),
            covers: self.covers,
            under,
            under_any: self.under_any,
            rare: self.rare,
            // Nobody looks at them where there are none.
            rarities: if self.rare == 0 { Rarities::all(f(&self.kind)) } else { self.rarities.map(f) },
        }
    }
}

impl<Q> Rarities<Q> {
    fn map<R>(&self, f: impl Fn(&Q) -> R + Copy) -> Rarities<R> {
        let [share, ior, thickness] = &self.film;
        Rarities {
            tangent: self.tangent.each(f),
            across: f(&self.across),
            film: [f(share), f(ior), f(thickness)],
            spread: f(&self.spread),
            channels: self.channels.each(f),
        }
    }
}

impl Rarities<Row> {
    fn put(&mut self, i: usize, of: &Rarities<f32>) {
        let Self { tangent, across, film, spread, channels } = self;
        for (rows, v) in [(tangent, of.tangent), (channels, of.channels)] {
            (rows.x[i], rows.y[i], rows.z[i]) = (v.x, v.y, v.z);
        }
        (across[i], spread[i]) = (of.across, of.spread);
        film.iter_mut().zip(of.film).for_each(|(row, x)| row[i] = x);
    }
}

impl SeenLobe<Row> {
    /// Writes point `i`.
    fn put(&mut self, i: usize, lobe: &SeenLobe<f32>) {
        let numbers = [
            (&mut self.kind, lobe.kind),
            (&mut self.cos, lobe.cos),
            (&mut self.alpha, lobe.alpha),
            (&mut self.eta, lobe.eta),
            (&mut self.hidden, lobe.hidden),
            (&mut self.lost, lobe.lost),
            (&mut self.chance, lobe.chance),
            (&mut self.share_of_more, lobe.share_of_more),
            (&mut self.cover, lobe.cover),
        ];
        numbers.into_iter().for_each(|(row, x)| row[i] = x);
        let vectors = [
            (&mut self.normal, lobe.normal),
            (&mut self.wo, lobe.wo),
            (&mut self.weight, lobe.weight),
            (&mut self.left, lobe.left),
            (&mut self.a, lobe.a),
            (&mut self.b, lobe.b),
            (&mut self.c, lobe.c),
            (&mut self.more, lobe.more),
        ];
        vectors.into_iter().for_each(|(rows, v)| (rows.x[i], rows.y[i], rows.z[i]) = (v.x, v.y, v.z));
        for (under, from) in self.under.iter_mut().zip(lobe.under) {
            *under |= (from & 1) << i;
        }
        if lobe.rare != 0 {
            self.rarities.put(i, &lobe.rarities);
        }
        self.rare |= lobe.rare;
        self.kinds |= lobe.kinds;
        self.under_any |= lobe.under_any;
        self.covers |= lobe.covers;
    }
}
