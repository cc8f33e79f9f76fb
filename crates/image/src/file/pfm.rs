// SPDX-License-Identifier: GPL-3.0-or-later
//! PFM: three lines of text, then 32-bit floats in rows from the bottom one. Colour only, exact to the bit.
//! From the format's description by Debevec. Written little-endian (scale -1); read in both orders,
//! grey (`Pf`) or coloured (`PF`), values times the scale's magnitude. Tests: `tests` in `tests/round_trip.rs`.

use super::format::{PictureFormat, Readers, Signature};
use super::limits::{PICTURE_BYTES, check_bytes};
use super::source::Source;
use crate::{Budget, Error, Picture};

/// Bytes that a header may have: far more than three numbers need.
const MAX_WORD: usize = 64;

/// The format.
pub(super) const FORMAT: PictureFormat = PictureFormat {
    name: "PFM",
    extensions: &["pfm"],
    notes: "linear radiance, 32 bits; grey files are read",
    is_for_screens: false,
    has_opacity: false,
    has_layers: false,
    is_whole: true,
    signature: Signature::Head(
        |head| matches!(head, [b'P', b'F' | b'f', space, ..] if space.is_ascii_whitespace()),
    ),
    read: Readers {
        picture: |source, length, budget, _| decode(source, length, budget),
        texels: None,
        stored: None,
    },
    write: Some(|picture, _, _| Ok(encode(picture))),
    bands: None,
};

fn encode(picture: &Picture) -> Vec<u8> {
    let header = format!("PF\n{} {}\n-1.0\n", picture.width, picture.height);
    let mut bytes = Vec::with_capacity(header.len() + picture.color.len() * 12);
    bytes.extend_from_slice(header.as_bytes());
    for row in picture.color.chunks_exact(picture.width as usize).rev() {
        for [r, g, b, _] in row {
            for value in [r, g, b] {
                bytes.extend_from_slice(&value.to_le_bytes());
            }
        }
    }
    bytes
}

fn decode(source: &mut dyn Source, length: u64, budget: &Budget) -> Result<Picture, Error> {
    let mut header = Header { source, read: 0 };
    let channels: usize = if header.token()? == "PF" { 3 } else { 1 };
    let width = header.number("width")?;
    let height = header.number("height")?;
    let scale = header.scale()?;
    let size = [u64::from(width), u64::from(height)];
    let row_bytes = u64::from(width) * channels as u64 * 4;
    check_bytes("PFM", size, header.read.saturating_add(row_bytes.saturating_mul(size[1])), length)?;
    budget.check("PFM", size, PICTURE_BYTES)?;

    let mut picture = Picture::new(width, height);
    let mut bytes = vec![0; row_bytes as usize];
    let float = |bytes: &[u8; 4]| {
        let value = if scale < 0.0 { f32::from_le_bytes(*bytes) } else { f32::from_be_bytes(*bytes) };
        // A factor of 1 must not touch the bits of a NaN.
        if scale.abs() == 1.0 { value } else { value * scale.abs() }
    };
    for row in picture.color.chunks_exact_mut(width as usize).rev() {
        source.read_exact(&mut bytes).map_err(Error::reading)?;
        let (values, _) = bytes.as_chunks::<4>();
        for (pixel, values) in row.iter_mut().zip(values.chunks_exact(channels)) {
            // Grey has one value for all three.
            let [r, g, b] = std::array::from_fn(|c| float(&values[c.min(channels - 1)]));
            *pixel = [r, g, b, 1.0];
        }
    }
    Ok(picture)
}

/// The words of the header, read byte by byte: exactly one space separates the last of them from the values.
struct Header<'a> {
    source: &'a mut dyn Source,
    read: u64,
}

impl Header<'_> {
    fn token(&mut self) -> Result<String, Error> {
        let mut token = String::new();
        loop {
            let mut byte = [0];
            self.source.read_exact(&mut byte).map_err(Error::reading)?;
            self.read += 1;
            match byte[0] {
                space if space.is_ascii_whitespace() && !token.is_empty() => return Ok(token),
                space if space.is_ascii_whitespace() => {}
                letter if letter.is_ascii_graphic() && token.len() < MAX_WORD => {
                    token.push(char::from(letter))
                }
                _ => return Err(Error::corrupt("PFM", "the header is not text")),
            }
            if self.read > 8 * MAX_WORD as u64 {
                return Err(Error::corrupt("PFM", "the header has no end"));
            }
        }
    }

    fn number(&mut self, what: &str) -> Result<u32, Error> {
        let token = self.token()?;
        token
            .parse()
            .map_err(|_| Error::corrupt("PFM", format!("the {what} '{token}' is not a number of pixels")))
    }

    fn scale(&mut self) -> Result<f32, Error> {
        let token = self.token()?;
        match token.parse::<f32>() {
            Ok(scale) if scale.is_finite() && scale != 0.0 => Ok(scale),
            _ => {
                Err(Error::corrupt("PFM", format!("the scale '{token}' is not a finite number other than 0")))
            }
        }
    }
}
