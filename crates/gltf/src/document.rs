// SPDX-License-Identifier: GPL-3.0-or-later
//! A glTF document with its buffers in memory.
//! Source: glTF 2.0 sections 3.6 and 3.12. Buffers: data URI, file in the document's folder, binary chunk.
//! Invariant: a buffer has the length that it declares. Tests: `tests/gltf.rs`, `tests/broken_files.rs`.

use std::cell::OnceCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use serde::Deserialize;
use serde_json::value::RawValue;

use super::base64::data_uri;
use super::container::Container;
use super::json::{self, Index, Root};
use super::{meshopt, variants};
use gnurt_image::{Budget, Excess};
use gnurt_scene::io::reader::quoted;
use gnurt_scene::io::reader::{self as source, Access};
use gnurt_scene::io::{Error, Oddity, Warnings};

/// The compression of primitives, which `draco` reads.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// Extensions that are shown, or whose absence is invisible.
const KNOWN_EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_primitive_restart",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_accessor_float64",
    "KHR_animation_pointer",
    DRACO,
    "KHR_gaussian_splatting",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_mesh_primitive_restart",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

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

/// Whether an extension has no visible effect.
fn is_unseen(name: &str) -> bool {
    UNSEEN.iter().any(|start| name.starts_with(start))
}

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
    /// The number of the chosen variant.
    pub(super) variant: Option<u32>,
    /// Whether the largest number of a type of indices begins a new strip or fan.
    pub(super) has_restarts: bool,
    buffers: Vec<Buffer<'a>>,
    /// Compressed views that were read.
    unpacked: HashMap<Index, OnceCell<Vec<u8>>>,
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
            variant: None,
            has_restarts: false,
            buffers: Vec::new(),
            unpacked: HashMap::new(),
            json,
            is_text: container.binary.is_none(),
        };
        document.root = serde_json::from_str(json)
            .map_err(|error| document.old().unwrap_or_else(|| document.broken("", json, &error)))?;
        document.check(warnings)?;
        if document.uses(DRACO) {
            access.budget.add_compressed(bytes.len() as u64);
        }
        let pieces = document.root.pieces() * size_of::<&RawValue>();
        document.hold(pieces, "the document")?;
        if access.is_confined() {
            document.check_files()?;
        }
        let chosen = variants::chosen(&document.root, &access.variants);
        document.variant = chosen.map_err(|(problem, remedy)| Error::data(path, None, problem, remedy))?;
        document.has_restarts = ["KHR_mesh_primitive_restart", "EXT_mesh_primitive_restart"]
            .iter()
            .any(|name| document.uses(name));
        if document.uses("EXT_meshopt_compression") || document.uses("KHR_meshopt_compression") {
            document.find_compressed()?;
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
            if !KNOWN_EXTENSIONS.contains(&name) && !is_unseen(name) {
                let problem = format!("the file requires the extension {}", quoted(name));
                return Err(Error::data(&self.path, None, problem, "write the file without it"));
            }
        }
        self.warn_unknown(warnings);
        Ok(())
    }

    /// Warns about extensions that are used but not supported.
    fn warn_unknown(&self, warnings: &mut Warnings) {
        for name in self.root.extensions_used.iter().map(|name| &**name) {
            let is_reported = [KNOWN_EXTENSIONS, TOLD_WHERE_USED].iter().any(|list| list.contains(&name));
            if !is_reported && !is_unseen(name) {
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
    pub(super) fn view(&self, index: Index, location: &str) -> Result<(json::BufferView<'a>, &[u8]), Error> {
        let view: json::BufferView<'a> = self.get(&self.root.buffer_views, index, location, "bufferView")?;
        let bytes = match view.extensions.meshopt().zip(self.unpacked.get(&index)) {
            Some((compressed, unpacked)) => self.unpacked(index, compressed, unpacked, location)?,
            None => self.part(index, (view.buffer, view.byte_offset, view.byte_length), location)?,
        };
        Ok((view, bytes))
    }

    /// Bytes of a buffer from an offset on, for a buffer view.
    fn part(
        &self,
        view: Index,
        (buffer, offset, length): (Index, u64, u64),
        location: &str,
    ) -> Result<&[u8], Error> {
        let missing = || self.error(location, format!("buffer {} does not exist", buffer.0), "");
        let buffer = self.buffers.get(buffer.value()).ok_or_else(missing)?;
        let buffer = &buffer.bytes.all()[..buffer.length];
        let start = usize::try_from(offset).ok();
        let end = offset.checked_add(length).and_then(|end| usize::try_from(end).ok());
        let bytes = start.zip(end).and_then(|(start, end)| buffer.get(start..end));
        bytes.ok_or_else(|| {
            let problem = format!("bufferView {} ends after its buffer's {} bytes", view.0, buffer.len());
            self.error(location, problem, "the buffer may have been cut off")
        })
    }

    /// The bytes of a compressed view, which stay in memory.
    fn unpacked<'b>(
        &'b self,
        index: Index,
        from: &json::Meshopt<'_>,
        to: &'b OnceCell<Vec<u8>>,
        location: &str,
    ) -> Result<&'b [u8], Error> {
        if let Some(known) = to.get() {
            return Ok(known);
        }
        let broken = |problem: String| {
            let problem = format!("bufferView {}, compressed by meshoptimizer: {problem}", index.0);
            self.error(location, problem, "write the file again")
        };
        let stream = self.part(index, (from.buffer, from.byte_offset, from.byte_length), location)?;
        let length = meshopt::length(from).map_err(broken)?;
        self.hold(length, location)?;
        self.work(length, location)?;
        let bytes = meshopt::decode(from, stream).map_err(broken)?;
        Ok(to.get_or_init(|| bytes))
    }

    /// Finds the compressed views.
    fn find_compressed(&mut self) -> Result<(), Error> {
        for (i, piece) in self.root.buffer_views.iter().enumerate() {
            let view: json::BufferView<'a> = self.read(piece, "bufferViews")?;
            if view.extensions.meshopt().is_some() {
                self.hold(2 * size_of::<(Index, OnceCell<Vec<u8>>)>(), "bufferViews")?;
                self.unpacked.insert(Index(i as u32), OnceCell::new());
            }
        }
        Ok(())
    }

    /// Whether the file requires an extension.
    pub(super) fn requires(&self, name: &str) -> bool {
        self.root.extensions_required.iter().any(|required| **required == *name)
    }

    /// Whether the file uses an extension.
    fn uses(&self, name: &str) -> bool {
        self.root.extensions_used.iter().any(|used| **used == *name)
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
            // The buffer of the uncompressed form, which is not there.
            None if !self.unpacked.is_empty() => return Ok(Buffer { bytes: Bytes::InFile(&[]), length: 0 }),
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
        if self.uses(DRACO) {
            self.budget().add_compressed(bytes.len() as u64);
        }
        let bytes = Rc::new(bytes);
        files.insert(true_name, bytes.clone());
        Ok(bytes)
    }
}
