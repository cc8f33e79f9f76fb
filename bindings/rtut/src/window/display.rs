// SPDX-License-Identifier: GPL-3.0-or-later
//! The main loop with a window. On winit and softbuffer. Tests: tests/window.rs.
//! winit's events are collected first, and the program is notified afterwards: a panic of winit ends in here,
//! while an exception of the program passes on to its own handler.

use std::collections::VecDeque;
use std::num::NonZeroU32;
use std::rc::Rc;
use std::time::Duration;

use softbuffer::{Context, Surface};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop, EventLoopProxy};
use winit::keyboard::{Key, NamedKey};
use winit::platform::pump_events::{EventLoopExtPumpEvents, PumpStatus};
use winit::window::{Window, WindowId};

use super::plain::keep;
use super::program::Program;
use super::settings::Settings;
use super::stage::{LARGEST, Waker};
use crate::guard::guard;

/// Shows the window until the user closes it or the program leaves.
pub(super) fn run(program: &dyn Program, settings: &Settings) -> Result<(), String> {
    let events = guard(EventLoop::new).ok_or_else(broken)?;
    let mut events = events.map_err(|error| characters(&error))?;
    let proxy = events.create_proxy();
    let _awake = Awake::while_open(program, proxy);
    let mut app = App { program, open: None, failure: None, happened: VecDeque::new(), drawn: 0 };
    let mut hands = Hands::default();
    let mut displayed = 0;
    // At first the window is opened, without waiting for anything.
    let mut patience = Some(Duration::ZERO);
    loop {
        let status = guard(|| events.pump_app_events(patience, &mut app)).ok_or_else(broken)?;
        if let Some(failure) = app.failure.take() {
            return Err(failure);
        }
        while let Some(event) = app.happened.pop_front() {
            match event {
                Event::Closed => return Ok(()),
                Event::Resized(size) => resize(program, size),
                Event::Hand(event) => hands.tell(program, event),
            }
            if settle(program, settings, &mut displayed)? {
                return Ok(());
            }
        }
        if let PumpStatus::Exit(_) = status {
            return Ok(());
        }
        if app.open.is_none() {
            continue;
        }
        let mut is_stale = false;
        program.stage(&mut |stage| is_stale = std::mem::take(&mut stage.is_stale));
        if is_stale {
            program.display();
        }
        let animates = program.idle();
        program.stage(&mut |stage| is_stale = stage.is_stale);
        // No swap follows soon: the last frame is shown, too.
        if !is_stale && !animates {
            program.finish();
        }
        if settle(program, settings, &mut displayed)? {
            return Ok(());
        }
        let mut pictures = 0;
        program.stage(&mut |stage| (is_stale, pictures) = (stage.is_stale, stage.pictures));
        let is_drawn = pictures == app.drawn;
        if !is_drawn && let Some(open) = &app.open {
            open.window.request_redraw();
        }
        // A requested picture comes with the next events.
        patience = (is_stale || animates).then_some(Duration::ZERO);
    }
}

/// While it lives, requests of the program on other threads wake the window.
struct Awake<'a>(&'a dyn Program);

impl<'a> Awake<'a> {
    fn while_open(program: &'a dyn Program, proxy: EventLoopProxy<()>) -> Self {
        let mut waker: Option<Waker> = Some(Box::new(move || {
            // A window that is gone needs not be woken.
            let _ = proxy.send_event(());
        }));
        program.stage(&mut |stage| stage.waker = waker.take());
        Self(program)
    }
}

impl Drop for Awake<'_> {
    fn drop(&mut self) {
        self.0.stage(&mut |stage| stage.waker = None);
    }
}

fn broken() -> String {
    "the window broke down: this is a bug in librtut".to_owned()
}

/// The work after each of the program's functions: saves pictures; returns whether the loop ends.
fn settle(program: &dyn Program, settings: &Settings, displayed: &mut u64) -> Result<bool, String> {
    keep(program, settings, displayed)?;
    let mut is_over = settings.is_enough(*displayed);
    program.stage(&mut |stage| is_over |= stage.is_leaving);
    Ok(is_over)
}

fn resize(program: &dyn Program, size: [u32; 2]) {
    if size.contains(&0) {
        return;
    }
    program.stage(&mut |stage| {
        stage.size = size.map(|side| side.min(LARGEST));
        stage.is_stale = true;
    });
    program.reshape(size);
}

/// Events for the program.
enum Event {
    Closed,
    Resized([u32; 2]),
    Hand(WindowEvent),
}

/// Pointer and buttons.
#[derive(Default)]
struct Hands {
    /// Pixel that the pointer is at.
    pointer: [i32; 2],
    /// Buttons that are down.
    buttons: u32,
}

impl Hands {
    fn tell(&mut self, program: &dyn Program, event: WindowEvent) {
        match event {
            WindowEvent::CursorMoved { position, .. } => {
                self.pointer = [position.x as i32, position.y as i32];
                program.motion(self.pointer, self.buttons > 0);
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let is_up = state == ElementState::Released;
                self.buttons = if is_up { self.buttons.saturating_sub(1) } else { self.buttons + 1 };
                if let Some(button) = number(button) {
                    program.mouse(button, is_up, self.pointer);
                }
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let up = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => lines > 0.0,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y > 0.0,
                };
                for is_up in [false, true] {
                    program.mouse(if up { 3 } else { 4 }, is_up, self.pointer);
                }
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } if event.state.is_pressed() => {
                if let Some(key) = character(&event) {
                    program.keyboard(key, self.pointer);
                } else if let Key::Named(named) = event.logical_key
                    && let Some(key) = special(named)
                {
                    program.special(key, self.pointer);
                }
            }
            _ => {}
        }
    }
}

struct App<'a> {
    program: &'a dyn Program,
    open: Option<Open>,
    failure: Option<String>,
    happened: VecDeque<Event>,
    /// Pictures that were drawn.
    drawn: u64,
}

struct Open {
    window: Rc<Window>,
    surface: Surface<Rc<Window>, Rc<Window>>,
}

/// Buttons as GLUT numbers them; a notch of the wheel is a press of 3 or 4.
fn number(button: MouseButton) -> Option<i32> {
    match button {
        MouseButton::Left => Some(0),
        MouseButton::Middle => Some(1),
        MouseButton::Right => Some(2),
        _ => None,
    }
}

/// Keys without a character, as GLUT numbers them.
fn special(key: NamedKey) -> Option<i32> {
    const FUNCTION: [NamedKey; 12] = [
        NamedKey::F1,
        NamedKey::F2,
        NamedKey::F3,
        NamedKey::F4,
        NamedKey::F5,
        NamedKey::F6,
        NamedKey::F7,
        NamedKey::F8,
        NamedKey::F9,
        NamedKey::F10,
        NamedKey::F11,
        NamedKey::F12,
    ];
    const OTHERS: [NamedKey; 9] = [
        NamedKey::ArrowLeft,
        NamedKey::ArrowUp,
        NamedKey::ArrowRight,
        NamedKey::ArrowDown,
        NamedKey::PageUp,
        NamedKey::PageDown,
        NamedKey::Home,
        NamedKey::End,
        NamedKey::Insert,
    ];
    let pixel_position = |keys: &[NamedKey], first: i32| {
        keys.iter().position(|&other| other == key).map(|pixel_position| first + pixel_position as i32)
    };
    pixel_position(&FUNCTION, 1).or_else(|| pixel_position(&OTHERS, 100))
}

/// The character of a key, if it is one byte.
fn character(event: &KeyEvent) -> Option<u8> {
    match &event.logical_key {
        Key::Named(NamedKey::Escape) => Some(27),
        Key::Named(NamedKey::Enter) => Some(13),
        Key::Named(NamedKey::Backspace) => Some(8),
        Key::Named(NamedKey::Delete) => Some(127),
        Key::Named(NamedKey::Tab) => Some(9),
        Key::Named(NamedKey::Space) => Some(b' '),
        Key::Character(text) => text.chars().next().and_then(|c| u8::try_from(c).ok()),
        _ => None,
    }
}

/// A display's message, without the source position in a library.
fn characters(error: &dyn std::fmt::Display) -> String {
    let message = error.to_string();
    let characters = message.strip_prefix("os error at ").and_then(|rest| rest.split_once(": "));
    characters.map_or(&message[..], |(_, characters)| characters).trim_end_matches('.').to_owned()
}

impl App<'_> {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), String> {
        let (mut title, mut size) = (String::new(), [0; 2]);
        self.program.stage(&mut |stage| (title, size) = (stage.title.clone(), stage.size));
        let attributes = Window::default_attributes()
            .with_title(title)
            .with_inner_size(PhysicalSize::new(size[0], size[1]));
        let window = Rc::new(events.create_window(attributes).map_err(|error| characters(&error))?);
        let context = Context::new(window.clone()).map_err(|error| error.to_string())?;
        let surface = Surface::new(&context, window.clone()).map_err(|error| error.to_string())?;
        self.happened.push_back(Event::Resized(window.inner_size().into()));
        self.open = Some(Open { window, surface });
        Ok(())
    }

    /// Draws the picture on the screen, or the part that fits.
    fn draw(&mut self) -> Result<(), String> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let size: [u32; 2] = open.window.inner_size().into();
        let [Some(columns), Some(rows)] = size.map(NonZeroU32::new) else { return Ok(()) };
        open.surface.resize(columns, rows).map_err(|error| error.to_string())?;
        let mut buffer = open.surface.buffer_mut().map_err(|error| error.to_string())?;
        buffer.fill(0);
        let drawn = &mut self.drawn;
        self.program.stage(&mut |stage| {
            *drawn = stage.pictures;
            let [width, height] = stage.screen_size.map(|side| side as usize);
            let from = stage.screen.chunks_exact(width.max(1)).take(height);
            for (to, from) in buffer.chunks_exact_mut(size[0] as usize).zip(from) {
                let shared = to.len().min(from.len());
                to[..shared].copy_from_slice(&from[..shared]);
            }
        });
        open.window.pre_present_notify();
        buffer.present().map_err(|error| error.to_string())
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_none()
            && let Err(failure) = self.open(events)
        {
            self.failure = Some(failure);
        }
    }

    fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => self.happened.push_back(Event::Closed),
            WindowEvent::Resized(size) => self.happened.push_back(Event::Resized(size.into())),
            WindowEvent::RedrawRequested => {
                if let Err(failure) = self.draw() {
                    self.failure = Some(failure);
                }
            }
            WindowEvent::CursorMoved { .. }
            | WindowEvent::MouseInput { .. }
            | WindowEvent::MouseWheel { .. }
            | WindowEvent::KeyboardInput { .. } => self.happened.push_back(Event::Hand(event)),
            _ => {}
        }
    }
}
