// SPDX-License-Identifier: GPL-3.0-or-later
//! The meaning of each property of a PLY vertex. Names as Blender, MeshLab, PBRT, Stanford and VTK write
//! them. Integer colours are sRGB-encoded, those of floats linear. Tests:
//! `tests/ply.rs::headers_of_all_kinds`.

use super::header::{Element, Property, Scalar};

/// Where a property of a vertex goes.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Slot {
    Position(usize),
    Normal(usize),
    Texcoord(usize),
    Color(usize),
    /// Unused.
    None,
}

impl Slot {
    pub(super) fn of(property: &Property) -> Self {
        if property.count.is_some() {
            return Self::None;
        }
        match &property.name[..] {
            "x" => Self::Position(0),
            "y" => Self::Position(1),
            "z" => Self::Position(2),
            "nx" => Self::Normal(0),
            "ny" => Self::Normal(1),
            "nz" => Self::Normal(2),
            "u" | "s" | "texture_u" | "texture_s" | "texcoord_u" => Self::Texcoord(0),
            "v" | "t" | "texture_v" | "texture_t" | "texcoord_v" => Self::Texcoord(1),
            "red" | "r" | "diffuse_red" => Self::Color(0),
            "green" | "g" | "diffuse_green" => Self::Color(1),
            "blue" | "b" | "diffuse_blue" => Self::Color(2),
            "alpha" | "a" | "diffuse_alpha" => Self::Color(3),
            _ => Self::None,
        }
    }
}

/// Which values the vertices of a file have.
#[derive(Clone, Copy)]
pub(super) struct Columns {
    pub(super) positions: bool,
    pub(super) normals: bool,
    pub(super) texcoords: bool,
    pub(super) colors: bool,
}

impl Columns {
    /// A value counts only if all of its components are there; opacity may be missing.
    pub(super) fn of(element: &Element) -> Self {
        let has = |slot: Slot| element.properties.iter().any(|property| Slot::of(property) == slot);
        Self {
            positions: (0..3).all(|k| has(Slot::Position(k))),
            normals: (0..3).all(|k| has(Slot::Normal(k))),
            texcoords: (0..2).all(|k| has(Slot::Texcoord(k))),
            colors: (0..3).all(|k| has(Slot::Color(k))),
        }
    }

    /// Bytes that a vertex takes.
    pub(super) fn vertex_bytes(self) -> usize {
        12 + if self.normals { 12 } else { 0 }
            + if self.texcoords { 8 } else { 0 }
            + if self.colors { 16 } else { 0 }
    }
}

/// A vertex: an attribute that is not in the file keeps its neutral value.
#[derive(Clone, Copy)]
pub(super) struct Vertex {
    pub(super) position: [f64; 3],
    pub(super) normal: [f32; 3],
    pub(super) texcoord: [f32; 2],
    pub(super) color: [f32; 4],
}

impl Vertex {
    pub(super) const NEUTRAL: Self =
        Self { position: [0.0; 3], normal: [0.0; 3], texcoord: [0.0; 2], color: [1.0; 4] };

    pub(super) fn set(&mut self, slot: Slot, value: f64, of_type: Scalar) {
        match slot {
            Slot::Position(k) => self.position[k] = value,
            Slot::Normal(k) => self.normal[k] = value as f32,
            Slot::Texcoord(k) => self.texcoord[k] = value as f32,
            Slot::Color(3) => self.color[3] = fraction(value, of_type),
            Slot::Color(k) => self.color[k] = linear(value, of_type),
            Slot::None => {}
        }
    }
}

/// Integers as shares of their largest value, floats as they are.
fn fraction(value: f64, of_type: Scalar) -> f32 {
    let largest = match of_type {
        Scalar::I8 => f64::from(i8::MAX),
        Scalar::U8 => f64::from(u8::MAX),
        Scalar::I16 => f64::from(i16::MAX),
        Scalar::U16 => f64::from(u16::MAX),
        // Files that declare colours as `int` hold bytes.
        Scalar::I32 | Scalar::U32 => f64::from(u8::MAX),
        Scalar::F32 | Scalar::F64 => 1.0,
    };
    (value as f32 / largest as f32).max(0.0)
}

/// Integers are sRGB-encoded, floats linear.
fn linear(value: f64, of_type: Scalar) -> f32 {
    let x = fraction(value, of_type);
    match of_type {
        Scalar::F32 | Scalar::F64 => x,
        _ => gnurt_image::srgb::decode(x),
    }
}
