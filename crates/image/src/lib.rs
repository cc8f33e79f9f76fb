// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures: the value of pixels, their files and their comparison. Knows neither rays nor threads.
#![forbid(unsafe_code)]

mod texels;

pub use texels::{TexelData, Texels};
