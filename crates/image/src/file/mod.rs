// SPDX-License-Identifier: GPL-3.0-or-later
//! Picture files: the format of a file, and the conversions from bytes to a picture and back. One file of
//! this folder per format; `raster` holds those that the `image` library decodes. In and out: linear light,
//! row 0 = top. Invariants: no panic on any bytes; declared sizes are checked against the file's length
//! before memory is taken, and the memory against the final size (`limits`); a failed write changes nothing.
//! Tests: `tests` (crate folder `tests/`): round trips, truncation at every length, corruption of every byte.

mod bands;
mod exr;
mod format;
mod guard;
mod hdr;
mod icc;
mod jpeg;
mod limits;
mod open;
mod options;
mod pfm;
mod png;
mod png_chunks;
mod raster;
mod replace;
mod screens;
mod source;
mod table;
mod tiff;
mod vp8l;
mod webp;
mod write_bands;

use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::Path;

pub use format::PictureFormat;
pub use guard::{expecting_panics, expects_panics};
pub use limits::MAX_PIXELS;
pub use open::{NotRegular, open_regular};
pub use options::{ExrCompression, ExrPixels, Workers, WriteOptions};
pub use png::{encode_screen, encode_texels};
pub use replace::{check_writable, replace_file, replace_file_if};
pub use write_bands::{band_unit, write_bands};

use crate::{Budget, Error, Picture, Stored, Texels};
use format::Meaning;
use options::ALONE;
use source::Source;

/// Writes a picture in the format that the file's name ends in. The file appears whole or not at all.
///
/// # Errors
/// [`Error::UnknownExtension`] for a name without a known format; [`Error::In`] or [`Error::File`] otherwise.
pub fn write(picture: &Picture, path: &Path, options: &WriteOptions) -> Result<(), Error> {
    let format = PictureFormat::from_path(path)?;
    let bytes = encode(picture, format, options).map_err(|error| error.in_file(path))?;
    replace_file(path, &bytes)
}

/// The bytes of a picture's file. The same picture gives the same bytes; of an EXR, attributes may change their order.
///
/// # Errors
/// [`Error::Shape`] if sizes do not fit, [`Error::TooLarge`] if the format cannot hold as many rows or columns.
pub fn encode(picture: &Picture, format: &PictureFormat, options: &WriteOptions) -> Result<Vec<u8>, Error> {
    encode_with(picture, format, options, ALONE)
}

/// [`encode`] with the caller's workers, which compress the blocks of an EXR. The bytes are the same.
///
/// # Errors
/// As of [`encode`].
pub fn encode_with(
    picture: &Picture,
    format: &PictureFormat,
    options: &WriteOptions,
    workers: Workers,
) -> Result<Vec<u8>, Error> {
    picture.check()?;
    match format.write {
        Some(encode) => encode(picture, options, workers),
        None => Err(Error::Shape(format!("{} files are not written", format.name))),
    }
}

/// Reads a picture of any known format into linear light.
///
/// # Errors
/// [`Error::File`] if the file cannot be read or is no regular one, [`Error::In`] if its data is bad.
pub fn read(path: &Path) -> Result<Picture, Error> {
    read_with(path, ALONE)
}

/// [`read`] with the caller's workers, which decompress the blocks of an EXR. The picture is the same.
///
/// # Errors
/// As of [`read`].
pub fn read_with(path: &Path, workers: Workers) -> Result<Picture, Error> {
    let (mut source, length) = open_picture(path)?;
    picture_from(&mut source, length, &path.to_string_lossy(), workers).map_err(|error| error.in_file(path))
}

/// Reads a picture from bytes; the name decides only where the bytes do not identify the format (TGA).
///
/// # Errors
/// [`Error::UnknownFormat`], [`Error::Corrupt`] or [`Error::TooLarge`].
pub fn decode(bytes: &[u8], name: &str) -> Result<Picture, Error> {
    picture_from(&mut Cursor::new(bytes), bytes.len() as u64, name, ALONE)
}

/// Reads a colour texture from bytes: 8-bit values stay bytes (sRGB), others become linear floats.
///
/// # Errors
/// As [`decode`].
pub fn decode_texture(bytes: &[u8], name: &str) -> Result<Texels, Error> {
    decode_texture_within(bytes, name, u64::MAX, ALONE)
}

/// As [`decode_texture`], but takes at most this many bytes of memory at once, the returned ones included. The caller's workers
/// decompress the blocks of an EXR; the texels are the same.
///
/// # Errors
/// As [`decode`].
pub fn decode_texture_within(
    bytes: &[u8],
    name: &str,
    most_bytes: u64,
    workers: Workers,
) -> Result<Texels, Error> {
    decode_texels(bytes, name, Meaning::Color, most_bytes, workers)
}

/// Reads a texture of measures (roughness, metalness) from bytes: integers are linear, not sRGB.
///
/// # Errors
/// As [`decode`].
pub fn decode_data_texture(bytes: &[u8], name: &str) -> Result<Texels, Error> {
    decode_data_texture_within(bytes, name, u64::MAX, ALONE)
}

/// As [`decode_data_texture`], but within memory and by workers as [`decode_texture_within`].
///
/// # Errors
/// As [`decode`].
pub fn decode_data_texture_within(
    bytes: &[u8],
    name: &str,
    most_bytes: u64,
    workers: Workers,
) -> Result<Texels, Error> {
    decode_texels(bytes, name, Meaning::Measure, most_bytes, workers)
}

fn decode_texels(
    bytes: &[u8],
    name: &str,
    meaning: Meaning,
    most_bytes: u64,
    workers: Workers,
) -> Result<Texels, Error> {
    let length = bytes.len() as u64;
    let budget = &Budget::of_picture(length).at_most(most_bytes);
    texels_from(&mut Cursor::new(bytes), length, name, meaning, budget, workers)
}

/// Reads a colour texture from a file; see [`decode_texture`].
///
/// # Errors
/// As [`read`].
pub fn read_texture(path: &Path) -> Result<Texels, Error> {
    read_texels(path, Meaning::Color, ALONE)
}

/// [`read_texture`] with the caller's workers, which decompress the blocks of an EXR. The texels are the same.
///
/// # Errors
/// As [`read`].
pub fn read_texture_with(path: &Path, workers: Workers) -> Result<Texels, Error> {
    read_texels(path, Meaning::Color, workers)
}

/// Reads a texture of measures from a file; see [`decode_data_texture`].
///
/// # Errors
/// As [`read`].
pub fn read_data_texture(path: &Path) -> Result<Texels, Error> {
    read_texels(path, Meaning::Measure, ALONE)
}

/// Reads a file as it is: all channels and levels, values as they are stored.
///
/// # Errors
/// As [`read`].
pub fn read_stored(path: &Path) -> Result<Stored, Error> {
    let (mut source, length) = open_picture(path)?;
    let budget = &Budget::of_picture(length);
    stored_from(&mut source, length, &path.to_string_lossy(), budget).map_err(|error| error.in_file(path))
}

/// A picture file, and its length.
fn open_picture(path: &Path) -> Result<(BufReader<File>, u64), Error> {
    let (file, length) = open_regular(path).map_err(|fault| fault.in_file(path, "a picture file"))?;
    Ok((BufReader::with_capacity(1 << 16, file), length))
}

fn stored_from(source: &mut dyn Source, length: u64, name: &str, budget: &Budget) -> Result<Stored, Error> {
    PictureFormat::of(source, length, name)?.stored(source, length, budget)
}

fn read_texels(path: &Path, meaning: Meaning, workers: Workers) -> Result<Texels, Error> {
    let (mut source, length) = open_picture(path)?;
    let budget = &Budget::of_picture(length);
    texels_from(&mut source, length, &path.to_string_lossy(), meaning, budget, workers)
        .map_err(|error| error.in_file(path))
}

fn picture_from(
    source: &mut dyn Source,
    length: u64,
    name: &str,
    workers: Workers,
) -> Result<Picture, Error> {
    let budget = &Budget::of_picture(length);
    (PictureFormat::of(source, length, name)?.read.picture)(source, length, budget, workers)
}

fn texels_from(
    source: &mut dyn Source,
    length: u64,
    name: &str,
    meaning: Meaning,
    budget: &Budget,
    workers: Workers,
) -> Result<Texels, Error> {
    PictureFormat::of(source, length, name)?.texels(source, length, meaning, budget, workers)
}
