// SPDX-License-Identifier: GPL-3.0-or-later
//! Value and density of the lobes of points, lobe by lobe, dimmed by the layers above.
//! Space: world, unit directions away from the surface. Tests: `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;

use super::exchange::Exchange;
use super::lobe::{Kind, rare};
use super::lobes::MOST;
use super::prepared_lobe::PreparedLobe;
use super::prepared_values::GRAZING;
use crate::real::{Real, Vector};

/// Value and density of the lobes of points, one lobe after the other, no more than [`MOST`]. Loops pass
/// references: lobes moved through iterators would go through memory.
pub(super) struct Sum<R: Real> {
    pub(super) value: Vector<R>,
    pub(super) pdf: R,
    /// Cosine to the points' normals, and points whose front is lit.
    cos: R,
    above: R::Mask,
    /// The light that layers above each leave.
    left: [Option<Vector<R>>; MOST],
}

impl<R: Real> Sum<R> {
    /// Of no lobe, at points with these normals, for the unit `wi`.
    #[inline(always)]
    pub(super) fn new(normal: Vector<R>, wi: Vector<R>) -> Self {
        let zero = wi.x.all(0.0);
        let cos = normal.dot(wi);
        let above = cos.above(zero);
        Self { value: Vector::grey(zero), pdf: zero, cos, above, left: [const { None }; MOST] }
    }

    /// Adds lobe `k`; those before were added before.
    #[inline(always)]
    pub(super) fn add(&mut self, k: usize, lobe: &PreparedLobe<R>, wi: Vector<R>) {
        let (light, density, weight) = self.of(k, lobe, wi, lobe.normal.dot(wi));
        self.value = self.value + light * weight;
        self.pdf = self.pdf + density * lobe.probability;
    }

    /// The same for a path that carries light and leaves to `wi`. The value is that of a path from there, in
    /// the measure of the points' normals, as if all lobes had those and refracted like the first that does.
    #[inline(always)]
    pub(super) fn add_carried(
        &mut self,
        k: usize,
        lobe: &PreparedLobe<R>,
        wi: Vector<R>,
        exchange: &Exchange,
    ) {
        let (mut way, mut i) = (wi, lobe.normal.dot(wi));
        let (zero, mut factor) = (i.all(0.0), i.all(1.0));
        let mut chosen = i.is(i);
        if let Some(tilt) = exchange.tilt {
            // Raised to where it sees the side of the lobe that it is on, as views are; a lobe sends no path there.
            let own = R::pick(self.above, i, -i);
            let lift = (i.all(GRAZING) - own).or_more(zero);
            let raised = lift.above(zero);
            let up = R::pick(self.above, lift, -lift);
            way = Vector::pick(raised, (wi + lobe.normal * up).normalize(), wi);
            i = R::pick(raised, lobe.normal.dot(way), i);
            factor = self.cos.size() * tilt / i.size();
            chosen = own.above(zero);
        }
        let (mut light, density, weight) = self.of(k, lobe, way, i);
        if lobe.rare & rare::SCALED != 0 {
            let own = R::pick(self.above, i, -i);
            let cos = R::pick(own.above_all(0.0), i.size(), i.all(GRAZING));
            light = light * lobe.rescaled(way, cos);
        }
        if lobe.has(Kind::Fibres) {
            let back = lobe.fibres_from(self.above & lobe.is(Kind::Fibres), way, i);
            light = Vector::pick(lobe.is(Kind::Fibres), Vector::grey(back), light);
        }
        let through = Vector::all(zero, exchange.through);
        let light = Vector::pick(self.above, light, light * through);
        self.value = self.value + light * weight * factor;
        self.pdf = self.pdf + R::pick(chosen, density, zero) * lobe.probability;
    }

    /// Value and density of lobe `k` for `wi` at the cosine `i`, and the factor of the value. Out of line: it is most of the
    /// evaluation of lobes, and every integrator has several.
    #[inline(always)]
    fn of(&mut self, k: usize, lobe: &PreparedLobe<R>, wi: Vector<R>, i: R) -> (Vector<R>, R, Vector<R>) {
        i.outline(
            #[inline(always)]
            || self.of_inline(k, lobe, wi, i),
        )
    }

    #[inline(always)]
    fn of_inline(
        &mut self,
        k: usize,
        lobe: &PreparedLobe<R>,
        wi: Vector<R>,
        i: R,
    ) -> (Vector<R>, R, Vector<R>) {
        // Behind a normal of the lobe's own light counts as grazing, as views do.
        let own = R::pick(self.above, i, -i);
        let cos = R::pick(own.above_all(0.0), i.size(), i.all(GRAZING));
        let split = lobe.split(Some(wi), cos);
        if lobe.covers {
            self.left[k] = Some(lobe.sent_back(cos, split).rest());
        }
        let (light, density) = lobe.eval_pdf(wi, i, self.above, split);
        let mut weight = lobe.weight;
        if lobe.any_layer_above != 0 {
            let mut rest = Vector::grey(i.all(1.0));
            for (j, left) in self.left.iter().enumerate() {
                if let Some(left) = left.filter(|_| lobe.any_layer_above >> j & 1 != 0) {
                    rest = Vector::pick(lobe.below(j), rest * left, rest);
                }
            }
            weight = weight * rest.min(lobe.left);
        }
        (light, density, weight)
    }

    /// The same with the same bits, faster, for a lobe that is nothing or Lambert's reflector, neither above nor below another one: most
    /// surfaces are so.
    #[inline(always)]
    pub(super) fn add_plain(&mut self, lobe: &PreparedLobe<R>, wi: Vector<R>) {
        let i = lobe.normal.dot(wi);
        let zero = i.all(0.0);
        let is = self.above & i.above(zero) & lobe.is(Kind::Diffuse);
        let by_cosine = R::pick(is, i.or_more(i.all(1e-20)) * FRAC_1_PI, zero);
        self.value = self.value + lobe.a * by_cosine * lobe.weight;
        self.pdf = self.pdf + by_cosine * lobe.probability;
    }
}
