// SPDX-License-Identifier: GPL-3.0-or-later
//! The chunks of a PNG, checked before it is decoded.
//! Source: PNG specification, third edition. Tests: `tests/broken.rs`.

use std::io::SeekFrom;

use super::limits::{check_bytes, check_size};
use super::source::Source;
use crate::Error;

/// Most bytes that a byte of compressed data can become: deflate's 258 for two bits.
const MAX_INFLATION: u64 = 1032;

/// Checks that all chunks are there and that the data can hold the declared size; returns the bytes of its pixels.
pub(super) fn check(source: &mut dyn Source, length: u64) -> Result<u64, Error> {
    let truncated = || Error::corrupt("PNG", "the file ends within a chunk; it is truncated");
    let mut offset = 8;
    let mut pixel_bytes = None;
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
            _ => {}
        }
        offset += 12 + chunk_length;
    }
    source.seek(SeekFrom::Start(0)).map_err(Error::reading)?;
    pixel_bytes.ok_or_else(|| Error::corrupt("PNG", "its header chunk is missing"))
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
