// SPDX-License-Identifier: GPL-3.0-or-later
//! The program's memory for pictures and its formats.
//! 8-bit formats encode sRGB (IEC 61966-2-1), float formats are linear and unclamped.
//! Invariant: rows are tight, the lowest one first; alpha is never encoded. Tests: `tests`; tests/c/scene.c.

use std::sync::Arc;

use gnurt::image::srgb;

use super::enums::FrameFormat;

/// Frames that start from now on are written to it.
pub(crate) const RT_NEXT_FRAME_BIT: u32 = 1;
/// The frame in flight is written to it.
pub(crate) const RT_IN_FLIGHT_BIT: u32 = 2;

/// Memory that belongs to the program. Offsets are those of the frame buffer that it was given for.
pub(crate) trait FrameMemory: Send + Sync {
    /// Copies bytes to it.
    fn write(&self, offset: usize, bytes: &[u8]);
    /// Where it begins; 0 if that is nobody's business.
    fn address(&self) -> usize {
        0
    }
}

/// Where a frame goes.
#[derive(Clone)]
pub(crate) struct FrameBuffer {
    /// The program's memory.
    pub(crate) memory: Arc<dyn FrameMemory>,
    /// Columns.
    pub(crate) width: u32,
    /// Rows.
    pub(crate) height: u32,
    /// The layout of pixels in it.
    pub(crate) format: FrameFormat,
}

/// The order of a pixel's numbers, as positions in red, green, blue, alpha.
fn channels(format: FrameFormat) -> &'static [usize] {
    use FrameFormat::{Bgr8, Bgr32, Bgra8, Bgra32, Rgb8, Rgb32, Rgba8, Rgba32};
    match format {
        Rgb32 | Rgb8 => &[0, 1, 2],
        Bgr32 | Bgr8 => &[2, 1, 0],
        Rgba32 | Rgba8 => &[0, 1, 2, 3],
        Bgra32 | Bgra8 => &[2, 1, 0, 3],
    }
}

/// Whether a number of a pixel is a float.
fn is_float(format: FrameFormat) -> bool {
    use FrameFormat::{Bgr32, Bgra32, Rgb32, Rgba32};
    matches!(format, Bgr32 | Rgb32 | Rgba32 | Bgra32)
}

/// Bytes of a pixel.
fn pixel_size(format: FrameFormat) -> usize {
    channels(format).len() * if is_float(format) { 4 } else { 1 }
}

/// Appends a pixel.
fn encode(format: FrameFormat, rgba: [f32; 4], bytes: &mut Vec<u8>) {
    const ALPHA: usize = 3;
    for &channel in channels(format) {
        let value = rgba[channel];
        if is_float(format) {
            bytes.extend_from_slice(&value.to_ne_bytes());
        } else if channel == ALPHA {
            bytes.push((value.clamp(0.0, 1.0) * 255.0).round() as u8);
        } else {
            bytes.push(srgb::encode_u8(value));
        }
    }
}

impl FrameBuffer {
    /// Where the program's memory begins.
    pub(crate) fn address(&self) -> usize {
        self.memory.address()
    }

    /// Writes a picture of the same size, whose first row is the top one.
    pub(crate) fn show(&self, colors: &[[f32; 4]]) {
        let row_size = self.width as usize * pixel_size(self.format);
        let mut bytes = Vec::with_capacity(row_size);
        let rows = colors.chunks_exact(self.width as usize);
        for (row, colors) in rows.rev().take(self.height as usize).enumerate() {
            bytes.clear();
            colors.iter().for_each(|&rgba| encode(self.format, rgba, &mut bytes));
            self.memory.write(row * row_size, &bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_in_every_format() {
        let encoded = |format| {
            let mut bytes = Vec::new();
            encode(format, [0.0, 2.0, 1.0, 0.5], &mut bytes);
            assert_eq!(bytes.len(), pixel_size(format), "size of {format:?}");
            bytes
        };
        let floats = |format| {
            let bytes = encoded(format);
            let chunks = bytes.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]]));
            chunks.collect::<Vec<_>>()
        };
        assert_eq!(floats(FrameFormat::Bgr32), [1.0, 2.0, 0.0], "blue first, not clamped");
        assert_eq!(floats(FrameFormat::Rgba32), [0.0, 2.0, 1.0, 0.5], "alpha last");
        assert_eq!(encoded(FrameFormat::Bgra8), [255, 255, 0, 128], "clamped; alpha is linear");
        let mut grey = Vec::new();
        encode(FrameFormat::Rgb8, [0.215_860_5; 4], &mut grey);
        assert_eq!(grey, [128; 3], "middle grey is encoded");
    }
}
