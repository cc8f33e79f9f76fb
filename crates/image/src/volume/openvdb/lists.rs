// SPDX-License-Identifier: GPL-3.0-or-later
//! Lists of values of a node: their type, their packing, and the unstored ones.
//! Source: the format of OpenVDB's files, versions 222 to 224 [Mus13]; original code. If only active values
//! are stored, a byte determines the others: the background, its negative, one or two values that follow.
//! Tests: `tests/volumes.rs`.

use crate::volume::blosc;
use crate::volume::bytes::{Bytes, corrupt};
use crate::volume::values::{Mask, Number, Value, Values};
use crate::{Budget, Error};

/// Type and packing of a grid's values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Format {
    /// As single values are stored; the background is one.
    pub(super) number: Number,
    /// Type in stored lists: may be halves for floats.
    pub(super) listed: Number,
    /// Numbers of a value: 1 or 3.
    pub(super) channels: usize,
    /// The file's flags: 1 for zlib, 2 for active values only, 4 for Blosc.
    pub(super) compression: u32,
}

impl Format {
    /// A single value.
    pub(super) fn value(&self, bytes: &mut Bytes<'_>) -> Result<Value, Error> {
        Ok(self.number.value(bytes.take(self.number.bytes() * self.channels)?))
    }

    /// `count` values as the file packs them.
    fn list(&self, bytes: &mut Bytes<'_>, count: usize) -> Result<Vec<f32>, Error> {
        let size = self.listed.bytes();
        let length = count * self.channels * size;
        if count == 0 && self.listed == Number::F16 {
            return Ok(Vec::new());
        }
        let packed;
        let stored = if self.compression & 5 == 0 {
            bytes.take(length)?
        } else {
            // Incompressible data is stored unchanged, with a negative length.
            let stored = bytes.i64()?;
            let part = usize::try_from(stored.unsigned_abs()).unwrap_or(usize::MAX);
            let part = bytes.take(part)?;
            if stored <= 0 {
                part
            } else if self.compression & 4 != 0 {
                packed = blosc::unpack(part, length)?;
                &packed
            } else {
                let mut whole = vec![0; length];
                blosc::inflate(part, &mut whole)?;
                packed = whole;
                &packed
            }
        };
        if stored.len() != length {
            return Err(corrupt(format!("{} bytes of values in place of {length}", stored.len())));
        }
        Ok(stored.chunks_exact(size).map(|stored| self.listed.read(stored)).collect())
    }

    /// The values of a node with this many positions, whose active ones are in `mask`.
    pub(super) fn values(
        &self,
        bytes: &mut Bytes<'_>,
        budget: &Budget,
        background: Value,
        (cells, mask): (usize, &Mask),
    ) -> Result<Values, Error> {
        const ALL: u8 = 6;
        let channels = self.channels;
        let how = bytes.u8()?;
        let mut inactive = [background; 2];
        match how {
            0 | ALL => {}
            1 | 3 => inactive[0] = background.map(|x| -x),
            2 | 4 => inactive[0] = self.value(bytes)?,
            5 => inactive = [self.value(bytes)?, self.value(bytes)?],
            _ => return Err(corrupt(format!("unknown storage {how} of values; 0 to 6 are valid"))),
        }
        let second = if matches!(how, 3..=5) { Some(Mask::read(bytes, cells)?) } else { None };
        let sparse = self.compression & 2 != 0 && how != ALL;
        let stored = if sparse { mask.count() } else { cells };
        let mut list = self.list(bytes, stored)?;
        if sparse {
            let mut whole = Vec::with_capacity(cells * channels);
            let mut next = list.chunks_exact(channels);
            for index in 0..cells {
                if mask.has(index) {
                    whole.extend_from_slice(next.next().unwrap_or_default());
                } else {
                    let other = second.as_ref().is_some_and(|second| second.has(index));
                    whole.extend_from_slice(&inactive[usize::from(other)][..channels]);
                }
            }
            list = whole;
        }
        Values::new(list, channels, budget)
    }
}
