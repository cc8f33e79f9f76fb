// SPDX-License-Identifier: GPL-3.0-or-later
//! The values of one node of a tree: numbers of several types in a file, single ones in memory.
//! Source: [Mus13]; original code. Both formats have the same masks: bit i stands for position i.
//! Tests: `tests/volumes.rs`, `tests/nano_volumes.rs`.

use half::f16;

use super::bytes::{Bytes, hold};
use crate::{Budget, Error};

/// Numbers as they are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    F16,
    F32,
    F64,
    U8,
    I16,
    I32,
    U32,
    I64,
}

impl Number {
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::F16 | Self::I16 => 2,
            Self::F32 | Self::I32 | Self::U32 => 4,
            Self::F64 | Self::I64 => 8,
        }
    }

    /// A number of exactly [`bytes`](Self::bytes).
    pub(super) fn read(self, bytes: &[u8]) -> f32 {
        let mut all = [0; 8];
        all[..bytes.len()].copy_from_slice(bytes);
        let [a, b, c, d, ..] = all;
        match self {
            Self::F16 => f16::from_le_bytes([a, b]).to_f32(),
            Self::F32 => f32::from_le_bytes([a, b, c, d]),
            Self::U8 => f32::from(a),
            Self::I16 => f32::from(i16::from_le_bytes([a, b])),
            Self::I32 => i32::from_le_bytes([a, b, c, d]) as f32,
            Self::U32 => u32::from_le_bytes([a, b, c, d]) as f32,
            Self::F64 => f64::from_le_bytes(all) as f32,
            Self::I64 => i64::from_le_bytes(all) as f32,
        }
    }
}

/// A value of up to three numbers; those that a grid lacks are 0.
pub(super) type Value = [f32; 3];

impl Number {
    /// A value of so many numbers, one after another.
    pub(super) fn value(self, stored: &[u8]) -> Value {
        let mut value = [0.0; 3];
        for (value, stored) in value.iter_mut().zip(stored.chunks_exact(self.bytes())) {
            *value = self.read(stored);
        }
        value
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
    /// Those of a node, of so many numbers each.
    pub(super) fn new(mut list: Vec<f32>, channels: usize, budget: &Budget) -> Result<Self, Error> {
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
