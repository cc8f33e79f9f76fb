// SPDX-License-Identifier: GPL-3.0-or-later
//! Sheen of cloth: upright fibres that are bright at grazing views.
//! Source: [EK17] (the distribution named Charlie), [NP13] (visibility); KHR_materials_sheen takes the same.
//! Differs: where the papers' lobe makes light it is scaled down.
//! Space: the shading frame. Albedos are tables over the cosine of the view and the roughness, made at first
//! use, with small steps where they are steep: at the horizon and for upright fibres.
//! Tests: `tests`, those of `bsdf` and `tests/mitsuba.rs`.

use std::f32::consts::TAU;
use std::sync::OnceLock;

use glam::Vec3;

use super::energy::cell;
use crate::real::Real;

/// Equal steps of the root of the cosine, and of the logarithm of the roughness from the smallest on.
const COSINES: usize = 64;
const ROUGHNESSES: usize = 24;
/// Smallest roughness: below it the lobe is a ring too thin to sample.
const SMOOTHEST: f32 = 0.07;

/// The lobe of white fibres times the cosine of `wi`; `roughness` is glTF's, in [0, 1]; `sin` is that of the half vector. Where
/// the model sends back more than all, for either direction, it is scaled down: that keeps it reciprocal, and no light is made.
#[inline(always)]
pub(super) fn lobe_cos<R: Real>(roughness: R, [o, i]: [R; 2], sin: R) -> R {
    o.each(
        #[inline(always)]
        |k| scaled(roughness.lane(k), [o.lane(k), i.lane(k)], sin.lane(k)),
    )
}

fn scaled(roughness: f32, [o, i]: [f32; 2], sin: f32) -> f32 {
    if i <= 0.0 {
        return 0.0;
    }
    let table = table();
    let made = |cos| interpolate(&table.made, roughness, cos);
    model_cos(roughness, [o, i], sin) / made(o).max(made(i)).max(1.0)
}

/// The lobe as the papers have it.
fn model_cos(roughness: f32, [o, i]: [f32; 2], sin: f32) -> f32 {
    let power = 1.0 / alpha(roughness);
    let density = (2.0 + power) * sin.powf(power) / TAU;
    density * i / (4.0 * (o + i - o * i))
}

/// Share of light that white fibres send back, seen at the cosine `cos`.
#[inline(always)]
pub(super) fn albedo<R: Real>(roughness: R, cos: R) -> R {
    cos.each(
        #[inline(always)]
        |i| sent_back(roughness.lane(i), cos.lane(i)),
    )
}

fn sent_back(roughness: f32, cos: f32) -> f32 {
    let table = table();
    let [made, retained] = [&table.made, &table.retained].map(|entries| interpolate(entries, roughness, cos));
    (made.min(1.0) * retained).clamp(0.0, 1.0)
}

fn alpha(roughness: f32) -> f32 {
    let roughness = roughness.max(SMOOTHEST);
    roughness * roughness
}

type Entries = [[f32; COSINES]; ROUGHNESSES];

struct Table {
    /// Albedo of the papers' lobe: more than 1 at grazing views.
    made: Entries,
    /// The same after scaling, over the smaller of `made` and 1: smoother than itself.
    retained: Entries,
}

fn interpolate(entries: &Entries, roughness: f32, cos: f32) -> f32 {
    let (row, t) = cell(1.0 - roughness.max(SMOOTHEST).ln() / SMOOTHEST.ln(), ROUGHNESSES);
    let (column, s) = cell(cos.max(0.0).sqrt(), COSINES);
    let at = |row: &[f32; COSINES]| row[column] + (row[column + 1] - row[column]) * s;
    let [below, above] = [at(&entries[row]), at(&entries[row + 1])];
    below + (above - below) * t
}

fn table() -> &'static Table {
    static TABLE: OnceLock<Box<Table>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let nothing = [[0.0; COSINES]; ROUGHNESSES];
        let mut table = Box::new(Table { made: nothing, retained: nothing });
        let roughness = |row: usize| SMOOTHEST.powf(1.0 - row as f32 / (ROUGHNESSES - 1) as f32);
        let cos = |column: usize| (column as f32 / (COSINES - 1) as f32).powi(2).max(1e-4);
        for row in 0..ROUGHNESSES {
            let roughness = roughness(row);
            let model = |wo: Vec3, wi: Vec3| model_cos(roughness, [wo.z, wi.z], sin_half(wo, wi));
            for column in 0..COSINES {
                table.made[row][column] = integral(cos(column), GRID, model);
            }
            for column in 0..COSINES {
                let made = |cos| interpolate(&table.made, roughness, cos);
                let here = made(cos(column)).max(1.0);
                let lobe = |wo, wi: Vec3| model(wo, wi) / made(wi.z).max(here);
                table.retained[row][column] =
                    integral(cos(column), GRID, lobe) / table.made[row][column].clamp(1e-30, 1.0);
            }
        }
        table
    })
}

/// Sine of the half vector to the shading normal z.
fn sin_half(wo: Vec3, wi: Vec3) -> f32 {
    let h = (wo + wi).normalize_or(Vec3::Z);
    (h.x * h.x + h.y * h.y).sqrt()
}

/// Rings and sectors that tables are sums over.
const GRID: [usize; 2] = [32, 24];

/// Albedo of `lobe` for light at cosine `cos`, by the midpoint rule; rings are narrow at the horizon, where
/// its peak is.
fn integral(cos: f32, [rings, sectors]: [usize; 2], lobe: impl Fn(Vec3, Vec3) -> f32) -> f32 {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut sum = 0.0;
    for ring in 0..rings {
        let [a, b] = [ring, ring + 1].map(|k| (k as f32 / rings as f32).powi(2));
        let z = 0.5 * (a + b);
        let r = (1.0 - z * z).sqrt();
        // Half of the circle, twice.
        for sector in 0..sectors {
            let (s, c) = (0.5 * TAU * (sector as f32 + 0.5) / sectors as f32).sin_cos();
            sum += lobe(wo, Vec3::new(r * c, r * s, z)) * (b - a) * TAU / sectors as f32;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Roughnesses and cosines on and between the tables' entries, many where fibres send back more than all.
    fn table_nodes() -> impl Iterator<Item = (f32, f32)> {
        let cosines = [0.005, 0.02, 0.05, 0.08, 0.11, 0.2, 0.4, 0.7, 1.0];
        [0.0, 0.09, 0.15, 0.22, 0.3, 0.5, 0.8, 1.0].into_iter().flat_map(move |r| cosines.map(|c| (r, c)))
    }

    #[test]
    fn albedo_is_what_the_lobe_sends_back() {
        for (roughness, cos) in table_nodes() {
            let expected =
                integral(cos, [300, 100], |wo, wi| lobe_cos(roughness, [wo.z, wi.z], sin_half(wo, wi)));
            let found = albedo(roughness, cos);
            assert!((found - expected).abs() < 0.005, "{roughness} {cos}: {found}, not {expected}");
            assert!(expected < 1.005, "{roughness} {cos}: makes light: {expected}");
        }
    }

    #[test]
    fn only_what_makes_light_is_scaled() {
        for (roughness, cos) in table_nodes() {
            let made = |cos| {
                integral(cos, [300, 100], |wo, wi| model_cos(roughness, [wo.z, wi.z], sin_half(wo, wi)))
            };
            let z = 0.3;
            let (wo, wi) =
                (Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos), Vec3::new(0.0, (1.0_f32 - z * z).sqrt(), z));
            let expected =
                model_cos(roughness, [wo.z, wi.z], sin_half(wo, wi)) / made(cos).max(made(z)).max(1.0);
            let found = lobe_cos(roughness, [wo.z, wi.z], sin_half(wo, wi));
            assert!(
                (found - expected).abs() < 0.005 * expected + 1e-6,
                "{roughness} {cos}: {found}, not {expected}"
            );
        }
    }
}
