// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures: the value of pixels, their files and their comparison. Uses neither rays nor threads.
#![forbid(unsafe_code)]

mod budget;
pub mod chromaticities;
mod colors;
mod compare;
mod error;
mod exposure;
mod file;
mod filter;
mod flip;
mod heat;
mod picture;
mod pyramid;
mod screen;
pub mod srgb;
mod ssim;
mod stored;
mod survey;
mod texels;
mod tile_file;
mod tiles;
mod tone;
pub mod udim;
mod volume;
mod working_space;

pub use budget::{Budget, Excess};
pub use colors::convert_from;
pub use compare::{Comparison, compare, differences};
pub use error::{Error, system_reason};
pub use exposure::exposure_for;
pub use file::{
    ExrCompression, ExrPixels, MAX_PIXELS, NotRegular, PictureFormat, Workers, WriteOptions, band_unit,
    check_writable, decode, decode_data_texture, decode_data_texture_within, decode_texture,
    decode_texture_within, encode, encode_screen, encode_texels, encode_with, expecting_panics,
    expects_panics, open_regular, read, read_data_texture, read_stored, read_texture, read_texture_with,
    read_with, replace_file, replace_file_if, write, write_bands,
};
pub use filter::{Filter, FilterShape};
pub use flip::flip;
pub use heat::{heat_color, heat_map};
pub use picture::{BACKGROUND, Channel, ChannelData, Layer, Opacity, Picture};
pub use pyramid::Weigh;
pub use stored::{Stored, StoredLevel, StoredValues};
pub use survey::Survey;
pub use texels::{TexelData, Texels, Tiled};
pub use tiles::{TileCache, TileCounts};
pub use tone::{ToneCurve, screen_bytes};
pub use volume::{Grid, Volume};
pub use working_space::{WorkingSpace, convert};

/// The name and version of the maker that files state.
pub const SOFTWARE: &str = concat!("GNU RT ", env!("CARGO_PKG_VERSION"));
