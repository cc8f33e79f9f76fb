// SPDX-License-Identifier: GPL-3.0-or-later
//! The pilot of [`Integrator::Auto`]: a few samples of the whole picture at a reduced size, under another seed, by paths and by
//! virtual lights. The one with the smaller product of variance and cost renders the picture. The pilot is discarded: the
//! choice does not depend on the picture's samples, so that these stay unbiased.
//! Light that one of them finds rarely makes it look quiet: where its mean is too low for chance, the other one is taken.
//! Cost is counted in rays, for a clock would not say the same twice.
//! Invariant: the choice depends on world, camera and options, neither on threads, crops, pieces nor numbers of samples.
//! Memory: one number for each pixel of the pilot and each of its samples, 80,000 times 8 for each integrator at most.
//! Tests: `tests`, crates/render/tests/auto.rs.

use std::sync::Arc;
use std::time::Instant;

use gnurt_accel::threads::{self, Pieces};
use gnurt_shading::CameraShader;

use crate::film::TileFilm;
use crate::job::Job;
use crate::many_lights;
use crate::options::{Caustics as Searches, Guiding, Integrator, RenderOptions};
use crate::progress::Watch;
use crate::sampler::Sampler;
use crate::stats::{ChoiceStats, MethodStats, RenderStats};
use crate::tracer::BatchTracer;
use crate::transport::manifold::Caustics;
use crate::world::World;

/// The seed of the pilot differs in these bits.
const PILOT: u64 = 0x9e6c_63d0_676a_9a99;
/// Samples of each pixel of the pilot, by each integrator.
const SAMPLES: u32 = 8;
/// Virtual lights of a sample of the pilot, and of the picture's where they are enough.
const FEW_LIGHTS: u32 = 32;
/// And at most, where the mean asks for more.
const MOST_LIGHTS: u32 = 1024;
/// Width of the squares whose mean stands for the brightness of their pixels.
const SQUARE: usize = 8;
/// A mean is too low for chance if it is so many standard errors below the other one.
const ERRORS: f64 = 3.0;
/// A mean of the pilot with a greater standard error is not known: rare lights carry it, of which pictures of few samples have
/// none.
const KNOWN: f64 = 0.05;
/// Time of a ray that gathers from a virtual light over that of others: 0.30 to 0.62 in six interiors.
const GATHERING: f64 = 0.45;

/// An integrator, and what speaks for it.
#[derive(Clone, Debug)]
pub(crate) struct Chosen {
    pub(crate) stats: ChoiceStats,
    /// The rays of the pilot.
    pub(crate) cost: RenderStats,
}

impl Chosen {
    /// Options with the integrator that was chosen, and as suits it.
    pub(crate) fn of(chosen: Option<&Self>, options: &RenderOptions) -> RenderOptions {
        match (options.integrator, chosen) {
            (Integrator::Auto, Some(Self { stats, .. })) => {
                with(options, stats.integrator, stats.virtual_lights)
            }
            (Integrator::Auto, None) => with(options, Integrator::Path, FEW_LIGHTS),
            _ => options.clone(),
        }
    }
}

/// The options with one of the integrators.
fn with(options: &RenderOptions, integrator: Integrator, vpls: u32) -> RenderOptions {
    let guiding = if options.guiding == Guiding::Off { Guiding::Auto } else { options.guiding };
    let caustics = if options.caustics == Searches::Off { Searches::Auto } else { options.caustics };
    RenderOptions { integrator, guiding, caustics, vpls, interleave: 1, ..options.clone() }
}

/// Whether virtual lights show all that the picture asks for.
fn is_open_question(world: &World, options: &RenderOptions) -> bool {
    let integrator = Integrator::BidirectionalInstantRadiosity;
    options.noise.is_none()
        && options.light_layers.iter().all(|layer| integrator.has_light_layer(layer))
        && world.media().is_empty()
        && !world.labels().has_links
        && !world.needs_times()
}

/// Renders the pilot and chooses. `None` if it was told to stop.
pub(crate) fn choose(
    world: &World,
    camera: &dyn CameraShader,
    (options, caustics): (&RenderOptions, Option<&Arc<Caustics>>),
    (watch, deadline): (&dyn Watch, Option<Instant>),
    pool: &rayon::ThreadPool,
) -> Option<Chosen> {
    let begin = Instant::now();
    let mut stats =
        ChoiceStats { integrator: Integrator::Path, virtual_lights: FEW_LIGHTS, methods: None, seconds: 0.0 };
    let mut cost = RenderStats::default();
    if is_open_question(world, options) {
        let pictures = |integrator| {
            let options = pilot_options(&with(options, integrator, FEW_LIGHTS));
            Pictures::render(world, camera, (&options, caustics), (watch, deadline), pool)
        };
        let paths = pictures(Integrator::Path)?;
        cost.add(&paths.stats);
        // Virtual lights show light below surfaces as diffuse.
        if !paths.goes_below {
            let lights = pictures(Integrator::BidirectionalInstantRadiosity)?;
            cost.add(&lights.stats);
            let mut methods = measure([&paths, &lights]);
            (methods[1], stats.virtual_lights) = with_enough(methods[1], lights.gathering());
            if is_better(&methods[1], &methods[0]) {
                stats.integrator = Integrator::BidirectionalInstantRadiosity;
            }
            stats.methods = Some(methods);
        }
    }
    stats.seconds = begin.elapsed().as_secs_f64();
    Some(Chosen { stats, cost: cost.without_samples() })
}

/// As many virtual lights as make the mean known, and a sample with these: the error of the mean falls with the root of their
/// number. That of pixels is left as it is, for it may come from other light. `gathering` is the part of the cost that grows.
fn with_enough(few: MethodStats, gathering: f64) -> (MethodStats, u32) {
    let (excess, most) = (few.mean_error / KNOWN, f64::from(MOST_LIGHTS / FEW_LIGHTS));
    let times = if excess > 1.0 { (excess * excess).ceil().min(most) } else { 1.0 };
    let enough = MethodStats {
        cost: few.cost + gathering * (times - 1.0),
        mean_error: few.mean_error / times.sqrt(),
        ..few
    };
    (enough, FEW_LIGHTS * times as u32)
}

/// Whether the first one of two methods is to be taken.
fn is_better(one: &MethodStats, other: &MethodStats) -> bool {
    let is_known = |method: &MethodStats| method.mean_error <= KNOWN;
    if is_known(one) != is_known(other) {
        return is_known(one);
    }
    let error = one.mean_error.hypot(other.mean_error) * ERRORS;
    let lacks = one.mean + error < other.mean;
    let exceeds = one.mean > other.mean + error;
    exceeds || (!lacks && one.product() < other.product())
}

/// Options of the pilot by one of the integrators.
fn pilot_options(options: &RenderOptions) -> RenderOptions {
    let of_pilot = options.of_pilot(PILOT);
    RenderOptions { lights_seed: None, guiding: Guiding::Off, spp: SAMPLES, ..of_pilot }
}

/// The samples of a method.
struct Pictures {
    width: usize,
    /// Mean of red, green and blue of each pixel, row by row, for each sample.
    samples: Vec<Vec<f32>>,
    stats: RenderStats,
    /// Whether paths went below a surface.
    goes_below: bool,
}

impl Pictures {
    fn render(
        world: &World,
        camera: &dyn CameraShader,
        (options, caustics): (&RenderOptions, Option<&Arc<Caustics>>),
        (watch, deadline): (&dyn Watch, Option<Instant>),
        pool: &rayon::ThreadPool,
    ) -> Option<Self> {
        let mut job = Job::new(world, camera, options, watch);
        job.deadline = deadline;
        job.caustics = caustics.cloned();
        let [width, height] = [options.width, options.height];
        let mut tiles = TileFilm::cover([0, 0, width, height], options);
        let (mut stats, mut samples, mut goes_below) = (RenderStats::default(), Vec::new(), false);
        let mut before = vec![0.0; width as usize * height as usize];
        let mut sums = before.clone();
        for sample in 0..options.spp {
            let pass = pool.install(|| many_lights::pass_lights(&job, sample));
            pass.iter().for_each(|pass| stats.add(&pass.stats));
            let sampler = Sampler { job: &job, pass: pass.as_ref() };
            let pieces = Pieces::new(&mut tiles, 1);
            let render = |tracer: &mut BatchTracer, n: usize| {
                sampler.render_samples(&mut pieces.lock(n)[0], tracer, sample + 1);
                (tracer.take_stats(), tracer.wavefront.below.has_begun)
            };
            let of_tiles =
                pool.install(|| threads::map_with(true, pieces.count(), || sampler.tracer(), render));
            for (of_tile, has_begun) in &of_tiles {
                stats.add(of_tile);
                goes_below |= has_begun;
            }
            if job.should_stop() {
                return None;
            }
            // A sample is the difference of sums.
            for tile in &tiles {
                for (i, [x, y]) in tile.pixels().enumerate() {
                    let [r, g, b, _] = tile.mean(i).map(f64::from);
                    sums[(y * width + x) as usize] = (r + g + b) / 3.0 * f64::from(tile.samples);
                }
            }
            samples.push(sums.iter().zip(&before).map(|(sum, before)| (sum - before) as f32).collect());
            before.clone_from(&sums);
        }
        Some(Self { width: width as usize, samples, stats, goes_below })
    }

    /// Cost of the rays to virtual lights of a sample of a pixel.
    fn gathering(&self) -> f64 {
        let samples: usize = self.samples.iter().map(Vec::len).sum();
        GATHERING * self.stats.gather_rays as f64 / samples.max(1) as f64
    }

    /// The mean of all samples.
    fn means(&self) -> Vec<f64> {
        let mut means = vec![0.0; self.samples.first().map_or(0, Vec::len)];
        for sample in &self.samples {
            means.iter_mut().zip(sample).for_each(|(sum, &value)| *sum += f64::from(value));
        }
        means.iter_mut().for_each(|sum| *sum /= self.samples.len().max(1) as f64);
        means
    }

    /// Variance of a sample over the square of a pixel's brightness, in the mean over pixels; cost of a sample; mean over
    /// brightness with its standard error.
    fn measure(&self, brightness: &[f64]) -> MethodStats {
        let (count, pixels) = (self.samples.len() as f64, brightness.len().max(1) as f64);
        let means = self.means();
        let mut variance = 0.0;
        let mut sums = Vec::with_capacity(self.samples.len());
        for sample in &self.samples {
            let mut sum = 0.0;
            for ((&value, mean), brightness) in sample.iter().zip(&means).zip(brightness) {
                variance += ((f64::from(value) - mean) / brightness).powi(2);
                sum += f64::from(value) / brightness;
            }
            sums.push(sum / pixels);
        }
        let mean = sums.iter().sum::<f64>() / count;
        let spread: f64 = sums.iter().map(|sum| (sum - mean).powi(2)).sum();
        MethodStats {
            variance: variance / (pixels * (count - 1.0)),
            cost: (self.stats.rays() as f64 - (1.0 - GATHERING) * self.stats.gather_rays as f64)
                / (pixels * count),
            mean,
            mean_error: (spread / (count * (count - 1.0))).sqrt(),
        }
    }
}

/// What speaks for each method: errors are relative to the same brightness.
fn measure(methods: [&Pictures; 2]) -> [MethodStats; 2] {
    let [a, b] = methods.map(Pictures::means);
    let both: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a + b) / 2.0).collect();
    let brightness = brightness(&both, methods[0].width);
    methods.map(|method| method.measure(&brightness))
}

/// The brightness of each pixel: the root of the mean of its square and of a hundredth of the picture's, so that black
/// counts little and is never divided by.
fn brightness(picture: &[f64], width: usize) -> Vec<f64> {
    let width = width.max(1);
    let columns = width.div_ceil(SQUARE);
    let square = |i: usize| i / width / SQUARE * columns + i % width / SQUARE;
    let mut sums = vec![(0.0, 0.0); columns * (picture.len() / width).div_ceil(SQUARE)];
    for (i, value) in picture.iter().enumerate() {
        let (sum, count) = &mut sums[square(i)];
        (*sum, *count) = (*sum + value, *count + 1.0);
    }
    let mean = picture.iter().sum::<f64>() / picture.len().max(1) as f64;
    let at = |i| {
        let (sum, count): (f64, f64) = sums[square(i)];
        (sum / count).hypot(0.1 * mean).max(f64::MIN_POSITIVE.sqrt())
    };
    (0..picture.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two samples of each pixel of a row.
    fn pictures(samples: [[f32; 4]; 2], rays: u64) -> Pictures {
        let stats = RenderStats { camera_rays: rays, ..RenderStats::default() };
        Pictures { width: 4, samples: samples.map(Vec::from).to_vec(), stats, goes_below: false }
    }

    #[test]
    fn variance_is_relative_to_brightness() {
        // Mean 2; one pixel with variance ((3 - 2)^2 + (1 - 2)^2) / 1, over 2^2 and a hundredth of it.
        let noisy = pictures([[3.0, 2.0, 2.0, 2.0], [1.0, 2.0, 2.0, 2.0]], 24);
        let still = pictures([[2.0; 4]; 2], 80);
        let [a, b] = measure([&noisy, &still]);
        assert!((a.variance - 2.0 / 4.04 / 4.0).abs() < 1e-9, "{a}");
        assert!((a.mean - 2.0 / 4.04_f64.sqrt()).abs() < 1e-9, "{a}");
        // Means of samples: a quarter above and below 2.
        assert!((a.mean_error - 0.25 / 4.04_f64.sqrt()).abs() < 1e-9, "{a}");
        assert_eq!((a.cost, b.cost), (3.0, 10.0), "rays for each sample of a pixel");
        assert_eq!((b.variance, b.mean_error, b.product()), (0.0, 0.0, 0.0), "{b}");
    }

    #[test]
    fn black_pictures_are_measured() {
        let black = pictures([[0.0; 4]; 2], 8);
        let [a, b] = measure([&black, &black]);
        assert_eq!((a.variance, b.mean, b.mean_error), (0.0, 0.0, 0.0));
    }

    #[test]
    fn more_lights_make_the_mean_known() {
        let few = MethodStats { variance: 1.0, cost: 12.0, mean: 1.0, mean_error: 0.04 };
        assert_eq!(with_enough(few, 9.0), (few, 32), "it is known");
        let (enough, lights) = with_enough(MethodStats { mean_error: 0.13, ..few }, 9.0);
        assert_eq!((lights, enough.cost), (224, 12.0 + 6.0 * 9.0), "seven times as many");
        assert!(enough.mean_error <= KNOWN && enough.variance == few.variance, "{enough}");
        let (most, lights) = with_enough(MethodStats { mean_error: 1.0, ..few }, 9.0);
        assert!(lights == 1024 && most.mean_error > KNOWN, "not known with the most: {most}");
        let (nothing, lights) = with_enough(MethodStats { mean_error: f64::NAN, ..few }, 9.0);
        assert!(lights == 32 && nothing.mean_error.is_nan(), "no number");
    }

    #[test]
    fn lost_light_is_worse_than_noise() {
        let noisy = MethodStats { variance: 4.0, cost: 1.0, mean: 1.0, mean_error: 0.01 };
        let quiet = MethodStats { variance: 1.0, cost: 1.0, ..noisy };
        assert!(is_better(&quiet, &noisy) && !is_better(&noisy, &quiet), "less noise");
        let dark = MethodStats { mean: 0.9, ..quiet };
        assert!(!is_better(&dark, &noisy) && is_better(&noisy, &dark), "its mean is too low for chance");
        let unknown = MethodStats { mean_error: 0.1, ..quiet };
        assert!(!is_better(&unknown, &noisy) && is_better(&noisy, &unknown), "its mean is not known");
        let both = MethodStats { mean_error: 0.1, ..noisy };
        assert!(is_better(&unknown, &both), "neither is known: less noise");
    }
}
