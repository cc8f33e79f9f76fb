// SPDX-License-Identifier: GPL-3.0-or-later
//! Thin films: reflectance under a layer of some hundred nanometres, with interference of its two sides'
//! reflections.
//! Source: \[BB17\] (the sum over reflections within the film, and the eye's curves as Gaussians, which turn it into colours); Fresnel's
//! equations for complex indices ([PJH23] section 9.3). Differs: both polarisations by complex amplitudes; each channel has its own phase;
//! colours are white where the film is thin to nothing, so that the film then is as if it were not there.
//! Units: nanometres; indices relative to vacuum. Colours are in [0, 1], because no reflectance is outside.
//! Light is computed point by point: films are rare.
//! Invariant: both sides of a boundary have the same reflectance along one ray. Tests: `tests`.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

/// A film.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Film {
    /// Share of the surface that it is on, in [0, 1]; 0 = there is none.
    pub share: f32,
    /// Its index of refraction, > 0.
    pub ior: f32,
    /// Nanometres, >= 0.
    pub thickness: f32,
}

impl Film {
    /// Whether there is one.
    #[must_use]
    pub fn is_there(&self) -> bool {
        self.share > 0.0 && self.ior > 0.0 && self.ior.is_finite() && self.thickness.is_finite()
    }
}

/// The material below.
#[derive(Clone, Copy, Debug)]
pub(super) enum Base {
    /// A material with this reflectance at normal incidence, by colour.
    Normal(Vec3),
    /// A metal, by its indices and extinction coefficients.
    Metal(Vec3, Vec3),
    /// Glass: the index on the side that light comes from over that beyond, the smaller being 1.
    Index(f32),
}

/// Reflections within the film that are summed one by one.
const ORDERS: usize = 3;

/// Sums of Gaussians, as strength, middle (waves per metre) and variance: the sensitivity curves of x, x
/// again, y and z.
const CURVES: [[f32; 3]; 4] = [
    [5.4856e-13, 1.6810e6, 4.3278e9],
    [9.7470e-14, 2.2399e6, 4.5282e9],
    [4.4201e-13, 1.7953e6, 9.3046e9],
    [5.2481e-13, 2.2084e6, 6.6121e9],
];
/// From x, x again, y and z to red, green and blue of sRGB.
const RGB: [[f32; 4]; 3] = [
    [3.240_97, 3.240_97, -1.537_383, -0.498_611],
    [-0.969_244, -0.969_244, 1.875_968, 0.041_555],
    [0.055_63, 0.055_63, -0.203_977, 1.056_972],
];

/// Response of one channel to a wave with the path difference `path` (metres) and a shift of phase, relative
/// to that without both.
fn response(channel: usize, path: f32, shift: f32) -> f32 {
    let at = |path: f32, shift: f32| -> f32 {
        let phase = TAU * path;
        let curve = |([strength, middle, variance], by): ([f32; 3], f32)| {
            by * strength
                * variance.sqrt()
                * (middle * phase + shift).cos()
                * (-variance * phase * phase).exp()
        };
        CURVES.into_iter().zip(RGB[channel]).map(curve).sum()
    };
    at(path, shift) / at(0.0, 0.0)
}

/// The product of two complex numbers, and the quotient.
fn times(a: Vec2, b: Vec2) -> Vec2 {
    Vec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

fn over(a: Vec2, b: Vec2) -> Vec2 {
    times(a, Vec2::new(b.x, -b.y)) / b.length_squared().max(f32::MIN_POSITIVE)
}

/// The square root in the right half of the plane.
fn root(a: Vec2) -> Vec2 {
    let length = a.length();
    let (re, im) = (((length + a.x) * 0.5).max(0.0).sqrt(), ((length - a.x) * 0.5).max(0.0).sqrt());
    Vec2::new(re, im.copysign(a.y))
}

/// Amplitudes that are mirrored where light at the cosine `cos` to the normal goes from the index `here` to a complex one, for light
/// that swings across the plane of incidence and within it.
fn amplitudes(cos: f32, here: f32, beyond: Vec2) -> [Vec2; 2] {
    let square = times(beyond, beyond);
    let within = root(square - Vec2::new(here * here * (1.0 - cos * cos), 0.0));
    let across = [Vec2::new(here * cos, 0.0) - within, Vec2::new(here * cos, 0.0) + within];
    let along = [square * cos - within * here, square * cos + within * here];
    [over(across[0], across[1]), over(along[0], along[1])]
}

/// Share of light that is mirrored, by colour, `cos` being that of the angle to the normal on the side that light comes from.
pub(super) fn reflectance(film: Film, cos: f32, base: Base) -> Vec3 {
    let cos = cos.clamp(0.0, 1.0);
    let here = match base {
        Base::Index(eta) => eta.max(1.0),
        _ => 1.0,
    };
    let sin2 = (here / film.ior).powi(2) * (1.0 - cos * cos);
    if sin2 >= 1.0 {
        return Vec3::ONE;
    }
    let within = (1.0 - sin2).sqrt();
    let upper = amplitudes(cos, here, Vec2::new(film.ior, 0.0)).map(|r| r.x);
    let path = 2.0 * film.ior * film.thickness * 1e-9 * within;
    let beyond = |channel: usize| match base {
        Base::Normal(f0) => {
            let root = f0[channel].clamp(0.0, 0.9999).sqrt();
            Vec2::new((1.0 + root) / (1.0 - root), 0.0)
        }
        Base::Metal(eta, k) => Vec2::new(eta[channel], k[channel]),
        Base::Index(eta) => Vec2::new((1.0 / eta).max(1.0), 0.0),
    };
    let channel = |channel: usize| {
        let lower = amplitudes(within, film.ior, beyond(channel));
        let mirrored: f32 =
            upper.into_iter().zip(lower).map(|(r, below)| interfere(channel, r, below, path)).sum();
        (0.5 * mirrored).clamp(0.0, 1.0)
    };
    Vec3::new(channel(0), channel(1), channel(2))
}

/// Reflectance of the film for one polarisation; `r` is the amplitude of its upper side from above, `below`
/// that of its lower one.
fn interfere(channel: usize, r: f32, below: Vec2, path: f32) -> f32 {
    let (upper, lower) = (r * r, below.length_squared().min(1.0));
    let both = (upper * lower).min(0.9999);
    let through = 1.0 - upper;
    let rest = through * through * lower / (1.0 - both);
    // Within the film light meets the upper side from below.
    let shift = below.y.atan2(below.x) + if r > 0.0 { PI } else { 0.0 };
    let mut sum = upper + rest;
    let mut part = rest - through;
    for order in 1..=ORDERS {
        part *= both.sqrt();
        let order = order as f32;
        sum += 2.0 * part * response(channel, order * path, order * shift);
    }
    sum
}

/// The same averaged over a cosine-weighted hemisphere.
pub(super) fn average(film: Film, base: Base) -> Vec3 {
    super::energy::RULE.into_iter().map(|(cos, weight)| reflectance(film, cos, base) * weight).sum()
}

#[cfg(test)]
mod tests {
    use super::super::fresnel;
    use super::*;

    const GOLD: Base = Base::Metal(Vec3::new(0.143, 0.375, 1.442), Vec3::new(3.983, 2.386, 1.603));

    fn of(thickness: f32) -> Film {
        Film { share: 1.0, ior: 1.33, thickness }
    }

    #[test]
    fn films_of_no_thickness_are_not_there() {
        for cos in [0.15_f32, 0.5, 0.9, 1.0] {
            let plastic = reflectance(of(0.0), cos, Base::Index(1.0 / 1.5));
            let bare = fresnel::dielectric(cos, 1.0 / 1.5);
            assert!(
                (plastic - Vec3::splat(bare)).abs().max_element() < 0.004,
                "{cos}: {plastic}, bare {bare}"
            );
            let Base::Metal(eta, k) = GOLD else { unreachable!("it is a metal") };
            let gold = reflectance(of(0.0), cos, GOLD);
            let bare = Vec3::from([0, 1, 2].map(|c| fresnel::conductor(cos, eta[c], k[c])));
            assert!((gold - bare).abs().max_element() < 0.01, "{cos}: {gold}, bare {bare}");
        }
    }

    /// Airy's formula wave by wave, over a spectrum that a channel sees alike from 380 to 780 nm: an oracle for thick films, whose
    /// colours are washed out, and for the mean over thicknesses of thin ones.
    #[test]
    fn the_mean_over_thicknesses_is_that_of_airys_formula() {
        for (cos, base) in
            [(0.9_f32, GOLD), (0.4, GOLD), (0.7, Base::Index(1.0 / 1.5)), (0.8, Base::Index(1.5))]
        {
            let here = if let Base::Index(eta) = base { eta.max(1.0) } else { 1.0 };
            let within = (1.0 - (here / 1.33_f32).powi(2) * (1.0 - cos * cos)).sqrt();
            let count = 200;
            let thickness = |i: u32| 2000.0 + 4.0 * i as f32;
            let found: Vec3 =
                (0..count).map(|i| reflectance(of(thickness(i)), cos, base) / count as f32).sum();
            let upper = amplitudes(cos, here, Vec2::new(1.33, 0.0));
            for channel in 0..3 {
                let beyond = match base {
                    Base::Metal(eta, k) => Vec2::new(eta[channel], k[channel]),
                    Base::Index(eta) => Vec2::new((1.0 / eta).max(1.0), 0.0),
                    Base::Normal(_) => unreachable!("not here"),
                };
                let lower = amplitudes(within, 1.33, beyond);
                let mut expected = 0.0;
                for (i, (r, below)) in
                    (0..100).flat_map(|i| upper.into_iter().zip(lower).map(move |x| (i, x)))
                {
                    let angle = times(below, Vec2::from_angle(TAU * i as f32 / 100.0));
                    let r = over(r + angle, Vec2::X + times(r, angle));
                    expected += 0.5 * r.length_squared() / 100.0;
                }
                let off = (found[channel] - expected).abs();
                assert!(off < 0.01, "cos {cos}, channel {channel}: {}, not {expected}", found[channel]);
            }
        }
    }

    #[test]
    fn both_sides_mirror_alike() {
        for thickness in [0.0, 150.0, 320.0, 900.0] {
            for cos in [0.2_f32, 0.6, 0.95] {
                let outside = reflectance(of(thickness), cos, Base::Index(1.0 / 1.6));
                let inside = (1.0 - (1.0 - cos * cos) / (1.6 * 1.6)).sqrt();
                let back = reflectance(of(thickness), inside, Base::Index(1.6));
                assert!((outside - back).abs().max_element() < 1e-4, "{thickness} {cos}: {outside}, {back}");
            }
        }
        assert_eq!(reflectance(of(300.0), 0.3, Base::Index(1.6)), Vec3::ONE, "total reflection");
    }

    /// Newton's colours: a film on plastic is dark where it is thin, and has hues where it is some hundred nanometres thick.
    #[test]
    fn films_have_colours() {
        let hue = |thickness| reflectance(of(thickness), 1.0, Base::Index(1.0 / 1.6));
        // A path of 545 nm within it, and both sides shift the phase alike: green adds up.
        let green = hue(205.0);
        assert!(green.y > 1.1 * green.x && green.y > 1.4 * green.z, "green: {green}");
        let span = |thickness| {
            let color = hue(thickness);
            color.max_element() - color.min_element()
        };
        assert!(
            span(300.0) > 0.01 && span(4000.0) < 0.002,
            "thick ones are grey: {} {}",
            span(300.0),
            span(4000.0)
        );
    }
}
