// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures larger than memory: their files are written band by band, from above, as the caller makes them.
//! A band is a picture of some of the rows. All have the same layers; the first one's metadata is the file's.
//! Invariants: the file appears whole or not at all; an EXR has the bytes of [`write`](super::write) under the same
//! options. Tests: `tests/bands.rs`.

use std::fmt::Display;
use std::fs::File;
use std::path::Path;

use super::format::PictureFormat;
use super::options::{Workers, WriteOptions};
use super::replace::replace_by;
use crate::{Error, Picture};

/// How a format writes bands.
#[derive(Debug)]
pub(super) struct BandWriter {
    /// Bands begin at multiples of this number of rows.
    pub(super) unit: fn(&WriteOptions) -> Result<u32, Error>,
    pub(super) write: WriteBands,
}

type WriteBands = fn(&mut File, &mut Bands, &WriteOptions, Workers) -> Result<(), Error>;

/// The bands that are still to come, and the size of the picture.
pub(super) struct Bands<'a> {
    pub(super) size: [u32; 2],
    path: &'a Path,
    row: u32,
    height: u32,
    make: &'a mut dyn FnMut([u32; 2]) -> Option<Picture>,
}

impl Bands<'_> {
    /// The next band, and its first row; `None` behind the last one.
    pub(super) fn next(&mut self) -> Result<Option<(u32, Picture)>, Error> {
        let [width, height] = self.size;
        if self.row >= height {
            return Ok(None);
        }
        let rows = [self.row, height.min(self.row.saturating_add(self.height))];
        let band = (self.make)(rows).ok_or(Error::Stopped)?;
        band.check()?;
        if [band.width, band.height] != [width, rows[1] - rows[0]] {
            let [w, h] = [band.width, band.height];
            return Err(Error::Shape(format!(
                "a band of {w} x {h} pixels for rows {} to {}",
                rows[0], rows[1]
            )));
        }
        self.row = rows[1];
        Ok(Some((rows[0], band)))
    }

    /// The failure to write.
    pub(super) fn failed(&self, why: &dyn Display) -> Error {
        Error::File { path: self.path.into(), what: format!("cannot be written: {why}") }
    }
}

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
    let mut bands = Bands { size, path, row: 0, height: rows, make };
    let write = |file: &mut File| match &format.bands {
        Some(writer) => (writer.write)(file, &mut bands, options, workers),
        None => Ok(()),
    };
    match replace_by(path, write, is_wanted) {
        Err(Error::Stopped) => Ok(false),
        result => result,
    }
}
