// SPDX-License-Identifier: GPL-3.0-or-later
//! Loading: a stage opened within its rights, on a thread of its own, whose panics become errors of the file.
//! Invariant: no panic of the library leaves this file. Tests: `tests/broken.rs`.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use gnurt_scene::io::reader::{self, Access};
use gnurt_scene::io::{Error, Loaded, VariantChoice};
use openusd::usd::Stage;

use crate::files::{Files, Resolver, SESSION};
use crate::reader::Reader;
use crate::walk;

/// The library descends into nested things by calling itself.
const STACK: usize = 256 << 20;
/// The remedy of faults without one of their own.
const REMEDY: &str = "valid are text layers (#usda 1.0), binary layers (PXR-USDC) and packages of them (zip)";

/// Reads a file into a scene.
pub(crate) fn load(path: &Path, access: &Access) -> Result<Loaded, Error> {
    // The system's own words for a file that is not there.
    drop(reader::open(path)?);
    let inner = access.renewed();
    let (loaded, length) = std::thread::scope(|scope| {
        let guarded = move || gnurt_image::expecting_panics(|| open(path, inner));
        let thread = std::thread::Builder::new().name("usd".into()).stack_size(STACK);
        let running = thread.spawn_scoped(scope, guarded).map_err(|error| {
            Error::io(path, format!("cannot be read on a thread of its own: {error}"), "free some memory")
        })?;
        running
            .join()
            .ok()
            .flatten()
            .unwrap_or_else(|| Err(Error::data(path, None, "the file contradicts itself", REMEDY)))
    })?;
    access.budget.add_file(length);
    Ok(loaded)
}

/// The scene, and the bytes of all files.
fn open(path: &Path, access: Access) -> Result<(Loaded, u64), Error> {
    let at = access.at;
    let session = session_layer(&access.variants)
        .map_err(|(problem, remedy)| Error::data(path, None, problem, remedy))?;
    let root = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let root = root.to_string_lossy().into_owned();
    let has_session = !access.variants.is_empty();
    let files = Rc::new(Files::new(access, session));
    let mut builder = Stage::builder().resolver(Resolver(files.clone()));
    if has_session {
        builder = builder.session_layer(SESSION);
    }
    let stage = builder.open(&root).map_err(|error| {
        let known = files.faults().into_iter().next();
        let problem = known.unwrap_or_else(|| plain(&format!("{error:#}"), path, &root));
        Error::data(path, line_of(&problem), problem, REMEDY)
    })?;
    let reader = Reader::new(stage, at, path.to_owned(), files.clone());
    reader.check_rate()?;
    reader.check_variants()?;
    let scene = walk::scene(&reader)?;
    reader.note_composition_errors();
    let paths: Vec<PathBuf> = std::iter::once(path.to_owned())
        .chain(files.paths().into_iter().filter(|file| file.to_string_lossy() != root))
        .collect();
    let length = files.length();
    Ok((Loaded { scene, warnings: reader.into_warnings(), files: paths }, length))
}

/// A message of the library without the long name of the file, which stands in front of it.
fn plain(message: &str, path: &Path, root: &str) -> String {
    message.replace(root, &path.display().to_string()).replace('\n', " ")
}

/// The number after the word `line`, if there is one.
fn line_of(message: &str) -> Option<u64> {
    let (_, rest) = message.split_once("line ")?;
    rest.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
}

/// A layer that chooses variants before all others do.
fn session_layer(variants: &[VariantChoice]) -> Result<String, (String, String)> {
    let mut text = "#usda 1.0\n".to_owned();
    for VariantChoice { prim, set, variant } in variants {
        let is_name =
            |name: &str| !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || "_-|.".contains(c));
        let is_path = prim.starts_with('/') && prim.len() > 1 && prim[1..].split('/').all(is_name);
        if !is_path || !is_name(set) || !is_name(variant) {
            let named = if prim.is_empty() { variant.clone() } else { format!("{prim}:{set}={variant}") };
            return Err((
                format!("variant '{named}'"),
                "valid is a path, a set and a variant: /World/Chair:fabric=red".to_owned(),
            ));
        }
        let names: Vec<&str> = prim[1..].split('/').collect();
        for (depth, name) in names.iter().enumerate() {
            let choice = match depth + 1 == names.len() {
                true => format!(" ( variants = {{ string {set} = \"{variant}\" }} )"),
                false => String::new(),
            };
            text += &format!("over \"{name}\"{choice}\n{{\n");
        }
        text += &"}\n".repeat(names.len());
    }
    Ok(text)
}
