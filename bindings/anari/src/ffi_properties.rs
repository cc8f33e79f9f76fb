// SPDX-License-Identifier: GPL-3.0-or-later
//! Properties of objects, as bytes: versions, bounds, durations. Tests: tests/introspection.rs, tests/frames.rs.

use std::ffi::{CString, c_char};
use std::sync::LazyLock;

use crate::device::Device;
use crate::ffi_introspection::extensions;
use crate::frame::Frame;
use crate::motion::MOMENT;
use crate::object::Object;
use crate::types::{self, DataType};
use crate::world::Stage;

/// The version, for programs that keep the address.
static NAME: LazyLock<CString> =
    LazyLock::new(|| CString::new(concat!("GNU RT ", env!("CARGO_PKG_VERSION"))).unwrap_or_default());

fn number(text: &str) -> i32 {
    text.parse().unwrap_or(0)
}

/// The value of a property; `None` where there is none. `wait` says whether to wait for a rendering.
pub(crate) fn property(
    device: &Device,
    object: &Object,
    name: &str,
    kind: DataType,
    wait: bool,
) -> Option<Vec<u8>> {
    if object.kind == types::DEVICE {
        return of_device(device, name, kind);
    }
    if let Some(frame) = Frame::of(object) {
        if wait {
            frame.wait();
        }
        let output = frame.output();
        return Some(match (name, kind) {
            ("duration", types::FLOAT32) => output.duration.to_ne_bytes().to_vec(),
            ("numSamples", types::INT32 | types::UINT32) => output.samples.to_ne_bytes().to_vec(),
            ("renderProgress" | "refinementProgress", types::FLOAT32) => {
                f32::from(u8::from(frame.is_ready())).to_ne_bytes().to_vec()
            }
            _ => return None,
        });
    }
    let has_bounds = [types::WORLD, types::GROUP, types::INSTANCE].contains(&object.kind);
    if !has_bounds || name != "bounds" || kind != types::FLOAT32_BOX3 {
        return None;
    }
    let report = |about: &Object, text: &str| device.reporter.warn(about, text);
    let corners = Stage::of(object, MOMENT, &report).bounds()?;
    Some(corners.as_flattened().iter().flat_map(|x| x.to_ne_bytes()).collect())
}

fn of_device(device: &Device, name: &str, kind: DataType) -> Option<Vec<u8>> {
    let (major, minor, patch) = (
        number(env!("CARGO_PKG_VERSION_MAJOR")),
        number(env!("CARGO_PKG_VERSION_MINOR")),
        number(env!("CARGO_PKG_VERSION_PATCH")),
    );
    let address = |address: usize| address.to_ne_bytes().to_vec();
    let whole = |number: i32| Some(number.to_ne_bytes().to_vec());
    match (name, kind) {
        ("version", types::INT32) => whole(10_000 * major + 100 * minor + patch),
        ("version.major", types::INT32) => whole(major),
        ("version.minor", types::INT32) => whole(minor),
        ("version.patch", types::INT32) => whole(patch),
        ("version.name", types::STRING) => Some(NAME.as_bytes_with_nul().to_vec()),
        ("version.name.size", types::UINT64) => {
            Some((NAME.as_bytes_with_nul().len() as u64).to_ne_bytes().to_vec())
        }
        ("geometryMaxIndex", types::UINT64) => Some(u64::from(u32::MAX - 1).to_ne_bytes().to_vec()),
        ("extension", types::STRING_LIST) => Some(address(extensions())),
        ("objects", types::UINT64) => Some((device.alive() as u64).to_ne_bytes().to_vec()),
        _ => None,
    }
}

/// Addresses of strings have the size of a pointer.
const _: () = assert!(size_of::<*const c_char>() == size_of::<usize>());
