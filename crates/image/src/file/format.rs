// SPDX-License-Identifier: GPL-3.0-or-later
//! A picture format: its names, the first bytes of its files, its reader and its writer.
//! Help texts, messages, the Python package and docs/reference/formats.md list formats from the table of them (`table.rs`).
//! Tests: `table.rs`.

use super::bands::BandWriter;
use super::options::{ALONE, Workers, WriteOptions};
use super::source::Source;
use crate::{Budget, Error, Picture, Stored, StoredValues, Texels};

/// A picture format.
#[derive(Debug)]
pub struct PictureFormat {
    /// Its name in texts.
    pub name: &'static str,
    /// Extensions of its files, in lower case, without the dot; the first is the usual one.
    pub extensions: &'static [&'static str],
    /// One line for the list of formats.
    pub notes: &'static str,
    /// Whether its pictures are for screens: written after exposure and tone curve.
    pub is_for_screens: bool,
    /// Whether it is written with opacity.
    pub has_opacity: bool,
    /// Whether it has layers in addition to the colours.
    pub has_layers: bool,
    /// Whether all files of the format are read.
    pub is_whole: bool,
    pub(super) signature: Signature,
    pub(super) read: Readers,
    pub(super) write: Option<Encode>,
    /// Its writer of pictures larger than memory.
    pub(super) bands: Option<BandWriter>,
}

/// The mark by which a format's files are recognised.
#[derive(Debug)]
pub(super) enum Signature {
    /// Their first bytes.
    Head(fn(&[u8; 12]) -> bool),
    /// Their last bytes, or the extension.
    Foot(&'static [u8]),
}

type Encode = fn(&Picture, &WriteOptions, Workers) -> Result<Vec<u8>, Error>;
type Decode<T> = fn(&mut dyn Source, u64, &Budget) -> Result<T, Error>;
type DecodePicture = fn(&mut dyn Source, u64, &Budget, Workers) -> Result<Picture, Error>;
type DecodeTexels = fn(&mut dyn Source, u64, Meaning, &Budget) -> Result<Texels, Error>;

/// A format's readers of a source and its length. Pictures of floats become textures and stored values by themselves.
#[derive(Debug)]
pub(super) struct Readers {
    pub(super) picture: DecodePicture,
    pub(super) texels: Option<DecodeTexels>,
    pub(super) stored: Option<Decode<Stored>>,
}

/// The meaning of integers in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// sRGB colours.
    Color,
    /// Linear values.
    Measure,
}

impl PictureFormat {
    /// Whether it can be written.
    #[must_use]
    pub fn is_written(&self) -> bool {
        self.write.is_some()
    }

    /// The usual extension, without the dot.
    #[must_use]
    pub fn extension(&self) -> &'static str {
        self.extensions.first().copied().unwrap_or_default()
    }

    pub(super) fn texels(
        &self,
        source: &mut dyn Source,
        length: u64,
        meaning: Meaning,
        budget: &Budget,
        workers: Workers,
    ) -> Result<Texels, Error> {
        match self.read.texels {
            Some(texels) => texels(source, length, meaning, budget),
            None => (self.read.picture)(source, length, budget, workers).map(Texels::from),
        }
    }

    pub(super) fn stored(
        &self,
        source: &mut dyn Source,
        length: u64,
        budget: &Budget,
    ) -> Result<Stored, Error> {
        if let Some(stored) = self.read.stored {
            return stored(source, length, budget);
        }
        let picture = (self.read.picture)(source, length, budget, ALONE)?;
        let values = picture.color.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
        Ok(Stored::plain([picture.width as usize, picture.height as usize], 3, StoredValues::F32(values)))
    }
}

impl PartialEq for PictureFormat {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}
