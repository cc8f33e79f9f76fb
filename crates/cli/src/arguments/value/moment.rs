// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of time: limits, times and frames of an animation. See docs/reference/cli.md. Tests: `tests`.

use std::time::Duration;

/// Frames of an animation, both ends included, and the distance from each to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange {
    pub(crate) first: u32,
    pub(crate) last: u32,
    pub(crate) step: u32,
}

impl FrameRange {
    /// The numbers, in order.
    pub(crate) fn numbers(self) -> impl Iterator<Item = u32> {
        (self.first..=self.last).step_by(self.step as usize)
    }

    /// How many there are.
    pub(crate) fn count(self) -> usize {
        ((self.last - self.first) / self.step) as usize + 1
    }

    /// The index of a number.
    pub(crate) fn index(self, number: u32) -> usize {
        (number.saturating_sub(self.first) / self.step) as usize
    }

    /// Number `i` of them.
    pub(crate) fn number(self, i: usize) -> u32 {
        self.first.saturating_add((i as u32).saturating_mul(self.step))
    }
}

/// `90`, `90s`, `1.5m`, `2h`, `500ms`.
pub(crate) fn time(text: &str) -> Result<Duration, String> {
    let form = || "give a time above 0 like 90, 90s, 1.5m or 2h".to_owned();
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0), ("", 1.0)];
    let (digits, unit) =
        units.iter().find_map(|(name, unit)| Some((text.strip_suffix(name)?, unit))).ok_or_else(form)?;
    let seconds = digits.trim_end().parse::<f64>().map_err(|_| form())? * unit;
    let time = Duration::try_from_secs_f64(seconds).map_err(|_| form())?;
    if time.is_zero() { Err(form()) } else { Ok(time) }
}

/// A time in an animation.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| "give a time in seconds like 1.5".into())
}

/// Frames per second.
pub(crate) fn frames_per_second(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| (1e-6..=1e6).contains(value));
    value.ok_or_else(|| "give frames per second above 0, like 24 or 29.97".into())
}

/// For how many frames a shutter is open.
pub(crate) fn shutter(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| (0.0..=1e6).contains(value));
    value.ok_or_else(|| "give how many frames the shutter is open, 0 or more, like 0.5".into())
}

/// `0..47`, `0..47:2` for every second frame, or one number.
pub(crate) fn frames(text: &str) -> Result<FrameRange, String> {
    const MOST: u32 = i32::MAX as u32;
    let number = |text: &str| text.trim().parse::<u32>().ok().filter(|&number| number <= MOST);
    let (ends, step) = text.split_once(':').unwrap_or((text, "1"));
    let (first, last) = ends.split_once("..").unwrap_or((ends, ends));
    let form = || {
        format!(
            "give the first and the last frame, and a step if it is not 1, like 0..47 or 0..47:2, whole numbers up to {MOST}"
        )
    };
    let (first, last) = number(first).zip(number(last)).ok_or_else(form)?;
    let step = number(step).filter(|&step| step > 0).ok_or_else(form)?;
    if last < first {
        return Err(format!("the last frame is before the first; did you mean {last}..{first}?"));
    }
    Ok(FrameRange { first, last, step })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times() {
        for (text, seconds) in [("90", 90.0), ("90s", 90.0), ("1.5m", 90.0), ("2h", 7200.0), ("500ms", 0.5)] {
            assert_eq!(time(text), Ok(Duration::from_secs_f64(seconds)), "'{text}'");
        }
        for bad in ["", "0", "-1", "s", "nan", "inf", "1e300", "5 minutes", "1d"] {
            assert!(time(bad).is_err(), "'{bad}' is no time");
        }
    }

    #[test]
    fn frames_have_both_ends() {
        let range = |first, last, step| Ok(FrameRange { first, last, step });
        assert_eq!(
            (frames("0..47"), frames("7"), frames("5..5"), frames("0..9:4")),
            (range(0, 47, 1), range(7, 7, 1), range(5, 5, 1), range(0, 9, 4)),
            "ends"
        );
        assert_eq!(frames("0..9:4").map(|range| range.numbers().collect()), Ok(vec![0, 4, 8]), "a step");
        assert!(frames("5..2").expect_err("turned round").contains("did you mean 2..5?"), "turned round");
        for bad in
            ["", "..", "1..", "..2", "-1..2", "1...2", "1..2147483648", "1.5..2", "a", "0..9:0", "0..9:"]
        {
            assert!(frames(bad).is_err(), "'{bad}' is no range");
        }
        assert_eq!((seconds("-0.5"), seconds("1e1")), (Ok(-0.5), Ok(10.0)), "moments");
        assert!(seconds("nan").is_err() && seconds("inf").is_err() && seconds("1s").is_err(), "no moments");
        assert!(frames_per_second("0").is_err() && frames_per_second("29.97").is_ok(), "rates");
    }
}
