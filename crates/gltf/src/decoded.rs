// SPDX-License-Identifier: GPL-3.0-or-later
//! A decompressed primitive: arrays in place of accessors, and the types of their numbers.
//! Source: glTF 2.0 section 3.6.2.2. Tests: `tests/draco.rs`.

use super::json::Index;

/// Types of components, by glTF's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
    F64,
}

impl ComponentType {
    pub(super) fn of(number: u64) -> Option<Self> {
        Some(match number {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            // KHR_accessor_float64.
            5130 => Self::F64,
            _ => return None,
        })
    }
}

/// A decoded primitive.
pub(super) struct Decoded {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Vertices.
    pub(super) count: usize,
    pub(super) arrays: Vec<(Index, Array)>,
}

/// The values of an attribute, vertex by vertex, little-endian and without gaps.
pub(super) struct Array {
    pub(super) component: ComponentType,
    pub(super) components: usize,
    pub(super) bytes: Vec<u8>,
}

impl Decoded {
    /// The values that replace those of an accessor.
    pub(super) fn array(&self, accessor: Index) -> Option<&Array> {
        self.arrays.iter().find(|(index, _)| *index == accessor).map(|(_, array)| array)
    }
}
