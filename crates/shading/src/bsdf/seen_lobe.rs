// SPDX-License-Identifier: GPL-3.0-or-later
//! One lobe of each of many points, seen from one direction each: what follows from the view, values and densities, branches.
//! Source: \[WMLT07\], \[Hei14\] (facets); \[KC17\] (further bounces); \[PJH23\] chapter 9. Space: world, unit directions away from the
//! surface. Invariant: one point and sixteen give the same bits at every CPU level. Proof: `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::alone::{self, Alone, View};
use super::diffuse_once::Model;
use super::dispersed::Colours;
use super::energy::lost;
use super::film::{self, Base, Film};
use super::ggx::Ggx;
use super::grain::{Grain, Slopes};
use super::lobe::{Kind, SCHLICK, rare};
use super::lobes::MOST;
use super::lobes_at::Rarities;
use super::rough_dielectric::{self, Glass, Plain, SeenGlass};
use super::{dielectric, dispersed, fresnel, oren_nayar, sheen};
use crate::real::{Real, Vector};
use crate::sampling::frame_around;

/// Kinds of glass.
const GLASS: u32 = Kind::Glass.bit() | Kind::Pane.bit() | Kind::SmoothGlass.bit() | Kind::SmoothPane.bit();

/// Cosine: a `wo` nearer to the shading normal's horizon than this, or below it, counts as that near.
pub const GRAZING: f32 = 1e-3;

/// Points' lobes in one place of their lists, seen from one direction each.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenLobe<R> {
    pub(super) kind: R,
    pub(super) kinds: u32,
    pub(super) normal: Vector<R>,
    /// Where it is seen from, raised to where that sees the front, and its cosine.
    pub(super) wo: Vector<R>,
    pub(super) cos: R,
    /// Multiplied to its values, but for what the layers above leave: `left` of that from where it is seen.
    pub(super) weight: Vector<R>,
    pub(super) left: Vector<R>,
    pub(super) a: Vector<R>,
    pub(super) b: Vector<R>,
    pub(super) c: Vector<R>,
    /// Colour of further bounces between facets.
    pub(super) more: Vector<R>,
    pub(super) alpha: R,
    pub(super) eta: R,
    /// Smith's auxiliary function, and what facets lose after one bounce.
    pub(super) hidden: R,
    pub(super) lost: R,
    /// Chance that it is drawn from; that further bounces are, if it is.
    pub(super) chance: R,
    pub(super) share_of_more: R,
    pub(super) cover: R,
    pub(super) covers: bool,
    /// Bits of the points below each of the lobes before.
    pub(super) under: [u32; MOST],
    pub(super) under_any: u32,
    pub(super) rare: u32,
    pub(super) rarities: Rarities<R>,
}

impl<Q: Copy> SeenLobe<Q> {
    /// No lobe: all its numbers are `zero`.
    #[inline(always)]
    pub(super) fn none(zero: Q) -> Self {
        let black = Vector { x: zero, y: zero, z: zero };
        Self {
            kind: zero,
            kinds: 0,
            normal: black,
            wo: black,
            cos: zero,
            weight: black,
            left: black,
            a: black,
            b: black,
            c: black,
            more: black,
            alpha: zero,
            eta: zero,
            hidden: zero,
            lost: zero,
            chance: zero,
            share_of_more: zero,
            cover: zero,
            covers: false,
            under: [0; MOST],
            under_any: 0,
            rare: 0,
            rarities: Rarities::all(zero),
        }
    }

    /// Changes each number by that of another; rare ones only where either has some.
    #[inline(always)]
    pub(super) fn each_with<P>(&mut self, other: &SeenLobe<P>, mut f: impl FnMut(&mut Q, &P)) {
        f(&mut self.kind, &other.kind);
        self.normal.each_with(&other.normal, &mut f);
        self.wo.each_with(&other.wo, &mut f);
        f(&mut self.cos, &other.cos);
        self.weight.each_with(&other.weight, &mut f);
        self.left.each_with(&other.left, &mut f);
        self.a.each_with(&other.a, &mut f);
        self.b.each_with(&other.b, &mut f);
        self.c.each_with(&other.c, &mut f);
        self.more.each_with(&other.more, &mut f);
        f(&mut self.alpha, &other.alpha);
        f(&mut self.eta, &other.eta);
        f(&mut self.hidden, &other.hidden);
        f(&mut self.lost, &other.lost);
        f(&mut self.chance, &other.chance);
        f(&mut self.share_of_more, &other.share_of_more);
        f(&mut self.cover, &other.cover);
        if self.rare | other.rare != 0 {
            self.rarities.each_with(&other.rarities, &mut f);
        }
    }
}

impl<R: Real> SeenLobe<R> {
    #[inline(always)]
    pub(super) fn has(&self, kind: Kind) -> bool {
        self.kinds & kind.bit() != 0
    }

    #[inline(always)]
    pub(super) fn is(&self, kind: Kind) -> R::Mask {
        self.kind.is(self.kind.all(kind as u32 as f32))
    }

    /// Its facets.
    #[inline(always)]
    pub(super) fn slopes(&self) -> Slopes<R> {
        let ggx = Ggx::from_alpha(self.alpha);
        if self.rare & rare::GRAIN == 0 {
            return Slopes { ggx, grain: None };
        }
        let Rarities { tangent, across, .. } = self.rarities;
        let is = across.above_all(0.0);
        // As narrow as slopes along the first axis may be.
        let across = R::pick(is, Ggx::from_alpha(across).alpha(), across);
        Slopes { ggx, grain: Some(Grain { tangent, bitangent: self.normal.cross(tangent), across, is }) }
    }

    #[inline(always)]
    pub(super) fn glass(&self, thin: bool) -> (Glass<R>, SeenGlass<R>) {
        let glass = Glass {
            slopes: self.slopes(),
            eta: self.eta,
            film: (self.rare & rare::FILM != 0).then_some(self.rarities.film),
            rise: Plain,
            tints: [self.a, self.b],
            losses: self.c,
            thin,
        };
        (glass, SeenGlass { hidden: self.hidden, lost: self.lost })
    }

    /// How its colours go apart.
    #[inline(always)]
    pub(super) fn colours(&self) -> Colours<R> {
        Colours { spread: self.rarities.spread, chances: self.rarities.channels }
    }

    /// What facets mirror at the cosine `cos`: `bare`, or what a film makes of it.
    #[inline(always)]
    fn filmed(&self, cos: R, bare: Vector<R>) -> Vector<R> {
        if self.rare & rare::FILM == 0 {
            return bare;
        }
        cos.apart(
            #[inline(always)]
            || {
                let [share, ior, thickness] = self.rarities.film;
                let metal = R::bits(self.is(Kind::Metal));
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

    /// What facets mirror, averaged over a cosine-weighted hemisphere, without a film.
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

    /// Facets whose reflectances rise by another power than Schlick's.
    #[inline(always)]
    fn is_risen(&self) -> R::Mask {
        self.eta.all(0.0).above(self.eta) & self.is(Kind::Facets)
    }

    /// About what facets send back at the cosine `cos` after one bounce that loses `lost` of white light; exact without a film, and where
    /// reflectances rise as Schlick's.
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
        cos.apart(
            #[inline(always)]
            || {
                let share = self.rarities.film[0];
                // Of those that are seen, the mean facet: by what the table says of Schlick's curve over them.
                let rise = split[1] / (split[0] + split[1]).or_more(cos.all(1e-6));
                let blurred = cos.each(
                    #[inline(always)]
                    |i| 1.0 - rise.lane(i).clamp(0.0, 1.0).powf(0.2),
                );
                let black = Vector::grey(cos.all(0.0));
                let under_film = self.filmed(blurred, black).over(share.or_more(cos.all(1e-6)));
                let under_film = under_film * (split[0] + split[1]);
                let mixed = schlick * share.rest() + under_film * share;
                Vector::pick(share.above_all(0.0), mixed, schlick)
            },
        )
    }

    /// Fills in what follows from the view; says which share of light the lobe scatters, without its weight.
    #[inline(always)]
    pub(super) fn look(&mut self) -> Vector<R> {
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
            // What is kept of one bounce stands in the place of what facets lose.
            self.lost = R::pick(is, white, self.lost);
            albedo = Vector::pick(is, Vector::pick(smooth, self.a, rough), albedo);
            let once = is & self.loses_light();
            if R::bits(once) != 0 {
                albedo = Vector::pick(once, self.a * self.white_once(None, self.cos), albedo);
            }
        }
        if self.has(Kind::Facets) || self.has(Kind::Metal) {
            let metal = self.is(Kind::Metal);
            let is = self.is(Kind::Facets) | metal;
            let slopes = self.slopes();
            let energy = slopes.energy();
            let split = slopes.split(Some(self.wo), self.cos);
            let lost_here = lost(split);
            let mut average = Vector::pick(metal, self.c, self.mirrored_on_average());
            if self.rare & rare::FILM != 0 {
                average = Vector::pick(self.rarities.film[0].above_all(0.0), self.c, average);
            }
            let more = energy.more(average);
            let once = Vector::pick(metal, self.c * lost_here.rest(), self.once(self.cos, split));
            let further = more * lost_here;
            let (by_facets, by_cosine) = (once.max_element(), further.max_element());
            let both = (by_facets + by_cosine).or_more(one.all(f32::MIN_POSITIVE));
            self.share_of_more = R::pick(is, by_cosine / both, self.share_of_more);
            self.more = Vector::pick(is, more, self.more);
            self.lost = R::pick(is, lost_here * energy.more_scale(), self.lost);
            self.hidden = R::pick(is, slopes.lambda(self.wo, self.cos), self.hidden);
            albedo = Vector::pick(is, once + further, albedo);
        }
        for (kind, thin) in [(Kind::Glass, false), (Kind::Pane, true)] {
            if self.has(kind) {
                let is = self.is(kind);
                let (seen, mirrored) = self.look_at_glass(thin);
                self.lost = R::pick(is, seen.lost, self.lost);
                self.hidden = R::pick(is, seen.hidden, self.hidden);
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
        if self.has(Kind::Mirror) {
            albedo = Vector::pick(self.is(Kind::Mirror), self.a, albedo);
        }
        if self.has(Kind::SmoothGlass) || self.has(Kind::SmoothPane) {
            let is = self.is(Kind::SmoothGlass) | self.is(Kind::SmoothPane);
            let mirrored = self.mirrored_by_plane();
            albedo = Vector::pick(is, self.a * mirrored + self.b * mirrored.rest(), albedo);
        }
        if self.kinds & alone::KINDS != 0 {
            let is = self.is_alone();
            let (seen, hidden, lost) = self.look_alone(is);
            self.hidden = R::pick(is, hidden, self.hidden);
            self.lost = R::pick(is, lost, self.lost);
            albedo = Vector::pick(is, seen, albedo);
        }
        albedo
    }

    /// Points whose lobe is looked at by itself.
    #[inline(always)]
    pub(super) fn is_alone(&self) -> R::Mask {
        let is = self.is(Kind::Phong) | self.is(Kind::Ward);
        is | self.is(Kind::Beckmann) | self.is(Kind::SchlickGlass) | self.is(Kind::Fibres)
    }

    /// That of point `i`, seen from `wo` in the frame of its slopes.
    fn alone(&self, i: usize, wo: Vec3) -> Alone {
        let (along, across) = (self.alpha.lane(i), self.rarities.across.lane(i));
        let [share, ior, thickness] = self.rarities.film;
        Alone {
            kind: Kind::ALL.get(self.kind.lane(i) as usize).copied().unwrap_or_default(),
            wo,
            a: self.a.get(i),
            b: self.b.get(i),
            c: self.c.get(i),
            widths: [along, if across > 0.0 { across } else { along }],
            eta: self.eta.lane(i),
            spread: self.rarities.spread.lane(i),
            film: [share.lane(i), ior.lane(i), thickness.lane(i)],
        }
    }

    /// The axes of the slopes.
    fn axes(&self) -> [Vector<R>; 2] {
        let [x, y] = frame_around(self.normal);
        let is = self.rarities.across.above_all(0.0);
        let along = Vector::pick(is, self.rarities.tangent, x);
        [along, Vector::pick(is, self.normal.cross(along), y)]
    }

    /// Albedos, [`hidden`](Self::hidden) and [`lost`](Self::lost) of points in a mask.
    #[inline(always)]
    fn look_alone(&self, is: R::Mask) -> (Vector<R>, R, R) {
        let [x, y] = self.axes();
        let wo = Vector::new(x.dot(self.wo), y.dot(self.wo), self.cos);
        let [r, g, b, hidden, lost] = self.cos.each_where(
            is,
            #[inline(always)]
            |i| {
                let View { albedo, hidden, lost } = self.alone(i, wo.get(i)).look();
                [albedo.x, albedo.y, albedo.z, hidden, lost]
            },
        );
        (Vector::new(r, g, b), hidden, lost)
    }

    /// Values times the cosine and densities of points in a mask for `wi` at the cosine `cos`.
    #[inline(always)]
    fn eval_pdf_alone(&self, is: R::Mask, wi: Vector<R>, cos: R) -> (Vector<R>, R) {
        cos.apart(
            #[inline(always)]
            || {
                let [x, y] = self.axes();
                let wo = Vector::new(x.dot(self.wo), y.dot(self.wo), self.cos);
                let wi = Vector::new(x.dot(wi), y.dot(wi), cos);
                let [r, g, b, density] = cos.each_where(
                    is,
                    #[inline(always)]
                    |i| {
                        let (hidden, lost) = (self.hidden.lane(i), self.lost.lane(i));
                        let (light, density) = self.alone(i, wo.get(i)).eval_pdf(hidden, lost, wi.get(i));
                        light.extend(density).into()
                    },
                );
                (Vector::new(r, g, b), density)
            },
        )
    }

    /// Where lobes of points in a mask send light that comes from `wo`, in the frame of that; zero where they send none.
    #[inline(always)]
    pub(super) fn sample_alone(&self, is: R::Mask, wo: Vector<R>, u: [R; 3], cosine: Vector<R>) -> Vector<R> {
        wo.x.apart(
            #[inline(always)]
            || {
                Vector::grey(wo.x.all(0.0)).each_colour(
                    is,
                    #[inline(always)]
                    |i, _| {
                        let (hidden, lost) = (self.hidden.lane(i), self.lost.lane(i));
                        let u = [u[0].lane(i), u[1].lane(i), u[2].lane(i)];
                        self.alone(i, wo.get(i)).sample(hidden, lost, u, cosine.get(i))
                    },
                )
            },
        )
    }

    /// Diffuse lobes of models that lose light.
    #[inline(always)]
    pub(super) fn loses_light(&self) -> R::Mask {
        self.eta.above_all(1.5)
    }

    /// Of those, the value times pi over the colour for a direction with this dot product to the view and this cosine; the share of light
    /// that is sent back over the colour, seen at that cosine, without one.
    #[inline(always)]
    fn white_once(&self, dot: Option<R>, cos: R) -> R {
        cos.apart(
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

    /// What follows from the view of rough glass, and the share of light that it mirrors.
    #[inline(always)]
    fn look_at_glass(&self, thin: bool) -> (SeenGlass<R>, Vector<R>) {
        self.cos.apart(
            #[inline(always)]
            || {
                let (glass, _) = self.glass(thin);
                // About: facets mirror as the plane does, blurred.
                let blurred = self.cos + (self.cos.all(0.7) - self.cos) * (self.alpha * 0.5);
                (glass.seen(self.wo, self.cos), glass.mirrored(blurred))
            },
        )
    }

    /// Share of light that smooth glass mirrors, by colour.
    #[inline(always)]
    pub(super) fn mirrored_by_plane(&self) -> Vector<R> {
        self.mirrored_at(self.cos, self.is(Kind::SmoothPane))
    }

    /// The same at the cosine `cos`, by panes or not.
    #[inline(always)]
    fn mirrored_at(&self, cos: R, pane: R::Mask) -> Vector<R> {
        let once = fresnel::dielectric(cos, self.eta);
        let bare = Vector::grey(R::pick(pane, dielectric::pane(once), once));
        if self.rare & rare::FILM == 0 {
            return bare;
        }
        rough_dielectric::filmed(self.rarities.film, cos, self.eta, pane, bare)
    }

    /// Share of light that a lobe which covers others sends back, towards the cosine `cos`; `split` is that of its facets there.
    #[inline(always)]
    pub(super) fn sent_back(&self, cos: R, split: [R; 2]) -> Vector<R> {
        let facets = self.once(cos, split) + self.more * lost(split);
        let is_facets = self.is(Kind::Facets);
        let mut back = Vector::pick(is_facets, facets, self.c);
        if self.has(Kind::Sheen) {
            back = Vector::pick(self.is(Kind::Sheen), Vector::grey(sheen::albedo(self.alpha, cos)), back);
        }
        let flat = self.is(Kind::Diffuse) | self.is(Kind::Mirror);
        back = Vector::pick(flat, self.a, back);
        let clear = !(is_facets | self.is(Kind::Sheen) | self.is(Kind::Metal) | flat);
        back = Vector::pick(clear, Vector::grey(cos.all(0.0)), back);
        if self.kinds & (GLASS | alone::KINDS) != 0 {
            let (is, glass) = cos.apart(
                #[inline(always)]
                || self.sent_back_by_glass(cos),
            );
            back = Vector::pick(is, glass, back);
        }
        back * self.cover
    }

    /// The same of glass of all kinds, and of what is looked at by itself: what is mirrored, about; and the points that have such.
    #[inline(always)]
    fn sent_back_by_glass(&self, cos: R) -> (R::Mask, Vector<R>) {
        let smooth = self.is(Kind::SmoothGlass) | self.is(Kind::SmoothPane);
        let pane = self.is(Kind::Pane) | self.is(Kind::SmoothPane);
        // Facets mirror as the plane does, blurred.
        let blurred = R::pick(smooth, cos, cos + (cos.all(0.7) - cos) * (self.alpha * 0.5));
        let glass = smooth | pane | self.is(Kind::Glass);
        let mut back = self.a * self.mirrored_at(blurred, pane);
        let is = self.is_alone();
        if self.kinds & alone::KINDS != 0 {
            back = back.each_colour(
                is,
                #[inline(always)]
                |i, _| {
                    let cos = cos.lane(i).clamp(GRAZING, 1.0);
                    self.alone(i, Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)).sent_back()
                },
            );
        }
        (glass | is, back)
    }

    /// What facets send back of white light at the cosine `cos` > 0, from the direction `w` or from all around.
    #[inline(always)]
    pub(super) fn split(&self, w: Option<Vector<R>>, cos: R) -> [R; 2] {
        if self.has(Kind::Facets) || self.has(Kind::Metal) {
            self.slopes().split(w, cos)
        } else {
            [cos.all(0.0); 2]
        }
    }

    /// Takes into account what the layers above leave: `left` of light from where it is seen, `average` of light from everywhere. A body
    /// that scatters to all sides gets what is left of both directions, over the mean of what is left; others the smaller of both.
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

    /// Points that lie below lobe `j`.
    #[inline(always)]
    pub(super) fn below(&self, j: usize) -> R::Mask {
        self.cos.points(u64::from(self.under[j]))
    }

    /// Value times the cosine, without weight, and density for `wi` at the cosine `i`, on the side `above` of the point;
    /// `split` is that of facets at `i`.
    #[inline(always)]
    fn eval_pdf(&self, wi: Vector<R>, i: R, above: R::Mask, split: [R; 2]) -> (Vector<R>, R) {
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
        let facets = Kind::Facets.bit() | Kind::Metal.bit() | Kind::Sheen.bit();
        if self.kinds & facets != 0 {
            let h = (self.wo + wi).normalize_or(self.normal);
            if self.has(Kind::Facets) || self.has(Kind::Metal) {
                let is = (self.is(Kind::Facets) | self.is(Kind::Metal)) & front;
                let slopes = self.slopes();
                let density = slopes.density(self.normal, h) / (self.cos * 4.0);
                let (one, cos_h) = (i.all(1.0), self.wo.dot(h));
                let lobe = density / (self.hidden + slopes.lambda(wi, i_front) + one);
                let mut rise = fresnel::schlick_rise(cos_h);
                if self.rare & rare::POWER != 0 {
                    rise = cos_h.apart(
                        #[inline(always)]
                        || self.risen(rise),
                    );
                }
                let mut reflectance = self.a + (self.b - self.a) * rise;
                if self.has(Kind::Metal) {
                    let metal = self.a.with(
                        self.b,
                        #[inline(always)]
                        |eta, k| fresnel::conductor(cos_h, eta, k),
                    );
                    reflectance = Vector::pick(self.is(Kind::Metal), metal, reflectance);
                }
                reflectance = self.filmed(cos_h, reflectance);
                let further = self.more * (self.lost * lost(split) * i_front);
                let mixed = self.share_of_more.rest() * density / (self.hidden + one)
                    + self.share_of_more * by_cosine;
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
                // Both normals must say the same of the side.
                let is = self.is(kind) & (front | (!above & zero.above(i)));
                (value, pdf) = (Vector::pick(is, light, value), R::pick(is, density, pdf));
            }
        }
        if self.kinds & alone::KINDS != 0 {
            let is = self.is_alone() & (front | (!above & zero.above(i)));
            let (light, density) = self.eval_pdf_alone(is, wi, i);
            (value, pdf) = (Vector::pick(is, light, value), R::pick(is, density, pdf));
        }
        (value, pdf)
    }
}

impl<R: Real> SeenLobe<R> {
    /// Value times the cosine and density of rough glass for `wi` at the cosine `i`.
    #[inline(always)]
    fn eval_pdf_of_glass(&self, thin: bool, wi: Vector<R>, i: R) -> (Vector<R>, R) {
        i.apart(
            #[inline(always)]
            || {
                let (glass, seen) = self.glass(thin);
                let (ways, cosines) = ([self.wo, wi], [self.cos, i]);
                let white = glass.eval_pdf(seen, self.normal, ways, cosines);
                if self.rare & rare::SPREAD == 0 || thin {
                    return white;
                }
                dispersed::eval_pdf(&glass, &self.colours(), self.normal, ways, cosines, white)
            },
        )
    }

    /// Where rough glass sends light that comes from `wo`, in the frame of that; and the points at which it does.
    #[inline(always)]
    pub(super) fn sample_glass(
        &self,
        thin: bool,
        wo: Vector<R>,
        u: [R; 3],
        cosine: Vector<R>,
    ) -> (Vector<R>, R::Mask) {
        wo.x.apart(
            #[inline(always)]
            || {
                let (glass, seen) = self.glass(thin);
                let white = glass.sample(seen, wo, u, cosine);
                if self.rare & rare::SPREAD == 0 || thin {
                    return white;
                }
                dispersed::sample(&glass, &self.colours(), [self.wo, wo], u, cosine, white)
            },
        )
    }
}

/// A direction and its share of the light.
type Branch<R> = (Vector<R>, Vector<R>);

impl<R: Real> SeenLobe<R> {
    /// Becomes `next` where the mask says so, as far as choosing directions asks.
    #[inline(always)]
    pub(super) fn mix(&mut self, mask: R::Mask, next: &Self) {
        self.kinds |= next.kinds;
        self.rare |= next.rare;
        self.each_with(
            next,
            #[inline(always)]
            |own, &next| *own = R::pick(mask, next, *own),
        );
    }

    /// Where delta lobes send light, mirrored and through, in the frame of `wo`, with its share of the light; and the
    /// probability with which the former is followed. What is bent by colour goes where yellow light does.
    #[inline(always)]
    pub(super) fn branches(&self, wo: Vector<R>) -> ([Branch<R>; 2], R) {
        let (zero, one) = (wo.z.all(0.0), wo.z.all(1.0));
        let mirrored = Vector::new(-wo.x, -wo.y, wo.z);
        let is_mirror = self.is(Kind::Mirror);
        let share = Vector::pick(is_mirror, Vector::grey(one), self.mirrored_by_plane());
        let (bent, some) = dielectric::refract(wo, Vector::all(one, Vec3::Z), self.eta);
        let pane = self.is(Kind::SmoothPane);
        let (through, some) = (Vector::pick(pane, -wo, bent), some | pane);
        let lights = [self.a * share, self.b * share.rest()];
        let lights = [lights[0], Vector::pick(some & !is_mirror, lights[1], Vector::grey(zero))];
        let [a, b] = lights.map(Vector::sum);
        let chance = R::pick((a + b).above(zero), a / (a + b), one);
        ([(mirrored, lights[0]), (through, lights[1])], chance)
    }
}

impl<R: Real> SeenLobe<R> {
    /// For smooth glass that bends colours into different directions, at the points in the mask: the direction that `u` chooses, in the
    /// frame of `wo`, and its light over the probability of that.
    #[inline(always)]
    pub(super) fn branch_by_colour(&self, mask: R::Mask, wo: Vector<R>, u: R) -> (Vector<R>, Vector<R>) {
        let [share, ior, thickness] = self.rarities.film;
        let [x, y, z, r, g, b] = u.each_where(
            mask,
            #[inline(always)]
            |i| {
                let colours = (self.rarities.spread.lane(i), self.rarities.channels.get(i));
                let film = Film { share: share.lane(i), ior: ior.lane(i), thickness: thickness.lane(i) };
                let tints = [self.a.get(i), self.b.get(i)];
                let (way, light) =
                    dispersed::branch(self.eta.lane(i), colours, film, tints, wo.get(i), u.lane(i));
                [way.x, way.y, way.z, light.x, light.y, light.z]
            },
        );
        (Vector::new(x, y, z), Vector::new(r, g, b))
    }
}

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
