// SPDX-License-Identifier: GPL-3.0-or-later
//! Value and density of the lobes of points, lobe by lobe, those that lie below others dimmed by what these leave.
//! Source: original. Space: world, unit directions away from the surface. Proof: `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;

use super::lobe::Kind;
use super::lobes::MOST;
use super::seen_lobe::SeenLobe;
use crate::real::{Real, Vector};

/// Value and density of the lobes of points, one lobe after the other, no more than [`MOST`]. Who loops hands over references: lobes that
/// are moved, as iterators do, go through memory.
pub(super) struct Sum<R: Real> {
    pub(super) value: Vector<R>,
    pub(super) pdf: R,
    /// Points whose front is lit.
    above: R::Mask,
    /// What those above others leave.
    left: [Option<Vector<R>>; MOST],
}

impl<R: Real> Sum<R> {
    /// Of no lobe, at points with these normals, for the unit `wi`.
    #[inline(always)]
    pub(super) fn new(normal: Vector<R>, wi: Vector<R>) -> Self {
        let zero = wi.x.all(0.0);
        let above = normal.dot(wi).above(zero);
        Self { value: Vector::grey(zero), pdf: zero, above, left: [const { None }; MOST] }
    }

    /// Adds lobe `k`; those before were added before.
    #[inline(always)]
    pub(super) fn add(&mut self, k: usize, lobe: &SeenLobe<R>, wi: Vector<R>) {
        let i = lobe.normal.dot(wi);
        let split = lobe.split(Some(wi), i.size());
        if lobe.covers {
            self.left[k] = Some(lobe.sent_back(i.size(), split).rest());
        }
        let (light, density) = lobe.eval_pdf(wi, i, self.above, split);
        let mut weight = lobe.weight;
        if lobe.under_any != 0 {
            let mut rest = Vector::grey(i.all(1.0));
            for (j, left) in self.left.iter().enumerate() {
                if let Some(left) = left.filter(|_| lobe.under_any >> j & 1 != 0) {
                    rest = Vector::pick(lobe.below(j), rest * left, rest);
                }
            }
            weight = weight * rest.min(lobe.left);
        }
        self.value = self.value + light * weight;
        self.pdf = self.pdf + density * lobe.chance;
    }

    /// The same with the same bits, faster, for a lobe that is nothing or Lambert's reflector, neither above nor below another one: most
    /// surfaces are so.
    #[inline(always)]
    pub(super) fn add_plain(&mut self, lobe: &SeenLobe<R>, wi: Vector<R>) {
        let i = lobe.normal.dot(wi);
        let zero = i.all(0.0);
        let is = self.above & i.above(zero) & lobe.is(Kind::Diffuse);
        let by_cosine = R::pick(is, i.or_more(i.all(1e-20)) * FRAC_1_PI, zero);
        self.value = self.value + lobe.a * by_cosine * lobe.weight;
        self.pdf = self.pdf + by_cosine * lobe.chance;
    }
}
