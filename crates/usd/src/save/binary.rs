// SPDX-License-Identifier: GPL-3.0-or-later
//! Binary layers of the library as OpenUSD reads them: names of children as vectors of names, short arrays uncompressed.
//! Source: `crateFile.cpp` of OpenUSD. Its integers are compressed from 16 on, the library's from 4 on; it reads children
//! as type 41, the library writes arrays of type 11. Tests: `tests/save.rs`.

use std::io::Cursor;

use openusd::sdf::{AbstractData, FieldKey, SpecType, Value, Variability};

use crate::bytes::{Bytes, Fault};
use crate::crate_check::{entry, integers, tokens, unpack};

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
/// The bits of a place.
const PAYLOAD: u64 = 0xffff_ffff_ffff;
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
    let section = |name: &[u8]| {
        let at = entry(&bytes, name)?.ok_or_else(|| "a section is missing".to_owned())?;
        Ok::<_, Fault>((at, bytes.number::<8>(at + 16)?))
    };
    let table = bytes.number::<8>(16)?;
    let text = tokens(&bytes, section(b"TOKENS")?.1)?;
    let tokens: Vec<&[u8]> = text.split(|&byte| byte == 0).collect();
    let (fields_entry, fields) = section(b"FIELDS")?;
    let count = bytes.number::<8>(fields)?;
    let (names, at) = integers(&bytes, fields + 8, count)?;
    let mut values = unpack(&bytes, at, count * 8)?;

    let mut arrays = Vec::new();
    for (value, &name) in values.as_chunks_mut::<8>().0.iter_mut().zip(&names) {
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

    let packed = lz4_flex::block::compress(&values);
    let mut section = layer[fields as usize..at as usize].to_vec();
    section.extend_from_slice(&(packed.len() as u64 + 1).to_le_bytes());
    // One piece.
    section.push(0);
    section.extend(packed);

    let (fields, size) = (table + arrays.len() as u64, section.len() as u64);
    let mut put = |at: u64, number: u64| {
        layer[at as usize..at as usize + 8].copy_from_slice(&number.to_le_bytes());
    };
    put(fields_entry + 16, fields);
    put(fields_entry + 24, size);
    put(16, fields + size);
    arrays.extend(section);
    layer.splice(table as usize..table as usize, arrays);
    Ok(layer)
}
