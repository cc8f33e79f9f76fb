// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures as PNG files. Bytes stay the bytes they were; floats are cut to `[0, 1]` and sRGB-encoded.
//! Source: original. Proof: `tests/save.rs::textures_come_back`.

use std::path::Path;

use gnurt_image::{OutputFormat, Picture, WriteOptions};

use crate::io::Error;
use crate::texture::{TexelData, Texels};

pub(super) fn encode(texels: &Texels, path: &Path) -> Result<Vec<u8>, Error> {
    let mut picture = Picture::new(texels.width, texels.height);
    let from_bytes = |bytes: &[[u8; 4]]| -> Vec<[f32; 4]> {
        let color = |&[r, g, b, a]: &[u8; 4]| {
            let [r, g, b] = [r, g, b].map(gnurt_image::srgb::decode_u8);
            [r, g, b, f32::from(a) / 255.0]
        };
        bytes.iter().map(color).collect()
    };
    picture.color = match &texels.data {
        TexelData::Srgb8(bytes) | TexelData::Linear8(bytes) => from_bytes(bytes),
        TexelData::Float(floats) => floats.clone(),
    };
    gnurt_image::encode(&picture, OutputFormat::Png, &WriteOptions::default())
        .map_err(|e| Error::io(path, format!("a texture cannot be written: {e}"), ""))
}
