// SPDX-License-Identifier: GPL-3.0-or-later
//! The chunks of a PNG, checked before it is decoded.
//! Source: PNG specification, third edition. Tests: `tests/broken.rs`.

use std::io::SeekFrom;

use super::icc::Space;
use super::limits::{check_bytes, check_size};
use super::source::Source;
use crate::Error;
use crate::chromaticities::{Chromaticities, DISPLAY_P3, REC709, REC2020};

/// Most bytes that a byte of compressed data can become: deflate's 258 for two bits.
const MAX_INFLATION: u64 = 1032;

/// Checks that all chunks are there and that the data can hold the declared size; returns the bytes of its
/// pixels, and the space of its colours where numbers give another than sRGB.
pub(super) fn check(source: &mut dyn Source, length: u64) -> Result<(u64, Option<Space>), Error> {
    let truncated = || Error::corrupt("PNG", "the file ends within a chunk; it is truncated");
    let mut offset = 8;
    let mut pixel_bytes = None;
    let mut space = Space::default();
    let mut is_srgb = false;
    let mut named = None;
    loop {
        let mut head = [0; 8];
        source.seek(SeekFrom::Start(offset)).map_err(Error::reading)?;
        source.read_exact(&mut head).map_err(|_| truncated())?;
        let [l0, l1, l2, l3, name @ ..] = head;
        let chunk_length = u64::from(u32::from_be_bytes([l0, l1, l2, l3]));
        // Length, name and checksum take 12 bytes.
        if offset + 12 + chunk_length > length {
            return Err(truncated());
        }
        match &name {
            b"IHDR" if chunk_length == 13 && offset == 8 => {
                let mut header = [0; 13];
                source.read_exact(&mut header).map_err(|_| truncated())?;
                pixel_bytes = Some(check_header(&header, length)?);
            }
            b"IEND" => break,
            b"sRGB" => is_srgb = true,
            b"gAMA" if chunk_length == 4 => {
                let [gamma] = numbers(source).ok_or_else(truncated)?;
                space.power = (gamma > 0.0).then(|| 1.0 / gamma);
            }
            b"cHRM" if chunk_length == 32 => {
                let [wx, wy, rx, ry, gx, gy, bx, by] = numbers(source).ok_or_else(truncated)?;
                let primaries = [[rx, ry], [gx, gy], [bx, by]];
                space.primaries = Some(Chromaticities { primaries, white: [wx, wy] });
            }
            b"cICP" if chunk_length == 4 => {
                let mut codes = [0; 4];
                source.read_exact(&mut codes).map_err(|_| truncated())?;
                named = coded(codes);
            }
            _ => {}
        }
        offset += 12 + chunk_length;
    }
    source.seek(SeekFrom::Start(0)).map_err(Error::reading)?;
    let pixel_bytes = pixel_bytes.ok_or_else(|| Error::corrupt("PNG", "its header chunk is missing"))?;
    // Codes come before the chunk sRGB, and that before the others.
    Ok((pixel_bytes, named.or(if is_srgb { None } else { Some(space) })))
}

/// Numbers of a chunk, in units of 1/100000.
fn numbers<const N: usize>(source: &mut dyn Source) -> Option<[f32; N]> {
    let mut bytes = vec![0; 4 * N];
    source.read_exact(&mut bytes).ok()?;
    Some(std::array::from_fn(|k| {
        let number = [0, 1, 2, 3].map(|i| bytes[4 * k + i]);
        (f64::from(u32::from_be_bytes(number)) / 1e5) as f32
    }))
}

/// The space of the codes of ITU-T H.273 that pictures use; `None` for HDR and for unknown ones.
fn coded([primaries, transfer, ..]: [u8; 4]) -> Option<Space> {
    let primaries = match primaries {
        1 => REC709,
        9 => REC2020,
        12 => DISPLAY_P3,
        _ => return None,
    };
    let power = match transfer {
        13 => None,
        // Rec. 709 and its relatives as screens show them.
        1 | 6 | 14 | 15 => Some(2.4),
        4 => Some(2.2),
        5 => Some(2.8),
        8 => Some(1.0),
        _ => return None,
    };
    Some(Space { primaries: Some(primaries), power })
}

fn check_header(header: &[u8; 13], length: u64) -> Result<u64, Error> {
    let [w0, w1, w2, w3, h0, h1, h2, h3, depth, color_type, ..] = *header;
    let width = u64::from(u32::from_be_bytes([w0, w1, w2, w3]));
    let height = u64::from(u32::from_be_bytes([h0, h1, h2, h3]));
    check_size("PNG", width, height)?;
    let channels = match color_type {
        0 | 3 => 1,
        4 => 2,
        2 => 3,
        6 => 4,
        _ => return Err(Error::corrupt("PNG", format!("unknown colour type {color_type}"))),
    };
    let row_bytes = (width * channels * u64::from(depth)).div_ceil(8) + 1;
    check_bytes("PNG", [width, height], row_bytes * height, length.saturating_mul(MAX_INFLATION))?;
    Ok(row_bytes * height)
}
