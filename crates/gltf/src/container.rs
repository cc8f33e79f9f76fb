// SPDX-License-Identifier: GPL-3.0-or-later
//! The outer layer of glTF files: a JSON text, or the chunks of a binary file.
//! Source: glTF 2.0 section 4 (GLB). A file that calls itself `.gltf` and begins as a binary one is read as such.
//! Tests: `tests/broken_files.rs`, `tests/mutations.rs`.

use std::path::Path;

use gnurt_scene::io::{Error, Oddity, Warnings};

/// The JSON text and the binary chunk.
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

const MAGIC: &[u8] = b"glTF";
const CHUNK_JSON: u32 = 0x4e4f_534a;
const CHUNK_BINARY: u32 = 0x004e_4942;

impl<'a> Container<'a> {
    pub(super) fn new(
        bytes: &'a [u8],
        is_binary: bool,
        path: &Path,
        warnings: &mut Warnings,
    ) -> Result<Self, Error> {
        if bytes.starts_with(MAGIC) {
            return Self::binary(bytes, path, warnings);
        }
        if is_binary {
            let remedy = "expected `glTF` in its first four bytes";
            return Err(Error::data(path, None, "not a binary glTF file", remedy));
        }
        Ok(Self { json: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), binary: None })
    }

    fn binary(bytes: &'a [u8], path: &Path, warnings: &mut Warnings) -> Result<Self, Error> {
        let cut_off = |what: &str| {
            Error::data(path, None, format!("the file ends in its {what}"), "it may have been cut off")
        };
        let u32_at = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let (version, length) = (u32_at(4), u32_at(8));
        let (Some(version), Some(length)) = (version, length) else {
            return Err(cut_off("header"));
        };
        if version != 2 {
            return Err(Error::data(path, None, format!("glTF version {version}"), "expected version 2"));
        }
        let declared = length as usize;
        if declared > bytes.len() {
            let problem = format!("{length} bytes are declared, but the file has {}", bytes.len());
            return Err(Error::data(path, None, problem, "it may have been cut off"));
        }
        let (mut json, mut binary) = (None, None);
        let mut at = 12;
        while let (Some(length), Some(kind)) = (u32_at(at), u32_at(at + 4)) {
            let end = (at + 8).checked_add(length as usize);
            let chunk = end.and_then(|end| bytes.get(at + 8..end));
            let slot = match kind {
                CHUNK_JSON if json.is_none() => Some(&mut json),
                CHUNK_BINARY if binary.is_none() => Some(&mut binary),
                _ => None,
            };
            // Behind the declared end only missing parts are read, because some programs declare too short a
            // length.
            if at >= declared && (slot.is_none() || chunk.is_none()) {
                break;
            }
            let chunk = chunk.ok_or_else(|| cut_off("chunks"))?;
            if let Some(slot) = slot {
                *slot = Some(chunk);
            }
            at += 8 + chunk.len().next_multiple_of(4);
        }
        let end = at.max(declared);
        if end < bytes.len() {
            let detail = format!("{} after byte {end}", bytes.len() - end);
            warnings.note(Oddity::TrailingData, path, None, detail);
        }
        let json = json.ok_or_else(|| Error::data(path, None, "no JSON chunk", "expected it first"))?;
        Ok(Self { json, binary })
    }
}
