// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench light`: how fast integrators come near the truth, in seconds of the processor.
//! The truth is two independent pictures by paths, R and S: the mean of (a - R)(a - S) has the mean of (a -
//! truth)^2, independent of their noise. Relative errors divide by the truth's square, smoothed over a few
//! pixels, plus a hundredth of the squared mean of the picture. Tests: `tests`.

use std::fmt::Write;

use gnurt::ThreadPool;
use gnurt::image::Picture;
use gnurt::render::{Accumulation, Guiding, Integrator, RenderOptions, Silent, World};
use gnurt::shading::CameraShader;

use crate::clock::process_seconds;

/// The pictures to compare, and the time.
#[derive(Clone, Debug)]
pub struct Options {
    /// The compared integrators.
    pub integrators: Vec<Integrator>,
    /// Size, depth, virtual lights; each seed is one more than the last.
    pub picture: RenderOptions,
    /// Seconds of all processors together that each picture may take; the current sample is finished.
    pub seconds: f64,
    /// Pictures by each.
    pub seeds: u64,
    /// Render each picture twice under the same virtual lights, and separate the common part of their errors
    /// from the rest.
    pub separate_lights: bool,
}

/// Errors of one picture after some samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Its integrator.
    pub integrator: Integrator,
    /// Which picture of theirs.
    pub seed: u64,
    /// Samples per pixel.
    pub samples: u32,
    /// Seconds of all processors together.
    pub seconds: f64,
    /// Mean relative squared error of pixels and colours.
    pub rel_mse: f64,
    /// Error of the mean of the picture, a share of it.
    pub mean_error: f64,
    /// The part of `rel_mse` due to virtual lights, if requested.
    pub of_lights: Option<f64>,
}

/// The truth, twice.
#[derive(Clone, Debug)]
pub struct Truth {
    pictures: [Picture; 2],
    /// One over the divisor of squared errors, per pixel.
    weights: Vec<f64>,
    mean: f64,
}

/// Pixels around each that its weight is smoothed over.
const AROUND: i64 = 2;
/// Share of the squared mean that keeps relative errors of black pixels finite.
const FLOOR: f64 = 0.01;

fn channel(picture: &Picture, pixel: usize, k: usize) -> f64 {
    f64::from(picture.color[pixel][k])
}

fn mean(picture: &Picture) -> f64 {
    let count = picture.color.len();
    (0..count).flat_map(|i| [0, 1, 2].map(|k| channel(picture, i, k))).sum::<f64>() / (3 * count) as f64
}

impl Truth {
    /// From two independent pictures of one size; `None` if the sizes differ.
    #[must_use]
    pub fn new(pictures: [Picture; 2]) -> Option<Self> {
        let [a, b] = &pictures;
        if (a.width, a.height) != (b.width, b.height) {
            return None;
        }
        let mean = 0.5 * (mean(a) + mean(b));
        let (width, height) = (i64::from(a.width), i64::from(a.height));
        let weight = |x: i64, y: i64| {
            let (mut sum, mut count) = (0.0, 0.0);
            for v in (y - AROUND).max(0)..=(y + AROUND).min(height - 1) {
                for u in (x - AROUND).max(0)..=(x + AROUND).min(width - 1) {
                    let pixel = (v * width + u) as usize;
                    sum += [0, 1, 2].map(|k| channel(a, pixel, k) + channel(b, pixel, k)).iter().sum::<f64>();
                    count += 6.0;
                }
            }
            let here: f64 = sum / count;
            1.0 / (here * here + FLOOR * mean * mean).max(f64::MIN_POSITIVE)
        };
        let weights = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| weight(x, y));
        let weights = weights.collect();
        Some(Self { pictures, weights, mean })
    }

    /// Rendered by paths, `spp` samples per pixel for each of the two.
    ///
    /// # Errors
    /// If the options leave nothing to render.
    pub fn by_paths(
        world: &World,
        camera: &dyn CameraShader,
        options: &RenderOptions,
        spp: u32,
        pool: &ThreadPool,
    ) -> Result<Self, gnurt::render::RenderError> {
        let picture = |seed| {
            let options = RenderOptions {
                integrator: Integrator::Path,
                clamp: None,
                guiding: Guiding::Off,
                spp,
                seed,
                time_limit: None,
                ..options.clone()
            };
            let mut picture = gnurt::render::render(world, camera, &options, pool, &Silent)?.picture;
            // The background counts as the rest does, also after the picture has been in a file.
            picture.make_opaque(None);
            Ok(picture)
        };
        let pictures = [picture(SEED)?, picture(SEED + 1)?];
        Ok(Self::new(pictures).expect("of one size"))
    }

    /// Both pictures.
    #[must_use]
    pub fn pictures(&self) -> &[Picture; 2] {
        &self.pictures
    }

    /// Mean relative squared error of a picture, and the error of its mean as a share.
    #[must_use]
    pub fn errors(&self, picture: &Picture) -> (f64, f64) {
        let [a, b] = &self.pictures;
        let mut sum = 0.0;
        for (i, weight) in self.weights.iter().enumerate() {
            for k in 0..3 {
                let found = channel(picture, i, k);
                sum += (found - channel(a, i, k)) * (found - channel(b, i, k)) * weight;
            }
        }
        let off = mean(picture) / self.mean - 1.0;
        (sum / (3 * self.weights.len()) as f64, off)
    }

    /// The common part of the relative squared errors of two pictures.
    #[must_use]
    pub fn in_common(&self, one: &Picture, other: &Picture) -> f64 {
        let [a, b] = &self.pictures;
        let mut sum = 0.0;
        for (i, weight) in self.weights.iter().enumerate() {
            for k in 0..3 {
                let off = |found: &Picture, truth: &Picture| channel(found, i, k) - channel(truth, i, k);
                sum += 0.5 * (off(one, a) * off(other, b) + off(one, b) * off(other, a)) * weight;
            }
        }
        sum / (3 * self.weights.len()) as f64
    }

    /// The difference of the means of the two, as a share: about twice the error of their mean.
    #[must_use]
    pub fn doubt(&self) -> f64 {
        let [a, b] = &self.pictures;
        (mean(a) - mean(b)).abs() / self.mean
    }
}

/// Seed of the truth's first picture, far from the measured ones.
const SEED: u64 = 1 << 40;

/// Renders and measures: seed by seed, the integrators alternating. `report` gets each point: at 1, 2, 4, ...
/// samples, and of the last.
///
/// # Errors
/// If the options leave nothing to render.
pub fn run(
    world: &World,
    camera: &dyn CameraShader,
    options: &Options,
    truth: &Truth,
    pool: &ThreadPool,
    report: &mut dyn FnMut(&Point, &Picture),
) -> Result<Vec<Point>, gnurt::render::RenderError> {
    let mut points = Vec::new();
    for seed in 0..options.seeds {
        for &integrator in &options.integrators {
            let seed_of_picture = options.picture.seed + seed;
            let picture = RenderOptions {
                integrator,
                seed: seed_of_picture,
                spp: u32::MAX >> 1,
                time_limit: None,
                ..options.picture.clone()
            };
            // Of other rays under the same virtual lights.
            let twin = options.separate_lights && integrator.has_virtual_lights();
            let lights_seed = Some(seed_of_picture);
            let of_twin = RenderOptions { seed: SEED + 2 + seed_of_picture, lights_seed, ..picture.clone() };
            let mut twin = if twin { Some(Accumulation::new(of_twin)?) } else { None };
            let mut accumulation = Accumulation::new(picture)?;
            let mut seconds = 0.0;
            loop {
                let begin = process_seconds();
                accumulation.pass(world, camera, 1, pool, &Silent);
                seconds += process_seconds() - begin;
                let (samples, over) = (accumulation.samples(), seconds >= options.seconds);
                if over || samples.is_power_of_two() {
                    let picture = accumulation.colors();
                    let (rel_mse, mean_error) = truth.errors(&picture);
                    let of_lights = twin.as_mut().map(|twin| {
                        twin.pass(world, camera, samples - twin.samples(), pool, &Silent);
                        truth.in_common(&picture, &twin.colors())
                    });
                    let point = Point { integrator, seed, samples, seconds, rel_mse, mean_error, of_lights };
                    report(&point, &picture);
                    points.push(point);
                }
                if over {
                    break;
                }
            }
        }
    }
    Ok(points)
}

/// The median of some values; NaN of none.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 { f64::NAN } else { 0.5 * (values[(n - 1) / 2] + values[n / 2]) }
}

/// Errors of an integrator when its time was over, over all seeds.
#[derive(Clone, Copy, Debug)]
pub struct Summary {
    /// The integrator.
    pub integrator: Integrator,
    /// Median of samples per pixel.
    pub samples: f64,
    /// Median of relative errors, scaled to the requested time: errors of means of independent samples fall
    /// as one over time.
    pub rel_mse: f64,
    /// The same for the part due to virtual lights, if requested.
    pub of_lights: Option<f64>,
    /// Root mean square of the errors of the pictures' means.
    pub mean_error: f64,
    /// Mean of the errors of the pictures' means: the error of all pictures together.
    pub bias: f64,
}

/// One summary for each integrator, in the order of the points.
#[must_use]
pub fn summaries(points: &[Point], seconds: f64) -> Vec<Summary> {
    let mut integrators: Vec<Integrator> = Vec::new();
    points.iter().for_each(|p| {
        if !integrators.contains(&p.integrator) {
            integrators.push(p.integrator);
        }
    });
    let of = |integrator: Integrator| {
        let last = |p: &&Point| {
            p.integrator == integrator
                && !points
                    .iter()
                    .any(|q| q.integrator == integrator && q.seed == p.seed && q.samples > p.samples)
        };
        let last: Vec<&Point> = points.iter().filter(last).collect();
        let count = last.len().max(1) as f64;
        Summary {
            integrator,
            samples: median(last.iter().map(|p| f64::from(p.samples)).collect()),
            rel_mse: median(last.iter().map(|p| p.rel_mse * p.seconds / seconds).collect()),
            of_lights: last
                .iter()
                .map(|p| p.of_lights.map(|own| own * p.seconds / seconds))
                .collect::<Option<Vec<f64>>>()
                .map(median),
            mean_error: (last.iter().map(|p| p.mean_error.powi(2)).sum::<f64>() / count).sqrt(),
            bias: last.iter().map(|p| p.mean_error).sum::<f64>() / count,
        }
    };
    integrators.into_iter().map(of).collect()
}

/// A table of summaries.
#[must_use]
pub fn table(summaries: &[Summary]) -> String {
    let mut text = String::from(
        "integrator  samples     relMSE  of lights  rms error of the mean  error of all together\n",
    );
    for s in summaries {
        let of_lights = s.of_lights.map_or_else(|| "-".to_owned(), |own| format!("{own:.6}"));
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{:<10} {:>8.0} {:>10.6} {:>10} {:>21.2}% {:>21.2}%",
            s.integrator.name(),
            s.samples,
            s.rel_mse,
            of_lights,
            100.0 * s.mean_error,
            100.0 * s.bias
        );
    }
    text
}

/// All points as a table of comma-separated values.
#[must_use]
pub fn csv(scene: &str, points: &[Point]) -> String {
    let mut text = String::from("scene,integrator,seed,samples,cpu_seconds,rel_mse,mean_error,of_lights\n");
    for p in points {
        let name = p.integrator.name();
        let _ = writeln!(
            text,
            "{scene},{name},{},{},{:.3},{:.3e},{:.3e},{}",
            p.seed,
            p.samples,
            p.seconds,
            p.rel_mse,
            p.mean_error,
            p.of_lights.map_or_else(String::new, |own| format!("{own:.3e}"))
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: u32) -> f32 {
        let mut x = n.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
        for _ in 0..3 {
            x = (x ^ (x >> 15)).wrapping_mul(0x2c1b_3c6d) ^ (x >> 12);
        }
        (x >> 8) as f32 / (1 << 24) as f32 - 0.5
    }

    fn picture(value: f32, noisy: f32, seed: u32) -> Picture {
        let mut picture = Picture::new(64, 64);
        for (i, pixel) in picture.color.iter_mut().enumerate() {
            let grey = value + noisy * noise(i as u32 + seed * 100_000);
            *pixel = [grey, grey, grey, 1.0];
        }
        picture
    }

    #[test]
    fn noise_of_the_truth_does_not_count() {
        let truth = Truth::new([picture(2.0, 1.0, 1), picture(2.0, 1.0, 2)]).expect("of one size");
        let (rel_mse, off) = truth.errors(&picture(2.2, 0.0, 3));
        // 0.2^2 / (2^2 * 1.01); each truth by itself would add its own variance of 1/12 on 4.
        assert!((rel_mse - 0.04 / 4.04).abs() < 0.002, "relMSE {rel_mse}");
        assert!((off - 0.1).abs() < 0.01, "the mean is off by {off}");
    }

    #[test]
    fn summaries_take_the_last_point_of_each_seed() {
        let point = |seed, samples, seconds, rel_mse| Point {
            integrator: Integrator::Path,
            seed,
            samples,
            seconds,
            rel_mse,
            mean_error: 0.1,
            of_lights: (samples > 1).then_some(0.5 * rel_mse),
        };
        let points =
            [point(0, 1, 1.0, 9.0), point(0, 2, 2.0, 1.0), point(1, 2, 4.0, 2.0), point(2, 2, 2.0, 3.0)];
        let found = summaries(&points, 2.0);
        assert_eq!(found.len(), 1, "one integrator");
        assert_eq!(found[0].rel_mse, 3.0, "the median of 1, 4 and 3");
        assert_eq!(found[0].of_lights, Some(1.5), "half of it");
    }

    #[test]
    fn errors_in_common_are_told_apart() {
        let truth = Truth::new([picture(2.0, 1.0, 1), picture(2.0, 1.0, 2)]).expect("of one size");
        let of = |seed| {
            let (mut shared, own) = (picture(2.0, 0.6, 3), picture(0.0, 0.8, seed));
            shared.color.iter_mut().zip(&own.color).for_each(|(a, b)| (0..3).for_each(|k| a[k] += b[k]));
            shared
        };
        let (one, other) = (of(4), of(5));
        let (common, all) = (truth.in_common(&one, &other), truth.errors(&one).0);
        // Variances of 0.36 / 12 and 0.64 / 12 on 2^2 * 1.01.
        assert!((common - 0.36 / 12.0 / 4.04).abs() < 0.001, "in common: {common}");
        assert!((all - 1.0 / 12.0 / 4.04).abs() < 0.002, "all: {all}");
    }
}
