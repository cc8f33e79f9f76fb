// SPDX-License-Identifier: GPL-3.0-or-later
//! Opening files: regular ones only, never more bytes than the file has, and only below a folder if there is one.
//! A pipe or a device could block or never end, so both are rejected before they are opened.
//! Tests: `tests::{refuses_what_is_no_file, finds_names_as_exporters_write_them}`, `tests/confine.rs`.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicBool, Ordering},
};

use gnurt_image::{Budget, Excess, NotRegular, TileCache};

use super::error::Error;
use super::options::{LoadOptions, VariantChoice};
use super::threads;

/// The files that a scene may name, and the budget for reading them.
#[derive(Debug, Default)]
pub struct Access {
    /// The folder, its true name, that files must lie below.
    confine: Option<PathBuf>,
    /// The cache of textures.
    pub tiles: Option<TileCache>,
    /// Memory and work spent so far.
    pub budget: Budget,
    /// See [`LoadOptions::at`].
    pub at: Option<f64>,
    /// See [`LoadOptions::variants`].
    pub variants: Vec<VariantChoice>,
    /// See [`LoadOptions::subdivision`].
    pub subdivision: Option<u32>,
    /// See [`LoadOptions::threads`].
    pub threads: usize,
}

impl Access {
    /// From `options`; an error if the folder is not one.
    pub fn new(options: &LoadOptions) -> Result<Self, Error> {
        let free = Self {
            confine: None,
            tiles: options.tiles.clone(),
            budget: Budget::default(),
            at: options.at,
            variants: options.variants.clone(),
            subdivision: options.subdivision,
            threads: options.threads,
        };
        let Some(folder) = &options.confine else {
            return Ok(free);
        };
        let folder = std::fs::canonicalize(folder).map_err(|e| Error::system(folder, &e))?;
        if !folder.is_dir() {
            return Err(Error::io(&folder, "is not a folder", "name the folder that files may be read from"));
        }
        Ok(Self { confine: Some(folder), ..free })
    }

    /// The same rights with a budget of its own, for libraries that open files themselves.
    #[must_use]
    pub fn renewed(&self) -> Self {
        Self {
            confine: self.confine.clone(),
            tiles: self.tiles.clone(),
            budget: Budget::default(),
            at: self.at,
            variants: self.variants.clone(),
            subdivision: self.subdivision,
            threads: self.threads,
        }
    }

    /// The number of threads that reading may use.
    pub fn threads(&self) -> usize {
        threads::count(self.threads)
    }

    /// Calls a job once for each number below a count, in any order, on these threads.
    pub fn work(&self, count: usize, job: &(dyn Fn(usize) + Sync)) {
        threads::for_each(self.threads(), count, job);
    }

    /// Whether files must lie below a folder.
    pub fn is_confined(&self) -> bool {
        self.confine.is_some()
    }

    /// The folder that files must be in.
    pub fn confined_to(&self) -> Option<PathBuf> {
        self.confine.clone()
    }

    /// Rejects a file outside of the folder that confines the scene; the error gives the fault and the
    /// remedy.
    pub fn check(&self, path: &Path) -> Result<(), (String, String)> {
        let Some(folder) = &self.confine else {
            return Ok(());
        };
        match locate(path, folder) {
            Err(Refusal::Outside) => Err((
                format!("{} is outside of the folder that files may be in", path.display()),
                format!("expected a file below {}", folder.display()),
            )),
            Ok(_) | Err(Refusal::System(_)) => Ok(()),
        }
    }

    /// The file that a scene names: a regular one, open for reading, and its length in bytes.
    pub fn open(&self, path: &Path) -> Result<(File, u64), Error> {
        self.budget.name_file().map_err(|e| Error::io(path, e.to_string(), Excess::REMEDY))?;
        let Some(folder) = &self.confine else {
            return open(path);
        };
        self.check(path).map_err(|(problem, remedy)| Error::io(path, problem, remedy))?;
        match locate(path, folder) {
            // By its resolved name, so that a link changed meanwhile has no effect.
            Ok(found) => open(&found),
            Err(Refusal::System(error)) => Err(Error::system(path, &error)),
            Err(Refusal::Outside) => Err(Error::io(path, "is outside", "")),
        }
    }

    /// The whole contents of a file that a scene names, or its first `limit` bytes.
    pub fn read(&self, path: &Path, limit: u64) -> Result<Vec<u8>, Error> {
        let (file, length) = self.open(path)?;
        let length = length.min(limit);
        self.budget.add_file(length);
        let capacity = usize::try_from(length).unwrap_or(usize::MAX);
        self.budget.hold(capacity).map_err(|e| Error::io(path, e.to_string(), Excess::REMEDY))?;
        read_open(file, length, path)
    }
}

/// Why a file is not to be had.
enum Refusal {
    Outside,
    System(std::io::Error),
}

/// The true name of a file below `folder`. The existence of files elsewhere is not revealed.
fn locate(path: &Path, folder: &Path) -> Result<PathBuf, Refusal> {
    match std::fs::canonicalize(path) {
        Ok(found) if found.starts_with(folder) => Ok(found),
        Ok(_) => Err(Refusal::Outside),
        Err(error) => {
            let mut above = path.ancestors().skip(1).map(|above| match above.as_os_str().is_empty() {
                true => Path::new("."),
                false => above,
            });
            let nearest = above.find_map(|above| std::fs::canonicalize(above).ok());
            // A dangling link may have a target outside.
            let is_link = std::fs::symlink_metadata(path).is_ok_and(|m| m.is_symlink());
            match nearest {
                Some(above) if above.starts_with(folder) && !is_link => Err(Refusal::System(error)),
                _ => Err(Refusal::Outside),
            }
        }
    }
}

/// A regular file, open for reading, and its length in bytes.
pub fn open(path: &Path) -> Result<(File, u64), Error> {
    gnurt_image::open_regular(path).map_err(|fault| match fault {
        NotRegular::System(error) => Error::system(path, &error),
        NotRegular::Folder => Error::io(path, "is a folder", "name a file in it"),
        NotRegular::Device => Error::io(path, "is a device or a pipe", "only regular files are read"),
    })
}

/// The whole contents of a regular file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Error> {
    let (file, length) = open(path)?;
    read_open(file, length, path)
}

/// The same on up to this many threads, where the file is large.
pub fn read_by(path: &Path, threads: usize) -> Result<Vec<u8>, Error> {
    let (file, length) = open(path)?;
    match read_pieces(&file, length, threads) {
        Some(bytes) => Ok(bytes),
        None => read_open(file, length, path),
    }
}

/// A large file in pieces, one for each thread: the system needs more time for new memory than for the copy. `None` where that
/// does not work, or is not worth it.
#[cfg(unix)]
fn read_pieces(file: &File, length: u64, threads: usize) -> Option<Vec<u8>> {
    use std::os::unix::fs::FileExt;
    /// Bytes that are worth a thread.
    const PIECE: u64 = 1 << 19;
    let pieces = (length / PIECE).min(threads as u64) as usize;
    if pieces < 2 {
        return None;
    }
    let length = usize::try_from(length).ok()?;
    // A lack of memory is an error of the other way, and would be the end of the program here.
    Vec::<u8>::new().try_reserve_exact(length).ok()?;
    let mut bytes = vec![0; length];
    let size = length.div_ceil(pieces);
    let parts: Vec<Mutex<&mut [u8]>> = bytes.chunks_mut(size).map(Mutex::new).collect();
    let is_read = AtomicBool::new(true);
    threads::for_each(threads, parts.len(), &|i| {
        let mut part = parts[i].lock().unwrap_or_else(PoisonError::into_inner);
        if file.read_exact_at(&mut part, (i * size) as u64).is_err() {
            is_read.store(false, Ordering::Relaxed);
        }
    });
    is_read.into_inner().then_some(bytes)
}

#[cfg(not(unix))]
fn read_pieces(_: &File, _: u64, _: usize) -> Option<Vec<u8>> {
    None
}

fn read_open(file: File, length: u64, path: &Path) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let capacity = usize::try_from(length).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(capacity).map_err(|_| Error::io(path, "does not fit into memory", ""))?;
    file.take(length).read_to_end(&mut bytes).map_err(|e| Error::system(path, &e))?;
    Ok(bytes)
}

/// The file of `name`, found in the file `from`: relative to the folder of `from`, unchanged; else with
/// backslashes as slashes; else with percent signs decoded. The first one that exists, or else the first one.
pub fn resolve(from: &Path, name: &str) -> PathBuf {
    let folder = from.parent().unwrap_or(Path::new(""));
    let as_written = folder.join(name);
    if !name.contains(['\\', '%']) || as_written.exists() {
        return as_written;
    }
    let slashes = name.replace('\\', "/");
    let decoded = percent_decode(&slashes);
    let others = [&slashes, &String::from_utf8_lossy(&decoded)[..]].map(|name| folder.join(name));
    others.into_iter().find(|path| path.exists()).unwrap_or(as_written)
}

/// Decodes `%20` and the like to bytes; an invalid code stays.
pub fn percent_decode(name: &str) -> Vec<u8> {
    let bytes = name.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let code = bytes.get(at + 1..at + 3).filter(|_| bytes[at] == b'%').and_then(|hex| {
            let digit = |b: u8| char::from(b).to_digit(16);
            Some((digit(hex[0])? * 16 + digit(hex[1])?) as u8)
        });
        decoded.push(code.unwrap_or(bytes[at]));
        at += if code.is_some() { 3 } else { 1 };
    }
    decoded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_is_no_file() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let message = |path: &Path| open(path).expect_err("it is no file").to_string();
        assert!(message(folder.path()).contains("is a folder"), "a folder");
        assert!(message(&folder.path().join("none.obj")).contains("no such file"), "nothing");
        if cfg!(unix) {
            assert!(message(Path::new("/dev/zero")).contains("device or a pipe"), "a device");
        }
    }

    #[test]
    fn finds_names_as_exporters_write_them() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::create_dir(folder.path().join("maps")).expect("a folder");
        let file = folder.path().join("maps/oak böard.png");
        std::fs::write(&file, b"x").expect("a file");
        let from = folder.path().join("scene.obj");
        for name in ["maps/oak böard.png", "maps\\oak böard.png", "maps/oak%20b%C3%B6ard.png"] {
            assert_eq!(resolve(&from, name), file, "{name}");
        }
        assert_eq!(percent_decode("100%, %zz, %4"), b"100%, %zz, %4", "what is no code stays");
    }
}
