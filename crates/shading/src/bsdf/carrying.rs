// SPDX-License-Identifier: GPL-3.0-or-later
//! A point's lobes for paths that carry light: prepared for the direction of the light, with the values of
//! paths from the eye.
//! Source: \[Vea97\] sections 5.2 (refraction), 5.3 (shading normals) and 8.3 (the scattered measure);
//! original for lobes with their own normals, each of which has its own correction.
//! Space: world, unit directions away from the surface.
//! Invariant: a value times [`Carrying::correction`] is the value of a path from the eye, times the ratio of
//! the cosines of the outgoing and the incoming direction to the geometric normal. Tests: `carrying_tests`;
//! crates/render/tests/agreement.rs.

use glam::Vec3;

use super::Bsdf;
use super::exchange::Exchange;
use super::lobes::MOST;
use super::prepared::Prepared;
use super::prepared_sum::Sum;
use super::prepared_values::GRAZING;
use super::sample::BsdfSample;
use crate::real::{Real, Vector};
use crate::sampling::{Basis, cosine_hemisphere};

/// Fraction of paths that a point with tilted lobes sends to all sides of the face: it is visible from below
/// a lobe's horizon, too.
const TO_ALL_SIDES: f32 = 0.25;

/// Lobes seen from where light came from.
#[derive(Clone, Debug)]
pub struct Carrying {
    prepared: Prepared<f32>,
    normal: Vec3,
    from: Vec3,
    /// To the normal.
    cos: f32,
    etas: Vec3,
    /// By lobe, where some differ.
    exchanges: Option<[Exchange; MOST]>,
    is_tilted: bool,
}

impl Carrying {
    /// A point's lobes for light that came from the unit direction `from`.
    #[must_use]
    pub fn new(bsdf: &Bsdf, from: Vec3) -> Self {
        Self::by(bsdf, from, Vec3::ONE)
    }

    /// The same where the light counts `light` by colour; see [`Bsdf::prepared_for`].
    #[must_use]
    pub fn by(bsdf: &Bsdf, from: Vec3, light: Vec3) -> Self {
        let (normal, etas) = (bsdf.normal(), bsdf.etas());
        let (lobes, cos) = (bsdf.lobes().as_slice(), normal.dot(from));
        let mut this = Self {
            prepared: bsdf.prepared_for(from, light),
            normal,
            from,
            cos,
            etas,
            exchanges: None,
            is_tilted: false,
        };
        // Most points have no such lobe.
        let of = |lobe| Exchange::of(lobe, (normal, etas), from, cos.max(GRAZING));
        if lobes.iter().any(|lobe| of(lobe).applies_to(lobe)) {
            let mut all = [Exchange::NONE; MOST];
            for (exchange, lobe) in all.iter_mut().zip(lobes) {
                *exchange = of(lobe);
                this.is_tilted |= exchange.tilt.is_some() && !lobe.is_black() && !lobe.kind.is_delta();
            }
            this.exchanges = Some(all);
            if cos > 0.0 {
                this.cos = cos.max(GRAZING);
            }
        }
        this
    }

    /// For each of many unit directions `wi` that the light may leave to: the value times |cos| to the shading normal, still without the
    /// [`correction`](Self::correction), and the density per solid angle with which lobes choose it.
    #[inline(always)]
    pub fn eval_pdf_all<R: Real>(&self, wi: Vector<R>) -> (Vector<R>, R) {
        let Some(exchanges) = &self.exchanges else { return self.prepared.eval_pdf_all(wi) };
        let mut sum = Sum::new(Vector::all(wi.x, self.normal), wi);
        for (k, (lobe, exchange)) in self.prepared.lobes().zip(exchanges).enumerate() {
            sum.add_carried(k, &lobe.for_all(wi.x), wi, exchange);
        }
        (sum.value, sum.pdf)
    }

    /// The same of one direction; the density is that of [`sample`](Self::sample). `ng` is the unit geometric normal, on the side that the
    /// light came from.
    #[must_use]
    pub fn eval_pdf(&self, wi: Vec3, ng: Vec3) -> (Vec3, f32) {
        let (value, pdf) = self.eval_pdf_all(wi.into());
        (value.into(), self.mixed(pdf, wi, ng))
    }

    /// The factor of the values: shading normals and refraction treat light and importance differently
    /// \[Vea97\]. `ng` is the unit geometric normal, on either side. Zero for light from below the shading
    /// normal, where light samples bring nothing, either.
    #[must_use]
    pub fn correction(&self, wi: Vec3, ng: Vec3) -> Vec3 {
        let (so, si) = (self.cos, self.normal.dot(wi));
        let (go, gi) = (ng.dot(self.from), ng.dot(wi));
        if so <= 0.0 || si == 0.0 || go == 0.0 {
            return Vec3::ZERO;
        }
        let eta = if si < 0.0 { self.etas } else { Vec3::ONE };
        eta * eta * (so * gi / (go * si)).abs()
    }

    /// Chooses the next direction of the light; as [`Bsdf::sample`], except for the weight, which is
    /// corrected. `ng` as for [`eval_pdf`](Self::eval_pdf).
    #[must_use]
    pub fn sample(&self, mut u: [f32; 3], ng: Vec3) -> Option<BsdfSample> {
        let mut share = 1.0;
        if self.is_tilted {
            if u[0] < TO_ALL_SIDES {
                let wi = Basis::around(ng).to_world(cosine_hemisphere([u[1], u[2]])).normalize();
                return self.chosen(wi, ng, true);
            }
            share -= TO_ALL_SIDES;
            u[0] = ((u[0] - TO_ALL_SIDES) / share).min(0.999_999_9);
        }
        let mut sample = self.prepared.sample(u).of_point()?;
        if let Some(exchanges) = &self.exchanges {
            if !sample.delta {
                return self.chosen(sample.wi, ng, sample.wide);
            }
            let k = self.prepared.place_of(u[0]);
            let normal = self.prepared.lobes().nth(k).map_or(self.normal, |lobe| lobe.normal.into());
            let Exchange { tilt, through } = exchanges[k];
            let tilt =
                tilt.map_or(1.0, |tilt| (tilt * self.normal.dot(sample.wi) / normal.dot(sample.wi)).abs());
            sample.weight *= tilt / share;
            if sample.transmitted {
                sample.weight *= through;
            }
        }
        sample.weight *= self.correction(sample.wi, ng);
        Some(sample)
    }

    /// A chosen direction, by any strategy.
    fn chosen(&self, wi: Vec3, ng: Vec3, wide: bool) -> Option<BsdfSample> {
        let (value, pdf) = self.eval_pdf(wi, ng);
        let weight = value / pdf * self.correction(wi, ng);
        let transmitted = self.normal.dot(wi) < 0.0;
        let sample = BsdfSample { wi, weight, pdf, delta: false, transmitted, wide };
        (pdf > 0.0 && weight.is_finite()).then_some(sample)
    }

    /// The density of all strategies for `wi`, given that of the lobes.
    fn mixed(&self, by_lobes: f32, wi: Vec3, ng: Vec3) -> f32 {
        if !self.is_tilted {
            return by_lobes;
        }
        let by_cosine = ng.dot(wi).max(0.0) * std::f32::consts::FRAC_1_PI;
        by_lobes + (by_cosine - by_lobes) * TO_ALL_SIDES
    }

    /// Cosine to the shading normal of where the light came from, as the [`correction`](Self::correction) counts it.
    #[must_use]
    pub fn cos(&self) -> f32 {
        self.cos
    }
}
