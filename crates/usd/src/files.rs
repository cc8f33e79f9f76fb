// SPDX-License-Identifier: GPL-3.0-or-later
//! The files that layers and textures come from: found beside the layer that names them, read by the scene's rights and budget.
//! Layers are checked before the library reads them, since it trusts the sizes that they declare.
//! Invariant: nothing is opened but by [`Access`]. Tests: `tests/broken.rs`, `tests/composition.rs`.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use gnurt_scene::io::reader::{self, Access};
use openusd::ar;

use crate::package::Package;
use crate::{crate_check, mtlx_layer, text_check, text_lists};

/// The identifier of the layer that chooses variants.
pub(crate) const SESSION: &str = "variants-of-the-command-line.usda";

/// Files by their identifiers: absolute paths, and those of packages with the name of an entry in brackets.
pub(crate) struct Files {
    pub(crate) access: Access,
    /// The text of the layer that chooses variants.
    session: String,
    read: RefCell<BTreeMap<PathBuf, Kept>>,
    /// Why layers could not be read.
    faults: RefCell<BTreeMap<String, String>>,
}

/// Bytes of a file, or why there are none.
type Kept = Result<Arc<Vec<u8>>, String>;

impl Files {
    pub(crate) fn new(access: Access, session: String) -> Self {
        Self { access, session, read: RefCell::default(), faults: RefCell::default() }
    }

    /// The bytes of a file or of an entry of a package.
    pub(crate) fn bytes(&self, identifier: &str) -> Result<Arc<Vec<u8>>, String> {
        match split(identifier) {
            None => self.file(Path::new(identifier)),
            Some((package, entry)) => {
                let bytes = self.file(Path::new(package))?;
                if mtlx_layer::is_document(package) {
                    return self.document(package).map(Arc::new);
                }
                let entry =
                    Package::open(&bytes).and_then(|package| package.entry(entry).map(<[u8]>::to_vec));
                let entry = entry.map_err(|fault| format!("{package}: {fault}"))?;
                self.access.budget.hold(entry.len()).map_err(|excess| format!("{package}: {excess}"))?;
                Ok(Arc::new(entry))
            }
        }
    }

    /// The layer of a document of MaterialX.
    fn document(&self, file: &str) -> Result<Vec<u8>, String> {
        let mut read = |path: &Path| {
            let bytes = self.file(path)?;
            String::from_utf8(bytes.to_vec()).map_err(|error| error.to_string())
        };
        mtlx_layer::layer(file, &mut read).map(String::into_bytes)
    }

    fn file(&self, path: &Path) -> Kept {
        if let Some(known) = self.read.borrow().get(path) {
            return known.clone();
        }
        let read = self.access.read(path, u64::MAX).map(Arc::new).map_err(|error| error.to_string());
        self.read.borrow_mut().insert(path.to_owned(), read.clone());
        read
    }

    /// The files that were asked for, those that could not be read included.
    pub(crate) fn paths(&self) -> Vec<PathBuf> {
        self.read.borrow().keys().cloned().collect()
    }

    /// Bytes of all files that were read.
    pub(crate) fn length(&self) -> u64 {
        self.read.borrow().values().flatten().map(|bytes| bytes.len() as u64).sum()
    }

    /// Why layers could not be read, if we know better than the library.
    pub(crate) fn faults(&self) -> Vec<String> {
        self.faults.borrow().values().cloned().collect()
    }

    /// A layer's bytes, looked over.
    fn layer(&self, identifier: &str) -> Result<Arc<Vec<u8>>, String> {
        let bytes = self.bytes(identifier)?;
        if bytes.starts_with(crate_check::MAGIC) {
            crate_check::check(&bytes)?;
        } else {
            text_check::check(&bytes)?;
        }
        let hold = |count: usize| self.access.budget.hold(count).map_err(|excess| excess.to_string());
        hold(bytes.len().saturating_mul(2))?;
        let is_text = !bytes.starts_with(crate_check::MAGIC);
        match is_text.then(|| text_lists::plain(&bytes)).flatten() {
            Some(plain) => hold(plain.len()).map(|()| Arc::new(plain)),
            None => Ok(bytes),
        }
    }
}

/// `package.usdz[entry]` as its parts.
pub(crate) fn split(identifier: &str) -> Option<(&str, &str)> {
    let (package, rest) = identifier.split_once('[')?;
    Some((package, rest.strip_suffix(']')?))
}

fn is_package(path: &str) -> bool {
    path.to_ascii_lowercase().ends_with(".usdz")
}

/// A path without `.` and, as far as there is something above, `..`.
fn normalized(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if normal.file_name().is_some() => {
                normal.pop();
            }
            other => normal.push(other),
        }
    }
    normal
}

/// The name of an entry, from the one that names it.
fn within(from: &str, name: &str) -> String {
    let folder = Path::new(from).parent().unwrap_or(Path::new(""));
    normalized(&folder.join(name.trim_start_matches('/'))).to_string_lossy().into_owned()
}

/// The library's access to files.
pub(crate) struct Resolver(pub(crate) Rc<Files>);

impl ar::Resolver for Resolver {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ar::ResolvedPath>) -> String {
        if asset_path.is_empty() || asset_path == SESSION {
            return asset_path.to_owned();
        }
        let from = anchor.map(ToString::to_string).unwrap_or_default();
        if let Some((package, entry)) = split(&from) {
            return match split(asset_path) {
                Some((inner, _)) => format!("{package}[{}]", within(entry, inner)),
                None => format!("{package}[{}]", within(entry, asset_path)),
            };
        }
        let (file, entry) = match split(asset_path) {
            Some((file, entry)) => (file, Some(entry)),
            None => (asset_path, None),
        };
        let file = normalized(&reader::resolve(Path::new(&from), file));
        let file = file.to_string_lossy();
        match entry {
            Some(entry) => format!("{file}[{entry}]"),
            None => file.into_owned(),
        }
    }

    fn resolve(&self, asset_path: &str) -> Option<ar::ResolvedPath> {
        let found = |path: &str| Some(ar::ResolvedPath::new(path));
        if asset_path == SESSION {
            return found(asset_path);
        }
        if let Some((package, entry)) = split(asset_path) {
            let bytes = self.0.file(Path::new(package)).ok()?;
            if mtlx_layer::is_document(package) {
                return found(asset_path);
            }
            let has = Package::open(&bytes).is_ok_and(|package| package.entry(entry).is_ok());
            return if has { found(asset_path) } else { None };
        }
        if mtlx_layer::is_document(asset_path) && Path::new(asset_path).exists() {
            return found(&format!("{asset_path}[{}]", mtlx_layer::LAYER));
        }
        if is_package(asset_path) {
            // A package that cannot be read is read once more, for its fault to be told.
            let first = self.0.file(Path::new(asset_path)).and_then(|bytes| {
                Package::open(&bytes).and_then(|package| package.first_layer().map(str::to_owned))
            });
            return match first {
                Ok(first) => found(&format!("{asset_path}[{first}]")),
                Err(fault) => {
                    self.0.faults.borrow_mut().insert(asset_path.to_owned(), fault);
                    found(&format!("{asset_path}[root.usda]"))
                }
            };
        }
        // A forbidden path is found here, there or not; it is refused when it is opened.
        let path = Path::new(asset_path);
        if self.0.access.check(path).is_err() || path.exists() { found(asset_path) } else { None }
    }

    fn resolve_for_new_asset(&self, _: &str) -> Option<ar::ResolvedPath> {
        None
    }

    fn open_asset(&self, resolved_path: &ar::ResolvedPath) -> io::Result<Box<dyn ar::Asset>> {
        let identifier = resolved_path.to_string();
        let bytes = match &identifier[..] {
            SESSION => Ok(Arc::new(self.0.session.clone().into_bytes())),
            _ => self.0.layer(&identifier),
        };
        let bytes = bytes.map_err(|fault| {
            self.0.faults.borrow_mut().insert(identifier, fault.clone());
            io::Error::other(fault)
        })?;
        Ok(Box::new(Shared(Cursor::new(Bytes(bytes)))))
    }

    fn get_modification_timestamp(&self, _: &str, _: &ar::ResolvedPath) -> Option<std::time::SystemTime> {
        None
    }
}

struct Bytes(Arc<Vec<u8>>);

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// A file in memory that others read, too.
struct Shared(Cursor<Bytes>);

impl Read for Shared {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        self.0.read(to)
    }
}

impl Seek for Shared {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

impl ar::Asset for Shared {
    fn size(&self) -> io::Result<u64> {
        Ok(self.0.get_ref().0.len() as u64)
    }
}
