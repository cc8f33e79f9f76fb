// SPDX-License-Identifier: GPL-3.0-or-later
//! The meaning of keys and mouse while pictures are shown. Pure: no window, no files. Tests: `tests`.

use gnurt::image::ToneCurve;

use super::composed::Comparison;
use super::items::Item;
use crate::exposure::Exposure;
use crate::input::{Button, Input, Key};

/// Stops of a key.
const STOPS: f32 = 0.25;
const MOST_STOPS: f32 = 60.0;
/// The enlargement of a notch of the wheel.
const NOTCH: f64 = 1.2;
const ZOOMS: [f64; 2] = [1.0 / 64.0, 256.0];

/// An action beyond the picture's display.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    Quit,
    Screenshot,
    Fullscreen(bool),
}

/// The state of the display.
#[derive(Clone, Debug)]
pub(crate) struct Controls {
    /// Columns and rows of the window.
    pub(crate) size: [u32; 2],
    /// Columns and rows of the picture.
    pub(crate) picture: [u32; 2],
    /// Pixels of the window for one of the picture; `None` = as large as fits.
    zoom: Option<f64>,
    /// The point of the picture in the middle of the window.
    center: [f64; 2],
    /// Parts of the picture, and the shown one.
    items: Vec<Item>,
    pub(crate) item: Item,
    /// Number of frames, and the shown one.
    pub(crate) frames: usize,
    pub(crate) frame: usize,
    /// Frames in a second, and whether they run.
    pub(crate) fps: f64,
    pub(crate) is_playing: bool,
    /// The share of the next frame that has passed.
    phase: f64,
    pub(crate) exposure: Exposure,
    initial_exposure: Exposure,
    pub(crate) comparison: Comparison,
    /// Where the second picture begins in a split, as a share of the width.
    pub(crate) split: f64,
    /// The one colour that is shown, in grey.
    pub(crate) channel: Option<usize>,
    pub(crate) hud: bool,
    pub(crate) help: bool,
    pub(crate) histogram: bool,
    fullscreen: bool,
    /// The button that is held, and whether it moves the line of a split.
    drag: Option<(Button, bool)>,
    cursor: [f64; 2],
    shift: bool,
    control: bool,
}

impl Controls {
    pub(crate) fn new(size: [u32; 2], frames: usize, item: Item, exposure: Exposure, fps: f64) -> Self {
        Self {
            size,
            picture: size,
            zoom: None,
            center: [0.0; 2],
            items: Vec::new(),
            item,
            frames,
            frame: 0,
            fps,
            is_playing: false,
            phase: 0.0,
            exposure,
            initial_exposure: exposure,
            comparison: Comparison::default(),
            split: 0.5,
            channel: None,
            hud: true,
            help: false,
            histogram: false,
            fullscreen: false,
            drag: None,
            cursor: [-1.0; 2],
            shift: false,
            control: false,
        }
    }

    /// Takes the size and the parts of the shown picture.
    pub(crate) fn show(&mut self, picture: [u32; 2], items: Vec<Item>) {
        if self.picture != picture {
            self.picture = picture;
            self.center = picture.map(|side| f64::from(side) / 2.0);
        }
        self.items = items;
    }

    /// Pixels of the window for one of the picture.
    pub(crate) fn zoom(&self) -> f64 {
        self.zoom.unwrap_or_else(|| {
            let fits = [0, 1].map(|k| f64::from(self.size[k].max(1)) / f64::from(self.picture[k].max(1)));
            let fits = fits[0].min(fits[1]);
            // Small pictures are shown by whole pixels.
            if fits >= 1.0 { fits.floor() } else { fits }
        })
    }

    /// The point of the picture at a point of the window.
    pub(crate) fn picture_point(&self, at: [f64; 2]) -> [f64; 2] {
        let center = match self.zoom {
            Some(_) => self.center,
            None => self.picture.map(|side| f64::from(side) / 2.0),
        };
        [0, 1].map(|k| center[k] + (at[k] - f64::from(self.size[k]) / 2.0) / self.zoom())
    }

    /// The pixel of the picture under the cursor.
    pub(crate) fn pixel(&self) -> Option<[u32; 2]> {
        let point = self.picture_point(self.cursor);
        let is_inside = (0..2).all(|k| {
            let is_in_window = self.cursor[k] >= 0.0 && self.cursor[k] < f64::from(self.size[k]);
            is_in_window && point[k] >= 0.0 && point[k] < f64::from(self.picture[k])
        });
        is_inside.then(|| point.map(|x| x as u32))
    }

    /// The first column of the second picture in a split.
    pub(crate) fn split_column(&self) -> u32 {
        (self.split * f64::from(self.picture[0])).round() as u32
    }

    /// The column of the window where the second picture begins in a split.
    pub(crate) fn split_line(&self) -> Option<usize> {
        let [left, _] = self.picture_point([0.0; 2]);
        let column = (f64::from(self.split_column()) - left) * self.zoom();
        let is_inside = column >= 0.0 && column < f64::from(self.size[0]);
        (self.comparison == Comparison::Split && is_inside).then_some(column as usize)
    }

    /// Exposure and tone curve of the shown part: data and differences that people see have no curve.
    pub(crate) fn shown_exposure(&self) -> Exposure {
        match self.item == Item::Color && self.comparison != Comparison::Flip {
            true => self.exposure,
            false => Exposure { tone: ToneCurve::Clamp, ..self.exposure },
        }
    }

    /// Whether something moves as long as nothing happens.
    pub(crate) fn is_playing(&self) -> bool {
        self.is_playing && self.frames > 1
    }

    /// Lets time pass: a film runs on, and begins again at its end.
    pub(crate) fn pass_time(&mut self, seconds: f64) {
        if self.is_playing() {
            self.phase += seconds * self.fps;
            let steps = self.phase.floor();
            self.phase -= steps;
            self.frame = (self.frame + steps as usize) % self.frames;
        }
    }

    /// Processes an event.
    pub(crate) fn handle(&mut self, input: Input) -> Option<Effect> {
        match input {
            Input::Modifiers { shift, control } => (self.shift, self.control) = (shift, control),
            Input::Cursor(at) => self.move_cursor(at),
            Input::ButtonDown(button) => {
                let moves_line = button == Button::Right || self.shift;
                self.drag = Some((button, moves_line));
                if moves_line {
                    self.move_line();
                }
            }
            Input::ButtonUp(button) => _ = self.drag.take_if(|(held, _)| *held == button),
            Input::Wheel(notches) => self.zoom_by(NOTCH.powf(notches.clamp(-50.0, 50.0))),
            Input::Size(size) => self.size = size,
            Input::FocusLost => self.drag = None,
            Input::Close => return Some(Effect::Quit),
            Input::KeyUp(_) => {}
            Input::KeyDown { key, repeat } => return self.press(key, repeat),
        }
        None
    }

    fn move_cursor(&mut self, at: [f64; 2]) {
        let by = [0, 1].map(|k| at[k] - self.cursor[k]);
        self.cursor = at;
        match self.drag {
            Some((_, true)) => self.move_line(),
            Some((_, false)) => {
                self.hold_zoom();
                let zoom = self.zoom();
                self.center = [0, 1].map(|k| self.center[k] - by[k] / zoom);
            }
            None => {}
        }
    }

    fn move_line(&mut self) {
        let share = self.picture_point(self.cursor)[0] / f64::from(self.picture[0].max(1));
        self.split = share.clamp(0.0, 1.0);
    }

    /// From now on the window shows this part, whatever its size.
    fn hold_zoom(&mut self) {
        if self.zoom.is_none() {
            self.center = self.picture.map(|side| f64::from(side) / 2.0);
            self.zoom = Some(self.zoom());
        }
    }

    /// Enlarges around the cursor.
    fn zoom_by(&mut self, factor: f64) {
        self.hold_zoom();
        let under = self.picture_point(self.cursor);
        let zoom = (self.zoom() * factor).clamp(ZOOMS[0], ZOOMS[1]);
        self.zoom = Some(zoom);
        self.center = [0, 1].map(|k| under[k] - (self.cursor[k] - f64::from(self.size[k]) / 2.0) / zoom);
    }

    fn press(&mut self, key: Key, repeat: bool) -> Option<Effect> {
        if self.control {
            return match key {
                Key::Char('s' | 'S') if !repeat => Some(Effect::Screenshot),
                Key::Char('q' | 'Q' | 'c' | 'C') => Some(Effect::Quit),
                _ => None,
            };
        }
        match key {
            Key::Char('b') => self.expose(STOPS),
            Key::Char('B') => self.expose(-STOPS),
            Key::Char('+' | '=') => self.zoom_by(NOTCH),
            Key::Char('-' | '_') => self.zoom_by(1.0 / NOTCH),
            Key::Char('.' | '>') | Key::Right => self.step(1),
            Key::Char(',' | '<') | Key::Left => self.step(self.frames.max(1) - 1),
            Key::Down => self.choose(1),
            Key::Up => self.choose(-1),
            Key::Tab => self.choose(if self.shift { -1 } else { 1 }),
            _ if repeat => {}
            Key::Escape => return Some(Effect::Quit),
            Key::F(12) => return Some(Effect::Screenshot),
            Key::Char('f' | 'F') | Key::F(11) => {
                self.fullscreen = !self.fullscreen;
                return Some(Effect::Fullscreen(self.fullscreen));
            }
            Key::Char('h' | 'H' | '?') | Key::F(1) => self.help = !self.help,
            Key::Char('g' | 'G') => self.hud = !self.hud,
            Key::Char('i' | 'I') => self.histogram = !self.histogram,
            Key::Char('t' | 'T') => self.exposure.tone = self.exposure.next_tone(),
            Key::Char('c' | 'C') => {
                self.channel = match self.channel {
                    None => Some(0),
                    Some(3) => None,
                    Some(channel) => Some(channel + 1),
                };
            }
            Key::Char('z' | 'Z') => {
                self.hold_zoom();
                self.zoom_by(1.0 / self.zoom());
            }
            Key::Char('x' | 'X') => self.zoom = None,
            Key::Char(' ') => self.is_playing = !self.is_playing,
            Key::Char('r' | 'R') => {
                (self.exposure, self.zoom, self.channel, self.split) =
                    (self.initial_exposure, None, None, 0.5);
                (self.frame, self.is_playing, self.phase) = (0, false, 0.0);
            }
            Key::Char(digit @ '1'..='5') => {
                let index = digit.to_digit(10).unwrap_or(1) as usize - 1;
                self.comparison = Comparison::ALL[index];
            }
            _ => {}
        }
        None
    }

    fn expose(&mut self, stops: f32) {
        self.exposure.stops = (self.exposure.stops + stops).clamp(-MOST_STOPS, MOST_STOPS);
    }

    fn step(&mut self, frames: usize) {
        self.is_playing = false;
        self.frame = (self.frame + frames) % self.frames.max(1);
    }

    /// Another part of the picture, from the list, which is a circle.
    fn choose(&mut self, by: isize) {
        let at = self.items.iter().position(|item| *item == self.item).unwrap_or(0);
        if let Some(item) =
            self.items.get((at as isize + by).rem_euclid(self.items.len().max(1) as isize) as usize)
        {
            self.item = item.clone();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn controls() -> Controls {
        let mut c = Controls::new([200, 100], 10, Item::Color, Exposure::default(), 24.0);
        c.show([400, 100], vec![Item::Color, Item::Layer("N".into()), Item::Layer("albedo".into())]);
        c
    }

    fn feed(c: &mut Controls, keys: &str) -> Vec<Effect> {
        keys.chars()
            .filter_map(|key| c.handle(Input::KeyDown { key: Key::Char(key), repeat: false }))
            .collect()
    }

    #[test]
    fn pictures_fit_and_grow_under_the_cursor() {
        let mut c = controls();
        assert_eq!(c.zoom(), 0.5, "all of it");
        assert_eq!(c.picture_point([0.0, 25.0]), [0.0, 0.0], "its upper left corner");
        c.handle(Input::Cursor([50.0, 50.0]));
        assert_eq!(c.pixel(), Some([100, 50]));
        c.handle(Input::Wheel(3.0));
        let [x, y] = c.picture_point([50.0, 50.0]);
        assert!((x - 100.0).abs() < 1e-9 && (y - 50.0).abs() < 1e-9, "that point stays: {x} {y}");
        feed(&mut c, "z");
        assert!((c.zoom() - 1.0).abs() < 1e-12, "one to one");
        c.handle(Input::ButtonDown(Button::Left));
        c.handle(Input::Cursor([60.0, 45.0]));
        c.handle(Input::ButtonUp(Button::Left));
        assert_eq!(c.pixel(), Some([100, 50]), "the picture follows the hand");
        feed(&mut c, "x");
        c.handle(Input::Size([2000, 1000]));
        assert_eq!(c.zoom(), 5.0, "by whole pixels");
        c.handle(Input::Cursor([10.0, 10.0]));
        assert_eq!(c.pixel(), None, "beside it");
    }

    #[test]
    fn keys_choose() {
        let mut c = controls();
        c.handle(Input::KeyDown { key: Key::Tab, repeat: false });
        assert_eq!(c.item, Item::Layer("N".into()));
        c.handle(Input::KeyDown { key: Key::Up, repeat: false });
        c.handle(Input::KeyDown { key: Key::Up, repeat: false });
        assert_eq!(c.item, Item::Layer("albedo".into()), "a circle");
        feed(&mut c, "bbB4cci");
        assert_eq!((c.exposure.stops, c.comparison, c.channel), (STOPS, Comparison::Difference, Some(1)));
        assert!(c.histogram);
        feed(&mut c, "cccc");
        assert_eq!(c.channel, Some(0), "past the opacity and all");
        assert_eq!(feed(&mut c, "f"), [Effect::Fullscreen(true)]);
        c.handle(Input::ButtonDown(Button::Right));
        c.handle(Input::Cursor([150.0, 50.0]));
        assert_eq!((c.split_column(), c.split_line()), (300, None), "it follows the hand, and is not needed");
        feed(&mut c, "3");
        assert_eq!(c.split_line(), Some(150), "under the hand");
        feed(&mut c, "r");
        assert_eq!((c.exposure.stops, c.channel, c.split_column()), (0.0, None, 200));
    }

    #[test]
    fn films_run_in_a_circle() {
        let mut c = controls();
        feed(&mut c, ",");
        assert_eq!(c.frame, 9, "before the first one");
        feed(&mut c, " ");
        c.pass_time(0.5);
        assert_eq!(c.frame, 1, "twelve frames on");
        c.pass_time(1.0 / 48.0);
        assert_eq!(c.frame, 1, "half a frame");
        c.pass_time(1.0 / 48.0 + 1e-9);
        assert_eq!(c.frame, 2);
        feed(&mut c, ".");
        assert!(c.frame == 3 && !c.is_playing(), "a step stops it");
        let mut still = Controls::new([1, 1], 1, Item::Color, Exposure::default(), 24.0);
        feed(&mut still, " ,");
        still.pass_time(1.0);
        assert!(still.frame == 0 && !still.is_playing());
    }
}
