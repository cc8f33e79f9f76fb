// SPDX-License-Identifier: GPL-3.0-or-later
//! Rough glass: GGX facets that mirror and refract, with what goes between them more than once.
//! Source: [WMLT07] (the lobe and its densities), [Hei14], [DB23]; [KC17] for further bounces: what one bounce loses comes
//! back as two diffuse lobes, mirrored and through, in the proportion that keeps the model reciprocal.
//! Space: the shading frame. Radiance is not scaled by the square of the index: see `bsdf`. So values through the surface
//! over the square of the index beyond are the same with both directions exchanged.
//! Proof: `tests::table_holds_the_lobe`, `tests` of `bsdf`.

use std::f32::consts::FRAC_1_PI;
use std::sync::OnceLock;

use glam::Vec3;

use super::dielectric::{pane, refract};
use super::energy::{Energy, place};
use super::ggx::Ggx;
use super::{BsdfSample, fresnel};
use crate::sampling::cosine_hemisphere;

/// Rough glass as one side of it is met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    ggx: Ggx,
    /// Index on the side that rays come from over the index beyond.
    eta: f32,
    reflectance: Vec3,
    transmittance: Vec3,
    thin: bool,
    /// Share of what one bounce loses, averaged over all directions, on this side and beyond.
    lost: [f32; 2],
    /// Share of further bounces that ends beyond.
    more_through: f32,
}

/// Nearer to 1 than this an index bends nothing that a float could tell.
const SMALLEST_STEP: f32 = 1e-3;

impl RoughDielectric {
    /// `alpha` is the width of the facets' slopes, in (0, 1]; `eta` the index of refraction on the side that rays come
    /// from over the index beyond, > 0; tints are in [0, 1]; `thin` is a pane whose faces lie so close that light goes
    /// through unbent.
    #[must_use]
    pub fn new(alpha: f32, eta: f32, reflectance: Vec3, transmittance: Vec3, thin: bool) -> Self {
        let ggx = Ggx::from_alpha(alpha);
        let eta = match eta {
            eta if thin => eta.min(1.0 / eta),
            eta if (eta - 1.0).abs() < SMALLEST_STEP => 1.0 + SMALLEST_STEP.copysign(eta - 1.0),
            eta => eta,
        };
        let rare = eta.min(1.0 / eta);
        let (lost, more_through) = if thin {
            let lost = 1.0 - Energy::of(ggx).white_average();
            ([lost; 2], 1.0 - pane_average(rare))
        } else {
            let lost = [eta, 1.0 / eta].map(|eta| 1.0 - Glass::of(ggx, eta).average());
            let mirrored = fresnel_average(rare);
            // With the index beyond as unit: shares through are as the inverse of these on the two sides.
            let capacity = [lost[0] * eta * eta, lost[1]];
            let through = (1.0 - mirrored) * capacity[0].min(capacity[1]) / capacity[0].max(1e-9);
            (lost, through.min(1.0))
        };
        Self { ggx, eta, reflectance, transmittance, thin, lost, more_through }
    }

    /// The same glass met from the other side.
    #[cfg(test)]
    pub(super) fn turned_over(&self) -> Self {
        let eta = if self.thin { self.eta } else { 1.0 / self.eta };
        Self::new(self.ggx.alpha(), eta, self.reflectance, self.transmittance, self.thin)
    }

    /// Index of refraction on the side that rays come from over the index beyond; 1 for panes.
    pub(super) fn eta(&self) -> f32 {
        if self.thin { 1.0 } else { self.eta }
    }

    /// Width of the facets' slopes.
    pub(super) fn alpha(&self) -> f32 {
        self.ggx.alpha()
    }

    /// Share of light that a facet mirrors.
    fn mirrored(&self, cos: f32) -> f32 {
        let once = fresnel::dielectric(cos, self.eta);
        if self.thin { pane(once) } else { once }
    }

    /// Probability with which a facet's mirrored branch is followed.
    fn chance(&self, mirrored: f32) -> f32 {
        let a = mirrored * self.reflectance.max_element();
        let b = (1.0 - mirrored) * self.transmittance.max_element();
        if a + b > 0.0 { a / (a + b) } else { 1.0 }
    }

    /// Share of light from cosine `cos` that one bounce sends back or through, on this side or beyond.
    fn once(&self, cos: f32, beyond: bool) -> f32 {
        if self.thin {
            Energy::of(self.ggx).white(cos)
        } else {
            Glass::of(self.ggx, if beyond { 1.0 / self.eta } else { self.eta }).albedo(cos)
        }
    }

    /// The facet that leads from `wo` through to `wi`, and the change of its solid angle with that of `wi`.
    fn facet_through(&self, wo: Vec3, wi: Vec3) -> Option<(Vec3, f32)> {
        if self.thin {
            let h = (wo + flipped(wi)).try_normalize()?;
            return Some((h, 1.0 / (4.0 * wo.dot(h))));
        }
        let h = (wo * self.eta + wi).try_normalize()?;
        let h = if h.z < 0.0 { -h } else { h };
        let (cos_o, cos_i) = (wo.dot(h), wi.dot(h));
        if cos_o <= 0.0 || cos_i >= 0.0 {
            return None;
        }
        let way = self.eta * cos_o + cos_i;
        let change = -cos_i / (way * way);
        change.is_finite().then_some((h, change))
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let cos_i = wi.z.abs();
        let lost = (1.0 - self.once(wo.z, false)) * FRAC_1_PI * cos_i;
        let more = |beyond: bool| {
            let mean = self.lost[usize::from(beyond)];
            if mean < 1e-6 { 0.0 } else { lost * (1.0 - self.once(cos_i, beyond)) / mean }
        };
        if wi.z > 0.0 {
            let h = (wo + wi).normalize_or(Vec3::Z);
            let once = self.mirrored(wo.dot(h)) * self.ggx.lobe_cos(wo, wi, h);
            return self.reflectance * (once + (1.0 - self.more_through) * more(false));
        }
        if wi.z == 0.0 {
            return Vec3::ZERO;
        }
        let once = self.facet_through(wo, wi).map_or(0.0, |(h, change)| {
            let cos = wo.dot(h);
            let shape = self.ggx.density(h) * self.ggx.visible_from_both(wo, wi) * cos * change / wo.z;
            (1.0 - self.mirrored(cos)) * shape
        });
        self.transmittance * (once + self.more_through * more(true))
    }

    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let more = 1.0 - self.once(wo.z, false);
        let visible = |h: Vec3| self.ggx.density(h) * self.ggx.visible_from(wo) / wo.z;
        if wi.z > 0.0 {
            let h = (wo + wi).normalize_or(Vec3::Z);
            let facets = self.chance(self.mirrored(wo.dot(h))) * self.ggx.mirrored_pdf(wo, h);
            return (1.0 - more) * facets + more * (1.0 - self.more_through) * FRAC_1_PI * wi.z;
        }
        let facets = self.facet_through(wo, wi).map_or(0.0, |(h, change)| {
            let cos = wo.dot(h);
            (1.0 - self.chance(self.mirrored(cos))) * visible(h) * cos * change
        });
        (1.0 - more) * facets - more * self.more_through * FRAC_1_PI * wi.z
    }

    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let (more, pair) = (1.0 - self.once(wo.z, false), [u[1], u[2]]);
        let wi = if u[0] < more {
            let wi = cosine_hemisphere(pair);
            if u[0] < more * self.more_through { flipped(wi) } else { wi }
        } else {
            let choice = (u[0] - more) / (1.0 - more);
            let h = self.ggx.sample_visible(wo, pair);
            let cos = wo.dot(h);
            let mirrored = (-wo).reflect(h);
            if choice < self.chance(self.mirrored(cos)) {
                Some(mirrored).filter(|wi| wi.z > 0.0)?
            } else if self.thin {
                Some(flipped(mirrored)).filter(|wi| wi.z < 0.0)?
            } else {
                refract_at(wo, h, self.eta).filter(|wi| wi.z < 0.0)?
            }
        };
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.eval(wo, wi) / pdf,
            pdf,
            delta: false,
            transmitted: wi.z < 0.0,
        })
    }

    pub(super) fn albedo(&self, wo: Vec3) -> Vec3 {
        // About: facets mirror as the plane does, blurred.
        let mirrored = self.mirrored(wo.z.lerp_to(0.7, self.ggx.alpha() * 0.5));
        self.transmittance.lerp(self.reflectance, mirrored)
    }
}

trait LerpTo {
    fn lerp_to(self, to: f32, t: f32) -> f32;
}

impl LerpTo for f32 {
    fn lerp_to(self, to: f32, t: f32) -> f32 {
        self + (to - self) * t
    }
}

fn flipped(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

/// `wo` refracted at the facet `h` that it sees; `None` if all is mirrored.
fn refract_at(wo: Vec3, h: Vec3, eta: f32) -> Option<Vec3> {
    let cos = wo.dot(h);
    let beyond = -refract(Vec3::new(0.0, (1.0 - cos * cos).max(0.0).sqrt(), cos), eta)?.z;
    Some((h * (eta * cos - beyond) - wo * eta).normalize())
}

/// Fresnel's share averaged over a cosine-weighted hemisphere on the rarer side, `eta` <= 1: the fit of [KC17].
fn fresnel_average(eta: f32) -> f32 {
    let ior = 1.0 / eta;
    ((ior - 1.0) / (4.085_67 + 1.000_71 * ior)).clamp(0.0, 1.0)
}

/// What both faces of a pane mirror, averaged over a cosine-weighted hemisphere; `eta` <= 1. Less than a pane of faces that each
/// mirror the average would.
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
    let (index, beyond) = place(2.0 * (1.0 - eta) / (1.0 + eta), INDICES);
    means[index].lerp_to(means[index + 1], beyond)
}

const COSINES: usize = 48;
const ROUGHNESSES: usize = 32;
const INDICES: usize = 65;

/// Albedos after one bounce by cosine, and their average over a cosine-weighted hemisphere.
struct Row {
    albedo: [f32; COSINES],
    average: f32,
}

/// A place between four rows.
struct Glass {
    /// By index, then by roughness.
    rows: [[&'static Row; 2]; 2],
    /// How far it is from the first ones.
    beyond: [f32; 2],
}

impl Glass {
    fn of(ggx: Ggx, eta: f32) -> Self {
        let (index, beyond) = place((eta - 1.0) / (eta + 1.0) + 0.5, INDICES);
        let (roughness, rougher) = place(ggx.alpha().sqrt(), ROUGHNESSES);
        let rows = [index, index + 1].map(|i| [roughness, roughness + 1].map(|r| row(i, r)));
        Self { rows, beyond: [beyond, rougher] }
    }

    fn mix(&self, of: impl Fn(&Row) -> f32) -> f32 {
        let [low, high] = self.rows.map(|[a, b]| of(a).lerp_to(of(b), self.beyond[1]));
        low.lerp_to(high, self.beyond[0])
    }

    fn albedo(&self, cos: f32) -> f32 {
        let (column, t) = place(cos, COSINES);
        self.mix(|row| row.albedo[column].lerp_to(row.albedo[column + 1], t))
    }

    fn average(&self) -> f32 {
        self.mix(|row| row.average)
    }
}

/// The integral of `2 cos f(cos)` over [0, 1] for `f` linear between its entries.
fn average(entries: &[f32; COSINES]) -> f32 {
    const STEP: f32 = 1.0 / (COSINES - 1) as f32;
    let segment = |k: usize| {
        let (a, b, x) = (entries[k], entries[k + 1], k as f32 * STEP);
        ((a + b) * x + (a + 2.0 * b) * (STEP / 3.0)) * STEP
    };
    (0..COSINES - 1).map(segment).sum()
}

/// A row of the table, made when it is first asked for: a scene has few kinds of glass.
fn row(index: usize, roughness: usize) -> &'static Row {
    // Boxes: room for all rows would be 400 KB of each program's and library's file.
    static ROWS: [[OnceLock<Box<Row>>; ROUGHNESSES]; INDICES] =
        [const { [const { OnceLock::new() }; ROUGHNESSES] }; INDICES];
    ROWS[index][roughness].get_or_init(|| {
        let s = index as f32 / (INDICES - 1) as f32 - 0.5;
        let ggx = Ggx::new(roughness as f32 / (ROUGHNESSES - 1) as f32);
        let entry =
            |c: usize| one_bounce(ggx, (1.0 + s) / (1.0 - s), (c as f32 / (COSINES - 1) as f32).max(1e-4));
        let albedo = std::array::from_fn(entry);
        Box::new(Row { albedo, average: average(&albedo) })
    })
}

/// Light from cosine `cos` after one bounce, mirrored and through.
fn one_bounce(ggx: Ggx, eta: f32, cos: f32) -> f32 {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mean = ggx.mean_visible(wo, |h| {
        let share = fresnel::dielectric(wo.dot(h), eta);
        let mirrored = share * ggx.sample_weight(wo, (-wo).reflect(h));
        let through = refract_at(wo, h, eta)
            .filter(|wi| wi.z < 0.0)
            .map_or(0.0, |wi| (1.0 - share) * ggx.visible_from_both(wo, wi) / ggx.visible_from(wo));
        mirrored + through
    });
    mean.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panes_mirror_on_average_what_the_average_of_their_shares_is() {
        for (ior, normal) in [(1.01_f32, 0.0), (1.33, 0.03), (1.5, 0.07), (2.2, 0.24)] {
            let share = |cos: f32| f64::from(pane(fresnel::dielectric(cos, 1.0 / ior)));
            let wanted: f64 = (0..10_000)
                .map(|k| (k as f32 + 0.5) / 10_000.0)
                .map(|c| 2e-4 * f64::from(c) * share(c))
                .sum();
            let found = f64::from(pane_average(1.0 / ior));
            assert!((found - wanted).abs() < 1e-3, "{ior}: {found}, not {wanted}");
            assert!(found > normal, "more than head on: {found}");
        }
    }

    #[test]
    fn table_holds_the_lobe() {
        for (roughness, eta, cos) in
            [(0.45, 0.7, 0.9), (0.81, 1.4, 0.33), (1.0, 0.55, 0.21), (0.7, 1.25, 0.52)]
        {
            let ggx = Ggx::new(roughness);
            let glass = RoughDielectric::new(ggx.alpha(), eta, Vec3::ONE, Vec3::ONE, false);
            let none_lost = RoughDielectric { lost: [0.0; 2], ..glass };
            let wo = Vec3::new((1.0_f32 - cos * cos).sqrt(), 0.0, cos);
            let (rings, sectors) = (1600, 200);
            let mut sum = 0.0_f64;
            for (ring, sector) in (0..rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
                let z = 2.0 * (ring as f32 + 0.5) / rings as f32 - 1.0;
                let (sin, azimuth) = ((1.0 - z * z).sqrt(), (sector as f32 + 0.5) / sectors as f32);
                let (s, c) = (azimuth * std::f32::consts::TAU).sin_cos();
                sum += f64::from(none_lost.eval(wo, Vec3::new(sin * c, sin * s, z)).x);
            }
            let wanted = sum * 2.0 * std::f64::consts::TAU / f64::from(rings * sectors);
            let found = f64::from(Glass::of(ggx, eta).albedo(cos));
            assert!((found - wanted).abs() < 4e-3, "{roughness} {eta} {cos}: {found}, not {wanted}");
        }
    }
}
