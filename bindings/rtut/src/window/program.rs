// SPDX-License-Identifier: GPL-3.0-or-later
//! The program's side of the main loop. Source: names after GLUT. Tests: tests/window.rs.

use super::stage::Stage;

/// Callbacks of the program; each does nothing unless the program has set a function for it. None is called
/// during another one, and none under a lock: they may call everything, and may be left by an exception.
pub(crate) trait Program {
    /// The window needs a frame.
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
    /// Called when there is nothing else to do; returns whether there is such a function.
    fn idle(&self) -> bool;
    /// Waits for the frame in flight, if there is one, and shows it.
    fn finish(&self);
    /// Runs `with` on the window's state, exclusively; it calls nothing of the program or of libOpenRT.
    fn stage(&self, with: &mut dyn FnMut(&mut Stage));
}
