// SPDX-License-Identifier: GPL-3.0-or-later
//! OpenEXR: a picture with all its layers, by the `exr` library.
//! Tests: `tests/{round_trip,broken}.rs`.

mod read;
mod write;

use super::bands::BandWriter;
use super::format::{PictureFormat, Readers, Signature};

/// The format.
pub(super) const FORMAT: PictureFormat = PictureFormat {
    name: "EXR",
    extensions: &["exr"],
    notes: "linear radiance and layers, 16 or 32 bits, rows or tiles; deep data is rejected",
    is_for_screens: false,
    has_opacity: true,
    has_layers: true,
    is_whole: true,
    signature: Signature::Head(|head| head.starts_with(&[0x76, 0x2f, 0x31, 0x01])),
    read: Readers { picture: read::decode, texels: None, stored: Some(read::stored) },
    write: Some(write::encode),
    bands: Some(BandWriter { unit: write::rows_of_blocks, write: write::write_bands }),
};
