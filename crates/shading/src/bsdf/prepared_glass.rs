// SPDX-License-Identifier: GPL-3.0-or-later
//! Glass, rough and smooth, and mirrors of many points, prepared for one direction each: reflected and
//! transmitted shares, and directions.
//! Source: \[WMLT07\]; films and dispersion as in `film.rs` and `dispersed.rs`. Space: world. Tests: `tests`
//! of `bsdf`.

use glam::Vec3;

use super::dispersed::Colours;
use super::film::Film;
use super::lobe::{Kind, rare};
use super::prepared_lobe::PreparedLobe;
use super::rough_dielectric::{self, Glass, Plain, PreparedGlass};
use super::{dielectric, dispersed, fresnel};
use crate::real::{Real, Vector};

/// A direction and its share of the light.
type Branch<R> = (Vector<R>, Vector<R>);

impl<R: Real> PreparedLobe<R> {
    #[inline(always)]
    pub(super) fn glass(&self, thin: bool) -> (Glass<R>, PreparedGlass<R>) {
        let glass = Glass {
            slopes: self.slopes(),
            eta: self.eta,
            film: (self.rare & rare::FILM != 0).then_some(self.rarities.film),
            rise: Plain,
            tints: [self.a, self.b],
            losses: self.c,
            thin,
        };
        (glass, PreparedGlass { hidden: self.hidden, lost: self.lost })
    }

    /// The dispersion of its colours.
    #[inline(always)]
    pub(super) fn colours(&self) -> Colours<R> {
        Colours { spread: self.rarities.spread, chances: self.rarities.channels }
    }

    /// The values of rough glass that depend on the view, and the share of reflected light.
    #[inline(always)]
    pub(super) fn prepare_glass(&self, thin: bool) -> (PreparedGlass<R>, Vector<R>) {
        self.cos.outline(
            #[inline(always)]
            || {
                let (glass, _) = self.glass(thin);
                (glass.prepared(self.wo, self.cos), self.mirrored_by_microfacets(self.cos, thin))
            },
        )
    }

    /// Share of light that rough glass mirrors at the cosine `cos`, by colour, further bounces included. About the share where
    /// microfacets are not even, are a pane's or have a film.
    #[inline(always)]
    pub(super) fn mirrored_by_microfacets(&self, cos: R, thin: bool) -> Vector<R> {
        // As the plane reflects, blurred.
        let blurred = cos + (cos.all(0.7) - cos) * (self.alpha * 0.5);
        if thin {
            return self.glass(true).0.mirrored(blurred);
        }
        let [once, lost] = rough_dielectric::mirrored_and_lost(self.slopes().ggx.alpha(), self.eta, cos);
        let bare = Vector::grey(once + lost * self.c.z.rest());
        if self.rare & rare::FILM == 0 {
            return bare;
        }
        rough_dielectric::filmed(self.rarities.film, blurred, self.eta, !cos.is(cos), bare)
    }

    /// Share of light that smooth glass mirrors, by colour.
    #[inline(always)]
    pub(super) fn mirrored_by_plane(&self) -> Vector<R> {
        self.mirrored_at(self.cos, self.is(Kind::SmoothPane))
    }

    /// The same at the cosine `cos`, by panes or not.
    #[inline(always)]
    pub(super) fn mirrored_at(&self, cos: R, pane: R::Mask) -> Vector<R> {
        let once = fresnel::dielectric(cos, self.eta);
        let bare = Vector::grey(R::pick(pane, dielectric::pane(once), once));
        if self.rare & rare::FILM == 0 {
            return bare;
        }
        rough_dielectric::filmed(self.rarities.film, cos, self.eta, pane, bare)
    }

    /// Value times the cosine and density of rough glass for `wi` at the cosine `i`.
    #[inline(always)]
    pub(super) fn eval_pdf_of_glass(&self, thin: bool, wi: Vector<R>, i: R) -> (Vector<R>, R) {
        i.outline(
            #[inline(always)]
            || {
                let (glass, prepared) = self.glass(thin);
                let (directions, cosines) = ([self.wo, wi], [self.cos, i]);
                let white = glass.eval_pdf(prepared, self.normal, directions, cosines);
                if self.rare & rare::SPREAD == 0 || thin {
                    return white;
                }
                dispersed::eval_pdf(&glass, &self.colours(), self.normal, directions, cosines, white)
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
        wo.x.outline(
            #[inline(always)]
            || {
                let (glass, prepared) = self.glass(thin);
                let white = glass.sample(prepared, wo, u, cosine);
                if self.rare & rare::SPREAD == 0 || thin {
                    return white;
                }
                dispersed::sample(&glass, &self.colours(), [self.wo, wo], u, cosine, white)
            },
        )
    }

    /// The directions of delta lobes, reflected and transmitted, in the frame of `wo`, with their shares of
    /// the light; and the probability of the reflection. Dispersed light takes the direction of yellow light.
    #[inline(always)]
    pub(super) fn branches(&self, wo: Vector<R>) -> ([Branch<R>; 2], R) {
        let (zero, one) = (wo.z.all(0.0), wo.z.all(1.0));
        let mirrored = Vector::new(-wo.x, -wo.y, wo.z);
        let (is_mirror, mirror) = self.mirrors(self.cos);
        let share = self.mirrored_by_plane();
        let (bent, some) = dielectric::refract(wo, Vector::all(one, Vec3::Z), self.eta);
        let pane = self.is(Kind::SmoothPane);
        let (through, some) = (Vector::pick(pane, -wo, bent), some | pane);
        let lights = [Vector::pick(is_mirror, mirror, self.a * share), self.b * share.rest()];
        let lights = [lights[0], Vector::pick(some & !is_mirror, lights[1], Vector::grey(zero))];
        let [a, b] = lights.map(Vector::sum);
        let probability = R::pick((a + b).above(zero), a / (a + b), one);
        ([(mirrored, lights[0]), (through, lights[1])], probability)
    }

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
                let (direction, light) =
                    dispersed::branch(self.eta.lane(i), colours, film, tints, wo.get(i), u.lane(i));
                [direction.x, direction.y, direction.z, light.x, light.y, light.z]
            },
        );
        (Vector::new(x, y, z), Vector::new(r, g, b))
    }
}
