// SPDX-License-Identifier: GPL-3.0-or-later
//! An attribute's arrays: one value for all, for each primitive, vertex or corner; the finest one counts.
//! Tests: tests/attributes.rs.

use crate::attribute::{Color, FREE, NAMES};
use crate::ffi_array::Array;
use crate::object::Snapshot;
use crate::types;

/// An attribute's values.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rates {
    pub(crate) constant: Option<Color>,
    pub(crate) primitive: Vec<Color>,
    pub(crate) vertex: Vec<Color>,
    /// One after the other for each primitive.
    pub(crate) corner: Vec<Color>,
}

/// The numbers of an array of this name, as four floats each; empty where there are none.
pub(crate) fn list(now: &Snapshot, name: &str) -> Vec<Color> {
    let array = now.object(name, types::ARRAY1D).and_then(|array| Array::of(array));
    array.and_then(Array::colors).unwrap_or_default()
}

impl Rates {
    /// All attributes of a geometry.
    pub(crate) fn all(now: &Snapshot) -> [Self; FREE] {
        NAMES.map(|name| Self {
            constant: now.color(name),
            primitive: list(now, &format!("primitive.{name}")),
            vertex: list(now, &format!("vertex.{name}")),
            corner: list(now, &format!("faceVarying.{name}")),
        })
    }
}
