// SPDX-License-Identifier: GPL-3.0-or-later
//! A window for OpenRT programs, in the manner of GLUT: the program gives functions, the main loop calls them.
//! Source: names after GLUT, on winit and softbuffer, which open the display's libraries when a window is requested. Tests: `tests`, tests/window.rs.
//!
//! A hop path: `rtutMainLoop` -> `run` -> `display` (a real window) or `plain` (none) -> the program's functions ->
//! `rtutSwapBuffers` -> `frames::swap`, whose picture the loop then shows.

mod display;
mod frames;
mod pixels;
mod plain;
mod program;
mod settings;
mod stage;

pub(crate) use frames::{Renderer, Use, finish, swap};
pub(crate) use pixels::Format;
pub(crate) use program::Program;
pub(crate) use settings::{FRAME, Settings};
pub(crate) use stage::{LARGEST, Stage};

/// Runs until the user or the program ends it.
pub(crate) fn run(program: &dyn Program, settings: &Settings) -> Result<(), String> {
    if settings.headless { plain::run(program, settings) } else { display::run(program, settings) }
}
