// SPDX-License-Identifier: GPL-3.0-or-later
//! How pictures are written.

use crate::{ToneCurve, WorkingSpace};

/// Precision of the colours in an EXR.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ExrPixels {
    /// Half where all values fit, else float: a sun that is seen is not cut off.
    #[default]
    Fitting,
    /// 16-bit floats: off by at most 1/2048, up to 65504; greater values become that.
    Half,
    /// 32-bit floats: exact.
    Float,
}

/// Compressions of an EXR.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ExrCompression {
    /// Nothing: the largest files, the quickest to read.
    None,
    /// Runs of equal bytes.
    Rle,
    /// Deflate, row by row.
    Zips,
    /// Deflate, 16 rows at a time.
    #[default]
    Zip,
    /// Wavelets: small files of noisy pictures.
    Piz,
    /// Deflate, floats rounded to 24 bits.
    Pxr24,
}

impl ExrCompression {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::None, Self::Rle, Self::Zips, Self::Zip, Self::Piz, Self::Pxr24];

    /// The name that users write.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rle => "rle",
            Self::Zips => "zips",
            Self::Zip => "zip",
            Self::Piz => "piz",
            Self::Pxr24 => "pxr24",
        }
    }
}

impl std::fmt::Display for ExrCompression {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// How a picture is written where the format leaves a choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WriteOptions {
    /// PNG, JPEG, WebP: how light above white is shown.
    pub tone: ToneCurve,
    /// PNG, JPEG, WebP: exposure in stops; each doubles the light.
    pub exposure: f32,
    /// EXR: precision of the colours. Channels of layers state their own.
    pub exr_pixels: ExrPixels,
    /// EXR: compression of all channels.
    pub exr_compression: ExrCompression,
    /// EXR: space of the colours.
    pub exr_space: WorkingSpace,
    /// EXR: width and height of tiles in pixels; `None` = rows.
    pub exr_tile: Option<u32>,
    /// PNG: whether a channel has 16 bits instead of 8.
    pub png_16_bits: bool,
    /// JPEG: from 1, the smallest file, to 100.
    pub jpeg_quality: u8,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self {
            tone: ToneCurve::default(),
            exposure: 0.0,
            exr_pixels: ExrPixels::default(),
            exr_compression: ExrCompression::default(),
            exr_space: WorkingSpace::default(),
            exr_tile: None,
            png_16_bits: false,
            jpeg_quality: 92,
        }
    }
}

/// Calls a job once for each number below a count, in any order, and returns when all calls have.
pub type Workers<'a> = &'a dyn Fn(usize, &(dyn Fn(usize) + Sync));

/// The calling thread.
pub(super) const ALONE: Workers<'static> = &|count, job| (0..count).for_each(job);
