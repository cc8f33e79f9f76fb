// SPDX-License-Identifier: GPL-3.0-or-later
//! Playing a clip: its current time, and the bar that shows it. Keys after mpv and Blender. Seconds are the
//! file's. Invariant: the time lies within the clip.
//! Tests: `tests`.

/// Frames per second that keys step by: film's.
const FPS: f64 = 24.0;
/// Rows of the bar, and its distance from the window's edges, in pixels of a letter.
const BAR: [usize; 2] = [6, 8];
const INK: u32 = 0x00f4_f4f4;

/// A clip that can be played.
#[derive(Clone, Debug, PartialEq)]
pub struct Playing {
    /// The times of its first and of its last key.
    range: [f64; 2],
    /// The displayed time; `None` = the scene at rest.
    clip_time: Option<f64>,
    runs: bool,
}

impl Playing {
    /// A clip with these first and last keys, not begun.
    #[must_use]
    pub fn new(range: [f64; 2]) -> Self {
        Self { range, clip_time: None, runs: false }
    }

    /// The times of its first and of its last key.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// The displayed time; `None` = the scene at rest.
    #[must_use]
    pub fn clip_time(&self) -> Option<f64> {
        self.clip_time
    }

    /// Whether it is playing.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.runs
    }

    /// Starts or stops.
    pub fn toggle(&mut self) {
        self.runs = !self.runs;
        self.clip_time.get_or_insert(self.range[0]);
    }

    /// Moves by this many frames, and stops there.
    pub fn step(&mut self, frames: f64) {
        self.runs = false;
        let now = self.clip_time.unwrap_or(self.range[0]);
        // From between two frames to the next one on that side.
        let at = now * FPS;
        let near = at.round();
        let frame = match (at - near).abs() < 1e-6 {
            true => near + frames,
            false if frames > 0.0 => at.floor() + frames,
            false => at.ceil() + frames,
        };
        self.clip_time = Some((frame / FPS).clamp(self.range[0], self.range[1]));
    }

    /// Advances the time; after the end it continues at the beginning.
    pub fn pass_time(&mut self, seconds: f64) {
        let ([first, last], Some(now)) = (self.range, self.clip_time) else { return };
        if !self.runs {
            return;
        }
        let length = last - first;
        let next = first + (now - first + seconds).rem_euclid(length);
        // A clip of one key has no length.
        self.clip_time = Some(if next.is_finite() { next } else { first });
    }

    /// Back to rest.
    pub fn rewind(&mut self) {
        *self = Self::new(self.range);
    }

    /// The line of numbers; `update` = milliseconds that poses and trees took.
    pub(crate) fn line(&self, update: f64) -> String {
        let [_, last] = self.range;
        match self.clip_time {
            None => format!("at rest  space plays {last:.2} s"),
            Some(now) => {
                let state = if self.runs { "" } else { "  stopped" };
                format!("{now:.2} of {last:.2} s{state}  update {update:.1} ms")
            }
        }
    }

    /// Draws a bar along the lower edge, filled up to the time.
    pub(crate) fn draw_bar(&self, screen: &mut [u32], [width, height]: [u32; 2], scale: usize) {
        let ([first, last], Some(now)) = (self.range, self.clip_time) else { return };
        let [width, height] = [width as usize, height as usize];
        let [rows, margin] = BAR.map(|side| side * scale);
        if width <= 2 * margin || height <= rows + 2 * margin || screen.len() < width * height {
            return;
        }
        let share = if last > first { ((now - first) / (last - first)).clamp(0.0, 1.0) } else { 1.0 };
        let (left, right) = (margin, width - margin);
        let filled = left + (share * (right - left) as f64).round() as usize;
        for row in screen.chunks_exact_mut(width).take(height - margin).skip(height - margin - rows) {
            row[left..filled].fill(INK);
            // A quarter of each channel.
            row[filled..right].iter_mut().for_each(|pixel| *pixel = *pixel >> 2 & 0x003f_3f3f);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_runs_in_a_circle_and_steps() {
        let mut p = Playing::new([1.0, 3.0]);
        p.pass_time(0.5);
        assert_eq!(p.clip_time(), None, "at rest until somebody starts it");
        p.toggle();
        p.pass_time(0.75);
        assert_eq!((p.clip_time(), p.is_running()), (Some(1.75), true), "from the first key");
        p.pass_time(1.5);
        assert_eq!(p.clip_time(), Some(1.25), "round");
        p.toggle();
        p.pass_time(9.0);
        assert_eq!(p.clip_time(), Some(1.25), "stopped");
        p.step(1.0);
        assert_eq!(p.clip_time(), Some(31.0 / 24.0), "the next frame");
        p.step(-1.0);
        p.step(-1.0);
        assert_eq!(p.clip_time(), Some(29.0 / 24.0), "two back");
        (0..99).for_each(|_| p.step(-1.0));
        assert_eq!(p.clip_time(), Some(1.0), "not before the first key");
        p.rewind();
        assert_eq!(p.clip_time(), None, "at rest");
        let mut still = Playing::new([0.0, 0.0]);
        still.toggle();
        still.pass_time(0.1);
        assert_eq!(still.clip_time(), Some(0.0), "a clip of one key");
    }

    #[test]
    fn the_bar_is_filled_up_to_the_moment() {
        let filled = |clip_time: f64| {
            let mut p = Playing::new([0.0, 2.0]);
            p.toggle();
            p.pass_time(clip_time);
            let mut screen = vec![0x0080_8080; 116 * 40];
            p.draw_bar(&mut screen, [116, 40], 1);
            let row = &screen[116 * 29..116 * 30];
            (row.iter().filter(|&&x| x == INK).count(), row.iter().filter(|&&x| x == 0x0020_2020).count())
        };
        assert_eq!((filled(0.0), filled(0.5), filled(1.5)), ((0, 100), (25, 75), (75, 25)), "of 100 pixels");
    }
}
