// SPDX-License-Identifier: GPL-3.0-or-later
//! Texels: the picture of a texture, in the form that its file had.
//! Source: original. Rows from the upper left texel on. Invariant: `data` holds `width * height` values, both at least 1.

use crate::{Picture, srgb};

/// Texels in rows, from the upper left one.
#[derive(Clone, Debug, PartialEq)]
pub struct Texels {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// The values.
    pub data: TexelData,
}

/// Texel values in the form that a file had, so that a picture takes no more memory than it must.
#[derive(Clone, Debug, PartialEq)]
pub enum TexelData {
    /// Red, green, blue as sRGB bytes and opacity as a linear byte.
    Srgb8(Vec<[u8; 4]>),
    /// Red, green, blue, opacity as linear bytes (roughness, metalness, OpenRT's byte textures).
    Linear8(Vec<[u8; 4]>),
    /// Linear floats, unclamped.
    Float(Vec<[f32; 4]>),
}

impl Texels {
    /// Bytes that the values take.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        match &self.data {
            TexelData::Srgb8(v) | TexelData::Linear8(v) => size_of_val(&v[..]),
            TexelData::Float(v) => size_of_val(&v[..]),
        }
    }
}

impl From<Picture> for Texels {
    /// The picture's colours as floats.
    fn from(picture: Picture) -> Self {
        Self { width: picture.width, height: picture.height, data: TexelData::Float(picture.color) }
    }
}

impl From<Texels> for Picture {
    /// The texels in linear light.
    fn from(texels: Texels) -> Self {
        let unit = |byte: u8| f32::from(byte) / 255.0;
        let color = match texels.data {
            TexelData::Srgb8(pixels) => pixels
                .iter()
                .map(|&[r, g, b, a]| [srgb::decode_u8(r), srgb::decode_u8(g), srgb::decode_u8(b), unit(a)])
                .collect(),
            TexelData::Linear8(pixels) => pixels.iter().map(|pixel| pixel.map(unit)).collect(),
            TexelData::Float(pixels) => pixels,
        };
        Self { width: texels.width, height: texels.height, color, ..Self::default() }
    }
}
