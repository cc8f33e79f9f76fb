// SPDX-License-Identifier: GPL-3.0-or-later
//! A window for OpenRT programs, in the manner of GLUT: the program gives functions, the main loop calls them.
//! Source: original; names after GLUT, on winit and softbuffer, which open the display's libraries when a window is asked
//! for. Proof: `tests`, tests/window.rs.
//!
//! A hop path: `rtutMainLoop` -> `run` -> `display` (a real window) or `plain` (none) -> the program's functions ->
//! `rtutSwapBuffers` -> `Stage::swap`, whose picture the loop then shows.

mod display;
mod pixels;
mod plain;
mod settings;
mod stage;

pub(crate) use pixels::Format;
pub(crate) use settings::{FRAME, Settings};
pub(crate) use stage::{LARGEST, Renderer, Stage};

/// What the program wants to be told; each does nothing unless it has given a function for it. None is called while
/// another one runs, and none while a lock is held: they may call everything.
pub(crate) trait Program {
    /// A frame is wanted.
    fn display(&self);
    /// The window has this size now.
    fn reshape(&self, size: [u32; 2]);
    /// A key with a character was pressed; the pointer is at this pixel, counted from the upper left one.
    fn keyboard(&self, key: u8, at: [i32; 2]);
    /// A key without one.
    fn special(&self, key: i32, at: [i32; 2]);
    /// A button went down or up.
    fn mouse(&self, button: i32, is_up: bool, at: [i32; 2]);
    /// The pointer has moved; with a button down or without.
    fn motion(&self, at: [i32; 2], dragged: bool);
    /// There is nothing else to do; says whether there is such a function.
    fn idle(&self) -> bool;
    /// Runs `with` on what the window shows; never while one of the other functions runs.
    fn stage(&self, with: &mut dyn FnMut(&mut Stage));
}

/// Runs until somebody wants to leave.
pub(crate) fn run(program: &dyn Program, settings: &Settings) -> Result<(), String> {
    if settings.headless { plain::run(program, settings) } else { display::run(program, settings) }
}
