// SPDX-License-Identifier: GPL-3.0-or-later
//! Stand-ins for the long arrays of a binary layer. Source: the crate format of OpenUSD, from version 0.7 on, where an array
//! is its length in 8 bytes and its elements. Tests: `tests/arrays.rs`.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::arrays::{Array, Arrays};
use crate::crate_check::Checked;
use crate::crate_fields::PAYLOAD;
use crate::layer::{Edit, Replacement};
use crate::packed_array::PackedArray;

/// Shorter arrays are left to the library.
const LEAST: u64 = 256;

/// Edits that replace long arrays of fields named `default`; their bytes become zeros where nothing else names them.
pub(crate) fn edits(file: &Arc<Vec<u8>>, checked: &Checked, arrays: &Arrays) -> Vec<Edit> {
    if checked.version < [0, 7, 0] {
        return Vec::new();
    }
    let fields = &checked.fields;
    let Some(default) = fields.tokens().iter().position(|&token| token == b"default") else {
        return Vec::new();
    };
    let mut edits = Vec::new();
    let mut appended: Vec<u8> = Vec::new();
    let mut values = fields.values.clone();
    let mut known: BTreeMap<u64, u64> = BTreeMap::new();
    for (value, &name) in values.as_chunks_mut::<8>().0.iter_mut().zip(&fields.names) {
        let old = u64::from_le_bytes(*value);
        if usize::try_from(name) != Ok(default) {
            continue;
        }
        if let Some(new) = known.get(&old) {
            *value = new.to_le_bytes();
            continue;
        }
        let Some(packed) = PackedArray::of(file, old).filter(|packed| packed.count >= LEAST) else {
            continue;
        };
        let (kind, range) = (packed.kind, packed.range());
        let Some(number) = arrays.add(Array::Packed(packed)) else { break };
        if !checked.nested.contains(&(old & PAYLOAD)) {
            edits.push(Edit { range, by: Replacement::Zeros });
        }
        let new = old & !(PAYLOAD | PackedArray::IS_COMPRESSED) | (file.len() + appended.len()) as u64;
        appended.extend_from_slice(&2_u64.to_le_bytes());
        appended.extend(kind.stand_in(number));
        known.insert(old, new);
        *value = new.to_le_bytes();
    }
    if known.is_empty() {
        return Vec::new();
    }
    let section = fields.section(file, &values);
    let (at, size) = ((file.len() + appended.len()) as u64, section.len() as u64);
    let entry = fields.entry as usize + 16;
    appended.extend(section);
    let place = [at.to_le_bytes(), size.to_le_bytes()].concat();
    edits.push(Edit { range: entry..entry + 16, by: Replacement::Bytes(place) });
    edits.push(Edit { range: file.len()..file.len(), by: Replacement::Bytes(appended) });
    edits
}
