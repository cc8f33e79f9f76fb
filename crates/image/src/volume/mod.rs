// SPDX-License-Identifier: GPL-3.0-or-later
//! Volumes: numbers at points of space, in sparse grids, as files of OpenVDB and NanoVDB hold them.
//! Source: Museth, VDB: High-Resolution Sparse Volumes with Dynamic Topology (2013) [Mus13], and NanoVDB [Mus21]; original code.
//! The first bytes of a file decide its format, whatever its name.
//! Invariant: reading takes no more memory than is allowed and its length accounts for, and examines each
//! byte once, for any file.
//! Tests: `tests/volumes.rs`, `tests/nano_volumes.rs`, whose files were written by OpenVDB and NanoVDB.

mod blosc;
mod bytes;
mod grid;
mod nanovdb;
mod openvdb;
mod tree;
mod values;

use std::io::Read;
use std::path::Path;

use crate::file::open_regular;
use crate::{Budget, Error};
use bytes::{corrupt, too_large};
pub use grid::Grid;

/// The grids of a file.
#[derive(Debug)]
pub struct Volume {
    grids: Vec<Grid>,
}

impl Volume {
    /// Reads a regular file of at most `limit` bytes; its contents take at most the same number of bytes of
    /// memory, and no more than its length accounts for, in addition to the file itself.
    ///
    /// # Errors
    /// The file cannot be read, is no regular file, has neither format, is broken, holds no numbers, or takes
    /// too much memory.
    pub fn read(path: &Path, limit: usize) -> Result<Self, Error> {
        let (source, length) =
            open_regular(path).map_err(|fault| fault.in_file(path, "a file of OpenVDB or NanoVDB"))?;
        let request = usize::try_from(length).ok().filter(|&length| length <= limit);
        let Some(request) = request else {
            return Err(too_large(limit).in_file(path));
        };
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(request).map_err(|_| too_large(limit).in_file(path))?;
        let read = source.take(length).read_to_end(&mut bytes);
        read.map_err(|error| Error::file(path, "cannot be read", &error))?;
        Self::decode(&bytes, limit).map_err(|error| error.in_file(path))
    }

    /// The same from a file's bytes.
    ///
    /// # Errors
    /// As [`read`](Self::read); the file is not named.
    pub fn decode(bytes: &[u8], limit: usize) -> Result<Self, Error> {
        let budget = &Budget::of_picture(bytes.len() as u64).at_most(limit as u64);
        let (grids, other) = if bytes.starts_with(&openvdb::MAGIC) {
            openvdb::read(bytes, budget)?
        } else if nanovdb::is_of(bytes) {
            nanovdb::read(bytes, budget)?
        } else {
            return Err(corrupt("it does not begin as files of OpenVDB or NanoVDB do"));
        };
        Self::of(grids, other)
    }

    /// A grid of NanoVDB as programs hold it in memory, without the head of a file.
    ///
    /// # Errors
    /// As [`decode`](Self::decode).
    pub fn decode_nanovdb_grid(bytes: &[u8], limit: usize) -> Result<Self, Error> {
        let budget = &Budget::of_picture(bytes.len() as u64).at_most(limit as u64);
        let (grids, other) = nanovdb::read_grid(bytes, budget)?;
        Self::of(grids, other)
    }

    fn of(grids: Vec<Grid>, other: Option<String>) -> Result<Self, Error> {
        match (&*grids, other) {
            ([], None) => Err(corrupt("no grids")),
            ([], Some(kind)) => Err(corrupt(format!(
                "no grid of numbers (the first is a {kind}); grids of floats, doubles and integers, one or three, are read"
            ))),
            _ => Ok(Self { grids }),
        }
    }

    /// The grids, at least one, in the file's order.
    #[must_use]
    pub fn grids(&self) -> &[Grid] {
        &self.grids
    }

    /// The first grid of a name.
    #[must_use]
    pub fn grid(&self, name: &str) -> Option<&Grid> {
        self.grids.iter().find(|grid| grid.name() == name)
    }
}
