// SPDX-License-Identifier: GPL-3.0-or-later
//! How much light rough facets send back after one bounce, and a lobe for what they send back after more.
//! Source: [KC17] (the lobe, from the albedo after one bounce; colour by the sum over bounces), tables over the cosine of
//! the view and the roughness, split as in [Kar13] so that they are linear in Schlick's two reflectances.
//! Invariant: averages are those of the interpolated tables, so that one bounce and the lobe sum to 1 for white facets
//! up to the rounding of floats. The tables are the same on all machines: they are sums in a fixed order.
//! Proof: `tests::{tables_hold_the_lobe, white_keeps_all_light}`.

use std::f32::consts::FRAC_1_PI;
use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::fresnel::{schlick_average, schlick_rise};
use super::ggx::Ggx;

/// Steps of the cosine and of the roughness (the root of alpha), both in [0, 1].
const COSINES: usize = 48;
const ROUGHNESSES: usize = 32;

/// Parts of an albedo that belong to the reflectance at normal (x) and at grazing incidence (y).
type Split = Vec2;

struct Table {
    albedo: [[Split; COSINES]; ROUGHNESSES],
    average: [Split; ROUGHNESSES],
}

/// A roughness: the entry at or before it, and how far it is beyond.
pub(super) type Row = (usize, f32);

/// What comes back of light from cosine `cos` after one bounce, by reflectance at normal and grazing incidence.
#[inline]
pub(super) fn look_up(row: Row, cos: f32) -> Split {
    let (column, t) = place(cos, COSINES);
    let at = |row: usize| {
        let row = &table().albedo[row];
        mix(row[column], row[column + 1], t)
    };
    mix(at(row.0), at(row.0 + 1), row.1)
}

/// The table's entries of one roughness, by reflectance at normal and grazing incidence: for many look-ups. Arrays of a
/// power of two, so that lanes need no check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SentBack([[f32; 64]; 2]);

impl SentBack {
    pub(super) fn of(row: Row) -> Self {
        let [below, above] = [row.0, row.0 + 1].map(|row| &table().albedo[row]);
        let mut entries = [[0.0; 64]; 2];
        for column in 0..COSINES {
            [entries[0][column], entries[1][column]] = mix(below[column], above[column], row.1).into();
        }
        Self(entries)
    }

    /// Share of light from cosine `cos` that facets send back at once, by reflectance at normal and grazing incidence.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, cos: f32) -> [f32; 2] {
        let scaled = cos.clamp(0.0, 1.0) * (COSINES - 1) as f32;
        let entry = (scaled as u32).min(COSINES as u32 - 2);
        let (low, high) = (entry as usize & 63, (entry as usize + 1) & 63);
        let (t, [normal, grazing]) = (scaled - entry as f32, &self.0);
        [normal[low] + (normal[high] - normal[low]) * t, grazing[low] + (grazing[high] - grazing[low]) * t]
    }
}

/// What facets of one roughness do to light on the whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Energy {
    row: Row,
    average: Split,
}

impl Energy {
    pub(super) fn of(ggx: Ggx) -> Self {
        let row = place(ggx.alpha().sqrt(), ROUGHNESSES);
        let average = mix(table().average[row.0], table().average[row.0 + 1], row.1);
        Self { row, average }
    }

    /// Where the tables hold its roughness.
    pub(super) fn row(self) -> Row {
        self.row
    }

    /// What comes back of light from cosine `cos` after one bounce, by reflectance at normal and grazing incidence.
    fn split(self, cos: f32) -> Split {
        look_up(self.row, cos)
    }

    /// Albedo after one bounce, for Schlick's reflectances `f0` and `f90`.
    pub(super) fn once(self, cos: f32, f0: Vec3, f90: f32) -> Vec3 {
        let split = self.split(cos);
        f0 * split.x + Vec3::splat(f90 * split.y)
    }

    /// Albedo after one bounce of facets that mirror all.
    pub(super) fn white(self, cos: f32) -> f32 {
        // Rounding must not make light.
        self.split(cos).element_sum().min(1.0)
    }

    /// [`white`](Self::white), averaged over a cosine-weighted hemisphere.
    pub(super) fn white_average(self) -> f32 {
        self.average.element_sum()
    }

    /// Share of what a first bounce leaves between the facets that comes out in the end, for facets that mirror
    /// `average` of the light, averaged over all angles.
    pub(super) fn more(self, average: Vec3) -> Vec3 {
        let white = self.average.element_sum();
        average * average * white / (Vec3::ONE - average * (1.0 - white))
    }

    /// The lobe of all bounces but the first, times the cosine of `wi`, before [`more`](Self::more) colours it.
    pub(super) fn more_cos(self, cos_o: f32, cos_i: f32) -> f32 {
        let lost = 1.0 - self.average.element_sum();
        if lost < 1e-6 {
            return 0.0;
        }
        (1.0 - self.white(cos_o)) * (1.0 - self.white(cos_i)) * FRAC_1_PI * cos_i / lost
    }

    /// Albedo after all bounces.
    pub(super) fn all(self, cos: f32, f0: Vec3, f90: f32) -> Vec3 {
        self.once(cos, f0, f90) + self.more(schlick_average(f0, f90)) * (1.0 - self.white(cos))
    }

    /// [`all`](Self::all), averaged over a cosine-weighted hemisphere.
    pub(super) fn all_average(self, f0: Vec3, f90: f32) -> Vec3 {
        let once = f0 * self.average.x + Vec3::splat(f90 * self.average.y);
        once + self.more(schlick_average(f0, f90)) * (1.0 - self.average.element_sum())
    }
}

#[inline(always)]
fn mix(a: Split, b: Split, t: f32) -> Split {
    a + (b - a) * t
}

/// The entry at or before `x` of [0, 1] cut into `n` entries, and how far `x` is beyond it.
pub(super) fn place(x: f32, n: usize) -> (usize, f32) {
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
fn albedo(ggx: Ggx, cos: f32) -> Split {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    ggx.mean_visible(wo, |h| {
        let weight = ggx.sample_weight(wo, (-wo).reflect(h));
        let rise = schlick_rise(wo.dot(h));
        Split::new(weight * (1.0 - rise), weight * rise)
    })
}

/// The integral of `2 cos f(cos)` over [0, 1] for `f` linear between its entries.
fn average(entries: &[Split; COSINES]) -> Split {
    let step = 1.0 / (COSINES - 1) as f32;
    let segment = |k: usize| {
        let (a, b, x) = (entries[k], entries[k + 1], k as f32 * step);
        // Of 2 (x + s t) (a + (b - a) t) over t in [0, 1], times the step s.
        let linear = (a + b) * x;
        let rest = (a + 2.0 * b) * (step / 3.0);
        (linear + rest) * step
    };
    (0..COSINES - 1).map(segment).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_the_lobe() {
        for (roughness, cos) in [(0.33, 0.9_f32), (0.5, 0.31), (0.77, 0.62), (1.0, 0.14), (1.0, 1.0)] {
            let ggx = Ggx::new(roughness);
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            // Midpoint rule over the hemisphere, apart from the sampling that the table is made with.
            let (rings, sectors) = (1000, 200);
            let mut sum = 0.0_f64;
            for (ring, sector) in (0..rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
                let z = (ring as f32 + 0.5) / rings as f32;
                let (sin, azimuth) = ((1.0 - z * z).sqrt(), (sector as f32 + 0.5) / sectors as f32);
                let (s, c) = (azimuth * std::f32::consts::TAU).sin_cos();
                let wi = Vec3::new(sin * c, sin * s, z);
                let h = (wo + wi).normalize();
                sum += f64::from(ggx.lobe_cos(wo, wi, h) * (0.1 + 0.9 * schlick_rise(wo.dot(h))));
            }
            let wanted = sum * std::f64::consts::TAU / f64::from(rings * sectors);
            let found = Energy::of(ggx).once(cos, Vec3::splat(0.1), 1.0).x;
            assert!((f64::from(found) - wanted).abs() < 2e-3, "{roughness} {cos}: {found}, not {wanted}");
        }
        // A sanity bound: the value itself is compared above.
        assert!(Energy::of(Ggx::new(1.0)).white(1.0) < 0.75, "one bounce loses light");
    }

    #[test]
    fn white_keeps_all_light() {
        for roughness in [0.0, 0.1, 0.45, 0.8, 1.0] {
            let energy = Energy::of(Ggx::new(roughness));
            for cos in [0.02, 0.4, 0.97] {
                assert!((energy.all(cos, Vec3::ONE, 1.0).x - 1.0).abs() < 1e-5, "by the closed form");
                let n = 4000;
                let more: f32 = (0..n)
                    .map(|i| (i as f32 + 0.5) / n as f32)
                    .map(|cos_i| std::f32::consts::TAU * energy.more_cos(cos, cos_i) / n as f32)
                    .sum();
                let wanted = 1.0 - energy.white(cos);
                assert!((more - wanted).abs() < 2e-3 + 2e-3 * wanted, "{roughness} {cos}: {more} {wanted}");
            }
            assert!((energy.all_average(Vec3::ONE, 1.0).x - 1.0).abs() < 1e-5, "and on average");
        }
    }
}
