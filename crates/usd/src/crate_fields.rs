// SPDX-License-Identifier: GPL-3.0-or-later
//! The table of fields of a binary layer: the name of each, and its value or where that is. It can be written again.
//! Source: the crate format of OpenUSD, section `FIELDS`. Tests: `tests/save.rs`, `tests/arrays.rs`.

use std::ops::Range;

use crate::bytes::{Bytes, Fault, skip_integers};
use crate::crate_parts::{entry, integers, unpack};

/// The bits of a place.
pub(crate) const PAYLOAD: u64 = 0xffff_ffff_ffff;

/// The fields of a layer.
pub(crate) struct Fields {
    /// The place of the section's entry in the table of sections.
    pub(crate) entry: u64,
    /// The name of each, a number of a token.
    pub(crate) names: Vec<i32>,
    /// The value of each in 8 bytes.
    pub(crate) values: Vec<u8>,
    /// All tokens, a zero behind each.
    tokens: Vec<u8>,
    /// Where the number of fields and the packed names are.
    head: Range<usize>,
}

impl Fields {
    /// The fields, whose names are among these tokens; `None` in a layer that has none.
    pub(crate) fn read(bytes: &Bytes<'_>, tokens: Vec<u8>) -> Result<Option<Self>, Fault> {
        let Some(entry_of_fields) = entry(bytes, b"FIELDS")? else { return Ok(None) };
        let begin = bytes.number::<8>(entry_of_fields + 16)?;
        let count = bytes.number::<8>(begin)?;
        skip_integers(bytes, begin + 8, count)?;
        bytes.allow(count, 24)?;
        let (names, end) = integers(bytes, begin + 8, count)?;
        let values = unpack(bytes, end, count * 8)?;
        Ok(Some(Self { entry: entry_of_fields, names, values, tokens, head: begin as usize..end as usize }))
    }

    /// All tokens.
    pub(crate) fn tokens(&self) -> Vec<&[u8]> {
        self.tokens.split(|&byte| byte == 0).collect()
    }

    /// The values of all fields.
    pub(crate) fn values(&self) -> impl Iterator<Item = u64> {
        self.values.as_chunks::<8>().0.iter().map(|&value| u64::from_le_bytes(value))
    }

    /// The section with other values, of which there are as many.
    pub(crate) fn section(&self, layer: &[u8], values: &[u8]) -> Vec<u8> {
        let packed = lz4_flex::block::compress(values);
        let mut section = layer[self.head.clone()].to_vec();
        section.extend_from_slice(&(packed.len() as u64 + 1).to_le_bytes());
        // One piece.
        section.push(0);
        section.extend(packed);
        section
    }
}
