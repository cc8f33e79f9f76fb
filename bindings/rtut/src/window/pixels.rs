// SPDX-License-Identifier: GPL-3.0-or-later
//! Frame buffers as pixels of a screen, `0x00RRGGBB`, the uppermost row first.
//! Source: openrt/types.h (formats; row 0 is the lowest); [IEC61966] (sRGB) for formats of floats, which are linear.
//! Tests: `tests`.

use std::io::Write;

/// The formats of rtSetFrameBuffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Format {
    /// Values per pixel.
    channels: usize,
    /// Blue comes first.
    is_bgr: bool,
    /// Floats in linear light; else sRGB-encoded bytes.
    is_float: bool,
}

impl Format {
    /// `RT_RGB_8`: the format of the library's own buffers.
    pub(crate) const RGB_8: Self = Self { channels: 3, is_bgr: false, is_float: false };

    /// `None` if it is no format.
    pub(crate) fn from_code(code: u32) -> Option<Self> {
        let (kind, is_float) = match code {
            0x300..=0x303 => (code - 0x300, true),
            0x310..=0x313 => (code - 0x310, false),
            _ => return None,
        };
        // Floats begin with BGR, bytes with RGB; see openrt/types.h.
        let (channels, is_bgr) = match (kind, is_float) {
            (0, true) => (3, true),
            (1, true) | (0, false) => (3, false),
            (2, true) | (1, false) => (4, false),
            (2, false) => (3, true),
            _ => (4, true),
        };
        Some(Self { channels, is_bgr, is_float })
    }

    /// Bytes of a pixel.
    pub(crate) fn pixel_bytes(self) -> usize {
        self.channels * if self.is_float { 4 } else { 1 }
    }
}

/// Converts a frame buffer into rows of a screen; `bytes` holds all its pixels.
pub(crate) fn to_screen(bytes: &[u8], width: usize, format: Format, out: &mut Vec<u32>) {
    let value = |pixel: &[u8], k: usize| -> u32 {
        if !format.is_float {
            return u32::from(pixel[k]);
        }
        let at = 4 * k;
        encode(f32::from_ne_bytes([pixel[at], pixel[at + 1], pixel[at + 2], pixel[at + 3]]))
    };
    let [red, green, blue] = if format.is_bgr { [2, 1, 0] } else { [0, 1, 2] };
    out.clear();
    for row in bytes.chunks_exact((width * format.pixel_bytes()).max(1)).rev() {
        let pixels = row.chunks_exact(format.pixel_bytes());
        out.extend(pixels.map(|p| value(p, red) << 16 | value(p, green) << 8 | value(p, blue)));
    }
}

/// The byte of linear light; NaN is 0.
fn encode(linear: f32) -> u32 {
    let x = linear.clamp(0.0, 1.0);
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u32
}

/// A picture file of the simplest kind (PPM).
pub(crate) fn write_ppm(
    to: &mut dyn Write,
    [width, height]: [u32; 2],
    screen: &[u32],
) -> std::io::Result<()> {
    write!(to, "P6\n{width} {height}\n255\n")?;
    let bytes: Vec<u8> =
        screen.iter().flat_map(|&pixel| [(pixel >> 16) as u8, (pixel >> 8) as u8, pixel as u8]).collect();
    to.write_all(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One column, red above blue, in every format.
    #[test]
    fn all_formats_show_the_same() {
        let (red, blue) = ([1.0_f32, 0.0, 0.0, 1.0], [0.0_f32, 0.0, 1.0, 1.0]);
        for code in (0x300..=0x303).chain(0x310..=0x313) {
            let format = Format::from_code(code).expect("a format");
            let order: &[usize] = match code {
                0x300 | 0x312 => &[2, 1, 0],
                0x301 | 0x310 => &[0, 1, 2],
                0x302 | 0x311 => &[0, 1, 2, 3],
                _ => &[2, 1, 0, 3],
            };
            let mut bytes = Vec::new();
            for (color, &k) in [blue, red].iter().flat_map(|color| order.iter().map(move |k| (color, k))) {
                if code < 0x310 {
                    bytes.extend(color[k].to_ne_bytes());
                } else {
                    bytes.push((255.0 * color[k]) as u8);
                }
            }
            assert_eq!(bytes.len(), 2 * format.pixel_bytes(), "{code:#x}");
            let mut screen = vec![7];
            to_screen(&bytes, 1, format, &mut screen);
            assert_eq!(screen, [0xff_0000, 0x0000_00ff], "{code:#x}");
        }
        assert_eq!([0x2ff, 0x304, 0x314, 0].map(Format::from_code), [None; 4], "no formats");
        assert_eq!([0.5, 2.0, -1.0, f32::NAN].map(encode), [188, 255, 0, 0], "sRGB");
    }

    #[test]
    fn files_hold_the_rows_of_the_screen() {
        let mut file = Vec::new();
        write_ppm(&mut file, [1, 2], &[0x01_0203, 0x0a_0b0c]).expect("memory");
        assert_eq!(file, b"P6\n1 2\n255\n\x01\x02\x03\x0a\x0b\x0c", "top row first");
    }
}
