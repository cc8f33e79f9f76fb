// SPDX-License-Identifier: GPL-3.0-or-later
//! The cost of reading files, in memory and in work, bounded by their lengths: of a picture, a volume, or a scene with its files.
//! Invariants: memory is requested before it is allocated. Memory held at once stays below [`BELIEVED`] or,
//! for long files, below [`GROWTH`] bytes for each byte of them ([`PICTURE_GROWTH`] for pictures and compressed meshes). All bytes
//! ever processed stay below [`WORK`] or [`WORK_GROWTH`] times the files' own, so that no short file takes
//! long.
//! Tests: `tests`; `tests/growth.rs` of this crate and of the scene crate count every allocation.

use std::cell::Cell;
use std::fmt;

/// Bytes that a scene may hold however short its files are.
const BELIEVED: u64 = 480 << 20;
/// Bytes that reading one picture may take however short its file is.
const PICTURE_BELIEVED: u64 = 512 << 20;
/// Bytes that each byte of a scene file or buffer may become beyond that.
const GROWTH: u64 = 16;
/// Bytes that each byte of a picture's file may become beyond that: flat pictures take next to nothing.
const PICTURE_GROWTH: u64 = 64;
/// Bytes that may be examined however short the files are.
const WORK: u64 = 1 << 30;
/// Bytes that may be examined for each byte of the files beyond that.
const WORK_GROWTH: u64 = 64;
/// Files that a scene may name: each is searched on the disk.
const MOST_FILES: u32 = 1 << 16;

/// The cost of files so far, and its limits.
#[derive(Debug)]
pub struct Budget {
    /// Bytes that may be held however short the files are.
    free: u64,
    /// Bytes that the files account for.
    accounted: Cell<u64>,
    length: Cell<u64>,
    held: Cell<u64>,
    worked: Cell<u64>,
    files: Cell<u32>,
}

/// An exceeded budget; `Display` names the resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Excess {
    /// The limit is this many bytes at once.
    Memory(u64),
    /// The limit is this many examined bytes.
    Work(u64),
    /// Too many files are named.
    Files,
}

impl Excess {
    /// The remedy.
    pub const REMEDY: &'static str = "leave out what is not needed, or divide the scene";
}

impl fmt::Display for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Memory(limit) => {
                write!(f, "more memory is needed than a file of this length may take, {} MiB", limit >> 20)
            }
            Self::Work(limit) => {
                let limit = limit >> 20;
                write!(f, "the same data is used too often: a file of this length may read {limit} MiB of it")
            }
            Self::Files => write!(f, "more than {MOST_FILES} files are named"),
        }
    }
}

impl Default for Budget {
    /// The budget of a scene, before any of its files.
    fn default() -> Self {
        Self::of_bytes(BELIEVED)
    }
}

impl Budget {
    /// The number of bytes that may be held at once.
    #[must_use]
    pub fn of_bytes(free: u64) -> Self {
        let [accounted, length, held, worked] = [const { Cell::new(0) }; 4];
        Self { free, accounted, length, held, worked, files: Cell::new(0) }
    }

    /// The budget of one picture or volume whose file has this many bytes.
    #[must_use]
    pub fn of_picture(length: u64) -> Self {
        Self::of_bytes(length.saturating_mul(PICTURE_GROWTH).max(PICTURE_BELIEVED))
    }

    /// The same with a lower limit.
    #[must_use]
    pub fn at_most(self, bytes: u64) -> Self {
        Self { free: self.free.min(bytes), ..self }
    }

    /// Counts a file of this many bytes that was read.
    pub fn add_file(&self, bytes: u64) {
        self.add(bytes, GROWTH);
    }

    /// Counts a picture of this many bytes that was read.
    pub fn add_picture(&self, bytes: u64) {
        self.add(bytes, PICTURE_GROWTH);
    }

    /// Counts that a file of this many bytes, added before, may hold compressed meshes.
    pub fn add_compressed(&self, bytes: u64) {
        let more = bytes.saturating_mul(PICTURE_GROWTH - GROWTH);
        self.accounted.set(self.accounted.get().saturating_add(more));
    }

    fn add(&self, bytes: u64, growth: u64) {
        self.accounted.set(self.accounted.get().saturating_add(bytes.saturating_mul(growth)));
        self.length.set(self.length.get().saturating_add(bytes));
    }

    /// Bytes that may be held at once.
    pub(crate) fn limit(&self) -> u64 {
        self.accounted.get().max(self.free)
    }

    /// Bytes that may still be held.
    pub fn left(&self) -> u64 {
        self.limit().saturating_sub(self.held.get())
    }

    /// Allows `bytes` more to be held.
    pub fn hold(&self, bytes: usize) -> Result<(), Excess> {
        let bytes = bytes as u64;
        if bytes > self.left() {
            return Err(Excess::Memory(self.limit()));
        }
        self.held.set(self.held.get() + bytes);
        Ok(())
    }

    /// Memory held now.
    pub fn held(&self) -> u64 {
        self.held.get()
    }

    /// Releases all that was held since [`held`](Self::held) returned `before`.
    pub fn settle(&self, before: u64) {
        self.held.set(before.min(self.held.get()));
    }

    /// Takes back `bytes` that were held.
    pub fn release(&self, bytes: usize) {
        self.held.set(self.held.get().saturating_sub(bytes as u64));
    }

    /// Allows `bytes` more to be examined.
    pub fn work(&self, bytes: usize) -> Result<(), Excess> {
        let worked = self.worked.get().saturating_add(bytes as u64);
        let limit = self.length.get().saturating_mul(WORK_GROWTH).max(WORK);
        if worked > limit {
            return Err(Excess::Work(limit));
        }
        self.worked.set(worked);
        Ok(())
    }

    /// Allows one more file to be searched.
    pub fn name_file(&self) -> Result<(), Excess> {
        if self.files.get() == MOST_FILES {
            return Err(Excess::Files);
        }
        self.files.set(self.files.get() + 1);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_grow_with_files() {
        let budget = Budget::default();
        let believed = BELIEVED as usize;
        budget.hold(believed).expect("a short file is believed so much");
        assert_eq!(budget.hold(1), Err(Excess::Memory(BELIEVED)), "and no more");
        budget.add_file(BELIEVED / GROWTH + 1);
        budget.hold(GROWTH as usize).expect("a long file may take more");
        budget.hold(1).expect_err("but not any amount");
        budget.release(believed);
        budget.hold(believed).expect("what was given back can be taken again");
        budget.work(WORK as usize).expect("much may be looked at");
        assert!(matches!(budget.work(usize::MAX), Err(Excess::Work(_))), "but not all the time");
    }

    #[test]
    fn files_are_counted() {
        let budget = Budget::default();
        (0..MOST_FILES).for_each(|_| budget.name_file().expect("files up to the limit"));
        let line = budget.name_file().expect_err("one too many").to_string();
        assert!(line.contains("65536 files"), "{line}");
    }
}
