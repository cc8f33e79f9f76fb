// SPDX-License-Identifier: GPL-3.0-or-later
//! The number of pixels to render while the camera moves: the most that keeps the motion smooth. Cost per
//! pixel is smoothed over frames, quickly upwards and slowly downwards, so that the size does not flicker.
//! Tests: `tests`.

use gnurt::render::{MotionCost, MotionShare};

/// Chooses the divisor of both sides of the picture, and how many pixels take fresh light where pictures
/// reuse the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Seconds that a frame may take.
    target: f64,
    /// Seconds per traced pixel, per shown one, and per fresh sample of light; `None` before the first
    /// measurement.
    remembering: Option<[f64; 3]>,
    /// Seconds per pixel of one sample; `None` before anything was measured.
    cost: Option<f64>,
    divisor: u32,
}

/// A cost that follows the measurements, quickly upwards and slowly downwards.
fn smoothed(before: f64, now: f64) -> f64 {
    before + if now < before { 0.2 } else { 0.5 } * (now - before)
}

/// Seconds that a picture which reuses others may take, and that it takes if it can. All pixels are traced
/// where that takes no longer than the latter.
const SLOWEST: f64 = 0.095;
const BRISK: f64 = 0.05;
/// Share of the traced pixels that get a fresh sample, at least and at most.
const LEAST_FRESH: f32 = 1.0 / 48.0;
const MOST_FRESH: f32 = 0.5;
const COARSEST: u32 = 8;
/// Before anything is known: soon enough for any integrator.
const FIRST: u32 = 4;

impl Pace {
    pub(crate) fn new(target: f64) -> Self {
        Self { target, remembering: None, cost: None, divisor: FIRST }
    }

    /// A frame of this many pixels took this many seconds.
    pub(crate) fn note(&mut self, pixels: u64, seconds: f64) {
        let cost = seconds / (pixels.max(1) as f64);
        self.cost = Some(self.cost.map_or(cost, |before| smoothed(before, cost)));
    }

    /// A frame of this many pixels that reuses others took this long.
    pub(crate) fn note_remembering(&mut self, pixels: u64, cost: MotionCost) {
        let costs = [
            cost.tracing_seconds / cost.traced.max(1) as f64,
            cost.showing_seconds / pixels.max(1) as f64,
            cost.sampling_seconds / cost.samples.max(1) as f64,
        ];
        let smooth = |before: [f64; 3]| [0, 1, 2].map(|k| smoothed(before[k], costs[k]));
        self.remembering = Some(self.remembering.map_or(costs, smooth));
    }

    /// The divisor of the sides, 1 to 8, and the shares of the pixels that are traced and sampled. All pixels
    /// are traced if that takes no longer than `BRISK` with the least of samples. Else one of four is, in
    /// the largest picture that takes no longer than `SLOWEST`. More samples are added up to the time `BRISK`.
    pub(crate) fn remembering(&self, [width, height]: [u32; 2]) -> (u32, MotionShare) {
        let Some([trace, show, sample]) = self.remembering else {
            // They are seldom slow.
            return (1, MotionShare { fresh: LEAST_FRESH, stride: 2 });
        };
        let pixels = |divisor: u32| f64::from(width.div_ceil(divisor)) * f64::from(height.div_ceil(divisor));
        let traced = |(divisor, stride): (u32, u32)| pixels(divisor * stride);
        let other = |plan: (u32, u32)| pixels(plan.0) * show + traced(plan) * trace;
        let seconds = |plan: (u32, u32)| other(plan) + f64::from(LEAST_FRESH) * traced(plan) * sample;
        let plan = if seconds((1, 1)) <= BRISK {
            (1, 1)
        } else {
            ((1..COARSEST).find(|&divisor| seconds((divisor, 2)) <= SLOWEST).unwrap_or(COARSEST), 2)
        };
        let fresh = (BRISK - other(plan)) / traced(plan) / sample.max(1e-12);
        let fresh = fresh.clamp(f64::from(LEAST_FRESH), f64::from(MOST_FRESH)) as f32;
        (plan.0, MotionShare { fresh, stride: plan.1 })
    }

    /// The divisor of the sides of a picture, 1 to 8.
    pub(crate) fn divisor(&mut self, [width, height]: [u32; 2]) -> u32 {
        if let Some(cost) = self.cost {
            let seconds = |divisor: u32| {
                cost * f64::from(width.div_ceil(divisor)) * f64::from(height.div_ceil(divisor))
            };
            // Finer only if that leaves some time: a size at the limit would come and go.
            let fits = |divisor: u32| {
                seconds(divisor) <= if divisor < self.divisor { 0.8 * self.target } else { self.target }
            };
            self.divisor = (1..COARSEST).find(|&divisor| fits(divisor)).unwrap_or(COARSEST);
        }
        self.divisor
    }

    /// Drops the measurements: another integrator, another scene.
    pub(crate) fn forget(&mut self) {
        *self = Self::new(self.target);
    }
}

/// A size with both sides divided, rounded up.
pub(crate) fn divided(size: [u32; 2], divisor: u32) -> [u32; 2] {
    size.map(|side| side.div_ceil(divisor).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs frames on a machine with this cost per pixel; the last divisors.
    fn settle(pace: &mut Pace, cost: f64) -> Vec<u32> {
        let size = [1280, 720];
        let divisors = (0..60).map(|_| {
            let divisor = pace.divisor(size);
            let [w, h] = divided(size, divisor);
            let pixels = u64::from(w) * u64::from(h);
            pace.note(pixels, cost * pixels as f64);
            divisor
        });
        divisors.collect::<Vec<_>>()[50..].to_vec()
    }

    #[test]
    fn sizes_settle_where_the_time_allows() {
        let mut pace = Pace::new(0.033);
        let whole = 1280.0 * 720.0;
        assert_eq!(settle(&mut pace, 0.02 / whole), [1; 10], "a fast one: all pixels");
        assert_eq!(settle(&mut pace, 0.12 / whole), [2; 10], "four times too slow for that: half");
        assert_eq!(settle(&mut pace, 9.0 / whole), [8; 10], "hopeless: the coarsest");
        assert_eq!(settle(&mut pace, 0.02 / whole), [1; 10], "and back");
        pace.forget();
        assert_eq!(pace.divisor([1280, 720]), FIRST, "as in the beginning");
    }

    #[test]
    fn whole_pictures_ask_for_as_much_light_as_there_is_time_for() {
        let size = [640, 480];
        let all = 640.0 * 480.0;
        let settle = |trace: f64, show: f64, sample: f64| {
            let mut pace = Pace::new(0.033);
            for _ in 0..50 {
                let (divisor, share) = pace.remembering(size);
                let pixels = divided(size, divisor).map(u64::from);
                let traced = divided(size, divisor * share.stride).map(u64::from);
                let (pixels, traced) = (pixels[0] * pixels[1], traced[0] * traced[1]);
                let samples = (f64::from(share.fresh) * traced as f64) as u64;
                let cost = MotionCost {
                    samples,
                    sampling_seconds: samples as f64 * sample / all,
                    traced,
                    tracing_seconds: traced as f64 * trace / all,
                    showing_seconds: pixels as f64 * show / all,
                };
                pace.note_remembering(pixels, cost);
            }
            let (divisor, share) = pace.remembering(size);
            (divisor, share.stride, share.fresh)
        };
        assert_eq!(settle(0.008, 0.002, 0.02), (1, 1, MOST_FRESH), "cheap: half of the pixels");
        let (divisor, stride, fresh) = settle(0.025, 0.005, 0.2);
        assert!((divisor, stride) == (1, 1) && (fresh - 0.1).abs() < 0.01, "0.02 s are left: {fresh}");
        let (divisor, stride, fresh) = settle(0.1, 0.01, 0.4);
        assert!((divisor, stride) == (1, 2) && (fresh - 0.15).abs() < 0.01, "a quarter is traced: {fresh}");
        assert_eq!(settle(0.3, 0.01, 0.2), (1, 2, LEAST_FRESH), "slow, but whole");
        assert_eq!(settle(0.6, 0.01, 0.5).0, 2, "too slow");
    }

    #[test]
    fn no_side_is_lost() {
        assert_eq!(divided([1279, 3], 4), [320, 1], "rounded up");
    }
}
