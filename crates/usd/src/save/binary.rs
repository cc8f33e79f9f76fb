// SPDX-License-Identifier: GPL-3.0-or-later
//! Binary layers of the library as OpenUSD reads them: names of children as vectors of names, short arrays uncompressed.
//! Source: `crateFile.cpp` of OpenUSD. Its integers are compressed from 16 on, the library's from 4 on; it reads children
//! as type 41, the library writes arrays of type 11. Tests: `tests/save.rs`.

use std::io::Cursor;

use openusd::sdf::{AbstractData, FieldKey, SpecType, Value, Variability};

use crate::bytes::{Bytes, Fault};
use crate::crate_fields::{Fields, PAYLOAD};
use crate::crate_parts::{integers, tokens};

/// Fields with names of children or their order.
const CHILDREN: [&[u8]; 6] = [
    b"primChildren",
    b"properties",
    b"variantChildren",
    b"variantSetChildren",
    b"primOrder",
    b"propertyOrder",
];
/// Arrays shorter than this are not compressed.
const SHORTEST_COMPRESSED: u64 = 16;
const IS_COMPRESSED: u64 = 1 << 61;
/// The type of a vector of names.
const NAMES: u64 = 41 << 48;
/// Types and bits of an array: of names, of `int`, of `uint`.
const NAME_ARRAY: u64 = 0x800b;
const INT_ARRAY: u64 = 0xa003;
const UINT_ARRAY: u64 = 0xa004;

/// The binary form of a layer's text.
pub(super) fn from_text(text: &str) -> Result<Vec<u8>, Fault> {
    let mut data = openusd::usda::parse(text).map_err(|error| error.to_string())?;
    // Relationships of text are uniform; the library leaves that out.
    for path in data.spec_paths() {
        if data.spec_type(&path) == Some(SpecType::Relationship) {
            let uniform = Value::Variability(Variability::Uniform);
            data.set_field(&path, FieldKey::Variability.as_str(), uniform);
        }
    }
    let mut bytes = Cursor::new(Vec::new());
    openusd::usdc::CrateWriter::write(&data, &mut bytes).map_err(|error| error.to_string())?;
    mend(bytes.into_inner())
}

/// The layer with its values retyped. They lie behind the rest, in front of the table of sections.
fn mend(mut layer: Vec<u8>) -> Result<Vec<u8>, Fault> {
    let bytes = Bytes::new(&layer);
    let table = bytes.number::<8>(16)?;
    let fields = Fields::read(&bytes, tokens(&bytes)?)?.ok_or_else(|| "a section is missing".to_owned())?;
    let (tokens, mut values) = (fields.tokens(), fields.values.clone());

    let mut arrays = Vec::new();
    for (value, &name) in values.as_chunks_mut::<8>().0.iter_mut().zip(&fields.names) {
        let old = u64::from_le_bytes(*value);
        let payload = old & PAYLOAD;
        let new = match old >> 48 {
            NAME_ARRAY if tokens.get(name as usize).is_some_and(|name| CHILDREN.contains(name)) => {
                NAMES | payload
            }
            INT_ARRAY | UINT_ARRAY if bytes.number::<8>(payload)? < SHORTEST_COMPRESSED => {
                let count = bytes.number::<8>(payload)?;
                let (integers, _) = integers(&bytes, payload + 8, count)?;
                let payload = table + arrays.len() as u64;
                arrays.extend_from_slice(&count.to_le_bytes());
                arrays.extend(integers.iter().flat_map(|integer| integer.to_le_bytes()));
                old & !(IS_COMPRESSED | PAYLOAD) | payload
            }
            _ => continue,
        };
        *value = new.to_le_bytes();
    }

    let section = fields.section(&layer, &values);
    let (at, size) = (table + arrays.len() as u64, section.len() as u64);
    let mut put = |at: u64, number: u64| {
        layer[at as usize..at as usize + 8].copy_from_slice(&number.to_le_bytes());
    };
    put(fields.entry + 16, at);
    put(fields.entry + 24, size);
    put(16, at + size);
    arrays.extend(section);
    layer.splice(table as usize..table as usize, arrays);
    Ok(layer)
}
