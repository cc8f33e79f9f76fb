// SPDX-License-Identifier: GPL-3.0-or-later
//! Light from everywhere: a constant, or a latitude-longitude picture chosen by its brightness.
//! Source: [PJH23] section 12.5 (importance sampling of pictures), [RH01] (irradiance by spherical harmonics). Differs: within a cell of the picture the direction is
//! uniform by solid angle, which is exact at the poles too.
//! Space: the picture's middle lies along -z and its upper edge at +y of the light's space.
//! Tests: `tests::{constant_is_exact, picture_matches_quadrature, directions_and_texels_agree}`.

use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::sync::Arc;

use glam::{Mat3, Vec3};
use gnurt_accel::Threads;
use gnurt_image::srgb::luminance;
use rayon::prelude::*;

use crate::batch::Vec3s;
use crate::color_map::ColorMap;
use crate::sampling::{Basis, GridDistribution, cosine_hemisphere};
use crate::shader::{EnvironmentShader, LightBatch, LightShader};
use crate::texture::{TextureSampler, Wrap};

/// The same radiance from everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantEnvironment {
    /// Radiance.
    pub radiance: Vec3,
}

impl EnvironmentShader for ConstantEnvironment {
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
        out.reset(dir.len(), self.radiance);
    }
}

impl LightShader for ConstantEnvironment {
    fn illuminate(&self, _p: &Vec3s, normal: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch) {
        for (i, &random) in random.iter().enumerate() {
            let local = cosine_hemisphere(random);
            // The density is cos / pi; a direction in the horizon itself is never needed.
            if local.z > 0.0 {
                out.dir.set(i, Basis::around(normal.get(i)).to_world(local).normalize());
                out.dist[i] = f32::INFINITY;
                out.radiance.set(i, self.radiance * (PI / local.z));
                out.pdf[i] = local.z * FRAC_1_PI;
            }
        }
    }

    fn is_visible(&self) -> bool {
        true
    }
}

/// Radiance by direction, from a picture.
pub struct PictureEnvironment {
    texture: TextureSampler,
    radiance: Vec3,
    /// From the product of both to the working space.
    map: ColorMap,
    world_from_light: Mat3,
    /// Functions of the texture only.
    choices: Arc<Choices>,
}

/// Brightness of a picture by direction, in its light's space.
struct Choices {
    grid: GridDistribution,
    irradiance: Irradiance,
    unevenness: f32,
}

/// The grid of choices has no more cells than this along each axis.
const MOST_CELLS: [u32; 2] = [1024, 512];

impl PictureEnvironment {
    /// `world_from_light` is a rotation; `radiance` is multiplied to the picture. `None` if all of it is black.
    #[must_use]
    pub fn new(
        texture: TextureSampler,
        radiance: Vec3,
        world_from_light: Mat3,
        threads: Threads,
    ) -> Option<Self> {
        let texture = TextureSampler {
            wrap: [Wrap::Repeat, Wrap::Clamp],
            linear: true,
            uv_from_mesh: TextureSampler::new(texture.texels.clone()).uv_from_mesh,
            ..texture
        };
        let choices = Arc::new(choices(&texture, threads)?);
        let map = ColorMap::default();
        (radiance.max_element() > 0.0).then_some(Self { texture, radiance, map, world_from_light, choices })
    }

    /// The same in a working space; picture and radiance are those of Rec. 709.
    #[must_use]
    pub fn mapped(self, map: ColorMap) -> Self {
        Self { map, ..self }
    }

    /// The same picture with another radiance and rotation. `None` if all of it is black.
    #[must_use]
    pub fn again(&self, radiance: Vec3, world_from_light: Mat3) -> Option<Self> {
        let (texture, choices) = (self.texture.clone(), self.choices.clone());
        let map = self.map;
        (radiance.max_element() > 0.0).then_some(Self { texture, radiance, map, world_from_light, choices })
    }

    /// Whether it shows the texels that `texture` does.
    #[must_use]
    pub fn shows(&self, texture: &TextureSampler) -> bool {
        Arc::ptr_eq(&self.texture.texels, &texture.texels)
    }

    /// Whether it has this brightness and rotation.
    #[must_use]
    pub fn shines_as(&self, radiance: Vec3, world_from_light: Mat3) -> bool {
        (self.radiance, self.world_from_light) == (radiance, world_from_light)
    }

    /// Whether the distribution that directions are chosen by is one for both.
    #[must_use]
    pub fn shares_distribution(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.choices, &other.choices)
    }

    /// Radiance from a unit direction.
    pub(super) fn at(&self, world_dir: Vec3) -> Vec3 {
        let dir = self.world_from_light.transpose() * world_dir;
        let [r, g, b, _] = self.texture.sample(uv_of(dir));
        self.map.of(self.radiance * Vec3::new(r, g, b).max(Vec3::ZERO))
    }

    /// Density per solid angle with which [`sample`](Self::sample) chooses a unit direction.
    pub(super) fn pdf(&self, world_dir: Vec3) -> f32 {
        let [u, v] = uv_of(self.world_from_light.transpose() * world_dir);
        let grid = &self.choices.grid;
        let (columns, rows) = (grid.width(), grid.height());
        let cell = |x: f32, n: usize| ((x * n as f32).max(0.0) as usize).min(n - 1);
        let (column, row) = (cell(u, columns), cell(1.0 - v, rows));
        grid.probability(column, row) / cell_solid_angle(row, columns, rows)
    }

    /// About the brightness that a surface which faces the unit `normal` (zero = any) receives.
    pub(super) fn irradiance(&self, normal: Vec3) -> f32 {
        let brightness = luminance(self.radiance.into());
        brightness * self.choices.irradiance.of(self.world_from_light.transpose() * normal)
    }

    /// 1 less the square of the mean brightness over the mean of its square.
    pub(super) fn unevenness(&self) -> f32 {
        self.choices.unevenness
    }

    /// A world direction and its density per solid angle.
    pub(super) fn sample(&self, random: [f32; 2]) -> (Vec3, f32) {
        let grid = &self.choices.grid;
        let point = grid.sample(random);
        let (columns, rows) = (grid.width() as f32, grid.height() as f32);
        let azimuth = TAU * ((point.column as f32 + point.within[0]) / columns - 0.5);
        let [upper, lower] = [0, 1].map(|k| (PI * (point.row + k) as f32 / rows).cos());
        let y = upper + point.within[1] * (lower - upper);
        let solid_angle = cell_solid_angle(point.row, grid.width(), grid.height());
        let radius = (1.0 - y * y).max(0.0).sqrt();
        let dir = Vec3::new(radius * azimuth.sin(), y, -radius * azimuth.cos());
        ((self.world_from_light * dir).normalize(), point.probability / solid_angle)
    }
}

impl EnvironmentShader for PictureEnvironment {
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
        (0..dir.len()).for_each(|i| out.set(i, self.at(dir.get(i))));
    }
}

impl LightShader for PictureEnvironment {
    fn illuminate(&self, _p: &Vec3s, _normal: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch) {
        for (i, &random) in random.iter().enumerate() {
            let (dir, pdf_sa) = self.sample(random);
            out.dir.set(i, dir);
            out.dist[i] = f32::INFINITY;
            out.radiance.set(i, self.at(dir) / pdf_sa);
            out.pdf[i] = pdf_sa;
        }
    }

    fn is_visible(&self) -> bool {
        true
    }
}

fn cell_solid_angle(row: usize, columns: usize, rows: usize) -> f32 {
    let [upper, lower] = [0, 1].map(|k| (PI * (row + k) as f32 / rows as f32).cos());
    TAU / columns as f32 * (upper - lower)
}

/// Texture coordinates of a unit direction of the light's space.
fn uv_of(dir: Vec3) -> [f32; 2] {
    [0.5 + dir.x.atan2(-dir.z) / TAU, 1.0 - dir.y.clamp(-1.0, 1.0).acos() / PI]
}

/// By brightness times solid angle of each cell. Cells include a margin beyond their edges, because
/// interpolation spreads light there: every emitting point has a probability above 0.
fn choices(texture: &TextureSampler, threads: Threads) -> Option<Choices> {
    let size = [texture.texels.width, texture.texels.height];
    let [columns, rows] = [0, 1].map(|k| size[k].clamp(1, MOST_CELLS[k]) as usize);
    // Enough samples per cell that no texel is missed.
    let [across, down] =
        [0, 1].map(|k| 1 + (size[k] as usize).div_ceil([columns, rows][k]) * if size[k] > 1 { 2 } else { 1 });
    let brightness = |[r, g, b, _]: [f32; 4]| f64::from(luminance([r, g, b])).max(0.0);
    let of_row = |row: usize| -> Vec<f64> {
        let [upper, lower] = [0, 1].map(|k| (f64::from(PI) * (row + k) as f64 / rows as f64).cos());
        let weight = |column: usize| {
            let mut sum = 0.0;
            for (i, j) in (0..=across).flat_map(|i| (0..=down).map(move |j| (i, j))) {
                let u = (column as f32 + i as f32 / across as f32) / columns as f32;
                let v = 1.0 - (row as f32 + j as f32 / down as f32) / rows as f32;
                sum += brightness(texture.sample([u, v]));
            }
            sum * (upper - lower)
        };
        (0..columns).map(weight).collect()
    };
    let weights: Vec<Vec<f64>> = threads.run(|parallel| {
        if parallel {
            (0..rows).into_par_iter().map(of_row).collect()
        } else {
            (0..rows).map(of_row).collect()
        }
    });
    // From sums of samples to integrals over cells.
    let scale = f64::from(TAU) / (columns * (across + 1) * (down + 1)) as f64;
    let grid = GridDistribution::new(columns, &weights.concat())?;
    Some(Choices { grid, irradiance: Irradiance::new(&weights, scale), unevenness: unevenness(&weights) })
}

/// Of brightness times solid angle of each cell, rows of columns: 1 less the square of the mean brightness over the mean of its square.
fn unevenness(cells: &[Vec<f64>]) -> f32 {
    let (mut total, mut squares, rows) = (0.0, 0.0, cells.len());
    for (row, cells) in cells.iter().enumerate() {
        let solid_angle = f64::from(cell_solid_angle(row, cells.len(), rows));
        total += cells.iter().sum::<f64>();
        squares += cells.iter().map(|cell| cell * cell / solid_angle).sum::<f64>();
    }
    (1.0 - total * total / (4.0 * f64::from(PI) * squares)).max(0.0) as f32
}

/// Irradiance by normal: nine spherical harmonics.
struct Irradiance {
    /// Coefficients of 1; x, y, z; xy, yz, zx, x² - y², 3 z² - 1.
    terms: [f32; 9],
    /// The integral over all directions.
    total: f32,
}

/// Least irradiance, by the integral over all directions: nine terms ring around a small sun, and may be negative.
const LEAST_IRRADIANCE: f32 = 0.02;

impl Irradiance {
    /// From the integral over each cell of a picture, rows of columns, each times `scale`.
    fn new(cells: &[Vec<f64>], scale: f64) -> Self {
        let (pi, rows) = (f64::from(PI), cells.len() as f64);
        let mut terms = [0.0; 9];
        for (row, cells) in cells.iter().enumerate() {
            let (sin, y) = (pi * (row as f64 + 0.5) / rows).sin_cos();
            for (column, &cell) in cells.iter().enumerate() {
                let (x, z) = (2.0 * pi * ((column as f64 + 0.5) / cells.len() as f64 - 0.5)).sin_cos();
                let basis = harmonics(sin * x, y, -sin * z);
                terms.iter_mut().zip(basis).for_each(|(term, value)| *term += scale * cell * value);
            }
        }
        let total = terms[0] as f32;
        // Squares of the harmonics' norms times the factors of a clamped cosine, by degree: pi, 2 pi / 3, pi / 4.
        let [first, second, third] = [1.0 / 4.0, 1.0 / 2.0, 15.0 / 16.0];
        let factors = [first, second, second, second, third, third, third, third / 4.0, third / 12.0];
        let terms = std::array::from_fn(|k| (terms[k] * factors[k]) as f32);
        Self { terms, total }
    }

    /// For a unit normal; for zero the integral over all directions.
    fn of(&self, n: Vec3) -> f32 {
        if n == Vec3::ZERO {
            return self.total;
        }
        let basis = harmonics(n.x, n.y, n.z);
        let sum: f32 = self.terms.iter().zip(basis).map(|(term, value)| term * value).sum();
        sum.max(LEAST_IRRADIANCE * self.total)
    }
}

/// The harmonics of a unit direction without their norms.
fn harmonics<F>(x: F, y: F, z: F) -> [F; 9]
where
    F: Copy + From<f32> + std::ops::Mul<Output = F> + std::ops::Sub<Output = F>,
{
    let (one, three) = (F::from(1.0), F::from(3.0));
    [one, x, y, z, x * y, y * z, z * x, x * x - y * y, three * z * z - one]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use gnurt_image::{TexelData, Texels};

    use super::*;
    use crate::batch::SampleKey;
    use crate::lights::EnvironmentLight;
    use crate::sampling::sample_pair;

    fn picture() -> PictureEnvironment {
        let (width, height) = (16, 8);
        let texel = |i: u32| match (i % width, i / width) {
            (12, 2) => [50.0, 20.0, 10.0, 1.0],
            (_, 0) => [1.0, 1.0, 1.0, 1.0],
            _ => [0.0, 0.1, 0.0, 1.0],
        };
        let data = TexelData::Float((0..width * height).map(texel).collect());
        let texture = TextureSampler::new(Arc::new(Texels { width, height, data }));
        let rotation = Mat3::from_rotation_x(0.4) * Mat3::from_rotation_y(1.1);
        PictureEnvironment::new(texture, Vec3::splat(2.0), rotation, Threads::Single).expect("it shines")
    }

    #[test]
    fn a_constant_is_the_same_on_all_sides() {
        let mut out = Vec3s::default();
        ConstantEnvironment { radiance: Vec3::Z }.miss(&Vec3s::splat(2, Vec3::X), &mut out);
        assert_eq!(out, Vec3s::splat(2, Vec3::Z), "two lanes of the value");
    }

    fn irradiance(light: &dyn LightShader, normal: Vec3) -> Vec3 {
        const N: u32 = 1 << 15;
        let random: Vec<_> =
            (0..N).map(|sample| sample_pair(0, SampleKey { pixel: 1, sample, branch: 0 }, 0, 0)).collect();
        let mut out = LightBatch::default();
        out.reset(random.len());
        let n = random.len();
        light.illuminate(&Vec3s::splat(n, Vec3::ZERO), &Vec3s::splat(n, normal), &random, &mut out);
        let lit = |i| out.radiance.get(i) * out.dir.get(i).dot(normal).max(0.0);
        (0..n).map(lit).sum::<Vec3>() / N as f32
    }

    #[test]
    fn constant_is_exact() {
        let light = ConstantEnvironment { radiance: Vec3::new(1.0, 0.5, 0.25) };
        let found = irradiance(&light, Vec3::new(0.6, 0.0, 0.8));
        assert!((found - light.radiance * PI).length() < 1e-3, "pi times the radiance, not {found}");
    }

    #[test]
    fn picture_matches_quadrature() {
        let light = picture();
        let normal = Vec3::new(0.36, 0.8, 0.48);
        let found = irradiance(&light, normal);
        // Midpoint rule over the sphere.
        let (mut sum, steps) = (Vec3::ZERO, 600);
        for (i, j) in (0..2 * steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
            let (azimuth, y) =
                (PI * (i as f32 + 0.5) / steps as f32, 1.0 - 2.0 * (j as f32 + 0.5) / steps as f32);
            let radius = (1.0 - y * y).sqrt();
            let dir = Vec3::new(radius * azimuth.cos(), y, radius * azimuth.sin());
            sum += light.at(dir) * dir.dot(normal).max(0.0);
        }
        let expected = sum * (TAU / (steps * steps) as f32);
        assert!((found / expected - 1.0).abs().max_element() < 0.01, "{found} instead of {expected}");
    }

    /// Estimates of irradiance beside sums over samples: the least of nine harmonics is a few percent of the most.
    #[test]
    fn irradiance_is_near_its_sum() {
        let light = picture();
        let normals = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z, Vec3::new(0.36, 0.8, 0.48)];
        let sums = normals.map(|normal| luminance(irradiance(&light, normal).into()));
        let most = sums.into_iter().fold(0.0, f32::max);
        for (normal, sum) in normals.into_iter().zip(sums) {
            let found = light.irradiance(normal);
            assert!((found - sum).abs() < 0.1 * most, "facing {normal}: {found} instead of {sum}");
        }
        let total = EnvironmentLight::Picture(Arc::new(picture())).total();
        let found = light.irradiance(Vec3::ZERO);
        assert!((found / total - 1.0).abs() < 0.05, "from all sides: {found} instead of {total}");
    }

    #[test]
    fn unevenness_is_that_of_the_brightness() {
        let of = |cells: &[f64]| {
            let rows = [0, 1, 2, 3].map(|row| {
                let solid_angle = f64::from(cell_solid_angle(row, cells.len(), 4));
                cells.iter().map(|cell| cell * solid_angle).collect()
            });
            unevenness(&rows)
        };
        assert!(of(&[2.0; 8]) < 1e-6, "the same from everywhere: {}", of(&[2.0; 8]));
        let half = of(&[0.0, 3.0]);
        assert!((half - 0.5).abs() < 1e-6, "a bright half: {half}");
        let mut sun = [0.0; 100];
        sun[7] = 1.0;
        assert!((of(&sun) - 0.99).abs() < 1e-5, "a hundredth: {}", of(&sun));
        assert!(picture().unevenness() > 0.5, "one bright texel of a dark sky: {}", picture().unevenness());
    }

    #[test]
    fn directions_and_texels_agree() {
        let light = picture();
        for sample in 0..1000 {
            let random = sample_pair(0, SampleKey { pixel: 1, sample, branch: 0 }, 0, 0);
            let point = light.choices.grid.sample(random);
            let local = light.world_from_light.transpose() * light.sample(random).0;
            let [u, v] = uv_of(local);
            let cell = [u * 16.0, (1.0 - v) * 8.0];
            let inside = [point.column, point.row]
                .iter()
                .zip(cell)
                .all(|(&c, x)| x > c as f32 - 1e-3 && x < c as f32 + 1.0 + 1e-3);
            assert!(inside, "{cell:?} is in column {} and row {}", point.column, point.row);
        }
        assert_eq!(uv_of(-Vec3::Z), [0.5, 0.5], "the middle lies along -z");
        assert_eq!(uv_of(Vec3::X)[0], 0.75, "+x is right of it");
        assert_eq!(uv_of(Vec3::Y)[1], 1.0, "+y is the upper edge");
    }
}
