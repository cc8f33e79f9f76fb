// SPDX-License-Identifier: GPL-3.0-or-later
//! Notices changes of files, by polling their times and sizes. Polling detects changes on any file system,
//! and those of editors that replace files instead of writing into them. A change counts only after two equal
//! polls, so that a file is not read during a write. Tests: `tests`.

use std::path::PathBuf;
use std::time::SystemTime;

/// Time and size of a file; `None` if it is not there.
type Mark = Option<(SystemTime, u64)>;

/// Files that are watched.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    files: Vec<PathBuf>,
    /// As they were when they were read.
    known: Vec<Mark>,
    /// Their state at the last check.
    known_marks: Vec<Mark>,
}

impl Watch {
    /// Watches these files from now on, in their current state.
    pub(crate) fn new(files: Vec<PathBuf>) -> Self {
        let marks: Vec<Mark> = files.iter().map(mark).collect();
        Self { files, known: marks.clone(), known_marks: marks }
    }

    /// Whether there are no files to watch.
    pub(crate) fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Checks; reports each change once, when the file has come to rest.
    pub(crate) fn has_changed(&mut self) -> bool {
        !self.changed().is_empty()
    }

    /// The same, and which files: all that have changed once all of them rest.
    pub(crate) fn changed(&mut self) -> Vec<PathBuf> {
        let now: Vec<Mark> = self.files.iter().map(mark).collect();
        let rests = now == self.known_marks;
        self.known_marks = now;
        if !rests || self.known_marks == self.known {
            return Vec::new();
        }
        let is_other = |&i: &usize| self.known_marks[i] != self.known[i];
        let changed = (0..self.files.len()).filter(is_other).map(|i| self.files[i].clone()).collect();
        self.known.clone_from(&self.known_marks);
        changed
    }
}

fn mark(path: &PathBuf) -> Mark {
    let data = std::fs::metadata(path).ok()?;
    Some((data.modified().ok()?, data.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_change_is_told_once_it_rests() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        std::fs::write(&a, "1").expect("a file");
        let mut watch = Watch::new(vec![a.clone(), b.clone()]);
        assert!(!watch.has_changed() && !watch.has_changed(), "nothing happens");
        std::fs::write(&a, "12").expect("a file");
        assert!(!watch.has_changed(), "it may still be written");
        std::fs::write(&a, "123").expect("a file");
        assert!(!watch.has_changed(), "as it was");
        assert!(watch.has_changed(), "now it rests");
        assert!(!watch.has_changed(), "told once");
        std::fs::write(&b, "new").expect("a file");
        assert!(!watch.has_changed() && watch.has_changed(), "a file that comes");
        std::fs::remove_file(&a).expect("it is there");
        assert!(!watch.has_changed() && watch.changed() == [a], "a file that goes");
    }
}
