// SPDX-License-Identifier: GPL-3.0-or-later
//! Directions by the map or by lobes or phase functions: one sample of both, at as many points at a time as the CPU's registers hold.
//! Source: [VG95] (one-sample model), [MGN17] section 3.3.
//! Space: world. Invariant: [`Mixture::pdf`] is the density with which [`Mixture::sample`] chooses; deltas are chosen by lobes
//! alone. Tests: crates/render/tests/{guide,lanes}.rs.

use glam::Vec3;
use gnurt_shading::bsdf::{Prepared, Sampled};
use gnurt_shading::lanes::{LANES, LanesOf};
use gnurt_shading::phase::Phase;
use gnurt_shading::real::{Real, Vector};

use super::space::Guide;
use crate::space_tree::{IN_MEDIUM, class_of};

/// The guide at some points.
pub(crate) struct Mixture<'a, R: Real> {
    guide: &'a Guide,
    roots: [u32; LANES],
    /// The share of directions that it chooses; 0 where it does not guide.
    share: R,
    /// The share of lobes that can be guided.
    pub(crate) guidable: R,
}

impl<'a, R: Real> Mixture<'a, R> {
    /// That of points at `p` with these normals, for those in the mask.
    #[inline(always)]
    pub(crate) fn new(
        guide: &'a Guide,
        there: R::Mask,
        [p, ns]: [Vector<R>; 2],
        prepared: &Prepared<R>,
    ) -> Self {
        let guidable = prepared.guidable();
        Self::of_cells(
            guide,
            there,
            guidable,
            #[inline(always)]
            |i| (p.get(i), class_of(ns.get(i))),
        )
    }

    /// That of points in media at `p`, for those in the mask.
    #[inline(always)]
    pub(crate) fn in_media(guide: &'a Guide, there: R::Mask, p: Vector<R>) -> Self {
        Self::of_cells(
            guide,
            there,
            p.x.all(1.0),
            #[inline(always)]
            |i| (p.get(i), IN_MEDIUM),
        )
    }

    #[inline(always)]
    fn of_cells(guide: &'a Guide, there: R::Mask, guidable: R, point: impl Fn(usize) -> (Vec3, u8)) -> Self {
        let zero = guidable.all(0.0);
        let mut roots = [u32::MAX; LANES];
        let mut shares = [0.0; LANES];
        for i in LanesOf(R::bits(there & guidable.above(zero))) {
            let (p, class) = point(i);
            if let Some(cell) = guide.cell(p, class) {
                (roots[i], shares[i]) = (cell.root, cell.share);
            }
        }
        Self { guide, roots, share: guidable * zero.load(&shares, 0), guidable }
    }

    /// The density of a unit direction that lobes choose with density `of_lobes`, at points in the mask; `of_lobes` at others.
    #[inline(always)]
    pub(crate) fn pdf(&self, requests: R::Mask, wi: Vector<R>, of_lobes: R) -> R {
        let is = self.share.above_all(0.0) & requests;
        if !R::any(is) {
            return of_lobes;
        }
        let [of_guide] = of_lobes.each_where(
            is,
            #[inline(always)]
            |i| [self.guide.pdf(self.roots[i], wi.get(i))],
        );
        R::pick(is, of_lobes * self.share.rest() + of_guide * self.share, of_lobes)
    }

    /// Points whose directions the guide chooses, by a number in [0, 1), and those where it could; and the number that is left for the rest.
    #[inline(always)]
    fn choose(&self, choice: R) -> ([R::Mask; 2], R) {
        let (by_guide, is) = (self.share.above(choice), self.share.above_all(0.0));
        let rest = ((choice - self.share) / self.share.rest()).within(0.0, 0.999_999_9);
        ([by_guide, is], R::pick(is, rest, choice))
    }

    /// Directions of the guide at the points in the mask.
    #[inline(always)]
    fn of_guide(&self, by_guide: R::Mask, [x, y]: [R; 2]) -> Vector<R> {
        let [dx, dy, dz] = x.each_where(
            by_guide,
            #[inline(always)]
            |i| self.guide.sample(self.roots[i], [x.lane(i), y.lane(i)]).into(),
        );
        Vector::new(dx, dy, dz)
    }

    /// Chooses where paths go on; numbers as for [`Prepared::sample`]. Returns the density of the lobes alone as well.
    #[inline(always)]
    pub(crate) fn sample(&self, prepared: &Prepared<R>, [choice, x, y]: [R; 3]) -> (Sampled<R>, R) {
        let zero = choice.all(0.0);
        let ([by_guide, is], rest) = self.choose(choice);
        let mut chosen = prepared.sample([rest, x, y]);
        if !R::any(is) {
            return (chosen, chosen.pdf);
        }
        let mut of_lobes = chosen.pdf;
        let mut value = chosen.weight * R::pick(chosen.delta, zero, chosen.pdf);
        if R::any(by_guide) {
            let wi = Vector::pick(by_guide, self.of_guide(by_guide, [x, y]), chosen.wi);
            let (seen, density) = prepared.eval_pdf(wi);
            value = Vector::pick(by_guide, seen, value);
            of_lobes = R::pick(by_guide, density, of_lobes);
            chosen.wi = wi;
            chosen.delta = chosen.delta & !by_guide;
            chosen.transmitted =
                (by_guide & zero.above(prepared.normal().dot(wi))) | (chosen.transmitted & !by_guide);
            chosen.wide = chosen.wide | (by_guide & prepared.is_wide());
            chosen.found = chosen.found | by_guide;
        }
        // Where lobes chose a delta, the guide could not have.
        let mixed = is & !chosen.delta;
        let pdf = R::pick(mixed, self.pdf(mixed, chosen.wi, R::pick(mixed, of_lobes, zero)), chosen.pdf);
        let weight = Vector::pick(mixed, value.over(pdf), chosen.weight);
        let weight = Vector::pick(is & chosen.delta, weight.over(self.share.rest()), weight);
        chosen.found = chosen.found & (pdf.above(zero) | chosen.delta) & weight.is_finite();
        (Sampled { weight, pdf, ..chosen }, of_lobes)
    }

    /// Chooses where light that travels along the unit direction `along` goes on in media; numbers as for [`Phase::sample`]. Returns
    /// the direction, its density, and that by the phase function alone, which is its value.
    #[inline(always)]
    pub(crate) fn sample_phase(
        &self,
        phase: &Phase<R>,
        along: Vector<R>,
        [choice, x, y]: [R; 3],
    ) -> (Vector<R>, R, R) {
        let ([by_guide, is], rest) = self.choose(choice);
        let (mut dir, mut value) = phase.sample(along, [rest, x, y]);
        if R::any(by_guide) {
            dir = Vector::pick(by_guide, self.of_guide(by_guide, [x, y]), dir);
            value = R::pick(by_guide, phase.value(along.dot(dir)), value);
        }
        (dir, self.pdf(is, dir, value), value)
    }

    /// How much more often than by lobes alone a direction of these densities is chosen, times that of the paths before: what roulette
    /// spares paths by.
    #[inline(always)]
    pub(crate) fn spared(before: R, [pdf, of_lobes]: [R; 2], known: R::Mask) -> R {
        let one = before.all(1.0);
        let known = known & of_lobes.above(before.all(0.0));
        let ratio = R::pick(known, pdf / R::pick(known, of_lobes, one), one);
        (before * ratio).within(0.01, 1e4)
    }
}
