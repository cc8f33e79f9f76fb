// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts of a binary layer: sections, compressed blocks, integers and tokens. Each is checked before memory is taken.
//! Source: the crate format of OpenUSD. Tests: `tests`, `tests/broken.rs`.

use crate::bytes::{Bytes, Fault, skip_integers};

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

/// Compressed integers of 32 bits, and the place behind them.
pub(crate) fn integers(bytes: &Bytes<'_>, at: u64, count: u64) -> Result<(Vec<i32>, u64), Fault> {
    let end = skip_integers(bytes, at, count)?;
    if count == 0 {
        return Ok((Vec::new(), end));
    }
    let codes = count.div_ceil(4);
    let packed = unpack(bytes, at, 4 + codes + 4 * count)?;
    let values =
        steps(&packed, count as usize).ok_or_else(|| format!("integers at byte {at} are damaged"))?;
    Ok((values, end))
}

/// Integers that are told by the steps between them: the commonest step, the size of each, and the others.
fn steps(packed: &[u8], count: usize) -> Option<Vec<i32>> {
    /// Bytes by code; the commonest step has none.
    const WIDTHS: [usize; 4] = [0, 1, 2, 4];
    let (&common, rest) = packed.split_first_chunk::<4>()?;
    let common = i32::from_le_bytes(common);
    let (codes, mut steps) = rest.split_at_checked(count.div_ceil(4))?;
    let (mut values, mut value) = (Vec::with_capacity(count), 0_i32);
    for (i, &code) in codes.iter().enumerate() {
        // Four steps are 16 bytes at most; behind the last ones are zeros.
        let mut last = [0; 16];
        let mut four = match steps.first_chunk::<16>() {
            Some(four) => four,
            None => {
                last[..steps.len()].copy_from_slice(steps);
                &last
            }
        }
        .as_slice();
        let mut used = 0;
        for k in 0..4.min(count - 4 * i) {
            let width = WIDTHS[usize::from(code >> (2 * k) & 3)];
            let step = match width {
                0 => common,
                _ => {
                    let (bytes, unused) = (four.first_chunk::<4>().copied(), 32 - 8 * width);
                    i32::from_le_bytes(bytes.unwrap_or_default()) << unused >> unused
                }
            };
            four = &four[width..];
            used += width;
            value = value.wrapping_add(step);
            values.push(value);
        }
        steps = steps.get(used..)?;
    }
    Some(values)
}

/// All tokens, a zero behind each; empty in a layer that has none.
pub(crate) fn tokens(bytes: &Bytes<'_>) -> Result<Vec<u8>, Fault> {
    let Some(entry) = entry(bytes, b"TOKENS")? else { return Ok(Vec::new()) };
    let at = bytes.number::<8>(entry + 16)?;
    let (count, size) = (bytes.number::<8>(at)?, bytes.number::<8>(at + 8)?);
    bytes.allow(count, 48)?;
    let text = unpack(bytes, at + 16, size)?;
    let there = text.iter().filter(|&&byte| byte == 0).count() as u64;
    if text.len() as u64 != size || there != count {
        return Err(format!("{count} names are declared, {there} are there"));
    }
    Ok(text)
}
