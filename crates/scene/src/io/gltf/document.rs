// SPDX-License-Identifier: GPL-3.0-or-later
//! A glTF document with its buffers in memory.
//! Source: glTF 2.0 sections 3.6 and 3.12. Buffers: data URI, file beside the document, binary chunk.
//! Invariant: a buffer has the length that it declares. Proof: `tests/gltf.rs`, `tests/broken_files.rs`.

use std::cell::Cell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use gltf::json::{self, Index};

use super::base64::data_uri;
use super::container::Container;
use crate::io::error::quoted;
use crate::io::{Error, Format, Oddity, Warnings, source};

/// Extensions whose absence nobody would notice.
const KNOWN_EXTENSIONS: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
];

/// Values may be used by several meshes and take more bytes in memory than in the file, but not this many times more.
const MOST_GROWTH: usize = 64;

/// The first `length` of these bytes; buffers that name the same file share them.
struct Buffer {
    bytes: Rc<Vec<u8>>,
    length: usize,
}

impl Buffer {
    fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}

/// The JSON, the buffers, and a limit on what is made of them.
pub(super) struct Document {
    pub(super) path: PathBuf,
    pub(super) root: json::Root,
    buffers: Vec<Buffer>,
    /// Bytes that arrays may still take.
    budget: Cell<usize>,
}

impl Document {
    pub(super) fn new(
        path: &Path,
        bytes: &[u8],
        format: Format,
        warnings: &mut Warnings,
    ) -> Result<Self, Error> {
        let container = Container::new(bytes, format, path)?;
        let root = parse(container.json, container.binary.is_none(), path)?;
        if !root.asset.version.starts_with("2.") {
            let problem = format!("glTF version {}", quoted(&root.asset.version));
            return Err(Error::data(path, None, problem, "expected version 2.0"));
        }
        for name in root.extensions_required.iter().filter(|name| !KNOWN_EXTENSIONS.contains(&name.as_str()))
        {
            warnings.note(Oddity::UnknownExtension, path, None, quoted(name));
        }
        let mut document = Self { path: path.to_owned(), root, buffers: Vec::new(), budget: Cell::new(0) };
        let (buffers, beside) = document.read_buffers(container.binary)?;
        document.buffers = buffers;
        let known = beside.saturating_add(bytes.len());
        document.budget = Cell::new(known.saturating_mul(MOST_GROWTH).saturating_add(1 << 24));
        Ok(document)
    }

    /// A mistake at a place such as `meshes[3]`.
    pub(super) fn error(&self, place: &str, problem: impl std::fmt::Display, remedy: &str) -> Error {
        Error::data(&self.path, None, format!("{place}: {problem}"), remedy)
    }

    /// What an index found at `place` points to.
    pub(super) fn get<T>(&self, index: Index<T>, place: &str, what: &str) -> Result<&T, Error>
    where
        json::Root: json::root::Get<T>,
    {
        let missing = || self.error(place, format!("{what} {} does not exist", index.value()), "");
        self.root.get(index).ok_or_else(missing)
    }

    /// Allows `bytes` more to be taken, or says that the file asks for more than it holds.
    pub(super) fn spend(&self, bytes: usize, place: &str) -> Result<(), Error> {
        let left = self.budget.get().checked_sub(bytes).ok_or_else(|| {
            let problem = format!("more than {MOST_GROWTH} times the file's own bytes are asked for");
            self.error(place, problem, "accessors should refer to data that is there")
        })?;
        self.budget.set(left);
        Ok(())
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, index: Index<json::buffer::View>, place: &str) -> Result<&[u8], Error> {
        let view = self.get(index, place, "bufferView")?;
        self.get(view.buffer, place, "buffer")?;
        let buffer = self.buffers[view.buffer.value()].bytes();
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0).and_then(|end| usize::try_from(end).ok());
        end.and_then(|end| buffer.get(start as usize..end)).ok_or_else(|| {
            let problem =
                format!("bufferView {} ends after its buffer's {} bytes", index.value(), buffer.len());
            self.error(place, problem, "the buffer may have been cut off")
        })
    }

    /// The buffers, and how many bytes were read from other files.
    fn read_buffers(&self, binary: Option<&[u8]>) -> Result<(Vec<Buffer>, usize), Error> {
        let mut files = HashMap::new();
        let buffers = self.root.buffers.iter().enumerate();
        let buffers: Result<Vec<_>, Error> =
            buffers.map(|(i, buffer)| self.read_buffer(i, buffer, binary, &mut files)).collect();
        Ok((buffers?, files.values().map(|bytes| bytes.len()).sum()))
    }

    fn read_buffer(
        &self,
        i: usize,
        buffer: &json::Buffer,
        binary: Option<&[u8]>,
        files: &mut HashMap<PathBuf, Rc<Vec<u8>>>,
    ) -> Result<Buffer, Error> {
        let place = format!("buffers[{i}]");
        let bytes = match &buffer.uri {
            None if i == 0 => Rc::new(binary.map(<[u8]>::to_vec).unwrap_or_default()),
            None => Rc::default(),
            Some(uri) if uri.starts_with("data:") => {
                data_uri(uri).ok_or_else(|| self.error(&place, "broken data URI", "expected base64"))?.into()
            }
            Some(uri) => self.read_file(uri, &place, files)?,
        };
        let declared = buffer.byte_length.0;
        let length = usize::try_from(declared).ok().filter(|&length| length <= bytes.len());
        let length = length.ok_or_else(|| {
            let problem = format!("{declared} bytes are declared, but there are {}", bytes.len());
            self.error(&place, problem, "the buffer may have been cut off")
        })?;
        Ok(Buffer { bytes, length })
    }

    /// The document's own file and those that it names.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let buffers = self.root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
        let images = self.root.images.iter().filter_map(|image| image.uri.as_deref());
        let named = buffers.chain(images).filter(|uri| !uri.starts_with("data:"));
        std::iter::once(self.path.clone()).chain(named.map(|uri| source::resolve(&self.path, uri))).collect()
    }

    /// The most bytes that a buffer declares: no file beside the document is read further.
    fn longest_buffer(&self) -> u64 {
        self.root.buffers.iter().map(|buffer| buffer.byte_length.0).max().unwrap_or(0)
    }

    /// The bytes of a file beside the document, each file once, by whatever names it goes.
    fn read_file(
        &self,
        uri: &str,
        place: &str,
        files: &mut HashMap<PathBuf, Rc<Vec<u8>>>,
    ) -> Result<Rc<Vec<u8>>, Error> {
        let file = source::resolve(&self.path, uri);
        let true_name = std::fs::canonicalize(&file).unwrap_or_else(|_| file.clone());
        if let Some(bytes) = files.get(&true_name) {
            return Ok(bytes.clone());
        }
        let bytes: Rc<Vec<u8>> = source::read(&file, self.longest_buffer())
            .map_err(|e| self.error(place, e.to_string(), ""))?
            .into();
        files.insert(true_name, bytes.clone());
        Ok(bytes)
    }
}

fn parse(json: &[u8], is_text: bool, path: &Path) -> Result<json::Root, Error> {
    json::deserialize::from_slice(json).map_err(|error| {
        let text = error.to_string();
        let problem = text.split(" at line ").next().unwrap_or_default();
        // In a binary file nobody sees lines.
        let line = (is_text && error.line() > 0).then_some(error.line() as u64);
        Error::data(path, line, format!("broken JSON: {problem}"), "expected a glTF 2.0 document")
    })
}
