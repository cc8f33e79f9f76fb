// SPDX-License-Identifier: GPL-3.0-or-later
//! The parts of a ZIP archive in memory.
//! Source: PKWARE, APPNOTE.TXT 6.3.10, sections 4.3 and 4.4: the central directory at the end names the parts,
//! stored or deflated. Archives of more than 4 GiB (ZIP64) are not read. Invariant: a part has the length that
//! the directory declares, and its budget is charged before it is unpacked. Tests: `tests/solids.rs`.

use std::io::Read;

use flate2::read::DeflateDecoder;
use gnurt_image::{Budget, Excess};

/// A part of an archive.
pub(super) struct Part<'a> {
    pub(super) name: String,
    packed: &'a [u8],
    length: usize,
    is_deflated: bool,
}

fn u16_at(bytes: &[u8], at: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(2)?)?;
    Some(usize::from(u16::from_le_bytes([bytes[0], bytes[1]])))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(4)?)?;
    usize::try_from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])).ok()
}

/// The parts of an archive; `None` if it is none.
pub(super) fn parts(bytes: &[u8]) -> Option<Vec<Part<'_>>> {
    // The end record is the last one, before a comment.
    const END: usize = 22;
    let first = bytes.len().saturating_sub(END + 65535);
    let last = bytes.len().checked_sub(END)?;
    let end = (first..=last).rev().find(|&at| bytes[at..].starts_with(b"PK\x05\x06"))?;
    let (count, mut at) = (u16_at(bytes, end + 10)?, u32_at(bytes, end + 16)?);
    let mut parts = Vec::new();
    for _ in 0..count {
        let entry = bytes.get(at..)?.strip_prefix(b"PK\x01\x02")?;
        // Offsets behind the signature are four less than the specification's.
        let (method, packed, length) = (u16_at(entry, 6)?, u32_at(entry, 16)?, u32_at(entry, 20)?);
        let [name, extra, comment] = [24, 26, 28].map(|at| u16_at(entry, at));
        let (name, extra, comment) = (name?, extra?, comment?);
        let local = u32_at(entry, 38)?;
        let text = String::from_utf8_lossy(entry.get(42..42 + name)?).into_owned();
        if ![0, 8].contains(&method) || u16_at(entry, 4)? & 1 != 0 {
            return None;
        }
        let header = bytes.get(local..)?.strip_prefix(b"PK\x03\x04")?;
        let start = 26 + u16_at(header, 22)? + u16_at(header, 24)?;
        let packed = header.get(start..start.checked_add(packed)?)?;
        parts.push(Part { name: text, packed, length, is_deflated: method == 8 });
        at = at.checked_add(46 + name + extra + comment)?;
    }
    Some(parts)
}

impl Part<'_> {
    /// Its contents; the error gives fault and remedy.
    pub(super) fn read(&self, budget: &Budget) -> Result<Vec<u8>, (String, &'static str)> {
        budget.hold(self.length).map_err(|excess| (excess.to_string(), Excess::REMEDY))?;
        let mut bytes = Vec::new();
        let limit = self.length as u64 + 1;
        let read = match self.is_deflated {
            true => DeflateDecoder::new(self.packed).take(limit).read_to_end(&mut bytes),
            false => self.packed.take(limit).read_to_end(&mut bytes),
        };
        match read {
            Ok(length) if length == self.length => Ok(bytes),
            _ => Err((format!("part {} is broken", self.name), "the file may have been cut off")),
        }
    }
}
