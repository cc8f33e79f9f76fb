// SPDX-License-Identifier: GPL-3.0-or-later
//! Writing of a file as a whole: under a temporary name in the same folder, synced, then renamed over it.
//! Symbolic links are followed, so that a link stays one. Invariants: after a failure the old file is
//! unchanged and no new one is left; the file's permissions are those of the old one, or the umask's.
//! Tests: `tests`.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::Error;

/// The limit of links before they count as a cycle, equal to Linux's.
const MAX_LINKS: usize = 40;

/// Whether a picture can be written to this path, to fail before the work instead of after it.
///
/// # Errors
/// [`Error::File`] if the folder is missing or cannot be written to, or the target is a folder, device or read-only file.
pub fn check_writable(path: &Path) -> Result<(), Error> {
    let target = follow_links(path)?;
    check_target(path, &target)?;
    // Only an attempt shows it: permissions, read-only file systems and quotas matter.
    temporary_beside(path, &target).map(drop)
}

/// Replaces a file by these bytes, or makes it.
///
/// # Errors
/// [`Error::File`] names the failed operation; then nothing has changed.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    replace_file_if(path, bytes, || true).map(drop)
}

/// As [`replace_file`], but checks once more, when all is written and nothing is visible yet, whether it is
/// still wanted; returns that. If not, nothing has changed.
///
/// # Errors
/// As [`replace_file`].
pub fn replace_file_if(path: &Path, bytes: &[u8], is_wanted: impl FnOnce() -> bool) -> Result<bool, Error> {
    let write =
        |file: &mut File| file.write_all(bytes).map_err(|e| Error::file(path, "cannot be written", &e));
    replace_by(path, write, is_wanted)
}

/// As [`replace_file_if`] for what `write` writes.
pub(super) fn replace_by(
    path: &Path,
    write: impl FnOnce(&mut File) -> Result<(), Error>,
    is_wanted: impl FnOnce() -> bool,
) -> Result<bool, Error> {
    let failed = |what: &str, error: &std::io::Error| Error::file(path, what, error);
    let target = follow_links(path)?;
    check_target(path, &target)?;
    let mut temporary = temporary_beside(path, &target)?;
    write(temporary.as_file_mut())?;
    if let Ok(old) = std::fs::metadata(&target) {
        let keep = temporary.as_file().set_permissions(old.permissions());
        keep.map_err(|e| failed("cannot keep the file's permissions", &e))?;
    }
    temporary.as_file().sync_all().map_err(|e| failed("cannot be written", &e))?;
    if !is_wanted() {
        return Ok(false);
    }
    temporary.persist(&target).map_err(|e| failed("cannot be replaced", &e.error))?;
    sync_folder(&target);
    Ok(true)
}

/// The path at the end of all links, whether there is a file or not.
fn follow_links(path: &Path) -> Result<PathBuf, Error> {
    let mut target = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        match std::fs::read_link(&target) {
            // A relative link starts at the folder of the link; `join` takes an absolute one as it is.
            Ok(next) => target = folder_of(&target).join(next),
            Err(_) => return Ok(target),
        }
    }
    Err(Error::File { path: path.into(), what: "cannot be written: its symbolic links form a circle".into() })
}

fn check_target(path: &Path, target: &Path) -> Result<(), Error> {
    let refuse = |what: String| Err(Error::File { path: path.into(), what });
    if target.file_name().is_none() {
        return refuse("cannot be written: it names no file".into());
    }
    let folder = folder_of(target);
    if !folder.is_dir() {
        let state = if folder.exists() { "is not a folder" } else { "does not exist" };
        return refuse(format!("cannot be written: {} {state}", folder.display()));
    }
    match std::fs::metadata(target) {
        Ok(old) if old.is_dir() => refuse("cannot be written: it is a folder".into()),
        Ok(old) if !old.is_file() => refuse("cannot be written: it is a device or pipe".into()),
        // A rename would replace a write-protected file without a check; opening it checks.
        Ok(_) => std::fs::OpenOptions::new()
            .write(true)
            .open(target)
            .map(drop)
            .map_err(|error| Error::file(path, "cannot be written", &error)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        // Such as a name that is too long, which a temporary name in its folder would not detect.
        Err(error) => Err(Error::file(path, "cannot be written", &error)),
    }
}

fn temporary_beside(path: &Path, target: &Path) -> Result<tempfile::NamedTempFile, Error> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".gnurt-").suffix(".part");
    #[cfg(unix)]
    {
        // The umask applies to these; without them the file would be private to the user.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder_of(target)).map_err(|error| Error::file(path, "cannot be written", &error))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Makes the new name last through a power cut where the system can; the file itself is already safe.
fn sync_folder(target: &Path) {
    if let Ok(folder) = File::open(folder_of(target)) {
        // Some file systems cannot sync folders; the picture is written all the same.
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("the folder can be listed");
        let mut names: Vec<_> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn folder() -> tempfile::TempDir {
        tempfile::tempdir().expect("a folder for the test")
    }

    #[test]
    fn files_are_made_and_replaced() {
        let folder = folder();
        let path = folder.path().join("a.png");
        for bytes in [&b"first"[..], b"second"] {
            replace_file(&path, bytes).expect("the folder can be written to");
            assert_eq!(
                std::fs::read(&path).expect("the file is there"),
                bytes,
                "the new bytes are in the file"
            );
            assert_eq!(names_in(folder.path()), ["a.png"], "nothing else is left");
        }
    }

    #[test]
    fn what_is_no_longer_wanted_leaves_nothing() {
        let folder = folder();
        let path = folder.path().join("a.png");
        std::fs::write(&path, "old").expect("an old file");
        assert!(!replace_file_if(&path, b"new", || false).expect("nothing goes wrong"), "the answer is told");
        assert_eq!(std::fs::read(&path).expect("the old file"), b"old", "the old file is as it was");
        assert_eq!(names_in(folder.path()), ["a.png"], "nothing else is left");
    }

    #[test]
    fn checking_leaves_nothing() {
        let folder = folder();
        check_writable(&folder.path().join("a.png")).expect("the folder can be written to");
        assert!(names_in(folder.path()).is_empty(), "checking made a file");
    }

    #[test]
    fn failures_name_the_file_and_leave_nothing() {
        let folder = folder();
        let inside = folder.path().join("inside");
        std::fs::create_dir(&inside).expect("a folder in the folder");
        std::fs::write(folder.path().join("file"), "old").expect("a file in the folder");
        let long = "x".repeat(300) + ".png";
        for path in [
            inside.clone(),
            folder.path().join("none/a.png"),
            folder.path().join("file/a.png"),
            folder.path().join(long),
        ] {
            for result in [check_writable(&path), replace_file(&path, b"new")] {
                let message = result.expect_err("this path cannot be written").to_string();
                assert!(message.starts_with(&path.display().to_string()), "the file is named: {message}");
            }
        }
        assert_eq!(names_in(folder.path()), ["file", "inside"], "nothing was made or removed");
        assert_eq!(std::fs::read(folder.path().join("file")).expect("the old file"), b"old", "nor changed");
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links() {
        let folder = folder();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("deep")).expect("a folder in the folder");
        std::os::unix::fs::symlink("deep/second", at("first")).expect("a relative link");
        std::os::unix::fs::symlink("real.png", at("deep/second")).expect("a link to nothing yet");
        replace_file(&at("first"), b"through links").expect("the link's target can be made");
        assert_eq!(
            std::fs::read(at("deep/real.png")).expect("the target"),
            b"through links",
            "the target's bytes"
        );
        assert!(at("first").is_symlink() && at("deep/second").is_symlink(), "both links are still links");
        assert_eq!(names_in(&at("deep")), ["real.png", "second"], "nothing is left beside the target");
    }

    #[cfg(unix)]
    #[test]
    fn circles_and_devices_are_refused() {
        let folder = folder();
        let circle = folder.path().join("circle.png");
        std::os::unix::fs::symlink("circle.png", &circle).expect("a link to itself");
        let message = check_writable(&circle).expect_err("a circle has no end").to_string();
        assert!(message.contains("circle"), "the message says so: {message}");
        let device = replace_file(Path::new("/dev/null"), b"").expect_err("a device is kept").to_string();
        assert!(device.contains("device"), "the message says so: {device}");
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_kept() {
        use std::os::unix::fs::PermissionsExt;
        let folder = folder();
        let path = folder.path().join("a.png");
        let mode =
            |path: &Path| std::fs::metadata(path).expect("the file is there").permissions().mode() & 0o777;
        std::fs::write(folder.path().join("plain"), "").expect("a file made the plain way");
        replace_file(&path, b"1").expect("the file can be made");
        assert_eq!(mode(&path), mode(&folder.path().join("plain")), "a new file follows the umask");
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o640)).expect("a mode can be set");
        replace_file(&path, b"2").expect("the file can be replaced");
        assert_eq!(mode(&path), 0o640, "a replaced file keeps its mode");
    }
}
