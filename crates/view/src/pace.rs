// SPDX-License-Identifier: GPL-3.0-or-later
//! The number of pixels to render while the camera moves: the most that keeps the motion smooth. Cost per
//! pixel is smoothed over frames, quickly upwards and slowly downwards, so that the size does not flicker.
//! Tests: `tests`.

use gnurt::render::MotionCost;

/// Chooses the divisor of both sides of the picture, and how many pixels take fresh light where pictures
/// reuse the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Seconds that a frame may take.
    target: f64,
    /// Seconds per rendered pixel, and per fresh sample of light; `None` before the first measurement.
    remembering: Option<[f64; 2]>,
    /// Seconds per pixel of one sample; `None` before anything was measured.
    cost: Option<f64>,
    divisor: u32,
}

/// A cost that follows the measurements, quickly upwards and slowly downwards.
fn smoothed(before: f64, now: f64) -> f64 {
    before + if now < before { 0.2 } else { 0.5 } * (now - before)
}

/// Seconds that a whole picture which reuses others may take, and that it takes if it can.
const SLOWEST: f64 = 0.095;
const BRISK: f64 = 0.05;
/// Share of the pixels that get a fresh sample.
const LEAST_FRESH: f32 = 1.0 / 24.0;
const MOST_FRESH: f32 = 0.5;
/// Before anything is known of such pictures: they are seldom slow.
const FIRST_REMEMBERING: u32 = 2;
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

    /// A frame of this many pixels that reuses others took this many seconds.
    pub(crate) fn note_remembering(&mut self, pixels: u64, cost: MotionCost) {
        let costs =
            [cost.other_seconds / pixels.max(1) as f64, cost.sampling_seconds / cost.samples.max(1) as f64];
        let smooth = |before: [f64; 2]| [0, 1].map(|k| smoothed(before[k], costs[k]));
        self.remembering = Some(self.remembering.map_or(costs, smooth));
    }

    /// The divisor of the sides, 1 to 8, and the fraction of the pixels with a fresh sample of light. The
    /// picture is whole if it takes no longer than `SLOWEST` with the least of them; more samples are added
    /// up to the time `BRISK`.
    pub(crate) fn remembering(&self, [width, height]: [u32; 2]) -> (u32, f32) {
        let Some([settle_time, sample]) = self.remembering else { return (FIRST_REMEMBERING, LEAST_FRESH) };
        let pixels = |divisor: u32| f64::from(width.div_ceil(divisor)) * f64::from(height.div_ceil(divisor));
        let least = settle_time + f64::from(LEAST_FRESH) * sample;
        let fits = |divisor: &u32| pixels(*divisor) * least <= SLOWEST;
        let divisor = (1..COARSEST).find(fits).unwrap_or(COARSEST);
        let fresh = (BRISK / pixels(divisor) - settle_time) / sample.max(1e-12);
        (divisor, fresh.clamp(f64::from(LEAST_FRESH), f64::from(MOST_FRESH)) as f32)
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
        let pixels = 640 * 480;
        let settle = |settle_time: f64, sample: f64| {
            let mut pace = Pace::new(0.033);
            for _ in 0..50 {
                let (divisor, fresh) = pace.remembering(size);
                let [w, h] = divided(size, divisor);
                let pixel_count = u64::from(w) * u64::from(h);
                let samples = (f64::from(fresh) * pixel_count as f64) as u64;
                let cost = MotionCost {
                    samples,
                    sampling_seconds: samples as f64 * sample,
                    other_seconds: pixel_count as f64 * settle_time,
                };
                pace.note_remembering(pixel_count, cost);
            }
            pace.remembering(size)
        };
        let pixel = 1.0 / f64::from(pixels);
        assert_eq!(settle(0.01 * pixel, 0.02 * pixel), (1, MOST_FRESH), "cheap: half of the pixels");
        let (divisor, fresh) = settle(0.03 * pixel, 0.2 * pixel);
        assert!(divisor == 1 && (fresh - 0.1).abs() < 0.01, "0.02 s are left: a tenth, {fresh}");
        assert_eq!(settle(0.06 * pixel, 0.5 * pixel), (1, LEAST_FRESH), "slow, but whole");
        assert_eq!(settle(0.3 * pixel, 0.5 * pixel).0, 2, "too slow");
    }

    #[test]
    fn no_side_is_lost() {
        assert_eq!(divided([1279, 3], 4), [320, 1], "rounded up");
    }
}
