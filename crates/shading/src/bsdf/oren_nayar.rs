// SPDX-License-Identifier: GPL-3.0-or-later
//! Rough diffuse surfaces, dusty ones: Oren's and Nayar's model as Fujii's fit, with all bounces between the
//! microfacets.
//! Source: [PKH25] (EON), which mends [ON94]; [Lam60] where the roughness is 0. Directions are given by their
//! cosines to the shading normal. `roughness` is in [0, 1]. Tests: `tests` of `bsdf`.

use std::f32::consts::{FRAC_1_PI, PI};

use crate::real::{Real, Vector};

const C1: f32 = 0.5 - 2.0 / (3.0 * PI);
const C2: f32 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// The value times the cosine of `wi` for two directions whose dot product is `dot`; `white_o` is
/// [`white_once`] of `wo`.
#[inline(always)]
pub(super) fn eval<R: Real>(
    albedo: Vector<R>,
    roughness: R,
    white_o: R,
    dot: R,
    [o, i]: [R; 2],
) -> Vector<R> {
    let zero = dot.all(0.0);
    let s = dot - o * i;
    let s_over_t = R::pick(s.above_all(0.0), s / o.or_more(i), s);
    let a = dot.all(1.0) / (roughness * C1 + dot.all(1.0));
    let once = albedo * (a * (roughness * s_over_t + dot.all(1.0)));
    let average = average(roughness);
    let lost = average.rest().or_more(dot.all(1e-7));
    let lobe = white_o.rest() * white_once(roughness, i).rest() / lost;
    (once + more(albedo, average) * lobe).max(Vector::grey(zero)) * (i * FRAC_1_PI)
}

/// Share of light from a direction that is sent back; `white_o` is its [`white_once`].
#[inline(always)]
pub(super) fn albedo<R: Real>(albedo: Vector<R>, roughness: R, white_o: R) -> Vector<R> {
    albedo * white_o + more(albedo, average(roughness)) * white_o.rest()
}

#[inline(always)]
fn average<R: Real>(roughness: R) -> R {
    let one = roughness.all(1.0);
    (roughness * C2 + one) / (roughness * C1 + one)
}

/// Colour of all bounces but the first.
#[inline(always)]
fn more<R: Real>(albedo: Vector<R>, average: R) -> Vector<R> {
    albedo.map(
        #[inline(always)]
        |a| a * a * average / (a * average.rest()).rest(),
    )
}

/// Albedo after one bounce of a white surface seen at the cosine `cos`: the integral in closed form.
#[inline(always)]
pub(super) fn white_once<R: Real>(roughness: R, cos: R) -> R {
    let cos = cos.within(0.0, 1.0);
    cos.each(
        #[inline(always)]
        |i| {
            let (roughness, cos) = (roughness.lane(i), cos.lane(i));
            let sin = (1.0 - cos * cos).sqrt();
            // (sin / cos) (1 - sin³) without the cancellation: 1 - sin = cos² / (1 + sin).
            let tail = sin * cos * (1.0 + sin + sin * sin) / (1.0 + sin);
            let g = sin * (cos.acos() - sin * cos) + 2.0 / 3.0 * (tail - sin);
            (1.0 + roughness * FRAC_1_PI * g) / (1.0 + C1 * roughness)
        },
    )
}
