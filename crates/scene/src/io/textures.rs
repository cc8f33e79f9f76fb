// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures of a file, each decoded once, and a warning where one is missing or broken.
//! Source: original. The picture's declared size is checked by the image crate before memory is taken.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::source;
use crate::texture::Texels;

/// What the values of a texture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Meaning {
    /// Colours: bytes are sRGB.
    Color,
    /// Numbers: bytes are linear.
    Data,
}

/// Pictures that were decoded already, or why they could not be.
#[derive(Default)]
pub(crate) struct Pictures {
    files: HashMap<(PathBuf, Meaning), Result<Arc<Texels>, String>>,
}

impl Pictures {
    /// The picture in a file; the error says why there is none.
    pub(crate) fn file(&mut self, path: &Path, meaning: Meaning) -> Result<Arc<Texels>, String> {
        let key = (path.to_owned(), meaning);
        self.files.entry(key).or_insert_with(|| load(path, meaning)).clone()
    }
}

fn load(path: &Path, meaning: Meaning) -> Result<Arc<Texels>, String> {
    let bytes = source::read(path, u64::MAX).map_err(|e| e.to_string())?;
    decode(&bytes, &path.to_string_lossy(), meaning)
}

/// Decodes the bytes of a picture file of any format; `name` is for messages.
pub(crate) fn decode(bytes: &[u8], name: &str, meaning: Meaning) -> Result<Arc<Texels>, String> {
    let texels = match meaning {
        Meaning::Color => gnurt_image::decode_texture(bytes, name),
        Meaning::Data => gnurt_image::decode_data_texture(bytes, name),
    };
    texels.map(Arc::new).map_err(|e| e.to_string())
}
