// SPDX-License-Identifier: GPL-3.0-or-later
//! Rough glass: GGX microfacets with reflection and refraction, and multiple scattering between them.
//! Source: [WMLT07] (the lobe and its densities), [Hei14], [DB23]; [KC17] for multiple scattering: the energy
//! that single scattering loses returns as two diffuse lobes, reflected and transmitted, in the proportion
//! that keeps the model reciprocal.
//! Space: the shading frame. Radiance is not scaled by the square of the index: see `bsdf`. So values through
//! the surface over the square of the index beyond are the same with both directions exchanged.
//! Tests: `tests::table_holds_the_lobe`, `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;
use std::sync::OnceLock;

use glam::{FloatExt, Vec2, Vec3};

use super::anisotropy::{self, Slopes};
use super::dielectric::{pane, refract};
use super::energy::{Energy, average, cell, lost};
use super::film::{self, Base, Film};
use super::fresnel;
use super::ggx::Ggx;
use crate::real::{Real, Vector};

/// An index nearer to 1 than this has no refraction that a float could represent.
const SMALLEST_STEP: f32 = 1e-3;

/// The effective index; and the energy that single scattering loses, averaged over all directions, on this
/// side and beyond, with the share of further bounces that ends beyond; for microfacets with slopes of two
/// widths.
pub(super) fn losses(widths: [f32; 2], eta: f32, thin: bool) -> (f32, Vec3) {
    let ggx = Ggx::from_alpha(widths[0]);
    let even = widths[0] == widths[1];
    let eta = match eta {
        eta if thin => eta.min(1.0 / eta),
        eta if (eta - 1.0).abs() < SMALLEST_STEP => 1.0 + SMALLEST_STEP.copysign(eta - 1.0),
        eta => eta,
    };
    let rare = eta.min(1.0 / eta);
    if thin {
        let lost = if even { lost(Energy::of(ggx).average) } else { 1.0 - anisotropy::mean_retained(widths) };
        return (eta, Vec3::new(lost, lost, 1.0 - pane_average(rare)));
    }
    let retained = |eta: f32| match even {
        true => Albedos::of(ggx.alpha(), eta).average(),
        false => anisotropy::mean_retained_by_glass(widths, eta),
    };
    let lost = [eta, 1.0 / eta].map(|eta| 1.0 - retained(eta));
    let mirrored = fresnel_average(rare);
    // With the index beyond as unit: shares through are as the inverse of these on the two sides.
    let capacity = [lost[0] * eta * eta, lost[1]];
    let through = (1.0 - mirrored) * capacity[0].min(capacity[1]) / capacity[0].max(1e-9);
    (eta, Vec3::new(lost[0], lost[1], through.min(1.0)))
}

/// Microfacets with reflection and refraction.
pub(super) trait Microfacets<R: Real>: Copy {
    /// Density of microfacets facing the unit `h` per solid angle and ground area, around the normal `n`.
    fn density(&self, n: Vector<R>, h: Vector<R>) -> R;
    /// Smith's auxiliary function of `w` at the cosine `cos`, of either sign.
    fn lambda(&self, w: Vector<R>, cos: R) -> R;
    /// A visible microfacet, in a frame with z = the normal and x along the slopes.
    fn sample_visible(&self, wo: Vector<R>, u: [R; 2]) -> Vector<R>;
    /// Share of light from `w` at the cosine `cos` > 0 that one bounce loses; `eta` is the index there over
    /// that beyond.
    fn lost(&self, w: Vector<R>, cos: R, eta: R, thin: bool) -> R;
}

impl<R: Real> Microfacets<R> for Slopes<R> {
    #[inline(always)]
    fn density(&self, n: Vector<R>, h: Vector<R>) -> R {
        Slopes::density(self, n, h)
    }

    #[inline(always)]
    fn lambda(&self, w: Vector<R>, cos: R) -> R {
        Slopes::lambda(self, w, cos)
    }

    #[inline(always)]
    fn sample_visible(&self, wo: Vector<R>, u: [R; 2]) -> Vector<R> {
        Slopes::sample_visible(self, wo, u)
    }

    #[inline(always)]
    fn lost(&self, w: Vector<R>, cos: R, eta: R, thin: bool) -> R {
        if thin {
            return lost(self.split(Some(w), cos));
        }
        let alpha = self.ggx.alpha();
        let [plain] = each_albedos(
            [alpha, eta, cos],
            #[inline(always)]
            |albedos, cos| [albedos.albedo(cos)],
        );
        self.retained_by_glass(w, cos, eta, plain).rest()
    }
}

/// Reflectance of microfacets without a film.
pub(super) trait Mirrored<R: Real>: Copy {
    /// Whether all colours alike.
    const IS_GREY: bool;

    /// The share, by colour, of light at the cosine `cos`; of a pane if `thin`.
    fn share(&self, cos: R, eta: R, thin: bool) -> Vector<R>;
}

/// Fresnel's equations.
#[derive(Clone, Copy)]
pub(super) struct Plain;

impl<R: Real> Mirrored<R> for Plain {
    const IS_GREY: bool = true;

    #[inline(always)]
    fn share(&self, cos: R, eta: R, thin: bool) -> Vector<R> {
        let once = fresnel::dielectric(cos, eta);
        Vector::grey(if thin { pane(once) } else { once })
    }
}

/// Rough glass as one side of it is met, or a pane.
#[derive(Clone, Copy)]
pub(super) struct Glass<R: Real, S = Slopes<R>, M = Plain> {
    pub(super) slopes: S,
    pub(super) eta: R,
    /// Share, index and thickness, where some point has one.
    pub(super) film: Option<[R; 3]>,
    /// Reflectance without a film.
    pub(super) rise: M,
    /// Tints of reflection and transmission.
    pub(super) tints: [Vector<R>; 2],
    /// See [`losses`].
    pub(super) losses: Vector<R>,
    pub(super) thin: bool,
}

/// Rough glass seen from `wo`.
#[derive(Clone, Copy)]
pub(super) struct PreparedGlass<R> {
    /// Smith's auxiliary function of `wo`.
    pub(super) hidden: R,
    /// Share of light that one bounce loses.
    pub(super) lost: R,
}

/// Reflectance under a film at the cosine `cos` on glass or a pane, mixed with the reflectance without one.
#[inline(always)]
pub(super) fn filmed<R: Real>(
    [share, ior, thickness]: [R; 3],
    cos: R,
    eta: R,
    thin: R::Mask,
    bare: Vector<R>,
) -> Vector<R> {
    let thin = R::bits(thin);
    bare.each_colour(
        share.above_all(0.0),
        #[inline(always)]
        |i, bare| {
            let film = Film { share: share.lane(i), ior: ior.lane(i), thickness: thickness.lane(i) };
            let once = film::reflectance(film, cos.lane(i), Base::Index(eta.lane(i)));
            let all = if thin >> i & 1 != 0 { once * 2.0 / (once + 1.0) } else { once };
            bare.lerp(all, film.share)
        },
    )
}

impl<R: Real> Glass<R> {
    /// That of one point.
    pub(super) fn point(&self, i: usize) -> Glass<f32> {
        Glass {
            slopes: self.slopes.point(i),
            eta: self.eta.lane(i),
            film: self.film.map(|film| film.map(|x| x.lane(i))),
            rise: Plain,
            tints: self.tints.map(|tint| tint.get(i).into()),
            losses: self.losses.get(i).into(),
            thin: self.thin,
        }
    }
}

impl<R: Real, S: Microfacets<R>, M: Mirrored<R>> Glass<R, S, M> {
    /// Reflectance of a microfacet, by colour.
    #[inline(always)]
    pub(super) fn mirrored(&self, cos: R) -> Vector<R> {
        let bare = self.rise.share(cos, self.eta, self.thin);
        let Some(film) = self.film else { return bare };
        let all = cos.is(cos);
        let thin = if self.thin { all } else { !all };
        filmed(film, cos, self.eta, thin, bare)
    }

    /// Probability with which a microfacet's mirrored branch is followed.
    #[inline(always)]
    pub(super) fn probability(&self, mirrored: Vector<R>) -> R {
        let mean = match self.film {
            _ if !M::IS_GREY => mirrored.sum() * (1.0 / 3.0),
            Some([share, ..]) => R::pick(share.above_all(0.0), mirrored.sum() * (1.0 / 3.0), mirrored.x),
            None => mirrored.x,
        };
        let a = mean * self.tints[0].max_element();
        let b = mean.rest() * self.tints[1].max_element();
        R::pick((a + b).above_all(0.0), a / (a + b), a.all(1.0))
    }

    /// Share of light from the direction `w` at the cosine `cos` > 0 that one bounce loses, on this side or
    /// beyond.
    #[inline(always)]
    pub(super) fn lost(&self, w: Vector<R>, cos: R, beyond: bool) -> R {
        let eta = if beyond { cos.all(1.0) / self.eta } else { self.eta };
        self.slopes.lost(w, cos, eta, self.thin)
    }

    /// Values common to all directions: `wo` lies at the cosine `cos_o` > 0.
    #[inline(always)]
    pub(super) fn prepared(&self, wo: Vector<R>, cos_o: R) -> PreparedGlass<R> {
        PreparedGlass { hidden: self.slopes.lambda(wo, cos_o), lost: self.lost(wo, cos_o, false) }
    }

    /// Value times cosine and density of the unit `wi`, for the unit normal `n`; `wo` lies at the cosine `o`
    /// > 0, `wi` at `i`.
    #[inline(always)]
    pub(super) fn eval_pdf(
        &self,
        prepared: PreparedGlass<R>,
        n: Vector<R>,
        [wo, wi]: [Vector<R>; 2],
        [o, i]: [R; 2],
    ) -> (Vector<R>, R) {
        let (zero, cos_i) = (o.all(0.0), i.size());
        let above = i.above(zero);
        let hidden = self.slopes.lambda(wi, cos_i);
        // The microfacet for `wi`, and the ratio of its solid angle to that of `wi`.
        let mirror = (wo + wi).normalize_or(n);
        let (microfacet, change) = if self.thin {
            let flipped = wi - n * (i * 2.0);
            let h = (wo + flipped).normalize_or(n);
            (h, o.all(0.25) / wo.dot(h))
        } else {
            let h = (wo * self.eta + wi).normalize_or(n);
            let h = Vector::pick(n.dot(h).above(zero), h, -h);
            let (cos_h, beyond) = (wo.dot(h), wi.dot(h));
            let denominator = self.eta * cos_h + beyond;
            let good = cos_h.above(zero) & zero.above(beyond);
            (h, R::pick(good, -beyond / (denominator * denominator), zero))
        };
        let change = R::pick(change.is_number() & change.above(zero), change, zero);
        let h = Vector::pick(above, mirror, microfacet);
        let cos_h = wo.dot(h);
        let change = R::pick(above, o.all(0.25) / cos_h.or_more(o.all(1e-20)), change);
        let density = self.slopes.density(n, h) * cos_h * change / o;
        let mirrored = self.mirrored(cos_h);
        let share = Vector::pick(above, mirrored, mirrored.rest());
        let [here, beyond] = [self.losses.x, self.losses.y];
        let mean = R::pick(above, here, beyond);
        let through = self.losses.z;
        let ends = R::pick(above, through.rest(), through);
        let lost_i = if R::bits(above) == 0 {
            self.lost(wi, cos_i, true)
        } else if R::bits(!above) == 0 || self.thin {
            self.lost(wi, cos_i, false)
        } else {
            R::pick(above, self.lost(wi, cos_i, false), self.lost(wi, cos_i, true))
        };
        let by_cosine = cos_i * FRAC_1_PI;
        let more = R::pick(mean.above_all(1e-6), prepared.lost * lost_i * by_cosine / mean, zero);
        let tint = Vector::pick(above, self.tints[0], self.tints[1]);
        let once = density / (prepared.hidden + hidden + o.all(1.0));
        let value = tint * (share * once + Vector::grey(ends * more));
        let probability = self.probability(mirrored);
        let probability = R::pick(above, probability, probability.rest());
        let microfacets = probability * density / (prepared.hidden + o.all(1.0));
        let pdf = prepared.lost.rest() * microfacets + prepared.lost * ends * by_cosine;
        let none = i.is(zero);
        (Vector::pick(none, Vector::grey(zero), value), R::pick(none, zero, pdf))
    }

    /// A direction in a frame with z = the normal and x along the slopes; `u` are numbers in [0, 1), of which
    /// the first chooses the event; and the points that have one.
    #[inline(always)]
    pub(super) fn sample(
        &self,
        prepared: PreparedGlass<R>,
        wo: Vector<R>,
        u: [R; 3],
        cosine: Vector<R>,
    ) -> (Vector<R>, R::Mask) {
        let zero = wo.z.all(0.0);
        let flip = |w: Vector<R>| Vector::new(w.x, w.y, -w.z);
        let further = prepared.lost.above(u[0]);
        let beyond = (prepared.lost * self.losses.z).above(u[0]);
        let scattered = Vector::pick(beyond, flip(cosine), cosine);
        let choice = (u[0] - prepared.lost) / prepared.lost.rest();
        let h = self.slopes.sample_visible(wo, [u[1], u[2]]);
        let cos = wo.dot(h);
        let mirrored = h * (cos * 2.0) - wo;
        let is_mirrored = self.probability(self.mirrored(cos)).above(choice);
        let (through, some) = if self.thin {
            (flip(mirrored), cos.is(cos))
        } else {
            let (wi, some) = refract(wo, h, self.eta);
            (wi.normalize_or(Vector::all(cos, Vec3::Z)), some)
        };
        let up = mirrored.z.above(zero);
        let down = zero.above(through.z) & some;
        let wi = Vector::pick(is_mirrored, mirrored, through);
        let good = (is_mirrored & up) | (!is_mirrored & down);
        (Vector::pick(further, scattered, wi), further | good)
    }
}

/// Fresnel's share averaged over a cosine-weighted hemisphere on the rarer side, `eta` <= 1: the fit of
/// [KC17].
fn fresnel_average(eta: f32) -> f32 {
    let ior = 1.0 / eta;
    ((ior - 1.0) / (4.085_67 + 1.000_71 * ior)).clamp(0.0, 1.0)
}

/// Reflectance of both faces of a pane, averaged over a cosine-weighted hemisphere; `eta` <= 1. It is less
/// than that of a pane whose faces each have the mean reflectance.
fn pane_average(eta: f32) -> f32 {
    static MEANS: OnceLock<[f32; INDICES]> = OnceLock::new();
    let means = MEANS.get_or_init(|| {
        std::array::from_fn(|index| {
            const STEPS: usize = 512;
            let s = 0.5 * index as f32 / (INDICES - 1) as f32;
            let middle = |k: usize| (k as f32 + 0.5) / STEPS as f32;
            let share = |cos: f32| pane(fresnel::dielectric(cos, (1.0 - s) / (1.0 + s)));
            (0..STEPS).map(middle).map(|cos| 2.0 * cos * share(cos) / STEPS as f32).sum()
        })
    });
    let (index, beyond) = cell(2.0 * (1.0 - eta) / (1.0 + eta), INDICES);
    means[index].lerp(means[index + 1], beyond)
}

const COSINES: usize = 48;
const ROUGHNESSES: usize = 32;
const INDICES: usize = 65;

/// Albedos after one bounce by cosine, the mirrored parts of them, and their average over a cosine-weighted hemisphere.
struct Row {
    albedo: [f32; COSINES],
    mirrored: [f32; COSINES],
    average: f32,
}

/// A position between four rows.
struct Albedos {
    /// By index, then by roughness.
    rows: [[&'static Row; 2]; 2],
    /// How far it is from the first ones.
    beyond: [f32; 2],
}

impl Albedos {
    fn of(alpha: f32, eta: f32) -> Self {
        let (index, beyond) = cell((eta - 1.0) / (eta + 1.0) + 0.5, INDICES);
        let (roughness, rougher) = cell(alpha.sqrt(), ROUGHNESSES);
        let rows = [index, index + 1].map(|i| [roughness, roughness + 1].map(|r| row(i, r)));
        Self { rows, beyond: [beyond, rougher] }
    }

    fn mix(&self, of: impl Fn(&Row) -> f32) -> f32 {
        let [low, high] = self.rows.map(|[a, b]| of(a).lerp(of(b), self.beyond[1]));
        low.lerp(high, self.beyond[0])
    }

    fn albedo(&self, cos: f32) -> f32 {
        let (column, t) = cell(cos, COSINES);
        self.mix(|row| row.albedo[column].lerp(row.albedo[column + 1], t))
    }

    fn mirrored_and_albedo(&self, cos: f32) -> [f32; 2] {
        let (column, t) = cell(cos, COSINES);
        let mixed =
            |of: fn(&Row) -> &[f32; COSINES]| self.mix(|row| of(row)[column].lerp(of(row)[column + 1], t));
        [mixed(|row| &row.mirrored), mixed(|row| &row.albedo)]
    }

    fn average(&self) -> f32 {
        self.mix(|row| row.average)
    }
}

/// Share of light at the cosine `cos` > 0 that even microfacets of glass mirror in one bounce, and that they lose.
#[inline(always)]
pub(super) fn mirrored_and_lost<R: Real>(alpha: R, eta: R, cos: R) -> [R; 2] {
    each_albedos(
        [alpha, eta, cos],
        #[inline(always)]
        |albedos, cos| {
            let [mirrored, albedo] = albedos.mirrored_and_albedo(cos);
            [mirrored, 1.0 - albedo]
        },
    )
}

/// Numbers of the albedos of each point at its cosine. Points side by side are often of one material: its position in the table is
/// computed once.
#[inline(always)]
fn each_albedos<R: Real, const N: usize>(
    [alpha, eta, cos]: [R; 3],
    f: impl Fn(&Albedos, f32) -> [f32; N],
) -> [R; N] {
    let mut last: Option<([f32; 2], Albedos)> = None;
    cos.each_of(
        #[inline(always)]
        |i| {
            let at = [alpha.lane(i), eta.lane(i)];
            let known = last.take().filter(|(place, _)| *place == at);
            let (_, albedos) = last.insert(known.unwrap_or_else(|| (at, Albedos::of(at[0], at[1]))));
            f(albedos, cos.lane(i))
        },
    )
}

/// A row of the table, computed at first use: a scene has few kinds of glass.
fn row(index: usize, roughness: usize) -> &'static Row {
    // Boxes: memory for all rows would be 400 KB of each program's and library's file.
    static ROWS: [[OnceLock<Box<Row>>; ROUGHNESSES]; INDICES] =
        [const { [const { OnceLock::new() }; ROUGHNESSES] }; INDICES];
    ROWS[index][roughness].get_or_init(|| {
        let s = index as f32 / (INDICES - 1) as f32 - 0.5;
        let ggx = Ggx::new(roughness as f32 / (ROUGHNESSES - 1) as f32);
        let entry =
            |c: usize| one_bounce(ggx, (1.0 + s) / (1.0 - s), (c as f32 / (COSINES - 1) as f32).max(1e-4));
        let both: [Vec2; COSINES] = std::array::from_fn(entry);
        let albedo = both.map(|both| both.element_sum().min(1.0));
        Box::new(Row { albedo, mirrored: both.map(|both| both.x), average: average(&albedo) })
    })
}

/// Light from cosine `cos` after one bounce, mirrored and through.
fn one_bounce(ggx: Ggx<f32>, eta: f32, cos: f32) -> Vec2 {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    ggx.mean_visible(wo, |h| {
        let share = fresnel::dielectric(wo.dot(h), eta);
        let weight = |cos_i: f32| ggx.sample_weight(cos, cos_i);
        let mirrored = (-wo).reflect(h);
        let mirrored = if mirrored.z > 0.0 { share * weight(mirrored.z) } else { 0.0 };
        let (through, some) = refract(wo.into(), h.into(), eta);
        let through = if some && through.z < 0.0 { (1.0 - share) * weight(-through.z) } else { 0.0 };
        Vec2::new(mirrored, through)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panes_mirror_on_average_what_the_average_of_their_shares_is() {
        for (ior, normal) in [(1.01_f32, 0.0), (1.33, 0.03), (1.5, 0.07), (2.2, 0.24)] {
            let share = |cos: f32| f64::from(pane(fresnel::dielectric(cos, 1.0 / ior)));
            let expected: f64 = (0..10_000)
                .map(|k| (k as f32 + 0.5) / 10_000.0)
                .map(|c| 2e-4 * f64::from(c) * share(c))
                .sum();
            let found = f64::from(pane_average(1.0 / ior));
            assert!((found - expected).abs() < 1e-3, "{ior}: {found}, not {expected}");
            assert!(found > normal, "more than head on: {found}");
        }
    }

    #[test]
    fn table_holds_the_lobe() {
        for (roughness, eta, cos) in
            [(0.45, 0.7, 0.9), (0.81, 1.4, 0.33), (1.0, 0.55, 0.21), (0.7, 1.25, 0.52)]
        {
            let ggx = Ggx::new(roughness);
            // Nothing lost: single scattering only.
            let tints = [Vector::grey(1.0); 2];
            let slopes = Slopes { ggx, anisotropy: None };
            let losses = Vector::grey(0.0);
            let glass = Glass { slopes, eta, film: None, rise: Plain, tints, losses, thin: false };
            let wo = Vec3::new((1.0_f32 - cos * cos).sqrt(), 0.0, cos);
            let prepared = glass.prepared(wo.into(), cos);
            let (rings, sectors) = (1600, 200);
            let mut sum = 0.0_f64;
            for (ring, sector) in (0..rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
                let z = 2.0 * (ring as f32 + 0.5) / rings as f32 - 1.0;
                let (sin, azimuth) = ((1.0 - z * z).sqrt(), (sector as f32 + 0.5) / sectors as f32);
                let (s, c) = (azimuth * std::f32::consts::TAU).sin_cos();
                let wi = Vec3::new(sin * c, sin * s, z);
                let (value, _) = glass.eval_pdf(prepared, Vec3::Z.into(), [wo.into(), wi.into()], [cos, z]);
                sum += f64::from(value.x);
            }
            let expected = sum * 2.0 * std::f64::consts::TAU / f64::from(rings * sectors);
            let found = f64::from(Albedos::of(ggx.alpha(), eta).albedo(cos));
            assert!((found - expected).abs() < 4e-3, "{roughness} {eta} {cos}: {found}, not {expected}");
        }
    }
}
