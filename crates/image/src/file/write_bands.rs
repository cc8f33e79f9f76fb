// SPDX-License-Identifier: GPL-3.0-or-later
//! Writing of pictures larger than memory: the caller makes one band after the other.
//! Invariants: the file appears whole or not at all; an EXR has the blocks of [`write`](super::write) under the same
//! options. Tests: `tests/bands.rs`.

use std::fs::File;
use std::path::Path;

use super::bands::Bands;
use super::format::PictureFormat;
use super::options::{Workers, WriteOptions};
use super::replace::replace_by;
use crate::{Error, Picture};

/// Bands of the formats that have them begin at multiples of this number of rows.
///
/// # Errors
/// [`Error::Shape`] if the format is not written in bands, or an EXR's precision depends on all of its values.
pub fn band_unit(format: &PictureFormat, options: &WriteOptions) -> Result<u32, Error> {
    let Some(writer) = &format.bands else {
        let able = PictureFormat::written().filter(|format| format.bands.is_some());
        let able: Vec<String> = able.map(|format| format!(".{}", format.extension())).collect();
        let able = able.join(" and ");
        return Err(Error::Shape(format!("{} files are not written in bands; {able} are", format.name)));
    };
    (writer.unit)(options)
}

/// Writes a picture of `size` that `make` makes in bands of `rows` rows, a multiple of [`band_unit`], from above: it gets
/// the first row and the one behind the last. Returns whether the file is there: it is not if `make` returns `None`.
///
/// # Errors
/// As [`band_unit`], and [`Error::Shape`] if a band has another size or other layers than the first;
/// [`Error::File`] names the failed operation. Nothing has changed then.
pub fn write_bands(
    path: &Path,
    size: [u32; 2],
    rows: u32,
    options: &WriteOptions,
    workers: Workers,
    make: &mut dyn FnMut([u32; 2]) -> Option<Picture>,
    is_wanted: impl FnOnce() -> bool,
) -> Result<bool, Error> {
    let format = PictureFormat::from_path(path)?;
    let unit = band_unit(format, options)?;
    if rows == 0 || !rows.is_multiple_of(unit) {
        return Err(Error::Shape(format!("bands of {rows} rows, which is not a multiple of {unit}")));
    }
    let mut bands = Bands::new(path, size, rows, make);
    let write = |file: &mut File| match &format.bands {
        Some(writer) => (writer.write)(file, &mut bands, options, workers),
        None => Ok(()),
    };
    match replace_by(path, write, is_wanted) {
        Err(Error::Stopped) => Ok(false),
        result => result,
    }
}
