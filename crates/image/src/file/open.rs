// SPDX-License-Identifier: GPL-3.0-or-later
//! Opening files to read: regular files only, since devices and pipes may block or never end.
//! Tests: `tests`.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crate::Error;

/// Opens a regular file that `request` ("a picture file") is to be in; gives its length too.
pub(crate) fn open_regular(path: &Path, request: &str) -> Result<(BufReader<File>, u64), Error> {
    // Asked before the file is opened: opening a pipe waits for its other end.
    let metadata = std::fs::metadata(path).map_err(|error| Error::file(path, "cannot be read", &error))?;
    if !metadata.is_file() {
        let kind = if metadata.is_dir() { "is a folder" } else { "is a device or pipe" };
        return Err(Error::File { path: path.into(), what: format!("{kind}; {request} is needed") });
    }
    let file = File::open(path).map_err(|error| Error::file(path, "cannot be read", &error))?;
    Ok((BufReader::with_capacity(1 << 16, file), metadata.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_opened() {
        let missing = open_regular(Path::new("no/such/file.png"), "a picture file")
            .expect_err("there is no such file")
            .to_string();
        assert!(missing.starts_with("no/such/file.png: cannot be read: "), "file and reason: {missing}");
        assert!(!missing.contains("os error"), "no error numbers: {missing}");
        let folder = open_regular(&std::env::temp_dir(), "a picture file")
            .expect_err("a folder is no picture")
            .to_string();
        assert!(folder.contains("is a folder"), "the message says what it is: {folder}");
        #[cfg(unix)]
        {
            let device = open_regular(Path::new("/dev/zero"), "a picture file")
                .expect_err("a device is no picture")
                .to_string();
            assert!(device.contains("is a device or pipe"), "the message says what it is: {device}");
        }
    }
}
