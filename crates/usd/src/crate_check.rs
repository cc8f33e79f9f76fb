// SPDX-License-Identifier: GPL-3.0-or-later
//! A look at binary layers (`.usdc`) before the library reads them: sizes that it would believe, trees that never end.
//! Source: the crate format of OpenUSD, versions 0.4 and later.
//! Invariant: for a file that passes, the library takes no more memory than a multiple of its length. Tests: `tests/broken.rs`.

use crate::bytes::{Bytes, Fault, skip_integers};
use crate::crate_values::Values;

/// The first bytes of a binary layer.
pub(crate) const MAGIC: &[u8] = b"PXR-USDC";
/// The greatest depth of nested prims.
pub(crate) const DEEPEST: usize = 256;
/// Looks a layer over.
pub(crate) fn check(all: &[u8]) -> Result<(), Fault> {
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
    let mut lengths = Vec::new();
    if let Some(at) = start(b"TOKENS")? {
        lengths = token_lengths(&bytes, at)?;
    }
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
    if let Some(at) = start(b"FIELDS")? {
        let count = bytes.number::<8>(at)?;
        let at = skip_integers(&bytes, at + 8, count)?;
        bytes.allow(count, 24)?;
        let values = unpack(&bytes, at, count * 8)?;
        let mut looked = Values::new(&bytes, version);
        for value in values.chunks_exact(8) {
            looked.check(value.iter().rev().fold(0, |sum, &digit| sum << 8 | u64::from(digit)))?;
        }
    }
    Ok(())
}

/// The place of a section's entry in the table of sections: its name, start and size.
pub(crate) fn entry(bytes: &Bytes<'_>, name: &[u8]) -> Result<Option<u64>, Fault> {
    let table = bytes.number::<8>(16)?;
    let sections = bytes.count(table, 32)?;
    if sections >= 64 {
        return Err(format!("{sections} sections are declared; there are six"));
    }
    Ok((0..sections).map(|section| table + 8 + 32 * section).find(|&at| {
        let found = &bytes.all[at as usize..at as usize + 16];
        found.starts_with(name) && found.get(name.len()) == Some(&0)
    }))
}

/// The bytes of an LZ4 block behind its length, at most `most` of them.
pub(crate) fn unpack(bytes: &Bytes<'_>, at: u64, most: u64) -> Result<Vec<u8>, Fault> {
    let length = bytes.count(at, 1)?;
    bytes.allow(most, 1)?;
    let begin = at as usize + 8;
    let damaged = || format!("compressed data at byte {at} is damaged");
    let (&chunks, packed) = bytes.all[begin..begin + length as usize].split_first().ok_or_else(damaged)?;
    if chunks != 0 {
        return Err(format!("compressed data at byte {at} is in {chunks} pieces; one is read"));
    }
    // No more than the block can become.
    let capacity = most.min(packed.len() as u64 * 255 + 64);
    let mut unpacked = vec![0; capacity as usize];
    let length = lz4_flex::decompress_into(packed, &mut unpacked).map_err(|_| damaged())?;
    unpacked.truncate(length);
    Ok(unpacked)
}

/// Compressed integers of 32 bits.
pub(crate) fn integers(bytes: &Bytes<'_>, at: u64, count: u64) -> Result<(Vec<i32>, u64), Fault> {
    let end = skip_integers(bytes, at, count)?;
    let damaged = || format!("integers at byte {at} are damaged");
    if count == 0 {
        return Ok((Vec::new(), end));
    }
    let codes = count.div_ceil(4);
    let packed = unpack(bytes, at, 4 + codes + 4 * count)?;
    let take = |at: &mut usize, width: usize| {
        let digits = packed.get(*at..*at + width).ok_or_else(damaged)?;
        *at += width;
        let mut whole = [if digits[width - 1] >= 128 { 255 } else { 0 }; 4];
        whole[..width].copy_from_slice(digits);
        Ok::<i32, Fault>(i32::from_le_bytes(whole))
    };
    let common = take(&mut 0, 4)?;
    let mut next = 4 + codes as usize;
    let (mut values, mut value) = (Vec::with_capacity(count as usize), 0_i32);
    for i in 0..count as usize {
        let code = packed.get(4 + i / 4).ok_or_else(damaged)? >> (2 * (i % 4)) & 3;
        let step = match code {
            0 => common,
            1 => take(&mut next, 1)?,
            2 => take(&mut next, 2)?,
            _ => take(&mut next, 4)?,
        };
        value = value.wrapping_add(step);
        values.push(value);
    }
    Ok((values, end))
}

/// All tokens, a zero behind each.
pub(crate) fn tokens(bytes: &Bytes<'_>, at: u64) -> Result<Vec<u8>, Fault> {
    let (count, size) = (bytes.number::<8>(at)?, bytes.number::<8>(at + 8)?);
    bytes.allow(count, 48)?;
    let text = unpack(bytes, at + 16, size)?;
    let there = text.iter().filter(|&&byte| byte == 0).count() as u64;
    if text.len() as u64 != size || there != count {
        return Err(format!("{count} names are declared, {there} are there"));
    }
    Ok(text)
}

/// The lengths of all tokens.
fn token_lengths(bytes: &Bytes<'_>, at: u64) -> Result<Vec<u32>, Fault> {
    let text = tokens(bytes, at)?;
    let mut lengths: Vec<u32> = text.split(|&byte| byte == 0).map(|token| token.len() as u32).collect();
    lengths.pop();
    Ok(lengths)
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
