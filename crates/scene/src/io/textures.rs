// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures of a file, each decoded once, and a warning where one is missing or broken.
//! Source: original. Proof: `tests`. The picture's declared size is checked by the image crate before memory is taken.

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

/// Bytes that the texels of a scene may take however short their files are.
const BELIEVED_BYTES: usize = 512 << 20;

/// Bytes of texels that each byte of a picture's file may become beyond that: a few flat pictures are no harm, a file
/// that names many of them is.
const MOST_GROWTH: usize = 64;

/// Pictures that were decoded already, or why they could not be, and a limit on what all of them take.
pub(crate) struct Pictures {
    files: HashMap<(PathBuf, Meaning), Result<Arc<Texels>, String>>,
    /// Bytes that texels may still take.
    budget: usize,
}

impl Default for Pictures {
    fn default() -> Self {
        Self { files: HashMap::new(), budget: BELIEVED_BYTES }
    }
}

impl Pictures {
    /// The picture in a file; the error says why there is none.
    pub(crate) fn file(&mut self, path: &Path, meaning: Meaning) -> Result<Arc<Texels>, String> {
        let key = (path.to_owned(), meaning);
        if let Some(known) = self.files.get(&key) {
            return known.clone();
        }
        let bytes = source::read(path, u64::MAX).map_err(|e| e.to_string());
        let loaded = bytes.and_then(|bytes| self.decode(&bytes, &path.to_string_lossy(), meaning));
        self.files.insert(key, loaded.clone());
        loaded
    }

    /// The files that were asked for, those that could not be read included.
    pub(crate) fn paths(&self) -> Vec<PathBuf> {
        let mut paths: Vec<PathBuf> = self.files.keys().map(|(path, _)| path.clone()).collect();
        paths.sort_unstable();
        paths.dedup();
        paths
    }

    /// Decodes the bytes of a picture file of any format; `name` is for messages.
    pub(crate) fn decode(
        &mut self,
        bytes: &[u8],
        name: &str,
        meaning: Meaning,
    ) -> Result<Arc<Texels>, String> {
        let texels = match meaning {
            Meaning::Color => gnurt_image::decode_texture(bytes, name),
            Meaning::Data => gnurt_image::decode_data_texture(bytes, name),
        };
        let texels = texels.map_err(|e| e.to_string())?;
        let allowed = self.budget.saturating_add(bytes.len().saturating_mul(MOST_GROWTH));
        self.budget = allowed.checked_sub(texels.memory_bytes()).ok_or_else(|| {
            let size = format!("{} x {} pixels of {} bytes", texels.width, texels.height, bytes.len());
            format!("{name}: {size} are one picture too many for the memory that textures may take")
        })?;
        Ok(Arc::new(texels))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_files_do_not_fill_the_memory() {
        let side: u32 = 2048;
        let (format, options) = (gnurt_image::OutputFormat::Png, gnurt_image::WriteOptions::default());
        let picture = gnurt_image::Picture::new(side, side);
        let flat = gnurt_image::encode(&picture, format, &options).expect("a flat picture");
        let mut pictures = Pictures::default();
        let mut held = 0;
        let refused = (0..100).find_map(|_| match pictures.decode(&flat, "flat.png", Meaning::Color) {
            Ok(texels) => {
                held += texels.memory_bytes();
                None
            }
            Err(why) => Some(why),
        });
        let why = refused.expect("100 times 16 MiB are too much");
        assert!(why.contains("flat.png: 2048 x 2048"), "which one, and why: {why}");
        assert!(held <= BELIEVED_BYTES + 100 * flat.len() * MOST_GROWTH, "{held} bytes are held");
    }
}
