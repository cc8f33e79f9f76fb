// SPDX-License-Identifier: GPL-3.0-or-later
//! Vertices as rows of bytes, all of one length: many at once. Rows of floats alone, as most files have them, take the
//! short way. Values are those of `Numbers`. Tests: `tests/ply.rs::{headers_of_all_kinds, long_files_are_read_alike}`.

use super::columns::{Columns, Slot, Vertex};
use super::header::{Element, Encoding, Scalar};
use crate::io::origin::Origin;
use crate::mesh::Mesh;

/// A property: its use, its first byte within a row, and its type.
type Field = (Slot, usize, Scalar);

/// The rows of an element.
pub(super) struct Rows {
    /// Bytes of a row.
    pub(super) size: usize,
    is_big: bool,
    /// The properties that are used, in the order of the file.
    fields: Vec<Field>,
}

impl Rows {
    /// Those of an element without lists, in an encoding of bytes.
    pub(super) fn of(element: &Element, encoding: Encoding) -> Option<Self> {
        if encoding == Encoding::Text || element.properties.iter().any(|property| property.count.is_some()) {
            return None;
        }
        let mut size = 0;
        let mut fields = Vec::new();
        for property in &element.properties {
            let slot = Slot::of(property);
            if slot != Slot::None {
                fields.push((slot, size, property.item));
            }
            size += property.item.size();
        }
        Some(Self { size, is_big: encoding == Encoding::BigEndian, fields })
    }

    /// Adds the vertices of whole rows to a mesh.
    pub(super) fn add(&self, bytes: &[u8], columns: Columns, origin: &mut Origin, mesh: &mut Mesh) {
        let rows = bytes.chunks_exact(self.size);
        let float = |row: &[u8], at: usize| f32::from_bits(self.bits(row, at));
        let position = [0, 1, 2].map(|k| self.float(Slot::Position(k)));
        let normal = [0, 1, 2].map(|k| self.float(Slot::Normal(k)));
        let texcoord = [0, 1].map(|k| self.float(Slot::Texcoord(k)));
        let is_plain = !columns.colors
            && (!columns.normals || normal.iter().all(Option::is_some))
            && (!columns.texcoords || texcoord.iter().all(Option::is_some));
        if let ([Some(x), Some(y), Some(z)], true) = (position, is_plain) {
            let place = |row: &[u8]| origin.place([x, y, z].map(|at| f64::from(float(row, at))));
            mesh.positions.extend(rows.clone().map(place));
            if let ([Some(x), Some(y), Some(z)], true) = (normal, columns.normals) {
                mesh.normals.extend(rows.clone().map(|row| [x, y, z].map(|at| float(row, at))));
            }
            if let ([Some(u), Some(v)], true) = (texcoord, columns.texcoords) {
                mesh.texcoords.extend(rows.map(|row| [u, v].map(|at| float(row, at))));
            }
            return;
        }
        for row in rows {
            let mut vertex = Vertex::NEUTRAL;
            for &(slot, at, of_type) in &self.fields {
                vertex.set(slot, self.value(row, at, of_type), of_type);
            }
            mesh.positions.push(origin.place(vertex.position));
            mesh.normals.extend(columns.normals.then_some(vertex.normal));
            mesh.texcoords.extend(columns.texcoords.then_some(vertex.texcoord));
            mesh.colors.extend(columns.colors.then_some(vertex.color));
        }
    }

    /// Where a value that is a float in single precision begins; the last property of the use counts.
    fn float(&self, slot: Slot) -> Option<usize> {
        let field = self.fields.iter().rfind(|(other, ..)| *other == slot)?;
        (field.2 == Scalar::F32).then_some(field.1)
    }

    /// Four bytes as a number.
    #[inline]
    fn bits(&self, row: &[u8], at: usize) -> u32 {
        let bits = u32::from_le_bytes(part(row, at));
        if self.is_big { bits.swap_bytes() } else { bits }
    }

    fn value(&self, row: &[u8], at: usize, of_type: Scalar) -> f64 {
        let two = || {
            let bits = u16::from_le_bytes(part(row, at));
            if self.is_big { bits.swap_bytes() } else { bits }
        };
        match of_type {
            Scalar::I8 => f64::from(row[at] as i8),
            Scalar::U8 => f64::from(row[at]),
            Scalar::I16 => f64::from(two() as i16),
            Scalar::U16 => f64::from(two()),
            Scalar::I32 => f64::from(self.bits(row, at) as i32),
            Scalar::U32 => f64::from(self.bits(row, at)),
            Scalar::F32 => f64::from(f32::from_bits(self.bits(row, at))),
            Scalar::F64 => {
                let bits = u64::from_le_bytes(part(row, at));
                f64::from_bits(if self.is_big { bits.swap_bytes() } else { bits })
            }
        }
    }
}

#[inline]
fn part<const N: usize>(row: &[u8], at: usize) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.copy_from_slice(&row[at..at + N]);
    bytes
}
