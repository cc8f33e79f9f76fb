// SPDX-License-Identifier: GPL-3.0-or-later
//! Which files shaders may name: included files and pictures, which may be in memory; and the cache of their
//! machine code.
//! Tests: `crates/sl-shading/tests/scripts.rs`.

use std::collections::HashMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnurt_image::{NotRegular, WorkingSpace};

use crate::texture::TextureSampler;

/// Bytes of a source file.
const LONGEST: u64 = 16 << 20;

/// Where shaders may take files from. `Codes` is the type of caches of machine code, which a program without the compiler
/// has none of.
#[derive(Clone, Debug, Default)]
pub struct Access<Codes = ()> {
    /// Only from below this folder; from anywhere if there is none.
    pub confined_to: Option<PathBuf>,
    /// Folders that `#include` searches after the shader's own.
    pub includes: Vec<String>,
    /// Source texts in memory, by their paths. They come before files.
    pub texts: Arc<HashMap<PathBuf, String>>,
    /// Pictures in memory, by the names that shaders call them. They come before files.
    pub pictures: Arc<HashMap<String, Arc<TextureSampler>>>,
    /// The cache of their machine code.
    pub codes: Codes,
    /// The space in which light is computed. Shaders compute in Rec. 709, and their closures are converted; those that
    /// trace rays or query lights themselves compute in this space.
    pub space: WorkingSpace,
}

impl<Codes> Access<Codes> {
    /// Whether a file may be read.
    #[must_use]
    pub fn allows(&self, path: &Path) -> bool {
        let Some(folder) = &self.confined_to else { return true };
        match (path.canonicalize(), folder.canonicalize()) {
            (Ok(path), Ok(folder)) => path.starts_with(folder),
            _ => false,
        }
    }

    /// Whether there is a text of this path.
    #[must_use]
    pub fn has(&self, path: &Path) -> bool {
        self.texts.contains_key(path) || path.is_file()
    }

    /// The text of a file.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub fn text(&self, path: &Path) -> Result<String, String> {
        if let Some(text) = self.texts.get(path) {
            return Ok(text.clone());
        }
        if !self.allows(path) {
            return Err("it is outside of the folder that files may come from".to_owned());
        }
        let reason = |error: std::io::Error| gnurt_image::system_reason(&error);
        let (file, _) = gnurt_image::open_regular(path).map_err(|fault| match fault {
            NotRegular::System(error) => reason(error),
            NotRegular::Folder | NotRegular::Device => "not a file".to_owned(),
        })?;
        let mut bytes = Vec::new();
        file.take(LONGEST + 1).read_to_end(&mut bytes).map_err(reason)?;
        if bytes.len() as u64 > LONGEST {
            return Err(format!("longer than {} MiB", LONGEST >> 20));
        }
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}
