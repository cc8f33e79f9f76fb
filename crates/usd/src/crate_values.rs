// SPDX-License-Identifier: GPL-3.0-or-later
//! A look at the values of a binary layer: lengths of arrays and lists, dictionaries within one another.
//! Source: the crate format of OpenUSD; numbers of types are its own. Tests: `tests/broken.rs`, `tests/arrays.rs`.

use std::collections::HashSet;

use crate::bytes::{Bytes, Fault, skip_integers};
use crate::crate_fields::PAYLOAD;

/// Dictionaries within one another.
const DEEPEST: u32 = 32;

/// A check of values under way.
pub(crate) struct Values<'a> {
    bytes: &'a Bytes<'a>,
    version: [u64; 3],
    /// Values that may still be looked at: a file may name the same one again and again.
    left: u64,
    /// Places of arrays within other values.
    nested: HashSet<u64>,
}

/// Bytes of an element of an array, by type; `None` = not of numbers.
fn size(kind: u64) -> Option<u64> {
    const SIZES: [u64; 31] = [
        0, 1, 1, 4, 4, 8, 8, 2, 4, 8, 0, 0, 0, 32, 72, 128, 32, 16, 8, 16, 8, 4, 8, 24, 12, 6, 12, 32, 16, 8,
        16,
    ];
    SIZES.get(kind as usize).copied().filter(|&size| size > 0).or((kind == 56).then_some(8))
}

impl<'a> Values<'a> {
    pub(crate) fn new(bytes: &'a Bytes<'a>, version: [u64; 3]) -> Self {
        Self { bytes, version, left: bytes.all.len() as u64 / 2 + 1024, nested: HashSet::new() }
    }

    /// The places of all arrays within dictionaries and samples.
    pub(crate) fn into_nested(self) -> HashSet<u64> {
        self.nested
    }

    /// Checks the value of a field.
    pub(crate) fn check(&mut self, value: u64) -> Result<(), Fault> {
        self.value(value, 0)
    }

    fn value(&mut self, value: u64, depth: u32) -> Result<(), Fault> {
        self.left = self.left.checked_sub(1).ok_or("the same values are named too often")?;
        let [is_array, is_inlined, is_compressed] = [63, 62, 61].map(|bit| value >> bit & 1 == 1);
        let (kind, at) = (value >> 48 & 0xff, value & PAYLOAD);
        if is_inlined || is_array && at == 0 {
            return Ok(());
        }
        match kind {
            _ if is_array && ((10..=12).contains(&kind) || kind == 57) => {
                // Tokens have the length of an array, the others that of a list.
                let (count, at) =
                    if kind == 11 { self.length(at)? } else { (self.bytes.number::<8>(at)?, at + 8) };
                self.bytes.capacity(at, count, 4)
            }
            _ if is_array => {
                if depth > 0 {
                    self.nested.insert(at);
                }
                self.array(kind, at, is_compressed)
            }
            31 => self.dictionary(at, depth).map(drop),
            32 | 33 | 34 | 54 => self.list(at, |values, at| values.items(at, 4)),
            36 | 38 => self.list(at, |values, at| values.items(at, 4)),
            37 | 39 => self.list(at, |values, at| values.items(at, 8)),
            35 => self.list(at, |values, at| values.references(at, depth)),
            55 => {
                let size = if self.version >= [0, 8, 0] { 24 } else { 8 };
                self.list(at, |values, at| values.items(at, size))
            }
            40 | 41 | 50 => self.items(at, 4).map(drop),
            45 | 48 | 58 => self.items(at, 8).map(drop),
            49 => self.items(at, 16).map(drop),
            46 => self.samples(at, depth),
            _ => self.bytes.number::<1>(at).map(drop),
        }
    }

    /// The length of an array, and where its data begin.
    fn length(&self, at: u64) -> Result<(u64, u64), Fault> {
        let at = if self.version < [0, 5, 0] { at + 4 } else { at };
        Ok(match self.version < [0, 7, 0] {
            true => (self.bytes.number::<4>(at)?, at + 4),
            false => (self.bytes.number::<8>(at)?, at + 8),
        })
    }

    fn array(&self, kind: u64, at: u64, is_compressed: bool) -> Result<(), Fault> {
        let size = size(kind).ok_or_else(|| format!("array of values of the unknown type {kind}"))?;
        let (count, at) = self.length(at)?;
        let is_packed = is_compressed && count >= 4;
        match kind {
            3..=6 if is_packed && self.version >= [0, 5, 0] => skip_integers(self.bytes, at, count).map(drop),
            7..=9 | 56 if is_packed && self.version >= [0, 6, 0] => {
                let table = self.bytes.number::<4>(at + 1)?;
                let at = match self.bytes.number::<1>(at)? as u8 {
                    b'i' => at + 1,
                    b't' => {
                        self.bytes.capacity(at + 5, table, size)?;
                        at + 5 + table * size
                    }
                    code => return Err(format!("array that is coded in the unknown way {code}")),
                };
                skip_integers(self.bytes, at, count).map(drop)
            }
            _ if is_compressed => {
                Err(format!("compressed array of values of type {kind}, which are never compressed"))
            }
            _ => self.bytes.capacity(at, count, size),
        }
    }

    /// The place behind a counted list of things of one size.
    fn items(&mut self, at: u64, size: u64) -> Result<u64, Fault> {
        let count = self.bytes.count(at, size)?;
        self.bytes.allow(count, 96)?;
        Ok(at + 8 + count * size)
    }

    fn list(
        &mut self,
        at: u64,
        mut items: impl FnMut(&mut Self, u64) -> Result<u64, Fault>,
    ) -> Result<(), Fault> {
        let header = self.bytes.number::<1>(at)?;
        let mut at = at + 1;
        for _ in 0..(header & 0b111_1110).count_ones() {
            at = items(self, at)?;
        }
        Ok(())
    }

    fn references(&mut self, at: u64, depth: u32) -> Result<u64, Fault> {
        let count = self.bytes.count(at, 32)?;
        self.bytes.allow(count, 256)?;
        (0..count).try_fold(at + 8, |at, _| self.dictionary(at + 24, depth))
    }

    /// A place that is told by how far it is from where it is told.
    fn leap(&self, at: u64) -> Result<u64, Fault> {
        let offset = self.bytes.number::<8>(at)? as i64;
        at.checked_add_signed(offset).ok_or_else(|| format!("damaged place at byte {at}"))
    }

    /// The place behind a dictionary.
    fn dictionary(&mut self, at: u64, depth: u32) -> Result<u64, Fault> {
        if depth >= DEEPEST {
            return Err(format!("dictionaries lie more than {DEEPEST} deep in one another"));
        }
        let count = self.bytes.number::<8>(at)?;
        let mut at = at + 8;
        for _ in 0..count {
            self.left = self.left.checked_sub(1).ok_or("the same dictionaries are named too often")?;
            let value = self.leap(at + 4)?;
            self.value(self.bytes.number::<8>(value)?, depth + 1)?;
            at = value + 8;
        }
        Ok(at)
    }

    fn samples(&mut self, at: u64, depth: u32) -> Result<(), Fault> {
        if depth >= DEEPEST {
            return Err("samples lie in one another".to_owned());
        }
        let times = self.leap(at)?;
        self.value(self.bytes.number::<8>(times)?, depth + 1)?;
        let list = self.leap(times + 8)?;
        let count = self.bytes.count(list, 8)?;
        for i in 0..count {
            self.value(self.bytes.number::<8>(list + 8 + 8 * i)?, depth + 1)?;
        }
        Ok(())
    }
}
