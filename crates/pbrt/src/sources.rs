// SPDX-License-Identifier: GPL-3.0-or-later
//! The text of files, unpacked where it is packed, and the stack of files that include each other.
//! Invariants: the budget allows bytes before they are taken; at most [`DEEPEST`] files are open at once; text that is
//! included again costs work, so that no short file takes long. Tests: `tests/broken.rs`.

use std::collections::HashSet;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use flate2::read::MultiGzDecoder;
use gnurt_scene::io::Error;
use gnurt_scene::io::reader::{Access, Excess, open};

/// Files that may include each other, one within the other.
const DEEPEST: usize = 32;
/// Bytes that are unpacked at once.
const PIECE: usize = 1 << 16;

/// Whether a name is that of a packed file.
pub(crate) fn is_packed(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("gz"))
}

/// Unpacks a gzip file; the budget allows each piece first.
pub(crate) fn unpack(packed: &[u8], path: &Path, access: &Access) -> Result<Vec<u8>, Error> {
    let mut unpacked = Vec::new();
    let mut decoder = MultiGzDecoder::new(packed);
    let mut piece = vec![0; PIECE];
    loop {
        let count = decoder.read(&mut piece).map_err(|e| {
            Error::data(
                path,
                None,
                format!("is not a whole gzip file: {e}"),
                "pack it again, or give it unpacked",
            )
        })?;
        if count == 0 {
            return Ok(unpacked);
        }
        let excess = |e: Excess| Error::data(path, None, e.to_string(), Excess::REMEDY);
        if unpacked.len() + count > unpacked.capacity() {
            // Both are held while it grows.
            let more = unpacked.capacity().max(count);
            access.budget.hold(more).map_err(excess)?;
            unpacked.reserve_exact(more);
        }
        unpacked.extend_from_slice(&piece[..count]);
    }
}

/// A file whose statements are read.
pub(crate) struct Source {
    pub(crate) path: Arc<Path>,
    pub(crate) bytes: Vec<u8>,
    /// The next byte.
    pub(crate) at: usize,
    /// Its line.
    pub(crate) line: u64,
    /// Attributes that were begun before it, where it is imported: what it sets ends with it.
    pub(crate) import: Option<usize>,
}

/// Files that include each other, the last one innermost.
pub(crate) struct Sources<'a> {
    access: &'a Access,
    pub(crate) stack: Vec<Source>,
    /// Files that were read once.
    known: HashSet<PathBuf>,
    /// All of them, in order.
    pub(crate) files: Vec<PathBuf>,
}

impl<'a> Sources<'a> {
    pub(crate) fn new(access: &'a Access) -> Self {
        Self { access, stack: Vec::new(), known: HashSet::new(), files: Vec::new() }
    }

    /// Opens the scene's own file, which the caller has chosen.
    pub(crate) fn open_first(&mut self, path: &Path) -> Result<(), Error> {
        let (file, length) = open(path)?;
        self.access.budget.add_file(length);
        self.take(file, length, path, None)
    }

    /// Opens a file that another one names.
    pub(crate) fn open_named(&mut self, path: &Path, import: Option<usize>) -> Result<(), Error> {
        if self.stack.len() >= DEEPEST {
            let problem = format!("more than {DEEPEST} files include each other");
            return Err(Error::data(path, None, problem, "a file must not include itself"));
        }
        let (file, length) = self.access.open(path)?;
        if self.known.contains(path) {
            let looked = usize::try_from(length).unwrap_or(usize::MAX).saturating_add(1 << 12);
            // Reading a statement takes longer than looking at a byte.
            let excess = |e: Excess| Error::data(path, None, e.to_string(), Excess::REMEDY);
            self.access.budget.work(looked.saturating_mul(16)).map_err(excess)?;
        } else {
            self.access.budget.add_file(length);
        }
        self.take(file, length, path, import)
    }

    fn take(
        &mut self,
        file: std::fs::File,
        length: u64,
        path: &Path,
        import: Option<usize>,
    ) -> Result<(), Error> {
        let excess = |e: Excess| Error::data(path, None, e.to_string(), Excess::REMEDY);
        let capacity = usize::try_from(length).unwrap_or(usize::MAX);
        self.access.budget.hold(capacity).map_err(excess)?;
        let mut bytes = Vec::new();
        let failed = |e: std::io::Error| Error::io(path, format!("cannot be read: {e}"), "");
        file.take(length).read_to_end(&mut bytes).map_err(failed)?;
        if is_packed(path) {
            let unpacked = unpack(&bytes, path, self.access)?;
            self.access.budget.release(capacity);
            bytes = unpacked;
        }
        if self.known.insert(path.to_owned()) {
            self.files.push(path.to_owned());
        }
        self.stack.push(Source { path: path.into(), bytes, at: 0, line: 1, import });
        Ok(())
    }

    /// Closes the innermost file.
    pub(crate) fn close(&mut self) -> Option<Source> {
        let source = self.stack.pop()?;
        self.access.budget.release(source.bytes.capacity());
        Some(source)
    }
}
