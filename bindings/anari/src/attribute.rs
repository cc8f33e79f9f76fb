// SPDX-License-Identifier: GPL-3.0-or-later
//! Attributes of surface points, which materials and samplers read by name.
//! Source: ANARI 1.1, section on attributes: components that an attribute lacks are 0, the fourth is 1.
//! Tests: tests/attributes.rs.

/// Four floats.
pub(crate) type Color = [f32; 4];

/// An attribute that is not there.
pub(crate) const NOTHING: Color = [0.0, 0.0, 0.0, 1.0];

/// How many attributes arrays may hold.
pub(crate) const FREE: usize = 5;
/// Their names: a parameter's name is `RATE.NAME`.
pub(crate) const NAMES: [&str; FREE] = ["color", "attribute0", "attribute1", "attribute2", "attribute3"];

/// Which attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Attribute {
    /// Of [`NAMES`].
    Free(usize),
    WorldPosition,
    WorldNormal,
    ObjectPosition,
    ObjectNormal,
    PrimitiveId,
}

impl Attribute {
    /// The attribute of a name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        if let Some(index) = NAMES.iter().position(|free| *free == name) {
            return Some(Self::Free(index));
        }
        Some(match name {
            "worldPosition" => Self::WorldPosition,
            "worldNormal" => Self::WorldNormal,
            "objectPosition" => Self::ObjectPosition,
            "objectNormal" => Self::ObjectNormal,
            "primitiveId" => Self::PrimitiveId,
            _ => return None,
        })
    }
}

/// A point that has attributes.
pub(crate) trait Point {
    /// The value of an attribute there.
    fn attribute(&self, which: Attribute) -> Color;

    /// Its primitive, counted from 0.
    fn primitive(&self) -> u32;
}

/// A sum of two values by share.
pub(crate) fn mix(a: Color, b: Color, share: f32) -> Color {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * share)
}

/// A sum of three values by weights.
pub(crate) fn weighted(values: [Color; 3], weights: [f32; 3]) -> Color {
    std::array::from_fn(|k| (0..3).map(|i| values[i][k] * weights[i]).sum())
}

/// The value of a list at a place from 0, its first, to 1, its last. Panics on an empty list.
pub(crate) fn between(list: &[Color], fraction: f32) -> Color {
    let x = fraction * (list.len() - 1) as f32;
    let first = (x as usize).min(list.len() - 1);
    mix(list[first], list[(first + 1).min(list.len() - 1)], x - first as f32)
}
