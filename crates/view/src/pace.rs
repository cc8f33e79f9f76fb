// SPDX-License-Identifier: GPL-3.0-or-later
//! How many pixels can be rendered while the camera moves: as many as keep the picture moving smoothly.
//! Source: original. Cost per pixel is smoothed over frames, quickly upwards and slowly downwards, so that the size does
//! not flicker. Proof: `tests`.

/// Chooses the divisor of both sides of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Seconds that a frame may take.
    target: f64,
    /// Seconds per pixel of one sample; `None` before anything was measured.
    cost: Option<f64>,
    divisor: u32,
}

const COARSEST: u32 = 8;
/// Before anything is known: soon enough for any integrator.
const FIRST: u32 = 4;

impl Pace {
    pub(crate) fn new(target: f64) -> Self {
        Self { target, cost: None, divisor: FIRST }
    }

    /// A frame of so many pixels took so long.
    pub(crate) fn note(&mut self, pixels: u64, seconds: f64) {
        let cost = seconds / (pixels.max(1) as f64);
        let smooth = match self.cost {
            Some(before) if cost < before => before + 0.2 * (cost - before),
            Some(before) => before + 0.5 * (cost - before),
            None => cost,
        };
        self.cost = Some(smooth);
    }

    /// What to divide the sides of a picture by, 1 to 8.
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

    /// Forgets what was measured: another integrator, another scene.
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
    fn no_side_is_lost() {
        assert_eq!(divided([1279, 3], 4), [320, 1], "rounded up");
    }
}
