// SPDX-License-Identifier: GPL-3.0-or-later
//! Options of the case `fuzzy`.

use gnurt::simd::Level;

/// The scenes to measure, and the method.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Frames; each is an update.
    pub frames: usize,
    /// Runs over the rays.
    pub rounds: usize,
    /// Columns and rows of primary rays.
    pub size: u32,
    /// Instruction set of rays, but those of fuzzy trees, which use none.
    pub level: Level,
    /// Rows and columns of quads of the tube.
    pub quads: [u32; 2],
}

/// Rows and columns of a tube of 14,400 triangles.
pub const QUADS: [u32; 2] = [120, 60];
