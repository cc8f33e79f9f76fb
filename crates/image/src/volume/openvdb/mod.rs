// SPDX-License-Identifier: GPL-3.0-or-later
//! Files of OpenVDB: the header, and grids one behind the other.
//! Source: [Mus13]; original code. Files of versions 222 (2013) to 224 are read: grids of floats, doubles and integers, one or
//! three, with any compression that OpenVDB writes.
//! Invariant: examines each byte once, for any file.
//! Tests: `tests/volumes.rs`, whose files were written by OpenVDB.

mod lists;
mod tree;

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::bytes::{Bytes, corrupt, hold};
use super::grid::Grid;
use super::values::Number;
use crate::{Budget, Error};
use lists::Format;
use tree::Reader;

/// What files begin with.
pub(super) const MAGIC: [u8; 8] = 0x5644_4220_i64.to_le_bytes();

/// Bytes that a grid takes in addition to its tree and its name.
const GRID_BYTES: usize = 256;

/// The grids of numbers of a file, and the first other kind.
pub(super) fn read(bytes: &[u8], budget: &Budget) -> Result<(Vec<Grid>, Option<String>), Error> {
    let bytes = &mut Bytes::new(bytes);
    let has_offsets = header(bytes)?;
    skip_metadata(bytes)?;
    let (mut grids, mut other) = (Vec::new(), None);
    for _ in 0..bytes.u32()? {
        let [name, kind, parent] = [bytes.text()?, bytes.text()?, bytes.text()?];
        if !has_offsets {
            return Err(corrupt("the positions of its grids are missing"));
        }
        let [start, _, end] = [bytes.i64()?, bytes.i64()?, bytes.i64()?];
        // Each grid is behind the one before, so that no byte is read for more than one of them.
        let mut part = bytes.part(start, end)?;
        hold(budget, GRID_BYTES + name.len() + kind.len())?;
        match format_of(&kind) {
            Some(format) => {
                let grid = grid_of(&grids, &mut part, budget, (name, &parent), format)?;
                grids.push(grid);
            }
            None => other = other.or(Some(kind)),
        }
    }
    Ok((grids, other))
}

/// Reads one of the grids, which may share the contents of the known grid named `parent`.
fn grid_of(
    known: &[Grid],
    bytes: &mut Bytes<'_>,
    budget: &Budget,
    (name, parent): (String, &str),
    mut format: Format,
) -> Result<Grid, Error> {
    format.compression = bytes.u32()?;
    skip_metadata(bytes)?;
    let world_from_index = map(bytes)?;
    let tree = if parent.is_empty() {
        Arc::new(Reader { bytes, budget, format }.tree()?)
    } else {
        let known = known.iter().find(|grid| grid.whole_name() == parent);
        known.ok_or_else(|| corrupt(format!("grid \"{parent}\" missing, which \"{name}\" shares")))?.tree()
    };
    Grid::new(name, world_from_index, tree)
}

/// Reads the header up to the metadata: whether the file states the offsets of its grids.
fn header(bytes: &mut Bytes<'_>) -> Result<bool, Error> {
    bytes.take(MAGIC.len())?;
    let version = bytes.u32()?;
    if !(222..=224).contains(&version) {
        return Err(corrupt(format!("version {version} of OpenVDB; 222 to 224 are read")));
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
