// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures: the value of pixels, their files and their comparison. Knows neither rays nor threads.
#![forbid(unsafe_code)]

mod error;
mod filter;
mod heat;
mod picture;
pub mod srgb;
mod texels;
mod tone;

pub use error::Error;
pub use filter::{Filter, FilterShape};
pub use heat::{heat_color, heat_map};
pub use picture::{Channel, ChannelData, Layer, Picture};
pub use texels::{TexelData, Texels};
pub use tone::{ToneCurve, screen_bytes};
