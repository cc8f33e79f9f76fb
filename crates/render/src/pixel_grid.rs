// SPDX-License-Identifier: GPL-3.0-or-later
//! Positions of pixels in the planes of a picture that holds all rows of the frame, or some of them.
//! Tests: crates/render/tests/bands.rs.

use crate::options::RenderOptions;

/// The columns of a picture, and its rows within the frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelGrid {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// The frame's row that is the picture's first.
    top: u32,
}

impl PixelGrid {
    /// That of the picture under these options.
    pub(crate) fn of(options: &RenderOptions) -> Self {
        let [top, end] = options.rows.unwrap_or([0, options.height]);
        Self { width: options.width, height: end.min(options.height).saturating_sub(top), top }
    }

    /// How many pixels there are.
    pub(crate) fn count(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The index of the pixel at this column and row of the frame; the row is one of the picture's.
    pub(crate) fn at(self, [x, y]: [u32; 2]) -> usize {
        (y - self.top) as usize * self.width as usize + x as usize
    }
}
