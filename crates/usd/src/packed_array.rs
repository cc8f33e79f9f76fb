// SPDX-License-Identifier: GPL-3.0-or-later
//! Long arrays of numbers in a binary layer, decoded when they are needed. Source: the crate format of OpenUSD.
//! Tests: `tests/arrays.rs`.

use std::ops::Range;
use std::sync::Arc;

use openusd::gf::{Vec2f, Vec3f, Vec4f};
use openusd::sdf::Value;

use crate::bytes::{Bytes, Fault};
use crate::crate_fields::PAYLOAD;
use crate::crate_parts::integers;
use crate::stand_in::Kind;

/// An array of a layer.
#[derive(Clone, Debug)]
pub(crate) struct PackedArray {
    layer: Arc<Vec<u8>>,
    pub(crate) kind: Kind,
    pub(crate) count: u64,
    is_compressed: bool,
    /// The place of its elements.
    at: u64,
}

impl PackedArray {
    pub(crate) const IS_COMPRESSED: u64 = 1 << 61;
    const IS_INLINED: u64 = 1 << 62;
    const IS_ARRAY: u64 = 1 << 63;

    /// The array that a checked value of a layer of version 0.7 or later is; `None` of other values.
    pub(crate) fn of(layer: &Arc<Vec<u8>>, value: u64) -> Option<Self> {
        let is_compressed = value & Self::IS_COMPRESSED != 0;
        let kind = match value >> 48 & 0xff {
            3 => Kind::Int,
            8 if !is_compressed => Kind::Floats(1),
            20 => Kind::Floats(2),
            24 => Kind::Floats(3),
            28 => Kind::Floats(4),
            _ => return None,
        };
        let at = value & PAYLOAD;
        let is_there = value & (Self::IS_ARRAY | Self::IS_INLINED) == Self::IS_ARRAY && at > 0;
        let count = is_there.then(|| Bytes::new(layer).number::<8>(at).ok()).flatten()?;
        Some(Self { layer: layer.clone(), kind, count, is_compressed, at: at + 8 })
    }

    /// All of its bytes, its length included.
    pub(crate) fn range(&self) -> Range<usize> {
        let size = match self.kind {
            _ if self.is_compressed => 8 + Bytes::new(&self.layer).number::<8>(self.at).unwrap_or(0),
            Kind::Int => 4 * self.count,
            Kind::Floats(width) => 4 * width as u64 * self.count,
        };
        let end = (self.at + size).min(self.layer.len() as u64);
        self.at as usize - 8..end as usize
    }

    /// The array.
    pub(crate) fn read(&self) -> Result<Value, Fault> {
        if self.is_compressed {
            return integers(&Bytes::new(&self.layer), self.at, self.count)
                .map(|(all, _)| Value::IntVec(all));
        }
        let bytes = &self.layer[self.range()][8..];
        Ok(match self.kind {
            Kind::Int => Value::IntVec(bytes.as_chunks().0.iter().map(|&x| i32::from_le_bytes(x)).collect()),
            Kind::Floats(1) => Value::FloatVec(floats(bytes).map(|[x]| x).collect()),
            Kind::Floats(2) => Value::Vec2fVec(floats(bytes).map(|[x, y]| Vec2f { x, y }).collect()),
            Kind::Floats(3) => Value::Vec3fVec(floats(bytes).map(|[x, y, z]| Vec3f { x, y, z }).collect()),
            Kind::Floats(_) => {
                Value::Vec4fVec(floats(bytes).map(|[x, y, z, w]| Vec4f { x, y, z, w }).collect())
            }
        })
    }
}

/// Vectors of so many floats.
fn floats<const N: usize>(bytes: &[u8]) -> impl Iterator<Item = [f32; N]> {
    bytes.as_chunks::<4>().0.as_chunks::<N>().0.iter().map(|vector| vector.map(f32::from_le_bytes))
}
