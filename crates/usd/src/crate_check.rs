// SPDX-License-Identifier: GPL-3.0-or-later
//! A look at binary layers (`.usdc`) before the library reads them: sizes that it would believe, trees that never end.
//! Source: the crate format of OpenUSD, versions 0.4 and later.
//! Invariant: for a file that passes, the library takes no more memory than a multiple of its length. Tests: `tests/broken.rs`.

use std::collections::HashSet;

use crate::bytes::{Bytes, Fault, skip_integers};
use crate::crate_fields::Fields;
use crate::crate_parts::{entry, integers, tokens};
use crate::crate_values::Values;

/// The first bytes of a binary layer.
pub(crate) const MAGIC: &[u8] = b"PXR-USDC";
/// The greatest depth of nested prims.
pub(crate) const DEEPEST: usize = 256;

/// A layer that passed.
pub(crate) struct Checked {
    pub(crate) version: [u64; 3],
    pub(crate) fields: Fields,
    /// The places of arrays within dictionaries and samples.
    pub(crate) nested: HashSet<u64>,
}

/// Looks a layer over; `None` if it is good and has no fields.
pub(crate) fn check(all: &[u8]) -> Result<Option<Checked>, Fault> {
    let bytes = Bytes::new(all);
    let version = [8, 9, 10].map(|at| bytes.number::<1>(at).unwrap_or(0));
    if version < [0, 4, 0] {
        let [major, minor, patch] = version;
        return Err(format!(
            "version {major}.{minor}.{patch} of the binary format; 0.4.0 and later are read"
        ));
    }
    let start =
        |name: &[u8]| entry(&bytes, name).and_then(|at| at.map(|at| bytes.number::<8>(at + 16)).transpose());
    let tokens = tokens(&bytes)?;
    let mut lengths: Vec<u32> = tokens.split(|&byte| byte == 0).map(|token| token.len() as u32).collect();
    lengths.pop();
    if let Some(at) = start(b"STRINGS")? {
        bytes.count(at, 4)?;
    }
    if let Some(at) = start(b"FIELDSETS")? {
        let count = bytes.number::<8>(at)?;
        skip_integers(&bytes, at + 8, count)?;
    }
    if let Some(at) = start(b"PATHS")? {
        check_paths(&bytes, at, &lengths)?;
    }
    if let Some(at) = start(b"SPECS")? {
        let count = bytes.number::<8>(at)?;
        bytes.allow(count, 96)?;
        (0..3).try_fold(at + 8, |at, _| skip_integers(&bytes, at, count))?;
    }
    let Some(fields) = Fields::read(&bytes, tokens)? else { return Ok(None) };
    let mut looked = Values::new(&bytes, version);
    fields.values().try_for_each(|value| looked.check(value))?;
    Ok(Some(Checked { version, fields, nested: looked.into_nested() }))
}

/// That paths make a tree which is not too deep, and whose names are not too much text.
fn check_paths(bytes: &Bytes<'_>, at: u64, tokens: &[u32]) -> Result<(), Fault> {
    let (paths, count) = (bytes.number::<8>(at)?, bytes.number::<8>(at + 8)?);
    bytes.allow(paths, 48)?;
    let (indices, at) = integers(bytes, at + 16, count)?;
    let (names, at) = integers(bytes, at, count)?;
    let (jumps, _) = integers(bytes, at, count)?;
    let damaged = || "the tree of paths is damaged".to_owned();
    let mut is_seen = vec![false; indices.len()];
    let (mut pending, mut text) = (vec![(0_usize, 0_usize, 0_u64)], 0_u64);
    while let Some((mut index, depth, above)) = pending.pop().filter(|_| !indices.is_empty()) {
        if depth > DEEPEST {
            return Err(format!("prims lie more than {DEEPEST} deep in one another"));
        }
        loop {
            let seen = is_seen.get_mut(index).ok_or_else(damaged)?;
            let is_there = usize::try_from(indices[index]).is_ok_and(|index| (index as u64) < paths);
            let name = if index == 0 { Some(&0) } else { tokens.get(names[index].unsigned_abs() as usize) };
            let (false, true, Some(&name)) = (*seen, is_there, name) else { return Err(damaged()) };
            *seen = true;
            let length = above + u64::from(name) + 1;
            text += length;
            bytes.allow(text, 1)?;
            let jump = jumps[index];
            if jump > 0 || jump == -1 {
                pending.push((index + 1, depth + 1, length));
            }
            match jump {
                0 => index += 1,
                1.. => index += jump as usize,
                _ => break,
            }
        }
    }
    Ok(())
}
