// SPDX-License-Identifier: GPL-3.0-or-later
//! Bands of a picture larger than memory, as the writers of formats get them: pictures of some of the rows, from above.
//! All have the same layers; the first one's metadata is the file's. Tests: `tests/bands.rs`.

use std::fmt::Display;
use std::fs::File;
use std::path::Path;

use super::options::{Workers, WriteOptions};
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

impl<'a> Bands<'a> {
    /// Bands of `height` rows that `make` makes, for the file of this name.
    pub(super) fn new(
        path: &'a Path,
        size: [u32; 2],
        height: u32,
        make: &'a mut dyn FnMut([u32; 2]) -> Option<Picture>,
    ) -> Self {
        Self { size, path, row: 0, height, make }
    }

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
