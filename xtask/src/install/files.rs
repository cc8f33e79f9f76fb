// SPDX-License-Identifier: GPL-3.0-or-later
//! Installation of files: existing ones are replaced, folders are made.

use std::path::{Component, Path, PathBuf};

use crate::failure::Failure;

pub(crate) fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    make_folder(to)?;
    // A running program's file cannot be written, but it can be replaced.
    let _ = std::fs::remove_file(to);
    std::fs::copy(from, to).map_err(|error| format!("{} to {}: {error}", from.display(), to.display()))?;
    Ok(())
}

pub(crate) fn write(to: &Path, text: &str) -> Result<(), Failure> {
    make_folder(to)?;
    let _ = std::fs::remove_file(to);
    std::fs::write(to, text).map_err(|error| format!("{}: {error}", to.display()))
}

pub(crate) fn link(target: &str, to: &Path) -> Result<(), Failure> {
    make_folder(to)?;
    let _ = std::fs::remove_file(to);
    #[cfg(unix)]
    let linked = std::os::unix::fs::symlink(target, to);
    #[cfg(not(unix))]
    let linked = std::fs::copy(to.with_file_name(target), to).map(drop);
    linked.map_err(|error| format!("{}: {error}", to.display()))
}

pub(crate) fn remove(file: &Path) -> Result<(), Failure> {
    std::fs::remove_file(file).map_err(|error| format!("{}: {error}", file.display()))
}

fn make_folder(file: &Path) -> Result<(), Failure> {
    let folder = file.parent().unwrap_or(file);
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))
}

pub(crate) fn read(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// The contents of a folder, in the order of names.
pub(crate) fn files_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    Ok(files)
}

/// All files and links below a folder, as paths from it.
pub(crate) fn tree(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut found = Vec::new();
    let mut todo = vec![folder.to_path_buf()];
    while let Some(at) = todo.pop() {
        for path in files_in(&at)? {
            if path.is_dir() && !path.is_symlink() {
                todo.push(path);
            } else if let Ok(path) = path.strip_prefix(folder) {
                found.push(path.to_path_buf());
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The relative path from one absolute folder to another.
pub(crate) fn relative(from: &Path, to: &Path) -> PathBuf {
    let (from, to): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (from.components().collect(), to.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = from[shared..].iter().map(|_| Component::ParentDir);
    up.chain(to[shared..].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_between_folders() {
        for (from, to, method) in [
            ("/usr/lib/x86_64-linux-gnu/cmake/OpenRT", "/usr/include", "../../../../include"),
            ("/usr/lib/cmake/OpenRT", "/usr/lib", "../.."),
            ("/a/b", "/a/b", ""),
            ("/a", "/a/b/c", "b/c"),
        ] {
            assert_eq!(relative(from.as_ref(), to.as_ref()), Path::new(method), "{from} to {to}");
        }
    }
}
