// SPDX-License-Identifier: GPL-3.0-or-later
//! Lobes prepared for one direction: values common to all other directions are computed once, then
//! evaluations, densities and samples follow. Written once for one point and for sixteen.
//! Source: \[WMLT07\], \[Hei14\], \[DB23\] (microfacets); \[KC17\] (multiple scattering; a layer dims a
//! diffuse body in its reciprocal form); microfacets below layers lose the larger share of both directions.
//! \[VG95\] (one sample, all lobes).
//! Space: world, unit directions away from the surface.
//! Invariants: a direction is chosen with the density of [`Prepared::eval_pdf`]; one point and sixteen give
//! the same bits at every CPU level. Tests: `tests`.

use glam::Vec3;

use super::dispersed::Colours;
use super::energy::RULE;
use super::lobe::{Kind, Lobe, rare};
use super::lobes::MOST;
use super::lobes_at::LobesAt;
use super::prepared_lobe::PreparedLobe;
use super::prepared_sum::Sum;
use super::prepared_values::GRAZING;
use super::sample::BsdfSample;
use super::scalar_lobes;
use crate::real::{Real, Vector};
use crate::sampling::{cosine_hemisphere_of, frame_around};

/// Microfacets of a smaller width (GGX alpha) find by themselves most of what they reflect.
const GUIDABLE: f32 = 0.1;

/// A direction that was chosen for each point.
#[derive(Clone, Copy)]
pub struct Sampled<R: Real> {
    /// Unit, world.
    pub wi: Vector<R>,
    /// BSDF times |cos| over the density.
    pub weight: Vector<R>,
    /// Density per solid angle, all lobes counted; infinite where `delta`.
    pub pdf: R,
    /// Points at which no light sample meets it.
    pub delta: R::Mask,
    /// Points at which it leads through the surface.
    pub transmitted: R::Mask,
    /// Points at which a lobe chose it that sends light to all sides.
    pub wide: R::Mask,
    /// Points that chose one; others hold anything.
    pub found: R::Mask,
}

impl Sampled<f32> {
    /// That of one point, if there is one.
    pub(super) fn of_point(self) -> Option<BsdfSample> {
        let Self { wi, weight, pdf, delta, transmitted, wide, found } = self;
        found.then(|| BsdfSample { wi: wi.into(), weight: weight.into(), pdf, delta, transmitted, wide })
    }
}

/// Lobes of points, each seen from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Prepared<R> {
    pub(super) normal: Vector<R>,
    /// One after the other; the rest of the positions, which is most of them, is not even cleared.
    pub(super) lobes: [Option<PreparedLobe<R>>; MOST],
    /// Share of light that is scattered.
    pub(super) albedo: Vector<R>,
}

impl<R: Real> Prepared<R> {
    /// Nothing seen yet: memory for [`ClosureBatch::prepare`](super::ClosureBatch::prepare), which is large, so that it stays where it is.
    #[inline(always)]
    pub fn none(like: R) -> Self {
        let black = Vector::grey(like.all(0.0));
        // A constant array of `None` would be all zeros: 23 KB to write, where eight marks do.
        let lobes = std::array::from_fn(
            #[inline(always)]
            |_| None,
        );
        Self { normal: black, lobes, albedo: black }
    }

    /// Points' lobes, `count` positions of them, for the unit direction `wo`; `normal` is unit. `light` is
    /// the weight of the scattered light by colour: dispersive lobes choose colours by it. The receiver must
    /// be empty.
    #[inline(always)]
    pub(crate) fn prepare<'a>(
        &mut self,
        count: usize,
        at: impl Fn(usize) -> LobesAt<'a, R>,
        normal: Vector<R>,
        wo: Vector<R>,
        light: Vector<R>,
    ) {
        let (zero, one) = (wo.x.all(0.0), wo.x.all(1.0));
        self.normal = normal;
        let mut total = zero;
        for k in 0..count.min(MOST) {
            let from = at(k);
            let (above, rest) = self.lobes.split_at_mut(k);
            let lobe = rest[0].insert(PreparedLobe::none(zero));
            (lobe.kind, lobe.kinds) = (from.kind, from.kinds);
            let own = !from.normal.is_zero();
            lobe.normal = Vector::pick(own, from.normal, normal);
            let cos = lobe.normal.dot(wo);
            let lift = (one.all(GRAZING) - cos).or_more(zero);
            let raised = lift.above(zero);
            let lifted = (wo + lobe.normal * lift).normalize();
            lobe.wo = Vector::pick(raised, lifted, wo);
            lobe.cos = R::pick(raised, lobe.normal.dot(lifted), cos);
            (lobe.a, lobe.b, lobe.c) = (from.a, from.b, from.c);
            (lobe.alpha, lobe.eta) = (from.alpha, from.eta);
            if from.covers {
                lobe.cover = from.cover;
            }
            (lobe.covers, lobe.any_layer_above) = (from.covers, from.any_layer_above);
            (lobe.weight, lobe.left) = (from.weight, Vector::grey(one));
            lobe.rare = from.rare;
            if lobe.rare != 0 {
                lobe.rarities = from.rarities;
                lobe.rarities.tangent = along(lobe.normal, from.rarities.tangent);
                lobe.rarities.channels = Colours::chances(light * from.weight);
            }
            let albedo = zero.outline(
                #[inline(always)]
                || lobe.prepare(),
            );
            if lobe.any_layer_above != 0 {
                for (j, layers_above) in lobe.layers_above.iter_mut().enumerate() {
                    for (i, bits) in from.layers_above.iter().enumerate() {
                        *layers_above |= (bits >> j & 1) << i;
                    }
                }
                let (left, average) = zero.outline(
                    #[inline(always)]
                    || (left_by(above, lobe, None), left_on_average(above, lobe)),
                );
                let scattered = lobe.weight * left * albedo;
                lobe.probability = scattered.max_element();
                self.albedo = self.albedo + scattered;
                lobe.put_below(left, average);
            } else {
                lobe.probability = (lobe.weight * albedo).max_element();
                self.albedo = self.albedo + lobe.weight * albedo;
            }
            total = total + lobe.probability;
        }
        let scale = R::pick(total.above(zero), one / total, zero);
        for lobe in self.lobes.iter_mut().map_while(Option::as_mut) {
            lobe.probability = lobe.probability * scale;
        }
    }

    /// The lobes, in the order of their positions.
    #[inline(always)]
    pub(super) fn lobes(&self) -> impl Iterator<Item = &PreparedLobe<R>> {
        self.lobes.iter().map_while(Option::as_ref)
    }

    /// BSDF times |cos| of the unit `wi`, and the density per solid angle with which [`sample`](Self::sample) chooses it;
    /// delta lobes count nothing.
    #[inline(always)]
    pub fn eval_pdf(&self, wi: Vector<R>) -> (Vector<R>, R) {
        let mut sum = Sum::new(self.normal, wi);
        for (k, lobe) in self.lobes.iter().enumerate() {
            let Some(lobe) = lobe else { break };
            sum.add(k, lobe, wi);
        }
        (sum.value, sum.pdf)
    }

    /// Chooses where paths go on; `u` holds numbers in [0, 1), the first of which chooses between lobes.
    #[inline(always)]
    pub fn sample(&self, u: [R; 3]) -> Sampled<R> {
        let (zero, one) = (u[0].all(0.0), u[0].all(1.0));
        let Some(only) = &self.lobes[0] else {
            let (wi, weight, none) = (self.normal, Vector::grey(zero), zero.above(zero));
            return Sampled {
                wi,
                weight,
                pdf: zero,
                delta: none,
                transmitted: none,
                wide: none,
                found: none,
            };
        };
        // The lobe, and the number as a new one.
        let mut before = zero;
        let mut mixed;
        let lobe = if self.lobes[1].is_none() {
            only
        } else {
            mixed = *only;
            for next in self.lobes().skip(1) {
                let past = before + mixed.probability;
                let on = !past.above(u[0]) & next.probability.above(zero);
                // Lobes of probability zero are between others and take none of the numbers.
                before = R::pick(on, past, before);
                mixed.mix(on, next);
            }
            &mixed
        };
        let first = ((u[0] - before) / lobe.probability).within(0.0, 0.999_999_9);
        let [mut tangent, mut bitangent] = frame_around(lobe.normal);
        if lobe.rare & rare::ANISOTROPY != 0 {
            let is = lobe.rarities.across.above_all(0.0);
            tangent = Vector::pick(is, lobe.rarities.tangent, tangent);
            bitangent = Vector::pick(is, lobe.normal.cross(tangent), bitangent);
        }
        let wo = Vector::new(tangent.dot(lobe.wo), bitangent.dot(lobe.wo), lobe.cos);
        let cosine = cosine_hemisphere_of([u[1], u[2]]);
        let mut wi = cosine;
        let mut found = lobe.probability.above(zero);
        if lobe.has(Kind::Microfacets) || lobe.has(Kind::Metal) {
            let is = (lobe.is(Kind::Microfacets) | lobe.is(Kind::Metal)) & !lobe.share_of_more.above(first);
            let h = lobe.slopes().sample_visible(wo, [u[1], u[2]]);
            wi = Vector::pick(is, h * (wo.dot(h) * 2.0) - wo, wi);
        }
        if lobe.has(Kind::Translucent) {
            let below = Vector::new(cosine.x, cosine.y, -cosine.z);
            wi = Vector::pick(lobe.is(Kind::Translucent), below, wi);
        }
        let mut through_is_fine = lobe.is(Kind::Translucent);
        for (kind, thin) in [(Kind::Glass, false), (Kind::Pane, true)] {
            if lobe.has(kind) {
                let (chosen, some) = lobe.sample_glass(thin, wo, [first, u[1], u[2]], cosine);
                let is = lobe.is(kind);
                wi = Vector::pick(is, chosen, wi);
                found = found & (some | !is);
                through_is_fine = through_is_fine | is;
            }
        }
        if lobe.kinds & scalar_lobes::KINDS != 0 {
            let is = lobe.is_scalar();
            let chosen = lobe.sample_scalar(is, wo, [first, u[1], u[2]], cosine);
            wi = Vector::pick(is, chosen, wi);
            found = found & !(is & chosen.is_zero());
            through_is_fine = through_is_fine | is;
        }
        let mut delta = one.above(one);
        let mut weight = Vector::grey(zero);
        if lobe.kinds & Kind::DELTAS != 0 {
            let glass = lobe.is(Kind::SmoothGlass) | lobe.is(Kind::SmoothPane);
            delta = glass;
            for kind in [Kind::Mirror, Kind::SmoothFacets, Kind::SmoothMetal] {
                delta = delta | lobe.is(kind);
            }
            let (branches, share) = lobe.branches(wo);
            let mirrors = !glass | share.above(first);
            let probability = R::pick(glass, R::pick(mirrors, share, share.rest()), one);
            let [(mirrored, light_mirrored), (through, light_through)] = branches;
            let light = Vector::pick(mirrors, light_mirrored, light_through);
            wi = Vector::pick(delta, Vector::pick(mirrors, mirrored, through), wi);
            weight =
                (light * lobe.weight * lobe.left.min(Vector::grey(one))).over(probability * lobe.probability);
            if lobe.rare & rare::SPREAD != 0 {
                let is = delta & glass & lobe.rarities.spread.above_all(0.0) & lobe.probability.above(zero);
                let (directions, lights) = lobe.branch_by_colour(is, wo, first);
                wi = Vector::pick(is, directions, wi);
                let lights = (lights * lobe.weight * lobe.left.min(Vector::grey(one))).over(lobe.probability);
                weight = Vector::pick(is, lights, weight);
            }
            through_is_fine = through_is_fine | (delta & glass);
        }
        found = found & (wi.z.above(zero) | through_is_fine);
        let wi = (tangent * wi.x + bitangent * wi.y + lobe.normal * wi.z).normalize();
        let mut pdf = one.all(f32::INFINITY);
        if R::bits(found & !delta) != 0 {
            let (value, density) = self.eval_pdf(wi);
            weight = Vector::pick(delta, weight, value.over(density));
            pdf = R::pick(delta, pdf, density);
        }
        let transmitted = zero.above(self.normal.dot(wi));
        found = found & pdf.above(zero) & weight.is_finite() & wi.is_finite();
        let fibres = lobe.is(Kind::Sheen) | lobe.is(Kind::Fibres);
        let wide = lobe.is(Kind::Diffuse) | lobe.is(Kind::Translucent) | fibres;
        Sampled { wi, weight, pdf, delta, transmitted, wide, found }
    }

    /// Points with a lobe of a kind for which `what` is true.
    #[inline(always)]
    fn any(&self, what: impl Fn(Kind) -> bool) -> R::Mask {
        let zero = self.normal.x.all(0.0);
        let mut any = zero.above(zero);
        for lobe in self.lobes() {
            for kind in Kind::ALL {
                if lobe.has(kind) && what(kind) {
                    any = any | (lobe.is(kind) & !lobe.weight.is_zero());
                }
            }
        }
        any
    }

    /// Points at which light samples can bring anything: some lobe is not a delta.
    #[inline(always)]
    pub fn is_smooth(&self) -> R::Mask {
        self.any(
            #[inline(always)]
            |kind| kind != Kind::None && !kind.is_delta(),
        )
    }

    /// Points at which light samples from behind can, too.
    #[inline(always)]
    pub fn is_translucent(&self) -> R::Mask {
        self.any(
            #[inline(always)]
            |kind| kind.goes_through() && !kind.is_delta(),
        )
    }

    /// The chance that a direction is drawn from a lobe wide enough to be worth guiding: one that sends light to all sides, or
    /// rough microfacets.
    #[inline(always)]
    pub fn guidable(&self) -> R {
        let mut sum = self.normal.x.all(0.0);
        let no = sum.above(sum);
        for lobe in self.lobes() {
            let mut is = no;
            for kind in Kind::ALL {
                if lobe.has(kind) && kind.is_wide() {
                    is = is | lobe.is(kind);
                } else if lobe.has(kind) && matches!(kind, Kind::Microfacets | Kind::Metal) {
                    is = is | (lobe.is(kind) & lobe.alpha.above_all(GUIDABLE));
                }
            }
            sum = sum + R::pick(is, lobe.probability, sum.all(0.0));
        }
        sum
    }

    /// Points with a lobe that sends light to all sides.
    #[inline(always)]
    pub fn is_wide(&self) -> R::Mask {
        self.any(
            #[inline(always)]
            |kind| kind.is_wide(),
        )
    }

    /// Shading normals.
    #[inline(always)]
    pub fn normal(&self) -> Vector<R> {
        self.normal
    }

    /// Share of light that is scattered to all sides, in [0, 1]; about, where no closed form is known.
    #[inline(always)]
    pub fn albedo(&self) -> Vector<R> {
        self.albedo
    }
}

/// The light that the lobes above `lobe` leave, for the prepared direction or for one cosine.
#[inline(always)]
fn left_by<R: Real>(
    above: &[Option<PreparedLobe<R>>],
    lobe: &PreparedLobe<R>,
    towards: Option<f32>,
) -> Vector<R> {
    let one = lobe.cos.all(1.0);
    let mut left = Vector::grey(one);
    for (j, top) in above.iter().flatten().enumerate() {
        if lobe.any_layer_above >> j & 1 != 0 {
            let (w, cos) = towards.map_or((Some(top.wo), top.cos), |cos| (None, one.all(cos)));
            let back = top.sent_back(cos, top.split(w, cos));
            left = Vector::pick(lobe.below(j), left * back.rest(), left);
        }
    }
    left
}

/// The same, averaged over a cosine-weighted hemisphere: by the tables if one layer of microfacets is above.
#[inline(always)]
fn left_on_average<R: Real>(above: &[Option<PreparedLobe<R>>], lobe: &PreparedLobe<R>) -> Vector<R> {
    let one = lobe.cos.all(1.0);
    let (mut any, mut twice) = (0, 0);
    for &layers_above in &lobe.layers_above {
        twice |= any & layers_above;
        any |= layers_above;
    }
    let mut average = Vector::grey(one);
    let mut rest = u64::from(any);
    for (j, top) in above.iter().flatten().enumerate() {
        let single = lobe.layers_above[j] & !twice;
        // The table holds Schlick's reflectances without films.
        if single != 0 && top.has(Kind::Microfacets) {
            let mut by_table = one.points(u64::from(single)) & top.is(Kind::Microfacets);
            if top.rare & rare::FILM != 0 {
                by_table = by_table & !top.rarities.film[0].above_all(0.0);
            }
            if top.rare & rare::SCALED != 0 {
                by_table = by_table & !top.is_scaled();
            }
            let left = top.sent_back(one, top.slopes().energy().average).rest();
            average = Vector::pick(by_table, left, average);
            rest &= !R::bits(by_table);
        }
    }
    if rest != 0 {
        let mut sum = Vector::grey(one.all(0.0));
        for (cos, weight) in RULE {
            sum = sum + left_by(above, lobe, Some(cos)) * one.all(weight);
        }
        average = Vector::pick(one.points(rest), sum, average);
    }
    average
}

/// `tangent` made perpendicular to the unit `normal`, unit; any direction along the surface if it is zero.
#[inline(always)]
fn along<R: Real>(normal: Vector<R>, tangent: Vector<R>) -> Vector<R> {
    let flat = tangent - normal * normal.dot(tangent);
    let [any, _] = frame_around(normal);
    let good = flat.length_squared().above_all(1e-8);
    Vector::pick(good, flat.normalize_or(any), any)
}

impl Prepared<f32> {
    /// One point's lobes; `light` as for [`Prepared::prepare`].
    pub(super) fn of_point(lobes: &[Lobe], normal: Vec3, wo: Vec3, light: Vec3) -> Self {
        let mut prepared = Self::none(0.0);
        let at = |k: usize| LobesAt::of_point(&lobes[k]);
        prepared.prepare(lobes.len(), at, normal.into(), wo.into(), light.into());
        prepared
    }

    /// The share that lobes which send light to all sides have in the value for the unit direction `wi`, by colour;
    /// 0 where the value is.
    pub(super) fn wide_share(&self, wi: Vec3) -> Vec3 {
        let (wi, mut wide) = (wi.into(), Vec3::ZERO);
        let mut sum = Sum::new(self.normal, wi);
        for (k, lobe) in self.lobes().enumerate() {
            let before = Vec3::from(sum.value);
            sum.add(k, lobe, wi);
            if Kind::ALL.get(lobe.kind as usize).is_some_and(|kind| kind.is_wide()) {
                wide += Vec3::from(sum.value) - before;
            }
        }
        let share = |k: usize| if wide[k] > 0.0 { (wide[k] / sum.value.get(0)[k]).min(1.0) } else { 0.0 };
        Vec3::new(share(0), share(1), share(2))
    }

    /// The weight of lobe `k`, and the light that the layers above it leave for the prepared direction.
    pub(super) fn reaching(&self, k: usize, weight: Vec3) -> Vec3 {
        let (above, rest) = self.lobes.split_at(k);
        let lobe = rest[0].as_ref();
        lobe.map_or(Vec3::ZERO, |lobe| weight * Vec3::from(left_by(above, lobe, None)))
    }

    /// The position of the lobe that [`sample`](Self::sample) draws from by this number.
    pub(super) fn place_of(&self, u: f32) -> usize {
        let (mut before, mut entry, mut probability) = (0.0, 0, 0.0);
        for (k, next) in self.lobes().enumerate() {
            if k == 0 || (before + probability <= u && next.probability > 0.0) {
                (before, entry, probability) = (before + probability, k, next.probability);
            }
        }
        entry
    }

    /// Delta lobes, reflected and transmitted: unit directions in the world, and shares of the light. Two
    /// refractions of one point differ in direction if their indices do: the stronger one represents both.
    pub(super) fn delta_branches(&self) -> [Option<(Vec3, Vec3)>; 2] {
        let mut out: [Option<(Vec3, Vec3)>; 2] = [None; 2];
        for lobe in self.lobes() {
            if lobe.kinds & Kind::DELTAS == 0 {
                continue;
            }
            let [tangent, bitangent] = frame_around(lobe.normal);
            let wo = Vector::new(tangent.dot(lobe.wo), bitangent.dot(lobe.wo), lobe.cos);
            let (branches, _) = lobe.branches(wo);
            for (out, (wi, light)) in out.iter_mut().zip(branches) {
                let light = Vec3::from(light * lobe.weight * lobe.left);
                if light == Vec3::ZERO {
                    continue;
                }
                let wi = Vec3::from((tangent * wi.x + bitangent * wi.y + lobe.normal * wi.z).normalize());
                *out = Some(match *out {
                    Some((other, before)) if before.element_sum() >= light.element_sum() => {
                        (other, before + light)
                    }
                    Some((_, before)) => (wi, before + light),
                    None => (wi, light),
                });
            }
        }
        out
    }
}
