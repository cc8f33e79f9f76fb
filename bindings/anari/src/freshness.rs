// SPDX-License-Identifier: GPL-3.0-or-later
//! When something changed that an object shows: the latest stamp of it and of all that it holds.
//! Each object is looked at once, however often it is held. Tests: tests/lifetimes.rs.

use std::collections::HashSet;
use std::sync::Arc;

use crate::ffi_array::Array;
use crate::object::{Object, Value};

/// The latest stamp of an object and of all objects that it holds, directly or not.
pub(crate) fn stamp(object: &Object) -> u64 {
    let mut seen = HashSet::from([object.handle]);
    let mut latest = 0;
    let mut left = contents(object, &mut latest);
    while let Some(held) = left.pop() {
        if seen.insert(held.handle) {
            left.extend(contents(&held, &mut latest));
        }
    }
    latest
}

/// The objects that an object holds directly; raises `latest` to its stamp.
fn contents(object: &Object, latest: &mut u64) -> Vec<Arc<Object>> {
    let now = object.committed();
    *latest = (*latest).max(now.stamp);
    let held = now.values().filter_map(|value| match value {
        Value::Object(object) => Some(object.clone()),
        _ => None,
    });
    let mut all: Vec<Arc<Object>> = held.collect();
    if let Some(array) = Array::of(object) {
        *latest = (*latest).max(array.stamp());
        all.extend(array.objects());
    }
    all
}
