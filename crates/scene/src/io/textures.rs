// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures of a file, each decoded once, and a warning where one is missing or broken.
//! Tests: `tests`. The image crate gets the rest of the budget, and checks a picture's declared size before
//! it takes memory.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::source::Access;
use crate::texture::Texels;

/// The meaning of a texture's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Meaning {
    /// Colours: bytes are sRGB.
    Color,
    /// Numbers: bytes are linear.
    Data,
}

/// Pictures that were decoded already, or why they could not be.
pub struct Pictures<'a> {
    access: &'a Access,
    files: HashMap<(PathBuf, Meaning), Result<Arc<Texels>, String>>,
}

impl<'a> Pictures<'a> {
    /// No pictures yet, read through `access`.
    pub fn new(access: &'a Access) -> Self {
        Self { access, files: HashMap::new() }
    }

    /// The picture in a file; the error names the file and the reason.
    pub fn file(&mut self, path: &Path, meaning: Meaning) -> Result<Arc<Texels>, String> {
        let key = (path.to_owned(), meaning);
        if let Some(known) = self.files.get(&key) {
            return known.clone();
        }
        let loaded = self.load(path, meaning);
        self.files.insert(key, loaded.clone());
        loaded
    }

    fn load(&self, path: &Path, meaning: Meaning) -> Result<Arc<Texels>, String> {
        let bytes = self.access.read(path, u64::MAX).map_err(|e| e.to_string())?;
        let decoded = self.decode(&bytes, &path.to_string_lossy(), meaning);
        self.access.budget.release(bytes.len());
        decoded
    }

    /// The requested files, unreadable ones included.
    pub fn paths(&self) -> Vec<PathBuf> {
        let mut paths: Vec<PathBuf> = self.files.keys().map(|(path, _)| path.clone()).collect();
        paths.sort_unstable();
        paths.dedup();
        paths
    }

    /// Decodes the bytes of a picture file of any format; `name` is for messages.
    pub fn decode(&self, bytes: &[u8], name: &str, meaning: Meaning) -> Result<Arc<Texels>, String> {
        let budget = &self.access.budget;
        budget.add_picture(bytes.len() as u64);
        let most = budget.left();
        let workers: gnurt_image::Workers<'_> = &|count, job| self.access.work(count, job);
        let texels = match meaning {
            Meaning::Color => gnurt_image::decode_texture_within(bytes, name, most, workers),
            Meaning::Data => gnurt_image::decode_data_texture_within(bytes, name, most, workers),
        };
        let texels = texels.map_err(|e| match e {
            gnurt_image::Error::TooMuchMemory { .. } if self.access.tiles.is_none() => {
                format!("{name}: {e}; or keep textures on the disk, `--texture-memory`")
            }
            _ => format!("{name}: {e}"),
        })?;
        let texels = match &self.access.tiles {
            Some(tiles) => tiles.keep(texels).map_err(|e| format!("{name}: {e}"))?,
            None => texels,
        };
        budget.hold(texels.memory_bytes()).map_err(|excess| format!("{name}: {excess}"))?;
        Ok(Arc::new(texels))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::LoadOptions;

    #[test]
    fn exrs_are_the_same_by_any_threads() {
        let (format, options) = (gnurt_image::PictureFormat::EXR, gnurt_image::WriteOptions::default());
        let mut picture = gnurt_image::Picture::new(256, 300);
        for (i, pixel) in picture.color.iter_mut().enumerate() {
            *pixel = [i as f32 * 0.25, (i * i % 77) as f32, 3.0, 1.0];
        }
        let file = gnurt_image::encode(&picture, format, &options).expect("a picture");
        let read = |threads: usize, meaning| {
            let access = Access::new(&LoadOptions { threads, ..LoadOptions::default() }).expect("no folder");
            Pictures::new(&access).decode(&file, "a.exr", meaning).expect("it was written")
        };
        for meaning in [Meaning::Color, Meaning::Data] {
            assert!(read(1, meaning) == read(4, meaning), "{meaning:?}");
        }
    }

    #[test]
    fn short_files_do_not_fill_the_memory() {
        let side: u32 = 2048;
        let (format, options) = (gnurt_image::PictureFormat::PNG, gnurt_image::WriteOptions::default());
        let picture = gnurt_image::Picture::new(side, side);
        let flat = gnurt_image::encode(&picture, format, &options).expect("a flat picture");
        let access = Access::default();
        let pictures = Pictures::new(&access);
        let mut held = 0;
        let refused = (0..100).find_map(|_| match pictures.decode(&flat, "flat.png", Meaning::Color) {
            Ok(texels) => {
                held += texels.memory_bytes();
                None
            }
            Err(why) => Some(why),
        });
        let why = refused.expect("100 times 16 MiB are too much");
        assert!(why.contains("flat.png: ") && why.contains("2048 x 2048"), "which one, and why: {why}");
        assert!(why.contains("--texture-memory"), "what helps: {why}");
        assert!(held <= 480 << 20, "{held} bytes are held");
    }
}
