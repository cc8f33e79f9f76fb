// SPDX-License-Identifier: GPL-3.0-or-later
//! Opening files: regular ones only, and never more bytes than the file has.
//! Source: original. A pipe or a device could block or never end, so both are refused before they are opened.
//! Proof: `tests::{refuses_what_is_no_file, finds_names_as_exporters_write_them}`.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::Error;

/// A regular file, open for reading, and its length in bytes.
pub(crate) fn open(path: &Path) -> Result<(File, u64), Error> {
    let metadata = std::fs::metadata(path).map_err(|e| Error::system(path, &e))?;
    if metadata.is_dir() {
        return Err(Error::io(path, "is a folder", "name a file in it"));
    }
    if !metadata.is_file() {
        return Err(Error::io(path, "is a device or a pipe", "only regular files are read"));
    }
    let file = File::open(path).map_err(|e| Error::system(path, &e))?;
    Ok((file, metadata.len()))
}

/// The whole contents of a regular file, or its first `limit` bytes.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, Error> {
    let (file, length) = open(path)?;
    let length = length.min(limit);
    let mut bytes = Vec::new();
    let wanted = usize::try_from(length).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(wanted).map_err(|_| Error::io(path, "does not fit into memory", ""))?;
    file.take(length).read_to_end(&mut bytes).map_err(|e| Error::system(path, &e))?;
    Ok(bytes)
}

/// The file that `name`, found in the file `from`, means: relative to the folder of `from`, as it stands; else with
/// backslashes as slashes; else with percent signs decoded. The first one that exists, or else the first one.
pub(crate) fn resolve(from: &Path, name: &str) -> PathBuf {
    let folder = from.parent().unwrap_or(Path::new(""));
    let slashes = name.replace('\\', "/");
    let decoded = percent_decode(&slashes);
    let candidates = [name, &slashes, &String::from_utf8_lossy(&decoded)].map(|name| folder.join(name));
    candidates.iter().find(|path| path.exists()).unwrap_or(&candidates[0]).clone()
}

/// `%20` and the like as the bytes they mean; what is no such code stays.
pub(crate) fn percent_decode(name: &str) -> Vec<u8> {
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
