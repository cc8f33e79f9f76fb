// SPDX-License-Identifier: GPL-3.0-or-later
//! The files that layers and textures come from: found beside the layer that names them, read by the scene's rights and budget.
//! Layers are checked before the library reads them, since it trusts the sizes that they declare.
//! Invariant: nothing is opened but by [`Access`]. Tests: `tests/broken.rs`, `tests/composition.rs`.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use gnurt_scene::io::reader::{self, Access};
use openusd::ar;

use crate::arrays::Arrays;
use crate::crate_check::Checked;
use crate::layer::{Asset, Edit, Layer};
use crate::package::Package;
use crate::{crate_arrays, crate_check, mtlx_layer, text_arrays, text_check, text_lists, text_numbers};

/// The identifier of the layer that chooses variants.
pub(crate) const SESSION: &str = "variants-of-the-command-line.usda";

/// Fields of values that vary with time.
const VARYING: [&[u8]; 3] = [b"timeSamples", b"clips", b"spline"];

/// Files by their identifiers: absolute paths, and those of packages with the name of an entry in brackets.
pub(crate) struct Files {
    pub(crate) access: Access,
    /// The text of the layer that chooses variants.
    session: String,
    read: RefCell<BTreeMap<PathBuf, Kept>>,
    /// Layers that were looked over.
    layers: RefCell<BTreeMap<String, Arc<Layer>>>,
    /// Their long arrays.
    pub(crate) arrays: Arrays,
    /// Whether one of them mentions values that vary with time.
    pub(crate) varies: Cell<bool>,
    /// Why layers could not be read.
    faults: RefCell<BTreeMap<String, String>>,
}

/// Memory of an edit that adds a byte.
const EDIT_BYTES: usize = size_of::<Edit>() + 32;

/// Bytes of a file, or why there are none.
type Kept = Result<Arc<Vec<u8>>, String>;

impl Files {
    pub(crate) fn new(access: Access, session: String) -> Self {
        let (read, layers, faults) = Default::default();
        Self { access, session, read, layers, arrays: Arrays::default(), varies: Cell::new(false), faults }
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

    /// A layer, looked over once, with stand-ins for its long arrays.
    fn layer(&self, identifier: &str) -> Result<Arc<Layer>, String> {
        if let Some(known) = self.layers.borrow().get(identifier) {
            return Ok(known.clone());
        }
        let bytes = match identifier {
            SESSION => Arc::new(self.session.clone().into_bytes()),
            _ => self.bytes(identifier)?,
        };
        let hold = |count: usize| self.access.budget.hold(count).map_err(|excess| excess.to_string());
        let layer = if bytes.starts_with(crate_check::MAGIC) {
            let checked = crate_check::check(&bytes)?;
            hold(bytes.len().saturating_mul(2))?;
            let varies =
                |checked: &Checked| checked.fields.tokens().iter().any(|token| VARYING.contains(token));
            self.varies.set(self.varies.get() || checked.as_ref().is_some_and(varies));
            let edits = checked.map(|checked| crate_arrays::edits(&bytes, &checked, &self.arrays));
            Layer::new(bytes, edits.unwrap_or_default())
        } else {
            let found = text_check::check(&bytes)?;
            hold(bytes.len().saturating_mul(2))?;
            let plain = text_lists::plain(&bytes).map(|plain| hold(plain.len()).map(|()| Arc::new(plain)));
            let text = plain.transpose()?.unwrap_or(bytes);
            self.varies.set(self.varies.get() || text_arrays::mentions(&text, &found, &VARYING));
            let mut edits = text_arrays::edits(&text, &found, &self.arrays, &self.access);
            let numbers = text_numbers::edits(&text, &edits);
            hold(numbers.len().saturating_mul(EDIT_BYTES))?;
            edits.extend(numbers);
            Layer::new(text, edits)
        };
        let layer = Arc::new(layer);
        self.layers.borrow_mut().insert(identifier.to_owned(), layer.clone());
        Ok(layer)
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
        let layer = self.0.layer(&identifier).map_err(|fault| {
            self.0.faults.borrow_mut().insert(identifier, fault.clone());
            io::Error::other(fault)
        })?;
        Ok(Box::new(Asset::new(layer)))
    }

    fn get_modification_timestamp(&self, _: &str, _: &ar::ResolvedPath) -> Option<std::time::SystemTime> {
        None
    }
}
