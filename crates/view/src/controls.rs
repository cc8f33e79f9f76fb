// SPDX-License-Identifier: GPL-3.0-or-later
//! The meaning of keys and mouse: state and event make the next state, and possibly an effect outside of it.
//! Keys after pbrt, Embree, Cycles, OSPRay and tev where those agree. `docs/reference/viewer.md` lists them.
//! Q and S fly, as in games: exit is Escape or Ctrl-Q, a picture is F12 or Ctrl-S.
//! Tests: `tests`, and `crates/cli/tests/program/window.rs` with a real window.

use std::f64::consts::PI;

use gnurt::scene::Camera;

use crate::choices::Choices;
use crate::exposure::Exposure;
use crate::flight::Flight;
use crate::input::{Button, Input, Key};
use crate::playing::Playing;
use crate::shader_controls::ShaderControls;
use crate::shown::Shown;

/// Requests of the controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Leave.
    Quit,
    /// Report the object at this pixel.
    Pick([u32; 2]),
    /// Write the picture to a file.
    Screenshot,
    /// Write all pictures from now on, or no longer.
    Record(bool),
    /// Print the camera as options of the command line.
    PrintCamera,
    /// Fill the screen, or no longer.
    Fullscreen(bool),
    /// Give the parameter of the chosen knob its value.
    Tune,
}

/// All that people can change.
#[derive(Clone, Debug)]
pub struct Controls {
    /// Where it is seen from.
    pub flight: Flight,
    /// The displayed quantity.
    pub shown: Shown,
    /// From light to bytes.
    pub exposure: Exposure,
    /// Whether numbers are shown.
    pub hud: bool,
    /// Whether the keys are explained.
    pub help: bool,
    /// Whether no samples are added.
    pub paused: bool,
    /// Whether the noise is taken out of pictures that rest.
    pub denoised: bool,
    /// Whether pictures are written as they come.
    pub recording: bool,
    /// The animation, if there is one.
    pub playing: Option<Playing>,
    /// Parameters of shaders.
    pub shader_controls: ShaderControls,
    /// Cameras of the scene, and clips with their names, that keys choose from.
    pub choices: Choices,
    initial: Flight,
    initial_exposure: Exposure,
    fullscreen: bool,
    /// Units of the world per second.
    speed: f64,
    /// Keys that are down and move something; at most one of each.
    held: Vec<Key>,
    shift: bool,
    control: bool,
    drag: Option<Drag>,
    cursor: [f64; 2],
    size: [u32; 2],
}

/// A button that is held.
#[derive(Clone, Copy, Debug)]
struct Drag {
    button: Button,
    pans: bool,
    /// How far the cursor went so far, in pixels.
    direction: f64,
}

/// A button that goes up before the cursor went this many pixels was clicked.
const CLICK: f64 = 4.0;
/// Seconds in which the flight covers the target's distance, at first.
const SECONDS_TO_TARGET: f64 = 2.0;
/// Radians per second of an arrow key.
const TURNING: f64 = 1.0;
/// The factor of the distance for a notch of the wheel.
const NOTCH: f64 = 0.9;
const FASTER: f64 = 1.5;
const STOPS: f32 = 0.25;
/// Steps of a knob with shift.
const MANY: f32 = 10.0;
const MOST_STOPS: f32 = 64.0;

/// Keys that do something for as long as they are held.
const MOVING: [Key; 10] = [
    Key::Char('w'),
    Key::Char('a'),
    Key::Char('s'),
    Key::Char('d'),
    Key::Char('q'),
    Key::Char('e'),
    Key::Left,
    Key::Right,
    Key::Up,
    Key::Down,
];

impl Controls {
    /// In the beginning; `None` if the camera has no view.
    #[must_use]
    pub fn new(camera: &Camera, shown: Shown, exposure: Exposure, size: [u32; 2]) -> Option<Self> {
        let flight = Flight::new(camera)?;
        Some(Self {
            speed: flight.distance() / SECONDS_TO_TARGET,
            initial: flight.clone(),
            flight,
            shown,
            exposure,
            initial_exposure: exposure,
            hud: true,
            help: false,
            paused: false,
            denoised: false,
            recording: false,
            playing: None,
            shader_controls: ShaderControls::default(),
            choices: Choices::default(),
            fullscreen: false,
            held: Vec::new(),
            shift: false,
            control: false,
            drag: None,
            cursor: [0.0; 2],
            size,
        })
    }

    /// Columns and rows of the window.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether something moves as long as nothing happens.
    #[must_use]
    pub fn is_flying(&self) -> bool {
        !self.held.is_empty() || self.is_playing()
    }

    /// Whether a clip runs.
    #[must_use]
    pub fn is_playing(&self) -> bool {
        self.playing.as_ref().is_some_and(Playing::is_running)
    }

    /// Whether a drag or a key holds the camera: it will probably move on.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.drag.is_some() || self.is_flying()
    }

    /// Whether a control key is held.
    #[must_use]
    pub fn is_control_held(&self) -> bool {
        self.control
    }

    /// Processes an event.
    pub fn handle(&mut self, input: Input) -> Option<Effect> {
        match input {
            Input::Modifiers { shift, control } => (self.shift, self.control) = (shift, control),
            Input::Cursor(at) => self.move_cursor(at),
            Input::ButtonDown(button) => {
                let pans = button == Button::Right || (button == Button::Left && self.shift);
                self.drag = Some(Drag { button, pans, direction: 0.0 });
            }
            Input::ButtonUp(button) => {
                let drag = self.drag.take_if(|drag| drag.button == button)?;
                let clicked = drag.direction < CLICK && button != Button::Right;
                return if clicked { self.pixel().map(Effect::Pick) } else { None };
            }
            Input::Wheel(notches) => self.flight.dolly(NOTCH.powf(notches.clamp(-50.0, 50.0))),
            Input::Size(size) => self.size = size,
            Input::FocusLost => {
                self.held.clear();
                self.drag = None;
            }
            Input::Close => return Some(Effect::Quit),
            Input::KeyUp(key) => self.held.retain(|&held| held != lower(key)),
            Input::KeyDown { key, repeat } => return self.press(key, repeat),
        }
        None
    }

    /// Lets time pass: keys that are held move the camera, a clip runs on.
    pub fn pass_time(&mut self, seconds: f64) {
        if let Some(playing) = &mut self.playing {
            playing.pass_time(seconds);
        }
        let held = |key: Key| f64::from(u8::from(self.held.contains(&key)));
        let between = |plus: Key, minus: Key| (held(plus) - held(minus)) * seconds;
        let [right, up, forward] = [('d', 'a'), ('e', 'q'), ('w', 's')]
            .map(|(plus, minus)| between(Key::Char(plus), Key::Char(minus)) * self.speed);
        let rotate = [between(Key::Left, Key::Right), between(Key::Up, Key::Down)].map(|x| x * TURNING);
        if [right, up, forward] != [0.0; 3] {
            self.flight.fly([right, up, forward]);
        }
        if rotate != [0.0; 2] {
            self.flight.rotate(rotate[0], rotate[1]);
        }
    }

    fn move_cursor(&mut self, at: [f64; 2]) {
        let [dx, dy] = [at[0] - self.cursor[0], at[1] - self.cursor[1]];
        self.cursor = at;
        let height = f64::from(self.size[1].max(1));
        if let Some(drag) = &mut self.drag {
            let before = drag.direction;
            drag.direction += dx.hypot(dy);
            // A hand that shakes while it clicks moves nothing.
            if drag.direction < CLICK || drag.button == Button::Middle {
                return;
            }
            let [dx, dy] = if before < CLICK {
                [dx, dy].map(|d| d * drag.direction / dx.hypot(dy).max(1e-9))
            } else {
                [dx, dy]
            };
            if drag.pans {
                self.flight.pan([dx, dy], height);
            } else {
                // The whole height is half a rotation; the scene follows the hand.
                self.flight.orbit(-dx / height * PI, dy / height * PI);
            }
        }
    }

    fn press(&mut self, key: Key, repeat: bool) -> Option<Effect> {
        if self.control {
            return match lower(key) {
                Key::Char('s') if !repeat => Some(Effect::Screenshot),
                Key::Char('r') if !repeat => {
                    self.recording = !self.recording;
                    Some(Effect::Record(self.recording))
                }
                Key::Char('q' | 'c') => Some(Effect::Quit),
                _ => None,
            };
        }
        if MOVING.contains(&lower(key)) {
            if !self.held.contains(&lower(key)) {
                self.held.push(lower(key));
            }
            return None;
        }
        match key {
            Key::Char('+' | '=') => self.speed = (self.speed * FASTER).min(1e12),
            Key::Char('-' | '_') => self.speed = (self.speed / FASTER).max(1e-12),
            Key::Char('.' | '>') => self.step(1.0),
            Key::Char(',' | '<') => self.step(-1.0),
            Key::Char('j' | 'J') => self.shader_controls.choose(-1),
            Key::Char('k' | 'K') => self.shader_controls.choose(1),
            Key::Char('u') => return self.adjust_control(-1.0),
            Key::Char('i') => return self.adjust_control(1.0),
            Key::Char('U') => return self.adjust_control(-MANY),
            Key::Char('I') => return self.adjust_control(MANY),
            Key::Char(']') => self.choose_camera(1),
            Key::Char('[') => self.choose_camera(-1),
            Key::Char('}') => self.choose_clip(1),
            Key::Char('{') => self.choose_clip(-1),
            Key::Char('b') => self.expose(STOPS),
            Key::Char('B') => self.expose(-STOPS),
            _ if repeat => {}
            Key::Escape => return Some(Effect::Quit),
            Key::F(12) => return Some(Effect::Screenshot),
            Key::Char('c' | 'C') => return Some(Effect::PrintCamera),
            Key::Char('f' | 'F') | Key::F(11) => {
                self.fullscreen = !self.fullscreen;
                return Some(Effect::Fullscreen(self.fullscreen));
            }
            Key::Char('h' | 'H' | '?') | Key::F(1) => self.help = !self.help,
            Key::Char('m' | 'M') => self.shader_controls.shown = !self.shader_controls.shown,
            Key::Char('o' | 'O') => return self.shader_controls.reset().then_some(Effect::Tune),
            Key::Char('g' | 'G') => self.hud = !self.hud,
            Key::Char('p' | 'P') => self.paused = !self.paused,
            Key::Char(' ') => {
                if let Some(playing) = &mut self.playing {
                    playing.toggle();
                }
            }
            Key::Char('n' | 'N') => self.denoised = !self.denoised,
            Key::Char('t' | 'T') => self.exposure.tone = self.exposure.next_tone(),
            Key::Char('r' | 'R') => {
                self.flight = self.initial.clone();
                self.exposure = self.initial_exposure;
                if let Some(playing) = &mut self.playing {
                    playing.rewind();
                }
            }
            Key::Tab => self.shown = self.shown.neighbour(if self.shift { -1 } else { 1 }),
            Key::Char(digit @ '0'..='9') => {
                // The keyboard's order: 0 comes behind 9.
                let index = (digit.to_digit(10).unwrap_or(0) as usize + 9) % 10;
                self.shown = Shown::all().get(index).copied().unwrap_or(self.shown);
            }
            _ => {}
        }
        None
    }

    fn adjust_control(&mut self, steps: f32) -> Option<Effect> {
        self.shader_controls.adjust_control(steps).then_some(Effect::Tune)
    }

    /// Looks through the first camera of another scene; R comes back to it.
    pub(crate) fn look_from_first(&mut self) {
        self.choose_camera(1);
        self.initial = self.flight.clone();
        self.speed = self.flight.distance() / SECONDS_TO_TARGET;
    }

    /// Looks through another camera of the scene.
    fn choose_camera(&mut self, by: isize) {
        let found = self.choices.next_camera(by);
        if let Some(flight) = found.and_then(Flight::new) {
            self.flight = flight;
        }
    }

    /// Shows another clip, at rest.
    fn choose_clip(&mut self, by: isize) {
        if let Some(range) = self.choices.next_clip(by) {
            self.playing = Some(Playing::new(range));
        }
    }

    fn step(&mut self, frames: f64) {
        if let Some(playing) = &mut self.playing {
            playing.step(frames);
        }
    }

    fn expose(&mut self, stops: f32) {
        self.exposure.stops = (self.exposure.stops + stops).clamp(-MOST_STOPS, MOST_STOPS);
    }

    /// The pixel under the cursor.
    fn pixel(&self) -> Option<[u32; 2]> {
        let inside = (0..2).all(|k| self.cursor[k] >= 0.0 && self.cursor[k] < f64::from(self.size[k]));
        inside.then(|| self.cursor.map(|at| at as u32))
    }
}

/// Shift changes characters, but not the meaning of a held key.
fn lower(key: Key) -> Key {
    match key {
        Key::Char(c) => Key::Char(c.to_ascii_lowercase()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn controls() -> Controls {
        let camera = Camera {
            name: String::new(),
            eye: [0.0, 0.0, 4.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov_y: 45.0,
            ..Camera::default()
        };
        Controls::new(&camera, Shown::all()[0], Exposure::default(), [400, 200]).expect("a view")
    }

    fn down(key: Key) -> Input {
        Input::KeyDown { key, repeat: false }
    }

    /// All effects of some events.
    fn feed(controls: &mut Controls, inputs: &[Input]) -> Vec<Effect> {
        inputs.iter().filter_map(|&input| controls.handle(input)).collect()
    }

    #[test]
    fn drags_move_the_camera_and_clicks_pick() {
        use Input::{ButtonDown, ButtonUp, Cursor};
        let mut c = controls();
        let before = c.flight.clone();
        let click =
            [Cursor([10.0, 20.0]), ButtonDown(Button::Left), Cursor([11.0, 20.0]), ButtonUp(Button::Left)];
        assert_eq!(feed(&mut c, &click), [Effect::Pick([11, 20])], "a click, though the hand shakes");
        assert_eq!(c.flight, before, "moves nothing");
        let drag =
            [ButtonDown(Button::Left), Cursor([61.0, 20.0]), Cursor([111.0, 20.0]), ButtonUp(Button::Left)];
        assert_eq!(feed(&mut c, &drag), [], "a drag is no click");
        let camera = c.flight.camera();
        assert!(
            (camera.eye[0] + 4.0).abs() < 1e-5,
            "half the height is a quarter turn to the left: {camera:?}"
        );
        assert_eq!(camera.target, [0.0; 3], "around the target");
        for (button, shift) in [(Button::Right, false), (Button::Left, true)] {
            let mut c = controls();
            let pan = [
                Input::Modifiers { shift, control: false },
                Cursor([0.0, 0.0]),
                ButtonDown(button),
                Cursor([50.0, 0.0]),
                ButtonUp(button),
            ];
            assert_eq!(feed(&mut c, &pan), [], "a drag is no click");
            assert!(c.flight.camera().target[0] < -0.5, "{button:?}: the target went along");
        }
        assert_eq!(feed(&mut c, &[ButtonDown(Button::Middle), ButtonUp(Button::Middle)]).len(), 1, "a pick");
        let outside = [Cursor([-1.0, 20.0]), ButtonDown(Button::Left), ButtonUp(Button::Left)];
        assert_eq!(feed(&mut c, &outside), [], "there is nothing outside");
    }

    #[test]
    fn held_keys_fly_until_they_are_let_go() {
        let mut c = controls();
        feed(&mut c, &[down(Key::Char('w')), Input::KeyDown { key: Key::Char('w'), repeat: true }]);
        assert!(c.is_flying(), "it is held");
        c.pass_time(0.5);
        assert!((c.flight.camera().eye[2] - 3.0).abs() < 1e-6, "half a second forward: {:?}", c.flight);
        // Shift came in between: the system reports another character now.
        feed(&mut c, &[Input::KeyUp(Key::Char('W'))]);
        assert!(!c.is_flying(), "let go");
        feed(&mut c, &[down(Key::Char('+')), down(Key::Char('d')), down(Key::Char('q'))]);
        c.pass_time(1.0);
        let eye = c.flight.camera().eye;
        assert!(
            (eye[0] - 3.0).abs() < 1e-5 && (eye[1] + 3.0).abs() < 1e-5,
            "right and down, faster: {eye:?}"
        );
        feed(&mut c, &[Input::FocusLost]);
        assert!(!c.is_flying(), "nobody holds the keys any more");
        feed(&mut c, &[down(Key::Left)]);
        c.pass_time(0.1);
        assert_eq!(c.flight.camera().eye, eye, "arrows turn the head only");
        feed(&mut c, &[down(Key::Char('r'))]);
        assert_eq!(c.flight.camera(), controls().flight.camera(), "home again");
    }

    #[test]
    fn keys_switch() {
        let mut c = controls();
        feed(&mut c, &[down(Key::Char('b')), down(Key::Char('b')), down(Key::Char('B'))]);
        assert_eq!(c.exposure.stops, STOPS, "brighter, brighter, darker");
        feed(&mut c, &[down(Key::Char('2'))]);
        assert_eq!(c.shown, Shown::all()[1], "the second one");
        feed(&mut c, &[down(Key::Tab)]);
        assert_eq!(c.shown, Shown::all()[2], "the one behind it");
        feed(&mut c, &['g', 'h', 'p', 'n'].map(|key| down(Key::Char(key))));
        assert!(!c.hud && c.help && c.paused && c.denoised, "all four");
        let tone = c.exposure.tone;
        feed(&mut c, &[down(Key::Char('t'))]);
        assert_ne!(c.exposure.tone, tone, "another curve");
        let distance = c.flight.distance();
        feed(&mut c, &[Input::Wheel(1.0)]);
        assert!(c.flight.distance() < distance, "nearer");
    }

    #[test]
    fn space_plays_and_keys_step() {
        let mut c = controls();
        feed(&mut c, &[down(Key::Char(' ')), down(Key::Char('.'))]);
        assert!(!c.is_playing(), "nothing moves here");
        c.playing = Some(Playing::new([0.0, 2.0]));
        feed(&mut c, &[down(Key::Char(' ')), Input::KeyDown { key: Key::Char(' '), repeat: true }]);
        assert!(c.is_playing() && c.is_flying() && c.is_held(), "it runs");
        c.pass_time(0.5);
        assert_eq!(c.playing.as_ref().and_then(Playing::clip_time), Some(0.5), "half a second");
        feed(&mut c, &[down(Key::Char('.')), down(Key::Char('.')), down(Key::Char(','))]);
        assert_eq!(
            c.playing.as_ref().and_then(Playing::clip_time),
            Some(13.0 / 24.0),
            "one frame on, stopped"
        );
        assert!(!c.is_playing(), "it was stepped");
        feed(&mut c, &[down(Key::Char('r'))]);
        assert_eq!(c.playing.as_ref().and_then(Playing::clip_time), None, "back to rest");
    }

    #[test]
    fn cameras_and_clips_are_chosen() {
        let mut c = controls();
        feed(&mut c, &[down(Key::Char(']')), down(Key::Char('}'))]);
        assert!(c.flight == controls().flight && c.playing.is_none(), "there are none");
        let at = |x: f32| Camera { eye: [x, 0.0, 9.0], ..controls().flight.camera() };
        c.choices = Choices::new(
            vec![at(1.0), at(2.0)],
            vec![("walk".into(), [0.0, 1.0]), ("run".into(), [0.0, 3.0])],
            Some(0),
        );
        feed(&mut c, &[down(Key::Char(']'))]);
        assert_eq!(c.flight.camera().eye, [1.0, 0.0, 9.0], "the first one");
        feed(&mut c, &[down(Key::Char('[')), down(Key::Char('}'))]);
        assert_eq!(c.flight.camera().eye, [2.0, 0.0, 9.0], "a circle");
        assert_eq!(c.playing.as_ref().map(Playing::range), Some([0.0, 3.0]), "the other clip");
        assert_eq!(c.choices.clip(), Some(1));
    }

    #[test]
    fn keys_ask() {
        let mut c = controls();
        let requested = [
            down(Key::F(12)),
            down(Key::Char('c')),
            down(Key::Char('f')),
            down(Key::Char('f')),
            down(Key::Escape),
        ];
        let effects = feed(&mut c, &requested);
        let expected = [
            Effect::Screenshot,
            Effect::PrintCamera,
            Effect::Fullscreen(true),
            Effect::Fullscreen(false),
            Effect::Quit,
        ];
        assert_eq!(effects, expected, "one each");
        feed(&mut c, &[Input::Modifiers { shift: false, control: true }]);
        let effects =
            feed(&mut c, &[down(Key::Char('s')), down(Key::Char('q')), down(Key::Char('w')), Input::Close]);
        assert_eq!(effects, [Effect::Screenshot, Effect::Quit, Effect::Quit], "with control");
        assert!(!c.is_flying(), "control and a letter do not fly");
        let effects = feed(&mut c, &[down(Key::Char('r')), down(Key::Char('r'))]);
        assert_eq!(effects, [Effect::Record(true), Effect::Record(false)], "on and off");
    }
}
