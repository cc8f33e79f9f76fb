// SPDX-License-Identifier: GPL-3.0-or-later
//! Volumes: numbers at points of space, in sparse grids, as OpenVDB's files hold them.
//! Source: Museth, VDB: High-Resolution Sparse Volumes with Dynamic Topology (2013) [Mus13]; original code. Files of versions 222 (2013)
//! to 224 are read: grids of floats, doubles and integers, one or three, with any compression that OpenVDB writes.
//! Space: a grid has whole coordinates of voxels (index), which an affine map takes to the space of its file (world).
//! Invariant: reading takes no more memory than is allowed and its length accounts for, and examines each
//! byte once, for any file.
//! Tests: `tests/volumes.rs`, whose files were written by OpenVDB.

mod blosc;
mod bytes;
mod tree;
mod values;

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::file::open_regular;
use crate::{Budget, Error};
use bytes::{Bytes, corrupt, hold, too_large};
use tree::{LEAF_SIZE, Reader, Tree};
use values::{Format, Number};

/// Bytes that a grid takes in addition to its tree and its name.
const GRID_BYTES: usize = 256;

/// The grids of a file.
#[derive(Debug)]
pub struct Volume {
    grids: Vec<Grid>,
}

/// Numbers at points of space: one or three at each.
#[derive(Clone)]
pub struct Grid {
    name: String,
    channels: usize,
    index_from_world: DAffine3,
    tree: Arc<Tree>,
}

impl std::fmt::Debug for Grid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Grid")
            .field("name", &self.name)
            .field("channels", &self.channels)
            .finish_non_exhaustive()
    }
}

impl Volume {
    /// Reads a regular file of at most `limit` bytes; its contents take at most the same number of bytes of
    /// memory, and no more than its length accounts for, in addition to the file itself.
    ///
    /// # Errors
    /// The file cannot be read, is no regular file, is no OpenVDB file, is broken, holds no numbers, or takes
    /// too much memory.
    pub fn read(path: &Path, limit: usize) -> Result<Self, Error> {
        let (source, length) =
            open_regular(path).map_err(|fault| fault.in_file(path, "a file of OpenVDB"))?;
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
        let bytes = &mut Bytes::new(bytes);
        let has_offsets = header(bytes)?;
        skip_metadata(bytes)?;
        let mut volume = Self { grids: Vec::new() };
        let mut others = Vec::new();
        for _ in 0..bytes.u32()? {
            let [name, kind, parent] = [bytes.text()?, bytes.text()?, bytes.text()?];
            if !has_offsets {
                return Err(corrupt("the positions of its grids are missing"));
            }
            let [start, _, end] = [bytes.i64()?, bytes.i64()?, bytes.i64()?];
            // Each grid is behind the one before, so that no byte is read for more than one of them.
            let part = bytes.part(start, end)?;
            hold(budget, GRID_BYTES + name.len() + kind.len())?;
            if let Some(format) = format_of(&kind) {
                let grid = volume.grid_of(&mut { part }, budget, (name, &parent), format)?;
                volume.grids.push(grid);
            } else if others.is_empty() {
                others.push(kind);
            }
        }
        match (&*volume.grids, &*others) {
            ([], []) => Err(corrupt("no grids")),
            ([], [kind, ..]) => Err(corrupt(format!(
                "no grid of numbers (the first is a {kind}); grids of floats, doubles and integers, one or three, are read"
            ))),
            _ => Ok(volume),
        }
    }

    /// Reads one of the grids, which may share the contents of the grid named `parent`.
    fn grid_of(
        &self,
        bytes: &mut Bytes<'_>,
        budget: &Budget,
        (name, parent): (String, &str),
        mut format: Format,
    ) -> Result<Grid, Error> {
        format.compression = bytes.u32()?;
        skip_metadata(bytes)?;
        let world_from_index = map(bytes)?;
        let index_from_world = world_from_index.inverse();
        if !index_from_world.is_finite() {
            return Err(corrupt(format!("the map of the grid \"{name}\" has no inverse")));
        }
        let tree = if parent.is_empty() {
            Arc::new(Tree::read(&mut Reader { bytes, budget, format })?)
        } else {
            let known = self.grids.iter().find(|grid| grid.name == parent);
            let known = known
                .ok_or_else(|| corrupt(format!("grid \"{parent}\" missing, which \"{name}\" shares")))?;
            known.tree.clone()
        };
        Ok(Grid { name, channels: format.channels, index_from_world, tree })
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

impl Grid {
    /// Its name, which others of the file may have as well.
    #[must_use]
    pub fn name(&self) -> &str {
        // A sign that is none of a text parts a name from a number where there are several of the name.
        self.name.split('\u{1e}').next().unwrap_or_default()
    }

    /// Numbers of a voxel: 1 or 3.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// From the file's world to coordinates in which voxels lie at whole numbers.
    #[must_use]
    pub fn index_from_world(&self) -> DAffine3 {
        self.index_from_world
    }

    /// The numbers of a voxel; those beyond [`channels`](Self::channels) are 0. A voxel that was not stored
    /// has the background.
    #[must_use]
    #[inline]
    pub fn voxel(&self, at: [i32; 3]) -> [f32; 3] {
        self.tree.get(at)
    }

    /// The first and the last active voxel along each axis; none where no voxel is active.
    #[must_use]
    pub fn active(&self) -> Option<[[i32; 3]; 2]> {
        self.tree.active
    }

    /// The same, rounded to whole leaves of the tree: the picture's size in other programs.
    #[must_use]
    pub fn window(&self) -> Option<[[i32; 3]; 2]> {
        let mask = LEAF_SIZE - 1;
        self.active().map(|[first, last]| [first.map(|x| x & !mask), last.map(|x| x | mask)])
    }
}

/// Reads the header up to the metadata: whether the file states the offsets of its grids.
fn header(bytes: &mut Bytes<'_>) -> Result<bool, Error> {
    const MAGIC: i64 = 0x5644_4220;
    if !bytes.i64().is_ok_and(|magic| magic == MAGIC) {
        return Err(corrupt("it does not begin as files of OpenVDB do"));
    }
    let version = bytes.u32()?;
    if !(222..=224).contains(&version) {
        return Err(corrupt(format!("version {version}; 222 to 224 are read")));
    }
    // The library's own version.
    bytes.take(8)?;
    let has_offsets = bytes.u8()? != 0;
    // A number that identifies the file.
    bytes.take(36)?;
    Ok(has_offsets)
}

/// Passes over metadata: nothing of it is needed.
fn skip_metadata(bytes: &mut Bytes<'_>) -> Result<(), Error> {
    for _ in 0..bytes.u32()? {
        bytes.text()?;
        bytes.text()?;
        let length = bytes.u32()? as usize;
        bytes.take(length)?;
    }
    Ok(())
}

/// How the values of a tree of such a type are stored, if they are numbers.
fn format_of(kind: &str) -> Option<Format> {
    let (kind, half) = match kind.strip_suffix("_HalfFloat") {
        Some(kind) => (kind, true),
        None => (kind, false),
    };
    let (number, channels) = match kind.strip_prefix("Tree_")?.strip_suffix("_5_4_3")? {
        "float" => (Number::F32, 1),
        "double" => (Number::F64, 1),
        "int32" => (Number::I32, 1),
        "int64" => (Number::I64, 1),
        "vec3s" => (Number::F32, 3),
        "vec3d" => (Number::F64, 3),
        "vec3i" => (Number::I32, 3),
        _ => return None,
    };
    let listed = if half && matches!(number, Number::F32 | Number::F64) { Number::F16 } else { number };
    Some(Format { number, listed, channels, compression: 0 })
}

/// Reads the transform from voxels to the world.
fn map(bytes: &mut Bytes<'_>) -> Result<DAffine3, Error> {
    let kind = bytes.text()?;
    let mut vector = || Ok::<_, Error>(DVec3::new(bytes.f64()?, bytes.f64()?, bytes.f64()?));
    Ok(match &*kind {
        // Values derived from the scale follow it.
        "UniformScaleMap" | "ScaleMap" => {
            let scale = vector()?;
            (0..4).try_for_each(|_| vector().map(drop))?;
            DAffine3::from_scale(scale)
        }
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let (offset, scale) = (vector()?, vector()?);
            (0..4).try_for_each(|_| vector().map(drop))?;
            DAffine3 { matrix3: DMat3::from_diagonal(scale), translation: offset }
        }
        "TranslationMap" => DAffine3::from_translation(vector()?),
        // Rows of four; points are rows, too.
        "AffineMap" | "UnitaryMap" => {
            let mut row =
                || Ok::<_, Error>((DVec3::new(bytes.f64()?, bytes.f64()?, bytes.f64()?), bytes.f64()?).0);
            let [x, y, z, offset] = [row()?, row()?, row()?, row()?];
            DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: offset }
        }
        _ => {
            return Err(corrupt(format!(
                "unsupported map {kind}; scales, translations and affine maps are supported"
            )));
        }
    })
}
