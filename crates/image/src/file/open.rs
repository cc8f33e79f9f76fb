// SPDX-License-Identifier: GPL-3.0-or-later
//! Opening files to read: regular files only, since devices and pipes may block or never end.
//! Tests: `tests`.

use std::fs::File;
use std::path::Path;

use crate::Error;

/// The reason why a file cannot be opened; each crate words it for its own errors.
#[derive(Debug)]
pub enum NotRegular {
    /// If the system rejects it.
    System(std::io::Error),
    /// It is a folder.
    Folder,
    /// It is a device or a pipe.
    Device,
}

impl NotRegular {
    /// The error of a picture file; `request` names the file that is needed.
    pub(crate) fn in_file(&self, path: &Path, request: &str) -> Error {
        let kind = match self {
            Self::System(error) => return Error::file(path, "cannot be read", error),
            Self::Folder => "is a folder",
            Self::Device => "is a device or pipe",
        };
        Error::File { path: path.into(), what: format!("{kind}; {request} is needed") }
    }
}

/// Opens a regular file; returns its length too.
///
/// # Errors
/// If there is no such file, it is not regular, or it may not be read.
pub fn open_regular(path: &Path) -> Result<(File, u64), NotRegular> {
    // Checked before the file is opened: opening a pipe waits for its other end.
    let metadata = std::fs::metadata(path).map_err(NotRegular::System)?;
    if metadata.is_dir() {
        return Err(NotRegular::Folder);
    }
    if !metadata.is_file() {
        return Err(NotRegular::Device);
    }
    let file = File::open(path).map_err(NotRegular::System)?;
    Ok((file, metadata.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_opened() {
        let message = |path: &Path| {
            let fault = open_regular(path).expect_err("it is no regular file");
            fault.in_file(path, "a picture file").to_string()
        };
        let missing = message(Path::new("no/such/file.png"));
        assert!(missing.starts_with("no/such/file.png: cannot be read: "), "file and reason: {missing}");
        assert!(!missing.contains("os error"), "no error numbers: {missing}");
        let folder = message(&std::env::temp_dir());
        assert!(
            folder.contains("is a folder; a picture file is needed"),
            "the message says what it is: {folder}"
        );
        #[cfg(unix)]
        {
            let device = message(Path::new("/dev/zero"));
            assert!(device.contains("is a device or pipe"), "the message says what it is: {device}");
        }
    }
}
