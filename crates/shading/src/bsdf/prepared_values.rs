// SPDX-License-Identifier: GPL-3.0-or-later
//! One lobe of each of many points, prepared for one direction each: values that depend on the view, albedo,
//! evaluations and densities.
//! Source: \[WMLT07\], \[Hei14\] (microfacets); \[KC17\] (further bounces); \[PJH23\] chapter 9. Space:
//! world, unit directions away from the surface. Invariant: one point and sixteen give the same bits at every
//! CPU level. Tests: `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::diffuse_once::Model;
use super::energy::lost;
use super::film::{self, Base, Film};
use super::lobe::{Kind, SCHLICK, rare};
use super::prepared_lobe::PreparedLobe;
use super::scalar_lobes;
use super::{fresnel, oren_nayar, sheen};
use crate::real::{Real, Vector};

/// Kinds of glass.
const GLASS: u32 = Kind::Glass.bit() | Kind::Pane.bit() | Kind::SmoothGlass.bit() | Kind::SmoothPane.bit();

/// Cosine: a `wo` nearer to the shading normal's horizon than this, or below it, counts as that near.
pub const GRAZING: f32 = 1e-3;

impl<R: Real> PreparedLobe<R> {
    /// Reflectance of microfacets at the cosine `cos`: `bare`, or with a film.
    #[inline(always)]
    fn filmed(&self, cos: R, bare: Vector<R>) -> Vector<R> {
        if self.rare & rare::FILM == 0 {
            return bare;
        }
        cos.outline(
            #[inline(always)]
            || {
                let [share, ior, thickness] = self.rarities.film;
                let metal = R::bits(self.is_metal());
                bare.each_colour(
                    share.above_all(0.0),
                    #[inline(always)]
                    |i, bare| {
                        let film =
                            Film { share: share.lane(i), ior: ior.lane(i), thickness: thickness.lane(i) };
                        let base = if metal >> i & 1 != 0 {
                            Base::Metal(self.a.get(i), self.b.get(i))
                        } else {
                            Base::Normal(self.a.get(i))
                        };
                        bare.lerp(film::reflectance(film, cos.lane(i), base), film.share)
                    },
                )
            },
        )
    }

    /// How far reflectances have risen where Schlick's have by `five`.
    #[inline(always)]
    fn risen(&self, five: R) -> R {
        five.each(
            #[inline(always)]
            |i| {
                let (five, eta) = (five.lane(i), self.eta.lane(i));
                if eta < 0.0 { five.max(0.0).powf(-eta / SCHLICK) } else { five }
            },
        )
    }

    /// Reflectance of microfacets, averaged over a cosine-weighted hemisphere, without a film.
    #[inline(always)]
    fn mirrored_on_average(&self) -> Vector<R> {
        let schlick = fresnel::schlick_average(self.a, self.b);
        if self.rare & rare::POWER == 0 {
            return schlick;
        }
        let rise = self.eta.each(
            #[inline(always)]
            |i| {
                let eta = self.eta.lane(i);
                let power = if eta < 0.0 { -eta } else { SCHLICK };
                2.0 / ((power + 1.0) * (power + 2.0))
            },
        );
        Vector::pick(self.is_risen(), self.a * rise.rest() + self.b * rise, schlick)
    }

    /// Microfacets whose reflectances rise by another power than Schlick's.
    #[inline(always)]
    fn is_risen(&self) -> R::Mask {
        self.eta.all(0.0).above(self.eta) & self.is(Kind::Microfacets)
    }

    /// Reflectance of microfacets, averaged over a cosine-weighted hemisphere.
    #[inline(always)]
    fn average(&self) -> Vector<R> {
        let average = Vector::pick(self.is(Kind::Metal), self.c, self.mirrored_on_average());
        if self.rare & rare::FILM == 0 {
            return average;
        }
        Vector::pick(self.rarities.film[0].above_all(0.0), self.c, average)
    }

    /// Microfacets whose light of further bounces is in their lobe, or lost.
    #[inline(always)]
    pub(super) fn is_scaled(&self) -> R::Mask {
        let none = self.cos.all(0.0);
        none.above(self.rarities.spread) & (self.is(Kind::Microfacets) | self.is(Kind::Metal))
    }

    /// The factor of those for a view at the cosine `cos` with this albedo of white microfacets.
    #[inline(always)]
    fn scale(&self, split: [R; 2], cos: R) -> Vector<R> {
        let one = self.cos.all(1.0);
        let white = split[0] + split[1];
        let again = lost(split) / white.or_more(one.all(1e-6));
        let kept = self.rarities.spread.above_all(-1.5);
        let plain = self.slopes().energy().more_per_bounce(self.average())
            * R::pick(kept, again, one.all(0.0))
            + Vector::grey(one);
        let seen = self.is_seen();
        if R::bits(seen) == 0 {
            return plain;
        }
        let mean = self.once(cos, split).over(white.or_more(one.all(1e-6)));
        let mean = Vector::pick(self.is(Kind::Metal), self.c, mean);
        Vector::pick(seen, mean * self.again(cos) + Vector::grey(one), plain)
    }

    /// Microfacets of [`BetweenFacets::Seen`](super::BetweenFacets::Seen); they are scaled ones.
    #[inline(always)]
    fn is_seen(&self) -> R::Mask {
        self.cos.all(-2.5).above(self.rarities.spread) & self.is_scaled()
    }

    /// Light of those that meets further facets, over light that does not, for white even ones at the cosine `cos`.
    #[inline(always)]
    fn again(&self, cos: R) -> R {
        let even = self.slopes().even().split(cos);
        lost(even) / (even[0] + even[1]).or_more(cos.all(1e-6))
    }

    /// Metals by their complex index, rough or smooth.
    #[inline(always)]
    fn is_metal(&self) -> R::Mask {
        self.is(Kind::Metal) | self.is(Kind::SmoothMetal)
    }

    /// Lobes that mirror in one direction and let nothing through; and the share of light that they do.
    #[inline(always)]
    pub(super) fn mirrors(&self, cos: R) -> (R::Mask, Vector<R>) {
        let (mut is, mut share) = (self.is(Kind::Mirror), self.a);
        if self.has(Kind::SmoothFacets) || self.has(Kind::SmoothMetal) {
            let smooth = self.is(Kind::SmoothFacets) | self.is(Kind::SmoothMetal);
            share = Vector::pick(smooth, self.mirrored_by_facet(cos), share);
            is = is | smooth;
        }
        (is, share)
    }

    /// Reflectance of a microfacet at the cosine `cos_h`.
    #[inline(always)]
    fn mirrored_by_facet(&self, cos_h: R) -> Vector<R> {
        let mut rise = fresnel::schlick_rise(cos_h);
        if self.rare & rare::POWER != 0 {
            rise = cos_h.outline(
                #[inline(always)]
                || self.risen(rise),
            );
        }
        let mut reflectance = self.a + (self.b - self.a) * rise;
        if self.has(Kind::Metal) || self.has(Kind::SmoothMetal) {
            let metal = self.a.with(
                self.b,
                #[inline(always)]
                |eta, k| fresnel::conductor(cos_h, eta, k),
            );
            reflectance = Vector::pick(self.is_metal(), metal, reflectance);
        }
        self.filmed(cos_h, reflectance)
    }

    /// The factor of values for a path that carries light and leaves to `wi` at the cosine `cos` > 0: the scale is that of the view.
    #[inline(always)]
    pub(super) fn rescaled(&self, wi: Vector<R>, cos: R) -> Vector<R> {
        let one = Vector::grey(self.cos.all(1.0));
        let other = self.scale(self.split(Some(wi), cos), cos).with(
            self.more,
            #[inline(always)]
            |there, here| there / here,
        );
        let mut factor = Vector::pick(self.is_scaled(), other, one);
        let seen = self.is_seen();
        if R::bits(seen) != 0 {
            let met = self.mirrored_by_facet(self.wo.dot((self.wo + wi).normalize()));
            let there = met * self.again(cos) + one;
            let here = met * self.more + one;
            let of_facet = there.with(
                here,
                #[inline(always)]
                |there, here| there / here,
            );
            factor = Vector::pick(seen, of_facet, factor);
        }
        factor
    }

    /// Approximate albedo of single scattering at the cosine `cos`, if white light loses `lost`; exact
    /// without a film, and for Schlick's reflectances.
    #[inline(always)]
    fn once(&self, cos: R, split: [R; 2]) -> Vector<R> {
        let mut schlick = self.a * split[0] + self.b * split[1];
        if self.rare & rare::POWER != 0 {
            let white = split[0] + split[1];
            let rise = self.risen(split[1] / white.or_more(cos.all(1e-6)));
            let other = (self.a * rise.rest() + self.b * rise) * white;
            schlick = Vector::pick(self.is_risen(), other, schlick);
        }
        if self.rare & rare::FILM == 0 {
            return schlick;
        }
        cos.outline(
            #[inline(always)]
            || {
                let share = self.rarities.film[0];
                // The mean visible microfacet, from the table's mean of Schlick's curve.
                let rise = split[1] / (split[0] + split[1]).or_more(cos.all(1e-6));
                let blurred = cos.each(
                    #[inline(always)]
                    |i| 1.0 - rise.lane(i).clamp(0.0, 1.0).powf(0.2),
                );
                let black = Vector::grey(cos.all(0.0));
                let filmed_base = self.filmed(blurred, black).over(share.or_more(cos.all(1e-6)));
                let filmed_base = filmed_base * (split[0] + split[1]);
                let mixed = schlick * share.rest() + filmed_base * share;
                Vector::pick(share.above_all(0.0), mixed, schlick)
            },
        )
    }

    /// Computes the values that depend on the view; returns the share of scattered light, without the lobe's
    /// weight.
    #[inline(always)]
    pub(super) fn prepare(&mut self) -> Vector<R> {
        let (zero, one) = (self.cos.all(0.0), self.cos.all(1.0));
        let mut albedo = Vector::grey(zero);
        if self.has(Kind::Diffuse) {
            let is = self.is(Kind::Diffuse);
            let smooth = self.alpha.is(zero);
            let mut white = one;
            if R::bits(is & !smooth) != 0 {
                white = R::pick(smooth, one, oren_nayar::white_once(self.alpha, self.cos));
            }
            let rough = oren_nayar::albedo(self.a, self.alpha, white);
            // The albedo of single scattering takes the place of the loss.
            self.lost = R::pick(is, white, self.lost);
            albedo = Vector::pick(is, Vector::pick(smooth, self.a, rough), albedo);
            let once = is & self.loses_light();
            if R::bits(once) != 0 {
                albedo = Vector::pick(once, self.a * self.white_once(None, self.cos), albedo);
            }
        }
        if self.has(Kind::Microfacets) || self.has(Kind::Metal) {
            let metal = self.is(Kind::Metal);
            let is = self.is(Kind::Microfacets) | metal;
            let slopes = self.slopes();
            let energy = slopes.energy();
            let split = slopes.split(Some(self.wo), self.cos);
            let lost_here = lost(split);
            let average = self.average();
            let mut more = energy.more(average);
            let mut once = Vector::pick(metal, self.c * lost_here.rest(), self.once(self.cos, split));
            let mut further = more * lost_here;
            let mut left = lost_here * energy.more_scale();
            if self.rare & rare::SCALED != 0 {
                let (scaled, scale) = (self.is_scaled(), self.scale(split, self.cos));
                more = Vector::pick(scaled, scale, more);
                let seen = self.is_seen();
                if R::bits(seen) != 0 {
                    more = Vector::pick(seen, Vector::grey(self.again(self.cos)), more);
                }
                once = Vector::pick(scaled, once * scale, once);
                further = Vector::pick(scaled, Vector::grey(zero), further);
                left = R::pick(scaled, zero, left);
            }
            let (by_microfacets, by_cosine) = (once.max_element(), further.max_element());
            let both = (by_microfacets + by_cosine).or_more(one.all(f32::MIN_POSITIVE));
            self.share_of_more = R::pick(is, by_cosine / both, self.share_of_more);
            self.more = Vector::pick(is, more, self.more);
            self.lost = R::pick(is, left, self.lost);
            self.hidden = R::pick(is, slopes.lambda(self.wo, self.cos), self.hidden);
            albedo = Vector::pick(is, once + further, albedo);
        }
        for (kind, thin) in [(Kind::Glass, false), (Kind::Pane, true)] {
            if self.has(kind) {
                let is = self.is(kind);
                let (prepared, mirrored) = self.prepare_glass(thin);
                self.lost = R::pick(is, prepared.lost, self.lost);
                self.hidden = R::pick(is, prepared.hidden, self.hidden);
                albedo = Vector::pick(is, self.b + (self.a - self.b) * mirrored, albedo);
            }
        }
        if self.has(Kind::Translucent) {
            albedo = Vector::pick(self.is(Kind::Translucent), self.a, albedo);
        }
        if self.has(Kind::Sheen) {
            let is = self.is(Kind::Sheen);
            albedo = Vector::pick(is, Vector::grey(sheen::albedo(self.alpha, self.cos)), albedo);
        }
        if self.kinds & Kind::MIRRORS != 0 {
            let (is, share) = self.mirrors(self.cos);
            albedo = Vector::pick(is, share, albedo);
        }
        if self.has(Kind::SmoothGlass) || self.has(Kind::SmoothPane) {
            let is = self.is(Kind::SmoothGlass) | self.is(Kind::SmoothPane);
            let mirrored = self.mirrored_by_plane();
            albedo = Vector::pick(is, self.a * mirrored + self.b * mirrored.rest(), albedo);
        }
        if self.kinds & scalar_lobes::KINDS != 0 {
            let is = self.is_scalar();
            let (prepared, hidden, lost) = self.prepare_scalar(is);
            self.hidden = R::pick(is, hidden, self.hidden);
            self.lost = R::pick(is, lost, self.lost);
            albedo = Vector::pick(is, prepared, albedo);
        }
        albedo
    }

    /// Diffuse lobes of models that lose light.
    #[inline(always)]
    pub(super) fn loses_light(&self) -> R::Mask {
        self.eta.above_all(1.5)
    }

    /// Of those, the value times pi over the colour for a direction with this dot product to the view and
    /// this cosine; the share of light that is sent back over the colour, seen at that cosine, without one.
    #[inline(always)]
    fn white_once(&self, dot: Option<R>, cos: R) -> R {
        cos.outline(
            #[inline(always)]
            || {
                cos.each(
                    #[inline(always)]
                    |i| {
                        let here = cos.lane(i);
                        let how = [self.alpha.lane(i), self.a.get(i).max_element()];
                        match (Model::of(self.eta.lane(i)), dot) {
                            (None, _) => 0.0,
                            (Some(model), None) => model.albedo(how, here),
                            (Some(model), Some(dot)) => {
                                model.value(how, dot.lane(i), [self.cos.lane(i), here])
                            }
                        }
                    },
                )
            },
        )
    }

    /// Fraction of light that a covering lobe reflects, towards the cosine `cos`; `split` is that of its
    /// microfacets there.
    #[inline(always)]
    pub(super) fn sent_back(&self, cos: R, split: [R; 2]) -> Vector<R> {
        let mut microfacets = self.once(cos, split) + self.more * lost(split);
        if self.rare & rare::SCALED != 0 {
            let scaled = self.once(cos, split) * self.scale(split, cos);
            microfacets = Vector::pick(self.is_scaled(), scaled, microfacets);
        }
        let is_microfacets = self.is(Kind::Microfacets);
        let mut back = Vector::pick(is_microfacets, microfacets, self.c);
        if self.has(Kind::Sheen) {
            back = Vector::pick(self.is(Kind::Sheen), Vector::grey(sheen::albedo(self.alpha, cos)), back);
        }
        let mut flat = self.is(Kind::Diffuse);
        back = Vector::pick(flat, self.a, back);
        if self.kinds & Kind::MIRRORS != 0 {
            let (is, share) = self.mirrors(cos);
            back = Vector::pick(is, share, back);
            flat = flat | is;
        }
        let clear = !(is_microfacets | self.is(Kind::Sheen) | self.is(Kind::Metal) | flat);
        back = Vector::pick(clear, Vector::grey(cos.all(0.0)), back);
        if self.kinds & (GLASS | scalar_lobes::KINDS) != 0 {
            let (is, glass) = cos.outline(
                #[inline(always)]
                || self.sent_back_by_glass(cos),
            );
            back = Vector::pick(is, glass, back);
        }
        back * self.cover
    }

    /// The same for glass of all kinds, and for lobes evaluated per point; and the points with such lobes.
    #[inline(always)]
    fn sent_back_by_glass(&self, cos: R) -> (R::Mask, Vector<R>) {
        let smooth = self.is(Kind::SmoothGlass) | self.is(Kind::SmoothPane);
        let mut share = self.mirrored_at(cos, self.is(Kind::SmoothPane));
        let mut glass = smooth;
        for (kind, thin) in [(Kind::Glass, false), (Kind::Pane, true)] {
            if self.has(kind) {
                glass = glass | self.is(kind);
                share = Vector::pick(self.is(kind), self.mirrored_by_microfacets(cos, thin), share);
            }
        }
        let mut back = self.a * share;
        let is = self.is_scalar();
        if self.kinds & scalar_lobes::KINDS != 0 {
            back = back.each_colour(
                is,
                #[inline(always)]
                |i, _| {
                    let cos = cos.lane(i).clamp(GRAZING, 1.0);
                    self.scalar(i, Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)).sent_back()
                },
            );
        }
        (glass | is, back)
    }

    /// Reflectance of white light at the cosine `cos` > 0, from the direction `w` or from all directions.
    #[inline(always)]
    pub(super) fn split(&self, w: Option<Vector<R>>, cos: R) -> [R; 2] {
        if self.has(Kind::Microfacets) || self.has(Kind::Metal) {
            self.slopes().split(w, cos)
        } else {
            [cos.all(0.0); 2]
        }
    }

    /// Accounts for the layers above: `left` is their transmittance for the prepared direction, `average` for
    /// all directions. A diffuse body gets the product of both directions over the mean; other lobes get the
    /// smaller of both.
    #[inline(always)]
    pub(super) fn put_below(&mut self, left: Vector<R>, average: Vector<R>) {
        let wide = self.is(Kind::Diffuse) | self.is(Kind::Translucent);
        let shared = (self.weight * left).with(
            average,
            #[inline(always)]
            |w, a| w / a.or_more(a.all(1e-6)),
        );
        self.weight = Vector::pick(wide, shared, self.weight);
        self.left = Vector::pick(wide, Vector::grey(self.cos.all(f32::MAX)), left);
    }

    /// Value times the cosine, without weight, and density for `wi` at the cosine `i`, on the side `above` of
    /// the point; `split` is that of microfacets at `i`.
    #[inline(always)]
    pub(super) fn eval_pdf(&self, wi: Vector<R>, i: R, above: R::Mask, split: [R; 2]) -> (Vector<R>, R) {
        let zero = i.all(0.0);
        let mut value = Vector::grey(zero);
        let mut pdf = zero;
        let front = above & i.above(zero);
        let i_front = i.or_more(i.all(1e-20));
        let by_cosine = i_front * FRAC_1_PI;
        if self.has(Kind::Translucent) {
            let is = self.is(Kind::Translucent) & !above & zero.above(i);
            let by_cosine = i.size() * FRAC_1_PI;
            (value, pdf) = (Vector::pick(is, self.a * by_cosine, value), R::pick(is, by_cosine, pdf));
        }
        if self.has(Kind::Diffuse) {
            let is = self.is(Kind::Diffuse) & front;
            let smooth = self.alpha.is(zero);
            let mut diffuse = self.a * by_cosine;
            if R::bits(is & !smooth) != 0 {
                let rough =
                    oren_nayar::eval(self.a, self.alpha, self.lost, self.wo.dot(wi), [self.cos, i_front]);
                diffuse = Vector::pick(smooth, diffuse, rough);
            }
            let once = is & self.loses_light();
            if R::bits(once) != 0 {
                let white = self.white_once(Some(self.wo.dot(wi)), i_front);
                diffuse = Vector::pick(once, self.a * (white * by_cosine), diffuse);
            }
            (value, pdf) = (Vector::pick(is, diffuse, value), R::pick(is, by_cosine, pdf));
        }
        let microfacets = Kind::Microfacets.bit() | Kind::Metal.bit() | Kind::Sheen.bit();
        if self.kinds & microfacets != 0 {
            let h = (self.wo + wi).normalize_or(self.normal);
            if self.has(Kind::Microfacets) || self.has(Kind::Metal) {
                let is = (self.is(Kind::Microfacets) | self.is(Kind::Metal)) & front;
                let slopes = self.slopes();
                let density = slopes.density(self.normal, h) / (self.cos * 4.0);
                let (one, cos_h) = (i.all(1.0), self.wo.dot(h));
                let lobe = density / (self.hidden + slopes.lambda(wi, i_front) + one);
                let mut reflectance = self.mirrored_by_facet(cos_h);
                let further = self.more * (self.lost * lost(split) * i_front);
                let mixed = self.share_of_more.rest() * density / (self.hidden + one)
                    + self.share_of_more * by_cosine;
                if self.rare & rare::SCALED != 0 {
                    let seen = reflectance * self.more + Vector::grey(one);
                    let scale = Vector::pick(self.is_seen(), seen, self.more);
                    reflectance = Vector::pick(self.is_scaled(), reflectance * scale, reflectance);
                }
                value = Vector::pick(is, reflectance * lobe + further, value);
                pdf = R::pick(is, mixed, pdf);
            }
            if self.has(Kind::Sheen) {
                let is = self.is(Kind::Sheen) & front;
                let lobe = sheen::lobe_cos(
                    self.alpha,
                    [self.cos, i_front],
                    self.normal.cross(h).length_squared().root(),
                );
                (value, pdf) = (Vector::pick(is, Vector::grey(lobe), value), R::pick(is, by_cosine, pdf));
            }
        }
        for (kind, thin) in [(Kind::Glass, false), (Kind::Pane, true)] {
            if self.has(kind) {
                let (light, density) = self.eval_pdf_of_glass(thin, wi, i);
                // Both normals must agree on the side.
                let is = self.is(kind) & (front | (!above & zero.above(i)));
                (value, pdf) = (Vector::pick(is, light, value), R::pick(is, density, pdf));
            }
        }
        if self.kinds & scalar_lobes::KINDS != 0 {
            let is = self.is_scalar() & (front | (!above & zero.above(i)));
            let (light, density) = self.eval_pdf_scalar(is, wi, i);
            (value, pdf) = (Vector::pick(is, light, value), R::pick(is, density, pdf));
        }
        (value, pdf)
    }
}
