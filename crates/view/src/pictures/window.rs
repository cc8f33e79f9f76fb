// SPDX-License-Identifier: GPL-3.0-or-later
//! The window of finished pictures. On winit and softbuffer, as the window of scenes.
//! Tests: `crates/cli/tests/program/window.rs`.

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use gnurt::ThreadPool;
use gnurt::image::Picture;
use softbuffer::{Context, Surface};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Fullscreen, Window, WindowId};

use super::canvas;
use super::composed::{Comparison, compose};
use super::controls::{Controls, Effect};
use super::histogram::Histogram;
use super::hud::{self, PICTURE_KEYS};
use super::items::{Item, items};
use super::loader::{Loader, ReadPicture};
use crate::error::ViewError;
use crate::events::{ByPlace, input};
use crate::exposure::Exposure;
use crate::screen::{Part, develop};
use crate::stage::Listener;
use crate::watch::Watch;
use crate::{screenshot, text};

/// The initial state of a window.
pub struct PictureOptions {
    /// A film, or one picture.
    pub files: Vec<PathBuf>,
    /// A film or a picture to compare it with; a shorter one ends with its last frame. Empty = none.
    pub others: Vec<PathBuf>,
    /// The shown part.
    pub item: Item,
    /// How the two are shown.
    pub comparison: Comparison,
    /// From light to bytes.
    pub exposure: Exposure,
    /// Frames in a second.
    pub fps: f64,
    /// The window's title.
    pub title: String,
    /// Where pictures are written.
    pub folder: PathBuf,
    /// Leave after this many frames.
    pub frames: Option<u64>,
    /// Bytes of pictures in memory, about.
    pub memory: usize,
}

/// Columns and rows that a window has at least.
const LEAST: [u32; 2] = [320, 240];
/// The share of the screen that a window takes at most.
const MOST: f64 = 0.9;
/// Between two frames of the screen while a film runs.
const STEP: Duration = Duration::from_millis(5);
/// Between two checks of files.
const WATCHED: Duration = Duration::from_millis(250);
/// How long a message is shown.
const MESSAGES: Duration = Duration::from_secs(8);
/// Frames that are read ahead.
const AHEAD: usize = 256;

/// Shows pictures until the user closes the window; `first` is that of the first file.
///
/// # Errors
/// [`ViewError::NoDisplay`] if there is no display; [`ViewError::Thread`] if no thread can be started.
pub fn run_picture_window(
    options: PictureOptions,
    first: Picture,
    read: ReadPicture,
    pool: ThreadPool,
    listener: Arc<dyn Listener>,
) -> Result<(), ViewError> {
    let size = [first.width, first.height];
    let events = EventLoop::<()>::with_user_event().build().map_err(|error| ViewError::no_display(&error))?;
    let proxy = events.create_proxy();
    // A loop that has ended needs no news.
    let notify = Box::new(move || _ = proxy.send_event(()));
    let loader = Loader::begin(read, options.memory, notify).map_err(ViewError::Thread)?;
    if let Some(path) = options.files.first() {
        loader.put(path.clone(), first);
    }
    let mut controls =
        Controls::new(size, options.files.len(), options.item.clone(), options.exposure, options.fps);
    controls.comparison = options.comparison;
    let watch = Watch::new(options.files.iter().chain(&options.others).cloned().collect());
    let mut app = App {
        options,
        controls,
        loader,
        watch,
        pool,
        listener,
        size,
        open: None,
        failure: None,
        shown: None,
        composed: None,
        message: None,
        now: Instant::now(),
        watched: Instant::now(),
        colors: Vec::new(),
        screen: Vec::new(),
        drawn: 0,
        screenshot_requested: false,
    };
    events.run_app(&mut app).map_err(|error| ViewError::no_display(&error))?;
    app.failure.map_or(Ok(()), Err)
}

/// Pictures of a frame.
struct ShownFrame {
    frame: usize,
    names: Vec<String>,
    pictures: Vec<Arc<Picture>>,
}

/// A picture as it is composed, and of what.
struct Composed {
    of: (Vec<Arc<Picture>>, Item, Comparison, u32),
    picture: Picture,
    histogram: Histogram,
}

/// The pixels of a window.
type Pixels = Surface<Rc<Window>, Rc<Window>>;

struct App {
    options: PictureOptions,
    controls: Controls,
    loader: Loader,
    watch: Watch,
    pool: ThreadPool,
    listener: Arc<dyn Listener>,
    /// Of the first picture.
    size: [u32; 2],
    open: Option<(Rc<Window>, Pixels)>,
    failure: Option<ViewError>,
    shown: Option<ShownFrame>,
    composed: Option<Composed>,
    message: Option<(Instant, String)>,
    now: Instant,
    watched: Instant,
    /// The window's light and its pixels.
    colors: Vec<[f32; 4]>,
    screen: Vec<u32>,
    /// Frames that reached the screen.
    drawn: u64,
    screenshot_requested: bool,
}

impl App {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), ViewError> {
        if self.open.is_some() {
            return Ok(());
        }
        let failed = |error: &dyn std::fmt::Display| ViewError::no_display(error);
        let screen = events.primary_monitor().or_else(|| events.available_monitors().next());
        let screen: Option<[u32; 2]> = screen.map(|screen| screen.size().into());
        let most = screen.filter(|screen| screen.iter().all(|&side| side > 0)).unwrap_or([1280, 800]);
        let share = [0, 1].map(|k| MOST * f64::from(most[k]) / f64::from(self.size[k].max(1)));
        let share = share[0].min(share[1]).min(1.0);
        let side = |k: usize| ((f64::from(self.size[k]) * share) as u32).max(LEAST[k]);
        let attributes = Window::default_attributes()
            .with_title(&self.options.title)
            .with_inner_size(PhysicalSize::new(side(0), side(1)));
        let window = Rc::new(events.create_window(attributes).map_err(|error| failed(&error))?);
        let context = Context::new(window.clone()).map_err(|error| failed(&error))?;
        let surface = Surface::new(&context, window.clone()).map_err(|error| failed(&error))?;
        window.request_redraw();
        self.open = Some((window, surface));
        Ok(())
    }

    /// The files of a frame.
    fn files(&self, frame: usize) -> Vec<PathBuf> {
        let other = self.options.others.get(frame).or(self.options.others.last());
        self.options.files.get(frame).into_iter().chain(other).cloned().collect()
    }

    /// Takes the pictures of the frame as soon as they are there.
    fn take_frame(&mut self) {
        let Controls { frame, frames, .. } = self.controls;
        let ahead = (0..frames.min(AHEAD)).map(|i| (frame + i) % frames.max(1));
        self.loader.want(ahead.flat_map(|frame| self.files(frame)).collect());
        let files = self.files(frame);
        let read: Option<Vec<_>> = files.iter().map(|file| self.loader.get(file)).collect();
        let Some(read) = read else { return };
        match read.into_iter().collect::<Result<Vec<_>, String>>() {
            Ok(pictures) => {
                let name =
                    |file: &PathBuf| file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                self.shown = Some(ShownFrame { frame, names: files.iter().map(name).collect(), pictures });
            }
            Err(why) => self.report(why),
        }
    }

    fn report(&mut self, message: String) {
        let is_new = self.message.as_ref().is_none_or(|(_, known)| *known != message);
        if is_new {
            self.listener.warning(&message);
        }
        self.message = Some((Instant::now(), message));
    }

    /// Composes the shown picture, if it is another one than before.
    fn compose(&mut self) {
        let Some(shown) = &self.shown else { return };
        let [first, second] = [shown.pictures.first(), shown.pictures.get(1)];
        let Some(first) = first else { return };
        self.controls.show([first.width, first.height], items(first));
        let Controls { item, comparison, .. } = &self.controls;
        let split = if *comparison == Comparison::Split { self.controls.split_column() } else { 0 };
        let is_known = self.composed.as_ref().is_some_and(|Composed { of, .. }| {
            let are_same = of.0.len() == shown.pictures.len()
                && of.0.iter().zip(&shown.pictures).all(|(a, b)| Arc::ptr_eq(a, b));
            are_same && (&of.1, of.2, of.3) == (item, *comparison, split)
        });
        if is_known {
            return;
        }
        let of = (shown.pictures.clone(), item.clone(), *comparison, split);
        match compose(first, second.map(|picture| &**picture), item, *comparison, split) {
            Ok(picture) => {
                let histogram = Histogram::of(&picture.color);
                self.composed = Some(Composed { of, picture, histogram });
            }
            Err(why) => self.report(why),
        }
    }

    fn draw(&mut self) -> Result<(), softbuffer::SoftBufferError> {
        let before = self.shown.as_ref().map(|shown| shown.frame);
        self.take_frame();
        self.compose();
        let Some((window, surface)) = &mut self.open else { return Ok(()) };
        let size: [u32; 2] = window.inner_size().into();
        let [Some(columns), Some(rows)] = size.map(NonZeroU32::new) else { return Ok(()) };
        self.controls.size = size;
        surface.resize(columns, rows)?;
        let mut buffer = surface.buffer_mut()?;
        let names_two = self.shown.as_ref().is_some_and(|shown| shown.pictures.len() == 2);
        if let Some(Composed { picture, histogram, .. }) = &self.composed {
            let exposure = self.controls.shown_exposure();
            canvas::draw(picture, &self.controls, &self.pool, &mut self.colors);
            let parts = Part::all_of(&self.colors, size);
            develop(exposure, parts, size, size, &mut self.screen, Some(&self.pool));
            let scale = (size[1] as usize / 800 + 1).min(4);
            if let Some(column) = self.controls.split_line().filter(|_| names_two) {
                let rows = self.screen.chunks_exact_mut(size[0] as usize);
                // Visible over dark and bright parts.
                rows.for_each(|row| row[column] ^= 0x0080_8080);
            }
            if self.controls.histogram {
                histogram.draw(&mut self.screen, size, scale, exposure.stops);
            }
            let shown = self.shown.as_ref();
            let names = shown.map(|shown| &shown.names[..]).unwrap_or_default();
            let picture = |k: usize| shown.and_then(|shown| shown.pictures.get(k)).map(|picture| &**picture);
            let mut lines = hud::lines(&self.controls, names, [picture(0), picture(1)]);
            self.message.take_if(|(since, _)| since.elapsed() > MESSAGES);
            lines.extend(self.message.iter().map(|(_, message)| message.clone()));
            if self.controls.help {
                let keys = PICTURE_KEYS.lines().chain([""]).map(str::to_owned);
                lines = keys.chain(lines).collect();
            }
            if self.controls.hud || self.controls.help {
                text::draw(&mut self.screen, size, [8, 8], scale, &lines);
            }
        }
        if self.screen.len() == buffer.len() {
            buffer.copy_from_slice(&self.screen);
        } else {
            buffer.fill(0);
        }
        window.pre_present_notify();
        buffer.present()?;
        let now = self.shown.as_ref().map(|shown| shown.frame);
        self.drawn += u64::from(now.is_some() && (now != before || self.drawn == 0));
        if now == Some(self.controls.frame) && std::mem::take(&mut self.screenshot_requested) {
            self.take_screenshot();
        }
        Ok(())
    }

    /// Writes the light that was drawn last.
    fn take_screenshot(&mut self) {
        let colors = &self.colors;
        let written = screenshot::write(
            &self.options.folder,
            colors,
            self.controls.size,
            self.controls.shown_exposure(),
        );
        let message = match written {
            Ok(path) => format!("wrote {}", path.display()),
            Err(why) => why,
        };
        self.listener.note(&message);
        self.message = Some((Instant::now(), message));
    }

    fn handle(&mut self, events: &ActiveEventLoop, effect: Option<Effect>) {
        match effect {
            Some(Effect::Quit) => events.exit(),
            Some(Effect::Screenshot) => self.screenshot_requested = true,
            Some(Effect::Fullscreen(fills)) => {
                if let Some((window, _)) = &self.open {
                    window.set_fullscreen(fills.then_some(Fullscreen::Borderless(None)));
                }
            }
            None => {}
        }
        self.redraw();
    }

    fn redraw(&self) {
        if let Some((window, _)) = &self.open {
            window.request_redraw();
        }
    }

    /// Shows a file that was dropped on the window.
    fn show_file(&mut self, path: &Path) {
        self.options.files = vec![path.to_owned()];
        self.options.others.clear();
        (self.controls.frames, self.controls.frame) = (1, 0);
        self.watch = Watch::new(self.options.files.clone());
        self.redraw();
    }

    fn fail(&mut self, events: &ActiveEventLoop, failure: ViewError) {
        self.failure = Some(failure);
        events.exit();
    }
}

impl ApplicationHandler<()> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if let Err(failure) = self.open(events) {
            self.fail(events, failure);
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, (): ()) {
        let is_waiting = self.shown.as_ref().is_none_or(|shown| shown.frame != self.controls.frame);
        if is_waiting || self.options.files.len() == 1 {
            self.redraw();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match &event {
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.draw() {
                    self.fail(events, ViewError::no_display(&error));
                }
                if self.options.frames.is_some_and(|frames| self.drawn >= frames) {
                    events.exit();
                }
            }
            WindowEvent::DroppedFile(path) => self.show_file(path),
            _ => {
                if let Some(input) = input(&event, ByPlace::None) {
                    let effect = self.controls.handle(input);
                    self.handle(events, effect);
                }
            }
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let seconds = self.now.elapsed().as_secs_f64();
        self.now = Instant::now();
        // A film waits for its frames: none is left out because a file is read slowly.
        let is_shown = self.shown.as_ref().is_some_and(|shown| shown.frame == self.controls.frame);
        if self.controls.is_playing() {
            let before = self.controls.frame;
            if is_shown {
                self.controls.pass_time(seconds.min(1.0 / self.controls.fps.max(1.0)));
            }
            if self.controls.frame != before {
                self.redraw();
            }
        }
        if self.watched.elapsed() >= WATCHED {
            self.watched = Instant::now();
            let changed = self.watch.changed();
            if !changed.is_empty() {
                self.loader.forget(&changed);
                self.redraw();
            }
        }
        let wait = if self.controls.is_playing() { STEP } else { WATCHED };
        events.set_control_flow(ControlFlow::wait_duration(wait));
    }
}
