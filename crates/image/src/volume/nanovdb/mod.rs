// SPDX-License-Identifier: GPL-3.0-or-later
//! Files of NanoVDB: segments of grids with any of its compressions, or grids alone, one behind the other.
//! Source: Museth, NanoVDB (2021) [Mus21]; original code. Files of the major version 32 (since 2021) are read: grids of floats,
//! doubles, integers, one or three, and floats in 1 to 16 bits. A grid's name is that of its segment, else its own.
//! Tests: `tests/nano_volumes.rs`, whose files were written by NanoVDB.

mod layout;
mod tree;

use std::borrow::Cow;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::blosc;
use super::bytes::{Bytes, corrupt, hold};
use super::grid::Grid;
use crate::{Budget, Error};
use layout::{GRID_BYTES, Layout, TREE_BYTES};
use tree::Reader;

/// What files and grids begin with; the eighth byte tells them apart since version 32.6.
const MAGIC: &[u8; 7] = b"NanoVDB";
/// The same of machines whose numbers begin with the highest byte.
const REVERSED: &[u8; 7] = b"BDVonaN";
const GRID_MAGIC: &[u8; 8] = b"NanoVDB1";
const VERSION: u32 = 32;
/// Most bytes of a part that Blosc packs.
const BLOSC_PART: usize = 1 << 30;
/// Bytes of a grid's description in a segment, without its name.
const DESCRIPTION: usize = 176;

/// Whether bytes begin as such a file.
pub(super) fn is_of(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || bytes.get(1..8).is_some_and(|bytes| bytes == REVERSED)
}

/// The grids of numbers of a file, and the first other type.
pub(super) fn read(bytes: &[u8], budget: &Budget) -> Result<(Vec<Grid>, Option<String>), Error> {
    if !bytes.starts_with(MAGIC) {
        return Err(corrupt("its numbers begin with the highest byte; write it on a machine like this one"));
    }
    let mut found = Found::default();
    let marks = [bytes.get(..8), bytes.get(664..672)];
    let mut bytes = Bytes::new(bytes);
    if marks.iter().any(|mark| mark.is_some_and(|mark| mark == GRID_MAGIC)) {
        while !bytes.is_at_end() {
            let length = Bytes::new(bytes.rest().get(32..).unwrap_or_default()).i64()?;
            let length = usize::try_from(length).ok().filter(|&length| length >= GRID_BYTES);
            let length = length.ok_or_else(|| corrupt("a grid is shorter than its head"))?;
            found.add(bytes.take(length)?, None, budget)?;
        }
    } else {
        while !bytes.is_at_end() {
            segment(&mut bytes, &mut found, budget)?;
        }
    }
    Ok((found.grids, found.other))
}

/// The same of one grid without a segment.
pub(super) fn read_grid(bytes: &[u8], budget: &Budget) -> Result<(Vec<Grid>, Option<String>), Error> {
    let mut found = Found::default();
    found.add(bytes, None, budget)?;
    Ok((found.grids, found.other))
}

/// Grids, and the first type that is none of numbers.
#[derive(Default)]
struct Found {
    grids: Vec<Grid>,
    other: Option<String>,
}

/// Checks a version.
fn check(version: u32) -> Result<(), Error> {
    let [major, minor] = [version >> 21, version >> 10 & 0x7ff];
    if major == VERSION {
        return Ok(());
    }
    Err(corrupt(format!(
        "version {major}.{minor} of NanoVDB; {VERSION}.0 and later ones of {VERSION} are read"
    )))
}

/// Reads a segment: a head, descriptions of grids, and the grids.
fn segment(bytes: &mut Bytes<'_>, found: &mut Found, budget: &Budget) -> Result<(), Error> {
    if !bytes.array::<8>()?.starts_with(MAGIC) {
        return Err(corrupt("a segment does not begin as those of NanoVDB do"));
    }
    check(bytes.u32()?)?;
    let counts = bytes.u32()?;
    let [count, codec] = [counts & 0xffff, counts >> 16];
    let mut described = Vec::new();
    for _ in 0..count {
        let description = &mut Bytes::new(bytes.take(DESCRIPTION)?);
        let [unpacked, packed] = [description.i64()?, description.i64()?];
        description.take(120)?;
        let name = bytes.take(description.u32()? as usize)?;
        hold(budget, size_of::<(i64, i64, &[u8])>())?;
        described.push((unpacked, packed, name));
    }
    for (unpacked, packed, name) in described {
        let [unpacked, packed] =
            [unpacked, packed].map(|length| usize::try_from(length).unwrap_or(usize::MAX));
        let grid = unpack(bytes.take(packed)?, unpacked, codec, budget)?;
        found.add(&grid, Some(name), budget)?;
    }
    Ok(())
}

/// The bytes of a grid.
fn unpack<'a>(packed: &'a [u8], length: usize, codec: u32, budget: &Budget) -> Result<Cow<'a, [u8]>, Error> {
    let mut bytes = Bytes::new(packed);
    // Blosc's parts are unpacked one by one.
    hold(budget, length.saturating_mul(codec as usize))?;
    let mut part = || {
        let length = usize::try_from(bytes.i64()?).unwrap_or(usize::MAX);
        bytes.take(length)
    };
    match codec {
        0 => Ok(Cow::Borrowed(packed)),
        1 => {
            let mut grid = vec![0; length];
            blosc::inflate(part()?, &mut grid)?;
            Ok(Cow::Owned(grid))
        }
        2 => {
            let mut grid = Vec::with_capacity(length);
            while grid.len() < length {
                grid.extend(blosc::unpack(part()?, (length - grid.len()).min(BLOSC_PART))?);
            }
            Ok(Cow::Owned(grid))
        }
        _ => Err(corrupt(format!("unknown compression {codec}; 0 (none), 1 (zlib) and 2 (Blosc) are read"))),
    }
}

/// The text before the first zero byte.
fn text(bytes: &[u8]) -> String {
    let text = bytes.split(|&byte| byte == 0).next().unwrap_or_default();
    String::from_utf8_lossy(text).into_owned()
}

impl Found {
    /// Reads a grid.
    fn add(&mut self, grid: &[u8], name: Option<&[u8]>, budget: &Budget) -> Result<(), Error> {
        let bytes = &mut Bytes::new(grid);
        if !bytes.array::<8>()?.starts_with(MAGIC) {
            return Err(corrupt("a grid does not begin as those of NanoVDB do"));
        }
        bytes.take(8)?;
        check(bytes.u32()?)?;
        bytes.take(20)?;
        let own = bytes.take(256)?;
        let name = text(name.unwrap_or(own));
        // The same map in single precision, and its inverse.
        bytes.take(88)?;
        let mut row = || Ok::<_, Error>(DVec3::new(bytes.f64()?, bytes.f64()?, bytes.f64()?));
        let rows = [row()?, row()?, row()?];
        (0..3).try_for_each(|_| row().map(drop))?;
        let translation = row()?;
        let matrix3 = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        // The last number of the map, bounds, the size of a voxel, and the class.
        bytes.take(8 + 48 + 24 + 4)?;
        let layout = match Layout::of_type(bytes.u32()?) {
            Ok(layout) => layout,
            Err(other) => {
                self.other.get_or_insert(other);
                return Ok(());
            }
        };
        let tree = &mut Bytes::new(grid.get(GRID_BYTES..).unwrap_or_default());
        let nodes = &mut Bytes::new(tree.take(TREE_BYTES)?);
        // Leaves, lower and upper nodes: found through their parents.
        nodes.take(24)?;
        let root = nodes.i64()?;
        hold(budget, size_of::<Grid>() + name.len())?;
        let tree = Reader::new(grid, layout, budget).tree(root)?;
        self.grids.push(Grid::new(name, DAffine3 { matrix3, translation }, Arc::new(tree))?);
        Ok(())
    }
}
