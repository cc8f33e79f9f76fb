// SPDX-License-Identifier: GPL-3.0-or-later
//! A glTF document with its buffers in memory.
//! Source: glTF 2.0 sections 3.6 and 3.12. Buffers: data URI, file in the document's folder, binary chunk.
//! Invariant: a buffer has the length that it declares. Tests: `tests/gltf.rs`, `tests/broken_files.rs`.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use serde::Deserialize;
use serde_json::value::RawValue;

use super::base64::data_uri;
use super::container::Container;
use super::json::{self, Index, Root};
use crate::io::error::quoted;
use crate::io::source::{self, Access};
use crate::io::{Error, Oddity, Warnings};
use gnurt_image::{Budget, Excess};

/// Extensions that are shown, or whose absence is invisible.
const KNOWN_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Extensions without which there is nothing to be seen.
const COMPRESSIONS: &[&str] =
    &["EXT_meshopt_compression", "KHR_draco_mesh_compression", "KHR_meshopt_compression"];

/// Extensions whose textures get a warning where a material reads one.
const TOLD_WHERE_USED: &[&str] = &["EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds"];

/// First letters of extensions that have no visible effect.
const UNSEEN: &[&str] = &[
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "KHR_audio",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_",
    "KHR_xmp",
];

/// The remedy for a compressed mesh.
const DECOMPRESS: &str = "this program does not unpack it; write the file without compression";

/// The limit of files in the list of a document's files.
const MOST_FILES: usize = 1 << 16;

/// The first `length` of these bytes; buffers that name the same file share them.
struct Buffer<'a> {
    bytes: Bytes<'a>,
    length: usize,
}

enum Bytes<'a> {
    InFile(&'a [u8]),
    Beside(Rc<Vec<u8>>),
}

impl Bytes<'_> {
    fn all(&self) -> &[u8] {
        match self {
            Self::InFile(bytes) => bytes,
            Self::Beside(bytes) => bytes,
        }
    }
}

/// The JSON, the buffers, and their memory budget.
pub(super) struct Document<'a> {
    pub(super) path: PathBuf,
    pub(super) root: Root<'a>,
    pub(super) access: &'a Access,
    buffers: Vec<Buffer<'a>>,
    /// The JSON; a binary file has no line numbers.
    json: &'a str,
    is_text: bool,
}

impl<'a> Document<'a> {
    pub(super) fn new(
        path: &Path,
        bytes: &'a [u8],
        is_binary: bool,
        access: &'a Access,
        warnings: &mut Warnings,
    ) -> Result<Self, Error> {
        let container = Container::new(bytes, is_binary, path, warnings)?;
        let json = std::str::from_utf8(container.json).map_err(|error| {
            let problem = format!("the JSON is invalid UTF-8 at its byte {}", error.valid_up_to());
            Error::data(path, None, problem, "expected a glTF 2.0 document")
        })?;
        let mut document = Self {
            path: path.to_owned(),
            root: Root::default(),
            access,
            buffers: Vec::new(),
            json,
            is_text: container.binary.is_none(),
        };
        document.root = serde_json::from_str(json)
            .map_err(|error| document.old().unwrap_or_else(|| document.broken("", json, &error)))?;
        document.check(warnings)?;
        let pieces = document.root.pieces() * size_of::<&RawValue>();
        document.hold(pieces, "the document")?;
        if access.is_confined() {
            document.check_files()?;
        }
        document.buffers = document.read_buffers(container.binary)?;
        Ok(document)
    }

    /// The error for a document of another version, whose arrays may have another form: those of glTF 1.0 are
    /// objects.
    fn old(&self) -> Option<Error> {
        let json::Versioned { asset } = serde_json::from_str(self.json).ok()?;
        let version = asset.version.get().trim_matches('"');
        (!version.starts_with("2.")).then(|| self.other_version(version))
    }

    fn other_version(&self, version: &str) -> Error {
        let problem = format!("glTF version {}", quoted(version));
        Error::data(&self.path, None, problem, "expected version 2.0")
    }

    /// Whether this program can show it.
    fn check(&self, warnings: &mut Warnings) -> Result<(), Error> {
        let Some(asset) = &self.root.asset else {
            let remedy = "expected a glTF 2.0 document";
            return Err(Error::data(&self.path, None, "broken JSON: missing field `asset`", remedy));
        };
        if !asset.version.starts_with("2.") {
            return Err(self.other_version(&asset.version));
        }
        for name in self.root.extensions_required.iter().map(|name| &**name) {
            if COMPRESSIONS.contains(&name) {
                return Err(Error::data(&self.path, None, format!("{name} is required"), DECOMPRESS));
            }
            if !KNOWN_EXTENSIONS.contains(&name) {
                warnings.note(Oddity::UnknownExtension, &self.path, None, quoted(name));
            }
        }
        self.warn_unknown(warnings);
        Ok(())
    }

    /// Warns about extensions that are used but not supported.
    fn warn_unknown(&self, warnings: &mut Warnings) {
        // Those beyond get a second warning; the set stays small for any file.
        const MOST_REQUIRED: usize = 1024;
        let required = self.root.extensions_required.iter().take(MOST_REQUIRED);
        let required: HashSet<&str> = required.map(|name| &**name).collect();
        for name in self.root.extensions_used.iter().map(|name| &**name) {
            let is_reported =
                [KNOWN_EXTENSIONS, COMPRESSIONS, TOLD_WHERE_USED].iter().any(|list| list.contains(&name));
            let is_unseen = UNSEEN.iter().any(|start| name.starts_with(start));
            if !is_reported && !is_unseen && !required.contains(name) {
                warnings.note(Oddity::NotShown, &self.path, None, format!("extension {}", quoted(name)));
            }
        }
    }

    /// Rejects files outside of the folder that confines the document.
    fn check_files(&self) -> Result<(), Error> {
        for (array, pieces) in [("buffers", &self.root.buffers), ("images", &self.root.images)] {
            for (i, piece) in pieces.iter().enumerate() {
                let named: json::Named<'_> = self.read(piece, array)?;
                let Some(uri) = named.uri.filter(|uri| !uri.starts_with("data:")) else { continue };
                let checked = self.access.check(&source::resolve(&self.path, &uri));
                checked.map_err(|(problem, remedy)| {
                    let before = piece.get().as_ptr() as usize - self.json.as_ptr() as usize;
                    let line = self.is_text.then(|| self.line_of(before));
                    Error::data(&self.path, line, format!("{array}[{i}]: {problem}"), remedy)
                })?;
            }
        }
        Ok(())
    }

    /// The line of a byte of the JSON.
    fn line_of(&self, byte: usize) -> u64 {
        1 + self.json.as_bytes()[..byte].iter().filter(|&&b| b == b'\n').count() as u64
    }

    /// A fault at a location such as `meshes[3]`.
    pub(super) fn error(&self, location: &str, problem: impl std::fmt::Display, remedy: &str) -> Error {
        Error::data(&self.path, None, format!("{location}: {problem}"), remedy)
    }

    /// A mesh that only its compressed form holds.
    pub(super) fn compressed(&self, location: &str) -> Error {
        self.error(location, "the mesh is compressed by KHR_draco_mesh_compression", DECOMPRESS)
    }

    /// Parses a piece of the JSON; `what` names it in a message.
    pub(super) fn read<T: Deserialize<'a>>(&self, piece: &'a RawValue, what: &str) -> Result<T, Error> {
        self.work(piece.get().len(), what)?;
        serde_json::from_str(piece.get()).map_err(|error| self.broken(what, piece.get(), &error))
    }

    /// The element of an array of the root for an index found at `location`.
    pub(super) fn get<T: Deserialize<'a>>(
        &self,
        array: &[&'a RawValue],
        index: Index,
        location: &str,
        what: &str,
    ) -> Result<T, Error> {
        let missing = || self.error(location, format!("{what} {} does not exist", index.0), "");
        let piece = array.get(index.value()).copied().ok_or_else(missing)?;
        self.work(piece.get().len(), location)?;
        serde_json::from_str(piece.get())
            .map_err(|error| self.broken(&format!("{what} {}", index.0), piece.get(), &error))
    }

    /// The error for a piece of the JSON, with the line of the file.
    fn broken(&self, what: &str, piece: &str, error: &serde_json::Error) -> Error {
        let text = error.to_string();
        let problem = text.split(" at line ").next().unwrap_or_default();
        let location = if what.is_empty() { String::new() } else { format!(" in {what}") };
        let before = (piece.as_ptr() as usize).saturating_sub(self.json.as_ptr() as usize);
        let line = (self.is_text && error.line() > 0).then(|| self.line_of(before) + error.line() as u64 - 1);
        let problem = format!("broken JSON{location}: {problem}");
        Error::data(&self.path, line, problem, "expected a glTF 2.0 document")
    }

    pub(super) fn budget(&self) -> &Budget {
        &self.access.budget
    }

    /// Allows `bytes` more to be held.
    pub(super) fn hold(&self, bytes: usize, location: &str) -> Result<(), Error> {
        self.budget().hold(bytes).map_err(|excess| self.error(location, excess, Excess::REMEDY))
    }

    /// Charges `bytes` of work.
    pub(super) fn work(&self, bytes: usize, location: &str) -> Result<(), Error> {
        self.budget().work(bytes).map_err(|excess| self.error(location, excess, Excess::REMEDY))
    }

    /// A buffer view and its bytes.
    pub(super) fn view(&self, index: Index, location: &str) -> Result<(json::BufferView, &[u8]), Error> {
        let view: json::BufferView = self.get(&self.root.buffer_views, index, location, "bufferView")?;
        let missing = || self.error(location, format!("buffer {} does not exist", view.buffer.0), "");
        let buffer = self.buffers.get(view.buffer.value()).ok_or_else(missing)?;
        let buffer = &buffer.bytes.all()[..buffer.length];
        let start = usize::try_from(view.byte_offset).ok();
        let end = view.byte_offset.checked_add(view.byte_length).and_then(|end| usize::try_from(end).ok());
        let bytes = start.zip(end).and_then(|(start, end)| buffer.get(start..end));
        let bytes = bytes.ok_or_else(|| {
            let problem = format!("bufferView {} ends after its buffer's {} bytes", index.0, buffer.len());
            self.error(location, problem, "the buffer may have been cut off")
        })?;
        Ok((view, bytes))
    }

    fn read_buffers(&self, binary: Option<&'a [u8]>) -> Result<Vec<Buffer<'a>>, Error> {
        let declared: Result<Vec<json::Buffer<'a>>, Error> = (0..self.root.buffers.len() as u32)
            .map(|i| self.get(&self.root.buffers, Index(i), "buffers", "buffer"))
            .collect();
        let declared = declared?;
        // No companion file is read further than its longest possible buffer.
        let longest = declared.iter().map(|buffer| buffer.byte_length).max().unwrap_or(0);
        let mut files = HashMap::new();
        let buffers = declared.iter().enumerate();
        buffers.map(|(i, buffer)| self.read_buffer(i, buffer, binary, longest, &mut files)).collect()
    }

    fn read_buffer(
        &self,
        i: usize,
        buffer: &json::Buffer<'a>,
        binary: Option<&'a [u8]>,
        longest: u64,
        files: &mut HashMap<PathBuf, Rc<Vec<u8>>>,
    ) -> Result<Buffer<'a>, Error> {
        let location = format!("buffers[{i}]");
        let bytes = match &buffer.uri {
            None if i == 0 => Bytes::InFile(binary.unwrap_or_default()),
            None => Bytes::InFile(&[]),
            Some(uri) if uri.starts_with("data:") => {
                self.hold(uri.len(), &location)?;
                let bytes = data_uri(uri);
                Bytes::Beside(
                    bytes.ok_or_else(|| self.error(&location, "broken data URI", "expected base64"))?.into(),
                )
            }
            Some(uri) => Bytes::Beside(self.read_file(uri, &location, longest, files)?),
        };
        let declared = buffer.byte_length;
        let there = bytes.all().len();
        let length = usize::try_from(declared).ok().filter(|&length| length <= there);
        let length = length.ok_or_else(|| {
            let problem = format!("{declared} bytes are declared, but there are {there}");
            self.error(&location, problem, "the buffer may have been cut off")
        })?;
        Ok(Buffer { bytes, length })
    }

    /// The document's own file and its companions.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let uri = |piece: &&'a RawValue| serde_json::from_str::<json::Named<'a>>(piece.get()).ok()?.uri;
        let named = self.root.buffers.iter().chain(&self.root.images).filter_map(uri);
        let companion_files = named.filter(|uri| !uri.starts_with("data:")).take(MOST_FILES);
        let companion_files = companion_files.map(|uri| source::resolve(&self.path, &uri));
        std::iter::once(self.path.clone()).chain(companion_files).collect()
    }

    /// The bytes of a companion file, each file once, under any name.
    fn read_file(
        &self,
        uri: &str,
        location: &str,
        longest: u64,
        files: &mut HashMap<PathBuf, Rc<Vec<u8>>>,
    ) -> Result<Rc<Vec<u8>>, Error> {
        self.budget().name_file().map_err(|excess| self.error(location, excess, Excess::REMEDY))?;
        let file = source::resolve(&self.path, uri);
        let true_name = std::fs::canonicalize(&file).unwrap_or_else(|_| file.clone());
        if let Some(bytes) = files.get(&true_name) {
            return Ok(bytes.clone());
        }
        let bytes = self.access.read(&file, longest).map_err(|e| self.error(location, e.to_string(), ""))?;
        let bytes = Rc::new(bytes);
        files.insert(true_name, bytes.clone());
        Ok(bytes)
    }
}
