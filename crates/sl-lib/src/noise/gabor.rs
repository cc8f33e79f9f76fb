// SPDX-License-Identifier: GPL-3.0-or-later
//! Gabor noise: a sum of waves under bells that are scattered at random, filtered by how much a point changes on the screen.
//! Source: [LLDD09], and [LD11] for the filter and solid noise; constants and the order of random numbers are those of OSL
//! 1.14, as is the scale, which brings results to about [-1, 1].
//! Invariant: the bits of OSL's where the system's `exp`, `sin` and `cos` are the same. Four-dimensional noise ignores time.
//! Tests: `tests/gabor.rs`.

use std::f32::consts::{PI, TAU};

use super::hash::hash_uints;
use super::period::wrap;
use crate::dual::Dual;
use crate::math::vectors::{cross, dot};
use crate::math::{exp2, sincos};
use crate::number::{Number, Real, UInt};

type Vec3 = [f32; 3];
type DualVec3 = [Dual<f32>; 3];

/// The options of `noise("gabor", ..)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaborOptions {
    /// 0: waves go in all directions; 1: along `direction`; others: in all directions of the xy plane, as fast as
    /// `direction` is long.
    pub anisotropic: i32,
    /// Whether to filter.
    pub do_filter: bool,
    /// Where waves go, and how many of them a unit holds.
    pub direction: Vec3,
    /// How wide a band of frequencies, in octaves; clamped to [0.01, 100].
    pub bandwidth: f32,
    /// How many bells a point is under, on average; clamped to [1, 32].
    pub impulses: f32,
}

impl Default for GaborOptions {
    fn default() -> Self {
        Self { anisotropic: 0, do_filter: true, direction: [1.0, 0.0, 0.0], bandwidth: 1.0, impulses: 16.0 }
    }
}

/// How many waves a unit holds where waves go in all directions, times pi / ln 2's root below.
const FREQUENCY: f32 = 2.0;
/// Bells end where they have fallen to this part of their height.
const TRUNCATION: f32 = 0.02;
/// sqrt(pi / ln 2), as OSL rounds it.
const SQRT_PI_OVER_LN2: f32 = 2.128_934;

/// The screen's filter in the plane of the surface.
#[derive(Clone, Copy)]
struct Filter {
    normal: Vec3,
    /// To the plane's axes and the normal; rows are multiplied from the left.
    plane_from_space: [Vec3; 3],
    /// The covariance of a pixel in the plane.
    covariance: Matrix2,
}

struct Gabor {
    options: GaborOptions,
    /// The width of bells.
    a: f32,
    radius: f32,
    /// Bells in a cell, on average.
    bells: f32,
    root_of_density: f32,
    filter: Option<Filter>,
    period: Option<Vec3>,
}

/// A random number generator of one multiplication: Borosh and Niederreiter's.
struct Random(u32);

impl Random {
    fn in_cell(cell: Vec3, seed: u32) -> Self {
        let [x, y, z] = cell.map(Real::floor_int);
        Self(hash_uints([x, y, z, UInt(seed)]).0.max(1))
    }

    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(3_039_177_861);
        self.0 as f32 / u32::MAX as f32
    }

    /// A whole number of Poisson's distribution.
    fn poisson(&mut self, mean: f32) -> u32 {
        let limit = (-mean).exp();
        let mut count = 0;
        let mut product = self.next();
        while product > limit {
            count += 1;
            product *= self.next();
        }
        count
    }
}

type Matrix2 = [[f32; 2]; 2];

fn determinant(m: &Matrix2) -> f32 {
    m[0][0] * m[1][1] - m[0][1] * m[1][0]
}

/// The inverse; the identity where there is none.
fn inverse(m: &Matrix2) -> Matrix2 {
    let r = m[0][0] * m[1][1] - m[1][0] * m[0][1];
    let s = [[m[1][1], -m[0][1]], [-m[1][0], m[0][0]]];
    let sound = r.abs() >= 1.0 || s.iter().flatten().all(|x| r.abs() / f32::MIN_POSITIVE > x.abs());
    if sound { s.map(|row| row.map(|x| x / r)) } else { [[1.0, 0.0], [0.0, 1.0]] }
}

fn product(a: &Matrix2, b: &Matrix2) -> Matrix2 {
    a.map(|row| [row[0] * b[0][0] + row[1] * b[1][0], row[0] * b[0][1] + row[1] * b[1][1]])
}

fn sum(a: &Matrix2, b: &Matrix2) -> Matrix2 {
    [0, 1].map(|i| [0, 1].map(|k| a[i][k] + b[i][k]))
}

fn scaled(m: &Matrix2, by: f32) -> Matrix2 {
    m.map(|row| row.map(|x| x * by))
}

fn row_times(v: [f32; 2], m: &Matrix2) -> [f32; 2] {
    [v[0] * m[0][0] + v[1] * m[1][0], v[0] * m[0][1] + v[1] * m[1][1]]
}

fn exp(x: Dual<f32>) -> Dual<f32> {
    let value = x.value.exp();
    x.chain(value, || value)
}

fn cos(x: Dual<f32>) -> Dual<f32> {
    let (sine, cosine) = x.value.sin_cos();
    x.chain(cosine, || -sine)
}

fn dot_constant<const N: usize>(a: [f32; N], x: [Dual<f32>; N]) -> Dual<f32> {
    let mut sum = x[0] * a[0];
    for (x, a) in x.into_iter().zip(a).skip(1) {
        sum = sum + x * a;
    }
    sum
}

/// A wave of this weight, direction and phase under a bell of width `a`, at `x`: equation 1.
fn kernel<const N: usize>(
    weight: Dual<f32>,
    omega: [f32; N],
    phase: Dual<f32>,
    a: f32,
    x: [Dual<f32>; N],
) -> Dual<f32> {
    let mut square = x[0] * x[0];
    for x in &x[1..] {
        square = square + *x * *x;
    }
    let bell = exp(square * (-PI * (a * a)));
    let wave = cos(dot_constant(omega, x) * TAU + phase);
    weight * bell * wave
}

fn normalized(v: Vec3) -> Vec3 {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    if length == 0.0 { v } else { v.map(|x| x / length) }
}

impl Filter {
    /// Of a point's derivatives; none where they are too small to matter or span no plane.
    fn new(p: DualVec3) -> Option<Self> {
        let (dx, dy) = (p.map(|x| x.dx), p.map(|x| x.dy));
        let normal = cross(dx, dy);
        // Less than a thousandth of a unit. NaN is none either.
        if !matches!(
            dot(normal, normal).partial_cmp(&1e-6),
            Some(std::cmp::Ordering::Greater | std::cmp::Ordering::Equal)
        ) {
            return None;
        }
        let n = normalized(normal);
        let t = normalized(if n[0].abs() < 0.9 { [0.0, n[2], -n[1]] } else { [-n[2], 0.0, n[0]] });
        let b = cross(n, t);
        let plane_from_space = [0, 1, 2].map(|i| [t[i], b[i], n[i]]);
        let row = |i: usize, k: usize| {
            dx[i] * plane_from_space[0][k] + dy[i] * plane_from_space[1][k] + 0.0 * plane_from_space[2][k]
        };
        let m = [[row(0, 0), row(0, 1)], [row(1, 0), row(1, 1)]];
        let transposed = [[m[0][0], m[1][0]], [m[0][1], m[1][1]]];
        let covariance = product(&product(&transposed, &[[0.25, 0.0], [0.0, 0.25]]), &m);
        (determinant(&covariance) >= 1e-18).then_some(Self { normal: n, plane_from_space, covariance })
    }

    /// A bell's wave, cut by the plane and filtered in it; `x` is the offset from the bell's centre.
    /// Equations 6 and 10.
    fn kernel(&self, a: f32, omega: Vec3, phase: f32, x: DualVec3) -> Dual<f32> {
        let m = &self.plane_from_space;
        let to_plane = |k: usize| omega[0] * m[0][k] + omega[1] * m[1][k] + omega[2] * m[2][k];
        let depth = -dot_constant(self.normal, x);
        let weight = exp((depth * depth) * (-PI * (a * a)));
        let phase = Dual::from(phase) - (depth * TAU) * to_plane(2);

        let wave = [to_plane(0), to_plane(1)];
        let pixel = &self.covariance;
        let bell = [[a * a / TAU, 0.0], [0.0, a * a / TAU]];
        let of_pixel = 1.0 / (TAU * determinant(pixel).sqrt());
        let pixel_frequencies = scaled(&inverse(pixel), (1.0 / (4.0 * std::f64::consts::PI.powi(2))) as f32);
        let both = sum(&bell, &pixel_frequencies);
        let moved = row_times(wave, &inverse(&both));
        let damping = (-0.5 * (moved[0] * wave[0] + moved[1] * wave[1])).exp();
        let weight = ((weight * of_pixel) * (1.0 / (TAU * determinant(&both).sqrt()))) * damping;
        let bell_inverse = inverse(&bell);
        let filtered = inverse(&sum(&inverse(&pixel_frequencies), &bell_inverse));
        let wave = row_times(wave, &product(&filtered, &bell_inverse));
        let a = ((std::f64::consts::TAU * f64::from(determinant(&filtered).sqrt())) as f32).sqrt();

        let along = |k: usize| x[0] * m[0][k] + x[1] * m[1][k] + x[2] * m[2][k];
        kernel(weight, wave, phase, a, [along(0), along(1)])
    }
}

impl Gabor {
    fn new(options: GaborOptions, p: DualVec3, period: Option<Vec3>) -> Self {
        let spread = f64::from(exp2(options.bandwidth.clamp(0.01, 100.0)));
        let a =
            (f64::from(FREQUENCY) * ((spread - 1.0) / (spread + 1.0)) * f64::from(SQRT_PI_OVER_LN2)) as f32;
        let radius = (-TRUNCATION.ln() / PI).sqrt() / a;
        let volume = radius * radius * radius;
        let sphere = (1.33333 * std::f64::consts::PI) as f32;
        let density = options.impulses.clamped(1.0, 32.0) / (sphere * volume);
        let filter = if options.do_filter { Filter::new(p) } else { None };
        let (bells, root_of_density) = (density * volume, 1.0 / density.sqrt());
        Self { options, a, radius, bells, root_of_density, filter, period }
    }

    /// A wave's direction and phase.
    fn wave(&self, random: &mut Random) -> (Vec3, f32) {
        let direction = self.options.direction;
        let omega = match self.options.anisotropic {
            1 => direction,
            0 => {
                let around = TAU * random.next();
                let r = random.next();
                let up = -(1.0 - r) + r;
                let across = (1.0 - up * up).max(0.0).sqrt();
                let (sine, cosine) = sincos(around);
                normalized([cosine * across, sine * across, up])
            }
            _ => {
                let [x, y, z] = direction;
                let length = (x * x + y * y + z * z).sqrt();
                let (sine, cosine) = sincos(TAU * random.next());
                [length * cosine, length * sine, length * 0.0]
            }
        };
        (omega, TAU * random.next())
    }

    /// Contribution of the kernels of a cell at `x`, which is relative to the cell's corner.
    fn cell(&self, corner: Vec3, x: DualVec3, seed: u32) -> Dual<f32> {
        let cell = self.period.map_or(corner, |period| wrap(corner, period));
        let mut random = Random::in_cell(cell, seed);
        let mut sum = Dual::from(0.0);
        for _ in 0..random.poisson(self.bells) {
            let [cz, cy, cx] = [random.next(), random.next(), random.next()];
            let offset = [(x[0] - cx) * self.radius, (x[1] - cy) * self.radius, (x[2] - cz) * self.radius];
            let (omega, phase) = self.wave(&mut random);
            let value = offset.map(|x| x.value);
            if dot(value, value) < self.radius * self.radius {
                let solid = || kernel(1.0.into(), omega, phase.into(), self.a, offset);
                let filtered = self.filter.map(|filter| filter.kernel(self.a, omega, phase, offset));
                // Extreme filters are beyond floats.
                sum = sum + filtered.filter(|x| x.value.is_finite()).unwrap_or_else(solid);
            }
        }
        sum
    }

    /// Noise at `p`, from the cell that it is in and all around.
    fn at(&self, p: DualVec3, seed: u32) -> Dual<f32> {
        let p = p.map(|x| x * (1.0 / self.radius));
        let floor = p.map(|x| x.value.floor());
        let x = [p[0] - floor[0], p[1] - floor[1], p[2] - floor[2]];
        let mut sum = Dual::from(0.0);
        for k in [-1.0, 0.0, 1.0] {
            for j in [-1.0, 0.0, 1.0] {
                for i in [-1.0, 0.0, 1.0] {
                    let corner = [floor[0] + i, floor[1] + j, floor[2] + k];
                    sum = sum + self.cell(corner, [x[0] - i, x[1] - j, x[2] - k], seed);
                }
            }
        }
        let variance = 1.0 / ((4.0 * std::f32::consts::SQRT_2) * (self.a * self.a * self.a));
        (sum * self.root_of_density) * (1.0 / (3.0 * variance.sqrt()) * 0.5)
    }
}

/// Gabor noise, in about [-1, 1]; it repeats where there is a period. Without derivatives nothing is filtered.
#[must_use]
pub fn gabor(p: [Dual<f32>; 3], period: Option<[f32; 3]>, options: &GaborOptions) -> Dual<f32> {
    Gabor::new(*options, p, period).at(p, 0)
}

/// Three Gabor noises.
#[must_use]
pub fn gabor3(p: [Dual<f32>; 3], period: Option<[f32; 3]>, options: &GaborOptions) -> [Dual<f32>; 3] {
    let noise = Gabor::new(*options, p, period);
    [0, 1, 2].map(|seed| noise.at(p, seed))
}
