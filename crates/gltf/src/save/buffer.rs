// SPDX-License-Identifier: GPL-3.0-or-later
//! The buffer of a glTF file in the making, with its views and accessors.
//! Source: glTF 2.0 section 3.6. Every view begins at a multiple of four bytes.

use serde_json::{Value, json};

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
/// What a view is for: `bufferView.target`, as graphics programs have it.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Bytes, and the JSON that describes them.
#[derive(Default)]
pub(super) struct Buffer {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
}

impl Buffer {
    /// Adds a separate view; returns its number.
    pub(super) fn add_bytes(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        self.views.len() - 1
    }

    pub(super) fn add_floats<const N: usize>(&mut self, shape: &str, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.add_bytes(&bytes);
        self.add_accessor(
            json!({ "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": shape }),
        )
    }

    /// Positions need their bounds.
    pub(super) fn add_positions(&mut self, values: &[[f32; 3]]) -> usize {
        let accessor = self.add_floats("VEC3", values);
        let bound = |pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|k| values.iter().map(|p| p[k]).reduce(pick).unwrap_or(0.0))
        };
        self.accessors[accessor]["min"] = json!(bound(f32::min));
        self.accessors[accessor]["max"] = json!(bound(f32::max));
        accessor
    }

    /// Times need their bounds.
    pub(super) fn add_times(&mut self, values: &[[f32; 1]]) -> usize {
        let accessor = self.add_floats("SCALAR", values);
        self.accessors[accessor]["min"] = json!([values.first().map_or(0.0, |time| time[0])]);
        self.accessors[accessor]["max"] = json!([values.last().map_or(0.0, |time| time[0])]);
        accessor
    }

    /// Truth values: everything but zero.
    pub(super) fn add_flags(&mut self, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().map(|&value| u8::from(value != 0.0)).collect();
        let view = self.add_bytes(&bytes);
        let count = values.len();
        self.add_accessor(
            json!({ "bufferView": view, "componentType": UNSIGNED_BYTE, "count": count, "type": "SCALAR" }),
        )
    }

    pub(super) fn add_joints(&mut self, values: &[[u16; 4]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|joint| joint.to_le_bytes()).collect();
        let view = self.add_bytes(&bytes);
        let count = values.len();
        self.add_accessor(
            json!({ "bufferView": view, "componentType": UNSIGNED_SHORT, "count": count, "type": "VEC4" }),
        )
    }

    pub(super) fn add_indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.add_bytes(&bytes);
        self.views[view]["target"] = INDICES.into();
        let count = 3 * triangles.len();
        self.add_accessor(
            json!({ "bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR" }),
        )
    }

    /// Says of the views of accessors, by name, that they hold attributes of vertices.
    pub(super) fn mark_attributes(&mut self, accessors: &Value) {
        for accessor in accessors.as_object().into_iter().flat_map(|named| named.values()) {
            let view = accessor.as_u64().and_then(|n| self.accessors[n as usize]["bufferView"].as_u64());
            if let Some(view) = view {
                self.views[view as usize]["target"] = VERTICES.into();
            }
        }
    }

    fn add_accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}
