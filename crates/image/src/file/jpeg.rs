// SPDX-License-Identifier: GPL-3.0-or-later
//! JPEG: a walk along its markers before it is decoded, since the decoder takes a truncated file for a whole one.
//! From ITU-T T.81, annex B. Tests: `tests/broken.rs`.

use std::io::SeekFrom;

use super::limits::check_density;
use super::source::Source;
use crate::Error;

/// Pixels that a byte of a JPEG holds at most. Only a single flat colour takes more, up to 340.
const PIXELS_PER_BYTE: u64 = 64;

/// Bytes that a file may have in addition to 8 for each pixel: thumbnails, profiles.
const MAX_EXTRA_BYTES: u64 = 1 << 26;

const END_OF_IMAGE: u8 = 0xd9;
const START_OF_SCAN: u8 = 0xda;

/// Checks that the file has a size, a scan and an end, and can hold its pixels; returns whether it has
/// several scans, between which a decoder stores all coefficients.
pub(super) fn check(source: &mut dyn Source, length: u64) -> Result<bool, Error> {
    let truncated = || Error::corrupt("JPEG", "the end of the picture is missing; the file is truncated");
    source.seek(SeekFrom::Start(2)).map_err(Error::reading)?;
    let mut has_size = false;
    let mut has_scan = false;
    let mut in_scans = false;
    let mut channels = 0;
    loop {
        let marker = next_marker(source)?.ok_or_else(truncated)?;
        match marker {
            END_OF_IMAGE => break,
            // Markers without a segment: temporary, restarts, a thumbnail's start.
            0x01 | 0xd0..=0xd8 => continue,
            _ => {}
        }
        let segment = read_u16(source)?.ok_or_else(truncated)?;
        let rest = segment
            .checked_sub(2)
            .ok_or_else(|| Error::corrupt("JPEG", "a segment is shorter than its length"))?;
        // Start of frame: all of C0..CF but the tables C4, CC and the extension C8.
        let is_frame = matches!(marker, 0xc0..=0xcf) && !matches!(marker, 0xc4 | 0xc8 | 0xcc);
        let skipped = if is_frame && rest >= 6 {
            channels = check_frame(source, length)?;
            has_size = true;
            in_scans |= !matches!(marker, 0xc0 | 0xc1);
            6
        } else if marker == START_OF_SCAN && rest >= 1 {
            let mut scanned = [0];
            source.read_exact(&mut scanned).map_err(|_| truncated())?;
            has_scan = true;
            // Channels that come one after the other.
            in_scans |= scanned[0] < channels;
            1
        } else {
            0
        };
        source.seek(SeekFrom::Current(i64::from(rest) - skipped)).map_err(Error::reading)?;
    }
    source.seek(SeekFrom::Start(0)).map_err(Error::reading)?;
    if has_size && has_scan { Ok(in_scans) } else { Err(Error::corrupt("JPEG", "it holds no picture")) }
}

/// Checks a frame's size; returns its number of channels.
fn check_frame(source: &mut dyn Source, length: u64) -> Result<u8, Error> {
    let mut head = [0; 6];
    source.read_exact(&mut head).map_err(Error::reading)?;
    let [_, h0, h1, w0, w1, channels] = head;
    let size = [u64::from(u16::from_be_bytes([w0, w1])), u64::from(u16::from_be_bytes([h0, h1]))];
    check_density("JPEG", size, length, PIXELS_PER_BYTE)?;
    if length > size[0] * size[1] * 8 + MAX_EXTRA_BYTES {
        return Err(Error::corrupt(
            "JPEG",
            format!("{length} bytes are too many for {} x {} pixels", size[0], size[1]),
        ));
    }
    Ok(channels)
}

/// Skips to the next FF that is neither stuffed (followed by 0) nor padding; gives the byte after it.
fn next_marker(source: &mut dyn Source) -> Result<Option<u8>, Error> {
    let mut after_ff = false;
    loop {
        let buffer = source.fill_buf().map_err(Error::reading)?;
        if buffer.is_empty() {
            return Ok(None);
        }
        let found = buffer.iter().position(|&byte| {
            let is_marker = after_ff && byte != 0 && byte != 0xff;
            after_ff = byte == 0xff;
            is_marker
        });
        let (used, marker) = found.map_or((buffer.len(), None), |at| (at + 1, Some(buffer[at])));
        source.consume(used);
        if marker.is_some() {
            return Ok(marker);
        }
    }
}

fn read_u16(source: &mut dyn Source) -> Result<Option<u16>, Error> {
    let mut bytes = [0; 2];
    match source.read_exact(&mut bytes) {
        Ok(()) => Ok(Some(u16::from_be_bytes(bytes))),
        Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(Error::reading(error)),
    }
}
