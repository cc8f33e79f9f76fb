// SPDX-License-Identifier: GPL-3.0-or-later
//! The file of a cache of tiles: pictures cut into tiles of 16 KiB, row by row, at offsets that never change.
//! It is an unnamed temporary file: other programs cannot change it, and it disappears with the program.
//! Invariant: no two pictures share a byte, so that several threads write at once. Tests: `tests` of `tiles.rs`.

use std::fs::File;
use std::io;
#[cfg(unix)]
use std::os::unix::fs::FileExt;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::Error;

/// Words of 64 bits that a tile has.
pub(crate) const WORDS: usize = 2048;
pub(crate) const TILE_BYTES: usize = WORDS * 8;

/// Columns and rows of a tile of texels of this many bytes.
#[inline]
pub(crate) fn tile_size(bytes: usize) -> [usize; 2] {
    match bytes {
        4 => [64, 64],
        8 => [64, 32],
        _ => [32, 32],
    }
}

pub(crate) struct TileFile {
    file: File,
    /// Where the next picture begins.
    end: AtomicU64,
}

impl TileFile {
    /// # Errors
    /// [`Error::File`] if the temporary folder takes no file.
    pub(crate) fn new() -> Result<Self, Error> {
        let file = tempfile::tempfile().map_err(|error| failure(&error))?;
        Ok(Self { file, end: AtomicU64::new(0) })
    }

    /// Bytes of all tiles.
    pub(crate) fn len(&self) -> u64 {
        self.end.load(Ordering::Relaxed)
    }

    /// Space for a picture whose texels have 4, 8 or 16 bytes.
    pub(crate) fn cutter(&self, [width, height]: [usize; 2], bytes: usize) -> Cutter<'_> {
        let [columns, rows] = tile_size(bytes);
        let (across, down) = (width.div_ceil(columns), height.div_ceil(rows));
        let offset = self.end.fetch_add((across * down * TILE_BYTES) as u64, Ordering::Relaxed);
        let band = Vec::with_capacity(rows.min(height) * width * bytes);
        Cutter { file: self, row_bytes: width * bytes, bytes, across, down, offset, at: offset, band }
    }

    /// Reads the tile that begins at `at`.
    pub(crate) fn read(&self, at: u64, tile: &mut [u8]) -> io::Result<()> {
        let mut done = 0;
        while done < tile.len() {
            match read_some(&self.file, &mut tile[done..], at + done as u64) {
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(read) => done += read,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn write(&self, at: u64, tile: &[u8]) -> Result<(), Error> {
        let mut done = 0;
        while done < tile.len() {
            match write_some(&self.file, &tile[done..], at + done as u64) {
                Ok(0) => return Err(failure(&io::ErrorKind::WriteZero.into())),
                Ok(written) => done += written,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(failure(&error)),
            }
        }
        Ok(())
    }

    #[cfg(test)]
    pub(crate) fn lose(&self) {
        self.file.set_len(0).expect("a shorter file");
    }
}

/// Takes a picture's rows, the upper one first, and writes tiles: no more than a row of tiles is in memory.
pub(crate) struct Cutter<'a> {
    file: &'a TileFile,
    row_bytes: usize,
    /// Of a texel.
    bytes: usize,
    /// Tiles next to each other, and below each other.
    pub(crate) across: usize,
    pub(crate) down: usize,
    /// Where the picture begins, and its next tile.
    pub(crate) offset: u64,
    at: u64,
    /// Rows that are not written yet.
    band: Vec<u8>,
}

impl Cutter<'_> {
    /// The next row: `push` appends its texels.
    ///
    /// # Errors
    /// [`Error::File`] if the file cannot grow.
    pub(crate) fn row(&mut self, push: impl FnOnce(&mut Vec<u8>)) -> Result<(), Error> {
        push(&mut self.band);
        let rows = tile_size(self.bytes)[1];
        if self.band.len() == rows * self.row_bytes { self.cut() } else { Ok(()) }
    }

    /// Writes the rest.
    ///
    /// # Errors
    /// As [`row`](Self::row).
    pub(crate) fn finish(mut self) -> Result<Self, Error> {
        if !self.band.is_empty() {
            self.cut()?;
        }
        Ok(self)
    }

    fn cut(&mut self) -> Result<(), Error> {
        let tile_row = tile_size(self.bytes)[0] * self.bytes;
        let mut tile = Vec::with_capacity(TILE_BYTES);
        for first in (0..self.across).map(|tile| tile * tile_row) {
            tile.clear();
            for (k, row) in self.band.chunks_exact(self.row_bytes).enumerate() {
                tile.extend_from_slice(&row[first..self.row_bytes.min(first + tile_row)]);
                tile.resize((k + 1) * tile_row, 0);
            }
            tile.resize(TILE_BYTES, 0);
            self.file.write(self.at, &tile)?;
            self.at += TILE_BYTES as u64;
        }
        self.band.clear();
        Ok(())
    }
}

fn failure(error: &io::Error) -> Error {
    Error::file(&std::env::temp_dir(), "no temporary file for textures", error)
}

#[cfg(unix)]
fn read_some(file: &File, to: &mut [u8], at: u64) -> io::Result<usize> {
    file.read_at(to, at)
}

#[cfg(unix)]
fn write_some(file: &File, from: &[u8], at: u64) -> io::Result<usize> {
    file.write_at(from, at)
}

#[cfg(windows)]
fn read_some(file: &File, to: &mut [u8], at: u64) -> io::Result<usize> {
    std::os::windows::fs::FileExt::seek_read(file, to, at)
}

#[cfg(windows)]
fn write_some(file: &File, from: &[u8], at: u64) -> io::Result<usize> {
    std::os::windows::fs::FileExt::seek_write(file, from, at)
}

// Files cannot be read at an offset there.
#[cfg(not(any(unix, windows)))]
fn read_some(_: &File, _: &mut [u8], _: u64) -> io::Result<usize> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(not(any(unix, windows)))]
fn write_some(_: &File, _: &[u8], _: u64) -> io::Result<usize> {
    Err(io::ErrorKind::Unsupported.into())
}
