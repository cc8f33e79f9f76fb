// SPDX-License-Identifier: GPL-3.0-or-later
//! Sheen of cloth: fibres that stand up and shine at grazing views.
//! Source: [EK17] (the distribution named Charlie), [NP13] (visibility); KHR_materials_sheen takes the same.
//! Space: the shading frame. Albedos are tables over the cosine of the view and the roughness, made at first use.
//! Proof: `tests::table_holds_the_lobe`, `tests` of `bsdf`.

use std::f32::consts::TAU;
use std::sync::OnceLock;

use glam::Vec3;

use super::energy::place;

const COSINES: usize = 32;
const ROUGHNESSES: usize = 24;
/// Smallest roughness: below it the lobe is a ring too thin to sample.
const SMOOTHEST: f32 = 0.07;

/// The lobe of white fibres times the cosine of `wi`; `roughness` is glTF's, in [0, 1]. Where the model sends back more than
/// all, for either direction, it is scaled down: that keeps it reciprocal, and no light is made.
pub(super) fn lobe_cos(roughness: f32, wo: Vec3, wi: Vec3) -> f32 {
    let most = whole(roughness, wo.z).max(whole(roughness, wi.z)).max(1.0);
    model_cos(roughness, wo, wi) / most
}

/// The lobe as the model has it.
fn model_cos(roughness: f32, wo: Vec3, wi: Vec3) -> f32 {
    let h = (wo + wi).normalize_or(Vec3::Z);
    let sin = (h.x * h.x + h.y * h.y).sqrt();
    let power = 1.0 / alpha(roughness);
    let density = (2.0 + power) * sin.powf(power) / TAU;
    density * wi.z / (4.0 * (wo.z + wi.z - wo.z * wi.z))
}

/// Share of light that white fibres send back, seen at the cosine `cos`; about, next to where the model makes light.
pub(super) fn albedo(roughness: f32, cos: f32) -> f32 {
    whole(roughness, cos).clamp(0.0, 1.0)
}

/// What the model sends back on light of 1: more than all at grazing views.
fn whole(roughness: f32, cos: f32) -> f32 {
    let (row, t) = place(roughness, ROUGHNESSES);
    let (column, s) = place(cos, COSINES);
    let at = |row: usize| {
        let row = &table()[row];
        row[column] + (row[column + 1] - row[column]) * s
    };
    at(row) + (at(row + 1) - at(row)) * t
}

fn alpha(roughness: f32) -> f32 {
    let roughness = roughness.max(SMOOTHEST);
    roughness * roughness
}

type Table = [[f32; COSINES]; ROUGHNESSES];

fn table() -> &'static Table {
    static TABLE: OnceLock<Box<Table>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut table = Box::new([[0.0; COSINES]; ROUGHNESSES]);
        for (r, row) in table.iter_mut().enumerate() {
            let roughness = r as f32 / (ROUGHNESSES - 1) as f32;
            for (c, entry) in row.iter_mut().enumerate() {
                *entry = integral(roughness, (c as f32 / (COSINES - 1) as f32).max(1e-3), 24, 24);
            }
        }
        table
    })
}

/// Midpoint rule; rings are narrow at the horizon, where the lobe is.
fn integral(roughness: f32, cos: f32, rings: usize, sectors: usize) -> f32 {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut sum = 0.0;
    for ring in 0..rings {
        let [a, b] = [ring, ring + 1].map(|k| (k as f32 / rings as f32).powi(2));
        let z = 0.5 * (a + b);
        let r = (1.0 - z * z).sqrt();
        // Half of the circle, twice.
        for sector in 0..sectors {
            let (s, c) = (0.5 * TAU * (sector as f32 + 0.5) / sectors as f32).sin_cos();
            sum += model_cos(roughness, wo, Vec3::new(r * c, r * s, z)) * (b - a) * TAU / sectors as f32;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_holds_the_lobe() {
        for (roughness, cos) in [(0.2, 0.9), (0.5, 0.1), (0.8, 0.47), (1.0, 0.03), (1.0, 1.0)] {
            let wanted = integral(roughness, cos, 600, 400);
            let found = albedo(roughness, cos);
            assert!((found - wanted.min(1.0)).abs() < 0.01, "{roughness} {cos}: {found}, not {wanted}");
        }
    }
}
