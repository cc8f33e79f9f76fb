// SPDX-License-Identifier: GPL-3.0-or-later
//! Glass that bends colours into different directions. Each of red, green and blue has its own index ([`eta_of`]).
//! A colour is chosen by the probabilities of a view, for the weights of its path: so a path of one colour
//! stays of that colour, and loses nothing more. One sample for all colours' lobes [VG95]; Cauchy's law as in
//! KHR_materials_dispersion. Points are evaluated one by one, because such glass is rare. Invariant:
//! reciprocal up to the square of each colour's own index.
//! Tests: `tests` of `bsdf`.

use glam::Vec3;

use super::dielectric::refract;
use super::film::{self, Base, Film};
use super::fresnel;
use super::lobe::eta_of;
use super::rough_dielectric::{Glass, PreparedGlass};
use crate::real::{Real, Vector};

/// Indices of some points, and probabilities of colours.
#[derive(Clone, Copy)]
pub(super) struct Colours<R> {
    /// See [`Lobe::spread`](super::Lobe::spread).
    pub(super) spread: R,
    /// Sums to 1 where the spread is not 0.
    pub(super) chances: Vector<R>,
}

impl<R: Real> Colours<R> {
    /// Probabilities for light of this weight, by colour.
    #[inline(always)]
    pub(super) fn chances(light: Vector<R>) -> Vector<R> {
        let sum = light.sum();
        let third = sum.all(1.0 / 3.0);
        Vector::pick(sum.above_all(0.0) & sum.is_number(), light.over(sum), Vector::grey(third))
    }

    fn point(&self, i: usize) -> (f32, Vec3) {
        (self.spread.lane(i), self.chances.get(i))
    }
}

/// The glass for one colour. Lost energy depends so little on the index that one colour's tables serve all
/// colours, except for the share of transmission.
fn of_colour(glass: &Glass<f32>, spread: f32, channel: usize) -> Glass<f32> {
    let eta = eta_of(glass.eta, spread, channel);
    let mut losses = glass.losses;
    losses.z = (losses.z * glass.eta / eta).min(1.0);
    Glass { eta, losses, ..*glass }
}

/// Values by colour and the density of all, in place of `plain` where colours differ; see
/// [`Glass::eval_pdf`].
#[inline(always)]
pub(super) fn eval_pdf<R: Real>(
    glass: &Glass<R>,
    colours: &Colours<R>,
    n: Vector<R>,
    [wo, wi]: [Vector<R>; 2],
    [o, i]: [R; 2],
    (value, pdf): (Vector<R>, R),
) -> (Vector<R>, R) {
    let is = colours.spread.above_all(0.0);
    let [r, g, b, density] = pdf.each_where(
        is,
        #[inline(always)]
        |k| {
            let directions = [wo.get(k), wi.get(k)];
            one(&glass.point(k), colours.point(k), n.get(k), directions, [o.lane(k), i.lane(k)])
        },
    );
    (Vector::pick(is, Vector::new(r, g, b), value), R::pick(is, density, pdf))
}

#[inline(never)]
fn one(
    glass: &Glass<f32>,
    (spread, chances): (f32, Vec3),
    n: Vec3,
    [wo, wi]: [Vec3; 2],
    [o, i]: [f32; 2],
) -> [f32; 4] {
    let (mut value, mut pdf) = (Vec3::ZERO, 0.0);
    for channel in 0..3 {
        let glass = of_colour(glass, spread, channel);
        let prepared = glass.prepared(wo.into(), o);
        let (light, density) = glass.eval_pdf(prepared, n.into(), [wo.into(), wi.into()], [o, i]);
        value[channel] = Vec3::from(light)[channel];
        pdf += chances[channel] * density;
    }
    value.extend(pdf).into()
}

/// Which colour a number in [0, 1) chooses, and a new number.
fn choose(chances: Vec3, u: f32) -> (usize, f32) {
    let mut before = 0.0;
    for channel in 0..2 {
        let past = before + chances[channel];
        if u < past {
            return (channel, ((u - before) / chances[channel]).clamp(0.0, 0.999_999_9));
        }
        before = past;
    }
    let last = if chances.z > 0.0 { 2 } else { usize::from(chances.y > 0.0) };
    (last, ((u - before) / chances.z.max(1e-20)).clamp(0.0, 0.999_999_9))
}

/// See [`Glass::sample`]: where colours differ, and whether there is a direction; `wo` is that of the world, `local` that of the frame.
#[inline(always)]
pub(super) fn sample<R: Real>(
    glass: &Glass<R>,
    colours: &Colours<R>,
    [wo, local]: [Vector<R>; 2],
    u: [R; 3],
    cosine: Vector<R>,
    (wi, some): (Vector<R>, R::Mask),
) -> (Vector<R>, R::Mask) {
    let is = colours.spread.above_all(0.0);
    let none = Vec3::ZERO;
    let chosen = wi.each_colour(
        is,
        #[inline(always)]
        |k, _| {
            let u = [u[0].lane(k), u[1].lane(k), u[2].lane(k)];
            let directions = [wo.get(k), local.get(k)];
            sample_one(&glass.point(k), colours.point(k), directions, u, cosine.get(k)).unwrap_or(none)
        },
    );
    (chosen, (is & !chosen.is_zero()) | (!is & some))
}

#[inline(never)]
fn sample_one(
    glass: &Glass<f32>,
    (spread, chances): (f32, Vec3),
    [wo, local]: [Vec3; 2],
    [first, x, y]: [f32; 3],
    cosine: Vec3,
) -> Option<Vec3> {
    let (channel, first) = choose(chances, first);
    let glass = of_colour(glass, spread, channel);
    let prepared: PreparedGlass<f32> = glass.prepared(wo.into(), local.z);
    let (wi, some) = glass.sample(prepared, local.into(), [first, x, y], cosine.into());
    some.then(|| wi.into())
}

/// Smooth glass: the direction in the frame of `wo`, unit, that `u` in [0, 1) chooses, and its light over the probability of that.
pub(super) fn branch(
    eta: f32,
    (spread, chances): (f32, Vec3),
    film: Film,
    tints: [Vec3; 2],
    wo: Vec3,
    u: f32,
) -> (Vec3, Vec3) {
    let etas = [0, 1, 2].map(|channel| eta_of(eta, spread, channel));
    let mirrored = Vec3::from([0, 1, 2].map(|channel| {
        let bare = fresnel::dielectric(wo.z, etas[channel]);
        if film.share > 0.0 {
            let filmed = film::reflectance(film, wo.z, Base::Index(etas[channel]))[channel];
            bare + (filmed - bare) * film.share
        } else {
            bare
        }
    }));
    let lights = [tints[0] * mirrored, tints[1] * (Vec3::ONE - mirrored)];
    let [a, b] = lights.map(|light| chances.dot(light));
    let probability = if a + b > 0.0 { a / (a + b) } else { 1.0 };
    if u < probability {
        return (Vec3::new(-wo.x, -wo.y, wo.z), lights[0] / probability);
    }
    let shares = chances * lights[1] / b;
    let (channel, _) = choose(shares, ((u - probability) / (1.0 - probability)).min(0.999_999_9));
    let (through, _) = refract(wo.into(), Vec3::Z.into(), etas[channel]);
    let mut light = Vec3::ZERO;
    light[channel] = lights[1][channel] / ((1.0 - probability) * shares[channel]);
    (Vec3::from(through), light)
}
