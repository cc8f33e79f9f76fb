// SPDX-License-Identifier: GPL-3.0-or-later
//! One element of a PLY body, vertex or face, as `ply-rs-bw` fills it.
//! Source: original; names as Blender, MeshLab, PBRT, Stanford and VTK write them.

use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult};

/// A vertex: what is not in the file stays at its neutral value.
#[derive(Clone, Copy)]
pub(super) struct Vertex {
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) texcoord: [f32; 2],
    pub(super) color: [f32; 4],
}

/// Where a property of a vertex goes.
enum Slot {
    Position(usize),
    Normal(usize),
    Texcoord(usize),
    Color(usize),
}

fn slot(name: &str) -> Option<Slot> {
    Some(match name {
        "x" => Slot::Position(0),
        "y" => Slot::Position(1),
        "z" => Slot::Position(2),
        "nx" => Slot::Normal(0),
        "ny" => Slot::Normal(1),
        "nz" => Slot::Normal(2),
        "u" | "s" | "texture_u" | "texture_s" | "texcoord_u" => Slot::Texcoord(0),
        "v" | "t" | "texture_v" | "texture_t" | "texcoord_v" => Slot::Texcoord(1),
        "red" | "r" | "diffuse_red" => Slot::Color(0),
        "green" | "g" | "diffuse_green" => Slot::Color(1),
        "blue" | "b" | "diffuse_blue" => Slot::Color(2),
        "alpha" | "a" | "diffuse_alpha" => Slot::Color(3),
        _ => return None,
    })
}

/// Which optional values the vertices of a file have.
#[derive(Clone, Copy)]
pub(super) struct Columns {
    pub(super) positions: bool,
    pub(super) normals: bool,
    pub(super) texcoords: bool,
    pub(super) colors: bool,
}

impl Columns {
    /// A value counts only if all of its components are there; opacity may be missing.
    pub(super) fn of(element: &ElementDef) -> Self {
        let slots = || element.properties.iter().filter_map(|(name, _)| slot(name));
        let count = |mask: fn(&Slot) -> bool| slots().filter(mask).count();
        Self {
            positions: count(|s| matches!(s, Slot::Position(_))) == 3,
            normals: count(|s| matches!(s, Slot::Normal(_))) == 3,
            texcoords: count(|s| matches!(s, Slot::Texcoord(_))) == 2,
            colors: count(|s| matches!(s, Slot::Color(0..=2))) == 3,
        }
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: [0.0; 3], normal: [0.0; 3], texcoord: [0.0; 2], color: [1.0; 4] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match slot(name) {
            Some(Slot::Position(k)) => self.position[k] = number(&property),
            Some(Slot::Normal(k)) => self.normal[k] = number(&property),
            Some(Slot::Texcoord(k)) => self.texcoord[k] = number(&property),
            Some(Slot::Color(3)) => self.color[3] = fraction(&property),
            Some(Slot::Color(k)) => self.color[k] = linear(&property),
            None => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// A scalar as a float; lists, which no slot has, as 0.
fn number(property: &Property) -> f32 {
    match *property {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x as f32,
        Property::UInt(x) => x as f32,
        Property::Float(x) => x,
        Property::Double(x) => x as f32,
        _ => 0.0,
    }
}

/// Integers as shares of their largest value, floats as they are.
fn fraction(property: &Property) -> f32 {
    let largest = match property {
        Property::Char(_) => f32::from(i8::MAX),
        Property::UChar(_) => f32::from(u8::MAX),
        Property::Short(_) => f32::from(i16::MAX),
        Property::UShort(_) => f32::from(u16::MAX),
        // Whoever writes colours as `int` means bytes.
        Property::Int(_) | Property::UInt(_) => f32::from(u8::MAX),
        _ => 1.0,
    };
    (number(property) / largest).max(0.0)
}

/// Integers are sRGB-encoded, floats linear.
fn linear(property: &Property) -> f32 {
    let x = fraction(property);
    match property {
        Property::Float(_) | Property::Double(_) => x,
        _ if x <= 0.04045 => x / 12.92,
        _ => ((x + 0.055) / 1.055).powf(2.4),
    }
}

/// A face: its corners as written, or a strip with -1 between its pieces.
pub(super) struct Face {
    pub(super) corners: Vec<i64>,
}

/// Whether a list of this name holds corners.
pub(super) fn is_corners(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self { corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !is_corners(name) {
            return PropertyAccessResult::Ignored;
        }
        self.corners = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that nobody asked for.
pub(super) struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
