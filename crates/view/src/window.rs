// SPDX-License-Identifier: GPL-3.0-or-later
//! The window: events in, pixels out. Everything else is decided elsewhere.
//! On winit and softbuffer, which open the display's libraries when a window is requested.
//! Tests: `crates/cli/tests/program/window.rs`.

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use gnurt::ThreadPool;
use gnurt::denoise;
use gnurt::render::RenderOptions;
use gnurt::scene::Camera;
use softbuffer::{Context, Surface};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Fullscreen, Window, WindowId};

use crate::camera_options::camera_options;
use crate::choices::Choices;
use crate::controls::{Controls, Effect};
use crate::error::ViewError;
use crate::events::{ByPlace, input};
use crate::exposure::Exposure;
use crate::hud;
use crate::input::Input;
use crate::memory;
use crate::pick::Pick;
use crate::playing::Playing;
use crate::recorder::Recorder;
use crate::render_thread::{RenderEvent, RenderRequest, RenderThread, RenderThreadParts};
use crate::screenshot;
use crate::shown::Shown;
use crate::stage::{Listener, Loader, Stage};
use crate::watch::Watch;

/// The initial state of a window.
pub struct WindowOptions {
    /// Size, samples, seed, integrator, filter, level: as `render` takes them.
    pub render: RenderOptions,
    /// Where it is seen from at first.
    pub camera: Camera,
    /// From light to bytes.
    pub exposure: Exposure,
    /// The window's title.
    pub title: String,
    /// Leave after this many pictures.
    pub frames: Option<u64>,
    /// Where pictures are written.
    pub folder: PathBuf,
    /// A message for the user once the window is open.
    pub note: Option<String>,
    /// How noise is taken out of pictures.
    pub denoiser: denoise::Options,
    /// Whether pictures at rest are denoised initially.
    pub is_denoised: bool,
}

/// The time for which a released camera counts as moving.
const REST: Duration = Duration::from_millis(120);
/// Between two steps of a flight.
const STEP: Duration = Duration::from_millis(10);
/// Between two checks of files.
const WATCHED: Duration = Duration::from_millis(250);
/// Between two checks of files of shaders: a saved one is read a tenth of a second later.
const SHADERS_WATCHED: Duration = Duration::from_millis(20);
/// How long a message is shown.
const MESSAGES: Duration = Duration::from_secs(12);

/// Shows a window until the user closes it.
///
/// # Errors
/// [`ViewError::NoDisplay`] if there is no display; others if there is nothing to show.
pub fn run_window(
    options: WindowOptions,
    stage: Stage,
    pool: ThreadPool,
    loader: Loader,
    listener: Arc<dyn Listener>,
) -> Result<(), ViewError> {
    options.render.region()?;
    let size = [options.render.width, options.render.height];
    let shown = Shown::Light(options.render.integrator);
    let mut controls =
        Controls::new(&options.camera, shown, options.exposure, size).ok_or(ViewError::NoView)?;
    controls.denoised = options.is_denoised;
    controls.playing = stage.range().map(Playing::new);
    controls.choices = Choices::of(&stage.scene, stage.clip);
    let events =
        EventLoop::<RenderEvent>::with_user_event().build().map_err(|error| ViewError::no_display(&error))?;
    let proxy = events.create_proxy();
    let (watch, shader_watch) = (Watch::new(stage.files.clone()), Watch::new(stage.scripts.files()));
    controls.shader_controls.replace(stage.scripts.shader_controls());
    let mut app = App {
        begin: Some((
            RenderThreadParts {
                stage,
                options: options.render.clone(),
                pool,
                loader,
                denoiser: options.denoiser.clone(),
                notify: notify(proxy),
            },
            size,
        )),
        options,
        controls,
        listener,
        watch,
        shader_watch,
        bad_shader: Vec::new(),
        reported: Vec::new(),
        open: None,
        failure: None,
        now: Instant::now(),
        moved: Instant::now(),
        watched: Instant::now(),
        shaders_watched: Instant::now(),
        messages: None,
        screenshot_requested: false,
        recorder: None,
        failed_recording: false,
        drawn: Vec::new(),
        shown_frames: 0,
    };
    events.run_app(&mut app).map_err(|error| ViewError::no_display(&error))?;
    app.failure.map_or(Ok(()), Err)
}

fn notify(proxy: EventLoopProxy<RenderEvent>) -> Box<dyn Fn(RenderEvent) + Send> {
    // A loop that has ended needs no news.
    Box::new(move |render_event| drop(proxy.send_event(render_event)))
}

struct App {
    /// The input of the render thread, until there is a window.
    begin: Option<(RenderThreadParts, [u32; 2])>,
    options: WindowOptions,
    controls: Controls,
    listener: Arc<dyn Listener>,
    watch: Watch,
    /// Files of shaders that are read again by themselves.
    shader_watch: Watch,
    /// The reason that a shader cannot be read again, until it is fixed.
    bad_shader: Vec<String>,
    /// Faults of shaders that were reported.
    reported: Vec<String>,
    open: Option<Open>,
    failure: Option<ViewError>,
    /// Up to when keys that are held have moved the camera.
    now: Instant,
    /// When the camera moved last.
    moved: Instant,
    watched: Instant,
    shaders_watched: Instant,
    messages: Option<(Instant, Vec<String>)>,
    screenshot_requested: bool,
    recorder: Option<Recorder>,
    /// Whether it can write no more.
    failed_recording: bool,
    /// When pictures reached the screen, within the last second.
    drawn: Vec<Instant>,
    /// Pictures that reached the screen.
    shown_frames: u64,
}

/// A window that is there.
struct Open {
    window: Rc<Window>,
    surface: Surface<Rc<Window>, Rc<Window>>,
    render_thread: RenderThread,
    /// The number of the picture that was drawn last.
    number: u64,
}

impl App {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), ViewError> {
        let Some((parts, [width, height])) = self.begin.take() else { return Ok(()) };
        let failed = |error: &dyn std::fmt::Display| ViewError::no_display(error);
        let attributes = Window::default_attributes()
            .with_title(&self.options.title)
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Rc::new(events.create_window(attributes).map_err(|error| failed(&error))?);
        let context = Context::new(window.clone()).map_err(|error| failed(&error))?;
        let surface = Surface::new(&context, window.clone()).map_err(|error| failed(&error))?;
        self.controls.handle(Input::Size(window.inner_size().into()));
        let render_thread = RenderThread::begin(parts, self.request())?;
        window.request_redraw();
        self.open = Some(Open { window, surface, render_thread, number: 0 });
        Ok(())
    }

    fn fail(&mut self, events: &ActiveEventLoop, failure: ViewError) {
        self.failure = Some(failure);
        events.exit();
    }

    fn request(&self) -> RenderRequest {
        RenderRequest {
            camera: self.controls.flight.camera(),
            shown: self.controls.shown,
            size: self.controls.size(),
            exposure: self.controls.exposure,
            moving: self.moved.elapsed() < REST,
            paused: self.controls.paused,
            denoised: self.controls.denoised,
            clip_time: self.controls.playing.as_ref().and_then(Playing::clip_time),
            clip: self.controls.choices.clip(),
        }
    }

    /// Lets held keys move the camera up to now.
    fn catch_up(&mut self) {
        let seconds = self.now.elapsed().as_secs_f64();
        self.now = Instant::now();
        if self.controls.is_flying() {
            self.controls.pass_time(seconds.min(0.25));
            self.moved = self.now;
        }
    }

    fn handle(&mut self, events: &ActiveEventLoop, input: Input) {
        self.catch_up();
        let before = (self.controls.flight.clone(), self.controls.playing.clone());
        let effect = self.controls.handle(input);
        if self.controls.flight != before.0 || self.controls.playing != before.1 {
            self.moved = self.now;
        }
        match effect {
            Some(Effect::Quit) => events.exit(),
            Some(Effect::Pick(pixel)) => self.pick(pixel),
            Some(Effect::Screenshot) => self.screenshot_requested = true,
            Some(Effect::Record(true)) => self.begin_recording(),
            Some(Effect::Record(false)) => self.end_recording(),
            Some(Effect::PrintCamera) => self.print_camera(),
            Some(Effect::Tune) => {
                if let (Some(open), Some(tuned)) = (&self.open, self.controls.shader_controls.chosen()) {
                    open.render_thread.tune(tuned);
                }
            }
            Some(Effect::Fullscreen(fills)) => {
                if let Some(open) = &self.open {
                    open.window.set_fullscreen(fills.then_some(Fullscreen::Borderless(None)));
                }
            }
            None => {}
        }
        let request = self.request();
        if let Some(open) = &self.open {
            open.render_thread.send_request(&request);
            open.window.request_redraw();
        }
        self.take_screenshot();
    }

    /// Watches the files of the shaders that there are now, and shows their parameters.
    fn check_shaders(&mut self) {
        let Some(open) = &self.open else { return };
        let stage = open.render_thread.stage();
        self.shader_watch = Watch::new(stage.scripts.files());
        self.controls.shader_controls.replace(stage.scripts.shader_controls());
    }

    fn report(&mut self, lines: Vec<String>) {
        self.messages = Some((Instant::now(), lines));
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }

    /// Reports a success or a failure.
    fn notify(&mut self, reported: Result<String, String>) {
        match &reported {
            Ok(what) => self.listener.note(what),
            Err(why) => self.listener.warning(why),
        }
        self.report(vec![reported.unwrap_or_else(|why| why)]);
    }

    fn begin_recording(&mut self) {
        match Recorder::begin(&self.options.folder) {
            Ok(recorder) => self.recorder = Some(recorder),
            Err(why) => {
                self.controls.recording = false;
                self.notify(Err(why));
            }
        }
    }

    fn end_recording(&mut self) {
        self.controls.recording = false;
        if let Some(recorder) = self.recorder.take() {
            self.notify(recorder.end());
        }
    }

    /// Reports faults of shaders, once.
    fn report_faults(&mut self) {
        let Some(open) = &self.open else { return };
        let stage = open.render_thread.stage();
        let mut faults = (stage.faults)();
        let all = stage.scripts.faults();
        drop(stage);
        faults.extend(all.iter().filter(|line| !self.reported.contains(line)).cloned());
        // A reloaded shader starts over.
        self.reported = all;
        if !faults.is_empty() {
            faults.iter().for_each(|fault| self.listener.warning(fault));
            self.report(faults);
        }
    }

    fn pick(&mut self, pixel: [u32; 2]) {
        let Some(open) = &self.open else { return };
        let stage = open.render_thread.stage();
        let pick = Pick::at(&stage, &self.controls.flight.camera(), pixel, self.controls.size());
        let [x, y] = pixel;
        match pick {
            Some(pick) => {
                self.listener.note(&format!("pixel {x},{y}: {pick}"));
                self.report(pick.lines().to_vec());
            }
            None => {
                self.listener.note(&format!("pixel {x},{y}: nothing"));
                self.report(vec!["nothing".into()]);
            }
        }
    }

    fn print_camera(&mut self) {
        let camera = self.controls.flight.camera();
        let Camera { eye, target, .. } = camera;
        let point = |[x, y, z]: [f32; 3]| format!("{x},{y},{z}");
        let stops = self.controls.exposure.stops;
        let options = format!("{} --exposure {stops}", camera_options(&camera));
        self.listener.camera(&options);
        self.report(vec![format!("--eye {}", point(eye)), format!("--target {}", point(target))]);
    }

    /// Writes the requested picture, as soon as there is one with all its pixels.
    fn take_screenshot(&mut self) {
        let Some(open) = self.open.as_ref().filter(|_| self.screenshot_requested) else { return };
        let written = {
            let front = open.render_thread.front();
            let size = front.readings.rendered;
            if !front.whole || !open.render_thread.is_current(&front) {
                return;
            }
            screenshot::write(&self.options.folder, &front.colors, size, front.exposure)
        };
        self.screenshot_requested = false;
        self.notify(written.map(|path| format!("wrote {}", path.display())));
    }

    fn draw(&mut self) -> Result<(), softbuffer::SoftBufferError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let size: [u32; 2] = open.window.inner_size().into();
        let [Some(columns), Some(rows)] = size.map(NonZeroU32::new) else { return Ok(()) };
        open.surface.resize(columns, rows)?;
        let mut buffer = open.surface.buffer_mut()?;
        let front = open.render_thread.front();
        if front.size == size && front.screen.len() == buffer.len() {
            buffer.copy_from_slice(&front.screen);
        } else {
            // A picture of another size: the part that fits, until the right one arrives.
            buffer.fill(0);
            let [width, height] = front.size.map(|side| side as usize);
            let rows = buffer.chunks_exact_mut(size[0] as usize).zip(front.screen.chunks_exact(width.max(1)));
            rows.take(height).for_each(|(to, from)| {
                let shared = to.len().min(from.len());
                to[..shared].copy_from_slice(&from[..shared]);
            });
        }
        let (readings, number) = (front.readings, front.number);
        let is_new = number != open.number;
        if let Some(recorder) = self.recorder.as_mut().filter(|_| is_new) {
            // Without the numbers over it.
            self.failed_recording |= !recorder.add(front.size, &front.screen);
        }
        drop(front);
        open.number = number;
        if is_new {
            let now = Instant::now();
            self.drawn.retain(|&at| now - at < Duration::from_secs(1));
            self.drawn.push(now);
            self.shown_frames += 1;
        }
        if self.controls.hud || self.controls.help {
            self.messages.take_if(|(since, _)| since.elapsed() > MESSAGES);
            let messages = self.messages.as_ref().map(|(_, lines)| &lines[..]).unwrap_or_default();
            let drawn = self.drawn.len() as f64;
            let mut lines = hud::lines(&self.controls, &readings, drawn, memory::resident(), messages);
            lines.extend(self.bad_shader.iter().cloned());
            lines.extend(self.recorder.as_ref().map(Recorder::status));
            hud::draw(&mut buffer, size, &self.controls, &lines);
        }
        open.window.pre_present_notify();
        buffer.present()
    }
}

impl ApplicationHandler<RenderEvent> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if let Err(failure) = self.open(events) {
            self.fail(events, failure);
        } else if let Some(note) = self.options.note.take() {
            self.listener.note(&note);
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, render_event: RenderEvent) {
        match render_event {
            RenderEvent::Picture => self.take_screenshot(),
            RenderEvent::Reloaded { files, is_other } => {
                self.watch = Watch::new(files);
                self.check_shaders();
                self.bad_shader.clear();
                let stage = self.open.as_ref().map(|open| open.render_thread.stage());
                let range = stage.as_ref().and_then(|stage| stage.range());
                if let Some(stage) = stage {
                    self.controls.choices = Choices::of(&stage.scene, stage.clip);
                }
                let is_same = self.controls.playing.as_ref().map(Playing::range) == range;
                if !is_same {
                    self.controls.playing = range.map(Playing::new);
                }
                if is_other {
                    self.controls.look_from_first();
                }
                let news = if is_other { "another scene was read" } else { "the scene was read again" };
                self.listener.note(news);
                self.report(vec![news.into()]);
            }
            RenderEvent::Shaders(lines) => {
                self.check_shaders();
                self.bad_shader.clear();
                lines.iter().for_each(|line| self.listener.note(line));
                self.report(lines);
            }
            RenderEvent::BadShader(why) => {
                self.listener.warning(&why);
                let lines = why.lines().map(str::to_owned);
                self.bad_shader =
                    std::iter::once("the shader before stays:".to_owned()).chain(lines).collect();
            }
            RenderEvent::Trouble(why) => {
                self.listener.warning(&why);
                self.report(vec!["not read again, the old scene stays:".into(), why]);
            }
            RenderEvent::Denoised(how) => self.notify(Ok(how)),
        }
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if let WindowEvent::RedrawRequested = event {
            if let Err(error) = self.draw() {
                self.fail(events, ViewError::no_display(&error));
            }
            if std::mem::take(&mut self.failed_recording) {
                self.end_recording();
            }
            if self.options.frames.is_some_and(|frames| self.shown_frames >= frames) {
                events.exit();
            }
            return;
        }
        if let WindowEvent::DroppedFile(path) = &event {
            if let Some(open) = &self.open {
                open.render_thread.reload(Some(path.clone()));
            }
            return self.report(vec![format!("reading {}", path.display())]);
        }
        let by_place = ByPlace::Flight { is_control_held: self.controls.is_control_held() };
        if let Some(input) = input(&event, by_place) {
            self.handle(events, input);
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        self.end_recording();
        self.report_faults();
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        self.catch_up();
        if self.watched.elapsed() >= WATCHED {
            self.watched = Instant::now();
            self.report_faults();
            if let Some(open) = self.open.as_ref().filter(|_| self.watch.has_changed()) {
                open.render_thread.reload(None);
            }
        }
        if self.shaders_watched.elapsed() >= SHADERS_WATCHED {
            self.shaders_watched = Instant::now();
            let changed = self.shader_watch.changed();
            if let Some(open) = self.open.as_ref().filter(|_| !changed.is_empty()) {
                open.render_thread.read_again(changed);
            }
        }
        let request = self.request();
        if let Some(open) = &self.open {
            open.render_thread.send_request(&request);
        }
        let busy = request.moving || self.controls.is_held();
        let idle = if self.shader_watch.is_empty() { WATCHED } else { SHADERS_WATCHED };
        events.set_control_flow(ControlFlow::wait_duration(if busy { STEP } else { idle }));
    }
}
