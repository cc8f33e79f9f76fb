// SPDX-License-Identifier: GPL-3.0-or-later
//! Albedo of rough microfacets after single scattering, and a lobe for multiple scattering.
//! Source: [KC17] (the lobe, from the albedo after one bounce; colour by the sum over bounces), tables over
//! the cosine of the view and the roughness, split as in [Kar13] so that they are linear in Schlick's two
//! reflectances.
//! Invariant: averages are those of the interpolated tables, so that single scattering and the lobe sum to 1
//! for white microfacets up to the rounding of floats. The tables are the same on all machines: they are sums
//! in a fixed order.
//! Tests: `tests::{tables_hold_the_lobe, white_keeps_all_light}`.

use std::f32::consts::FRAC_1_PI;
use std::iter::Sum;
use std::ops::{Add, Mul};
use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::fresnel::schlick_rise;
use super::ggx::Ggx;
use crate::real::{Real, Vector};

/// Steps of the cosine and of the roughness (the root of alpha), both in [0, 1].
const COSINES: usize = 48;
const ROUGHNESSES: usize = 32;

/// Gauss's rule with four points for the measure 2 cos dcos on [0, 1].
pub(super) const RULE: [(f32, f32); 4] = [
    (0.139_759_86, 0.062_361_94),
    (0.416_409_57, 0.259_695_1),
    (0.723_157, 0.406_929_14),
    (0.942_895_8, 0.271_013_83),
];

/// Parts of an albedo that belong to the reflectance at normal (x) and at grazing incidence (y).
type Split = Vec2;

struct Table {
    albedo: [[Split; COSINES]; ROUGHNESSES],
    average: [Split; ROUGHNESSES],
}

/// Mean scattering of microfacets of one roughness.
#[derive(Clone, Copy, Debug)]
pub(super) struct Energy<R> {
    /// Root of the microfacets' width.
    pub(super) roughness: R,
    /// Parts of the albedo averaged over a cosine-weighted hemisphere.
    pub(super) average: [R; 2],
}

impl<R: Real> Energy<R> {
    #[inline(always)]
    pub(super) fn of(ggx: Ggx<R>) -> Self {
        let roughness = ggx.alpha().root();
        let average = roughness.each_of(
            #[inline(always)]
            |i| {
                let (row, beyond) = cell(roughness.lane(i), ROUGHNESSES);
                mix(table().average[row], table().average[row + 1], beyond).into()
            },
        );
        Self { roughness, average }
    }

    /// Albedo of single scattering at cosine `cos`, by reflectance at normal and grazing incidence.
    #[inline(always)]
    pub(super) fn split(self, cos: R) -> [R; 2] {
        let table = table();
        cos.each_of(
            #[inline(always)]
            |i| {
                let (row, beyond) = cell(self.roughness.lane(i), ROUGHNESSES);
                let (column, t) = cell(cos.lane(i), COSINES);
                let at = |row: &[Split; COSINES]| mix(row[column], row[column + 1], t);
                mix(at(&table.albedo[row]), at(&table.albedo[row + 1]), beyond).into()
            },
        )
    }

    /// Fraction of the light left between the microfacets after the first bounce that finally leaves, for a
    /// mean reflectance of `average`, averaged over all angles.
    #[inline(always)]
    pub(super) fn more(self, average: Vector<R>) -> Vector<R> {
        let white = self.average[0] + self.average[1];
        average.map(
            #[inline(always)]
            |a| a * a * white / (a * white.rest()).rest(),
        )
    }

    /// The same over the mean reflectance: a factor of light that met one microfacet.
    #[inline(always)]
    pub(super) fn more_per_bounce(self, average: Vector<R>) -> Vector<R> {
        let white = self.average[0] + self.average[1];
        average.map(
            #[inline(always)]
            |a| a * white / (a * white.rest()).rest(),
        )
    }

    /// The factor of the losses of both directions and one cosine in the lobe of multiple scattering.
    #[inline(always)]
    pub(super) fn more_scale(self) -> R {
        let lost = (self.average[0] + self.average[1]).rest();
        let scale = lost.all(FRAC_1_PI) / lost;
        R::pick(lost.above_all(1e-6), scale, lost.all(0.0))
    }
}

/// Fraction of light left between perfectly reflecting microfacets after one bounce. Rounding must not make
/// light.
#[inline(always)]
pub(super) fn lost<R: Real>(split: [R; 2]) -> R {
    (split[0] + split[1]).rest().or_more(split[0].all(0.0))
}

#[inline(always)]
fn mix(a: Split, b: Split, t: f32) -> Split {
    a + (b - a) * t
}

/// The entry at or before `x` of [0, 1] cut into `n` entries, and how far `x` is beyond it.
#[inline(always)]
pub(super) fn cell(x: f32, n: usize) -> (usize, f32) {
    let scaled = x.clamp(0.0, 1.0) * (n - 1) as f32;
    let entry = (scaled as usize).min(n - 2);
    (entry, scaled - entry as f32)
}

fn table() -> &'static Table {
    static TABLE: OnceLock<Box<Table>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut table = Box::new(Table {
            albedo: [[Split::ZERO; COSINES]; ROUGHNESSES],
            average: [Split::ZERO; ROUGHNESSES],
        });
        for r in 0..ROUGHNESSES {
            let ggx = Ggx::new(r as f32 / (ROUGHNESSES - 1) as f32);
            for c in 0..COSINES {
                table.albedo[r][c] = albedo(ggx, (c as f32 / (COSINES - 1) as f32).max(1e-4));
            }
            table.average[r] = average(&table.albedo[r]);
        }
        table
    })
}

/// One bounce of light from cosine `cos`.
fn albedo(ggx: Ggx<f32>, cos: f32) -> Split {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    ggx.mean_visible(wo, |h| {
        let wi = (-wo).reflect(h);
        let weight = if wi.z > 0.0 { ggx.sample_weight(wo.z, wi.z) } else { 0.0 };
        let rise = schlick_rise(wo.dot(h));
        Split::new(weight * (1.0 - rise), weight * rise)
    })
}

/// The integral of `2 cos f(cos)` over [0, 1] for `f` linear between its entries.
pub(super) fn average<T, const N: usize>(entries: &[T; N]) -> T
where
    T: Copy + Add<Output = T> + Mul<f32, Output = T> + Sum,
{
    let step = 1.0 / (N - 1) as f32;
    let segment = |k: usize| {
        let (a, b, x) = (entries[k], entries[k + 1], k as f32 * step);
        // Of 2 (x + s t) (a + (b - a) t) over t in [0, 1], times the step s.
        let linear = (a + b) * x;
        let rest = (a + b * 2.0) * (step / 3.0);
        (linear + rest) * step
    };
    (0..N - 1).map(segment).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_the_lobe() {
        for (roughness, cos) in [(0.33, 0.9_f32), (0.5, 0.31), (0.77, 0.62), (1.0, 0.14), (1.0, 1.0)] {
            let ggx = Ggx::new(roughness);
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            // Midpoint rule over the hemisphere, independent of the sampling for the table.
            let (rings, sectors) = (1000, 200);
            let mut sum = 0.0_f64;
            for (ring, sector) in (0..rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
                let z = (ring as f32 + 0.5) / rings as f32;
                let (sin, azimuth) = ((1.0 - z * z).sqrt(), (sector as f32 + 0.5) / sectors as f32);
                let (s, c) = (azimuth * std::f32::consts::TAU).sin_cos();
                let wi = Vec3::new(sin * c, sin * s, z);
                let h = (wo + wi).normalize();
                let density = ggx.density(h.z, h.x * h.x + h.y * h.y);
                let lobe = density / ((1.0 + ggx.lambda(cos) + ggx.lambda(z)) * 4.0 * cos);
                sum += f64::from(lobe * (0.1 + 0.9 * schlick_rise(wo.dot(h))));
            }
            let expected = sum * std::f64::consts::TAU / f64::from(rings * sectors);
            let [normal, grazing] = Energy::of(ggx).split(cos);
            let found = 0.1 * normal + grazing;
            assert!((f64::from(found) - expected).abs() < 2e-3, "{roughness} {cos}: {found}, not {expected}");
        }
        // A sanity bound: the value itself is compared above.
        assert!(lost(Energy::of(Ggx::new(1.0)).split(1.0)) > 0.25, "one bounce loses light");
    }

    #[test]
    fn white_keeps_all_light() {
        for roughness in [0.0, 0.1, 0.45, 0.8, 1.0] {
            let energy = Energy::of(Ggx::new(roughness));
            for cos in [0.02, 0.4, 0.97] {
                let (n, left, scale) = (4000, lost(energy.split(cos)), energy.more_scale());
                let more: f32 = (0..n)
                    .map(|i| (i as f32 + 0.5) / n as f32)
                    .map(|cos_i| {
                        std::f32::consts::TAU * cos_i * left * lost(energy.split(cos_i)) * scale / n as f32
                    })
                    .sum();
                let expected = left;
                assert!(
                    (more - expected).abs() < 2e-3 + 2e-3 * expected,
                    "{roughness} {cos}: {more} {expected}"
                );
            }
            let more = energy.more(Vector::grey(1.0)).x;
            assert!((more - 1.0).abs() < 1e-5, "white facets let all out in the end");
        }
    }
}
