// SPDX-License-Identifier: GPL-3.0-or-later
//! Why a picture cannot be denoised.

/// Why a picture cannot be denoised.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A name of no denoiser.
    #[error("unknown denoiser '{name}': expected {expected}")]
    UnknownMethod {
        /// As it was given.
        name: String,
        /// All that there are, between commas.
        expected: String,
    },
    /// The picture lacks the features of its camera rays' hits.
    #[error(
        "the picture has no channel '{0}': denoising needs the layers albedo, N and variance, which EXR files of renderings have"
    )]
    NoChannel(String),
    /// The region is empty or not within the picture.
    #[error("the region {region:?} is outside of a picture of {width} x {height} pixels")]
    Region {
        /// As it was given.
        region: [u32; 4],
        /// Columns of the picture.
        width: u32,
        /// Rows of the picture.
        height: u32,
    },
    /// Values and pixels differ in number.
    #[error("{0}")]
    Shape(String),
    /// The library cannot be loaded, or violates its interface.
    #[error("Open Image Denoise cannot be used: {0}")]
    Oidn(String),
}
