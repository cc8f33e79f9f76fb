// SPDX-License-Identifier: GPL-3.0-or-later
//! The values of one node of a tree: their type, their packing, and the unstored ones.
//! Source: the format of OpenVDB's files, versions 222 to 224 [Mus13]; original code. If only active values
//! are stored, a byte determines the others: the background, its negative, one or two values that follow.
//! Tests: `tests/volumes.rs`.

use half::f16;

use super::blosc;
use super::bytes::{Bytes, corrupt, hold};
use crate::{Budget, Error};

/// Numbers as they are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    F16,
    F32,
    F64,
    I32,
    I64,
}

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

impl Number {
    fn bytes(self) -> usize {
        match self {
            Self::F16 => 2,
            Self::F32 | Self::I32 => 4,
            Self::F64 | Self::I64 => 8,
        }
    }

    /// A number of exactly [`bytes`](Self::bytes).
    fn read(self, bytes: &[u8]) -> f32 {
        let mut all = [0; 8];
        all[..bytes.len()].copy_from_slice(bytes);
        let [a, b, c, d, ..] = all;
        match self {
            Self::F16 => f16::from_le_bytes([a, b]).to_f32(),
            Self::F32 => f32::from_le_bytes([a, b, c, d]),
            Self::I32 => i32::from_le_bytes([a, b, c, d]) as f32,
            Self::F64 => f64::from_le_bytes(all) as f32,
            Self::I64 => i64::from_le_bytes(all) as f32,
        }
    }
}

/// A value of up to three numbers; those that a grid lacks are 0.
pub(super) type Value = [f32; 3];

impl Format {
    /// A single value.
    pub(super) fn value(&self, bytes: &mut Bytes<'_>) -> Result<Value, Error> {
        let size = self.number.bytes();
        let stored = bytes.take(size * self.channels)?;
        let mut value = [0.0; 3];
        for (value, stored) in value.iter_mut().zip(stored.chunks_exact(size)) {
            *value = self.number.read(stored);
        }
        Ok(value)
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
}

/// A bit for each position of a node.
pub(super) struct Mask(Vec<u64>);

impl Mask {
    pub(super) fn read(bytes: &mut Bytes<'_>, cells: usize) -> Result<Self, Error> {
        let mask_bits = bytes.take(cells / 8)?.chunks_exact(8);
        Ok(Self(
            mask_bits
                .map(|bits| bits.iter().rev().fold(0, |all, &byte| all << 8 | u64::from(byte)))
                .collect(),
        ))
    }

    pub(super) fn has(&self, index: usize) -> bool {
        self.0[index / 64] >> (index % 64) & 1 != 0
    }

    pub(super) fn mask_bits(&self) -> &[u64] {
        &self.0
    }

    /// The number of its positions.
    pub(super) fn count(&self) -> usize {
        self.0.iter().map(|bits| bits.count_ones() as usize).sum()
    }

    /// Its positions, in order.
    pub(super) fn cells(&self) -> impl Iterator<Item = usize> {
        self.0.iter().enumerate().flat_map(|(i, &bits)| {
            let mut left = bits;
            std::iter::from_fn(move || {
                let index = (left != 0).then(|| 64 * i + left.trailing_zeros() as usize);
                left &= left.wrapping_sub(1);
                index
            })
        })
    }
}

/// The values of a node, one after another; only one where all are the same.
pub(super) struct Values(Box<[f32]>);

impl Values {
    /// Reads those of a node with this many positions, whose active ones are in `mask`.
    pub(super) fn read(
        bytes: &mut Bytes<'_>,
        budget: &Budget,
        (format, background): (&Format, Value),
        (cells, mask): (usize, &Mask),
    ) -> Result<Self, Error> {
        const ALL: u8 = 6;
        let channels = format.channels;
        let how = bytes.u8()?;
        let mut inactive = [background; 2];
        match how {
            0 | ALL => {}
            1 | 3 => inactive[0] = background.map(|x| -x),
            2 | 4 => inactive[0] = format.value(bytes)?,
            5 => inactive = [format.value(bytes)?, format.value(bytes)?],
            _ => return Err(corrupt(format!("unknown storage {how} of values; 0 to 6 are valid"))),
        }
        let second = if matches!(how, 3..=5) { Some(Mask::read(bytes, cells)?) } else { None };
        let sparse = format.compression & 2 != 0 && how != ALL;
        let stored = if sparse { mask.count() } else { cells };
        let mut list = format.list(bytes, stored)?;
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
        if list.chunks_exact(channels).all(|value| value == &list[..channels]) {
            list.truncate(channels);
        }
        hold(budget, size_of_val(&*list))?;
        Ok(Self(list.into()))
    }

    pub(super) fn get(&self, index: usize, channels: usize) -> Value {
        let start = if self.0.len() == channels { 0 } else { index * channels };
        let mut value = [0.0; 3];
        value[..channels].copy_from_slice(&self.0[start..start + channels]);
        value
    }
}
