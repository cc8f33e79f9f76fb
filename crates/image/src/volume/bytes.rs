// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers and texts of a file, one after another, little-endian; and how much memory may still be taken for them.
//! Tests: `tests/volumes.rs`.

use crate::{Budget, Error};

/// Characters of a message: names that a file holds may be as long as it.
const LONGEST: usize = 300;

/// An error about the contents of a file, on one line.
pub(super) fn corrupt(what: impl Into<String>) -> Error {
    let printable = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let what: String = what.into().chars().take(LONGEST).map(printable).collect();
    Error::corrupt("volume", what)
}

/// The error for a file that takes too much memory.
pub(super) fn too_large(limit: usize) -> Error {
    corrupt(format!("it takes more than the {} MiB allowed", limit >> 20))
}

/// The rest of a file.
pub(super) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    /// Continues at another offset.
    pub(super) fn seek(&mut self, at: i64) -> Result<(), Error> {
        let inside = usize::try_from(at).ok().filter(|&at| at <= self.all.len());
        self.at = inside.ok_or_else(|| corrupt(format!("a part at byte {at} is behind the end")))?;
        Ok(())
    }

    /// The bytes between two positions, both behind the bytes read so far; reading continues after them.
    pub(super) fn part(&mut self, start: i64, end: i64) -> Result<Self, Error> {
        let before = self.at;
        // Of a truncated file, the existing part is read first.
        self.seek(end.min(self.all.len() as i64))?;
        match usize::try_from(start).ok().filter(|&start| before <= start && start <= self.at) {
            Some(at) => Ok(Self { all: &self.all[..self.at], at }),
            None => Err(corrupt(format!("a part from byte {start} to {end} is not behind byte {before}"))),
        }
    }

    /// The bytes that were not read yet.
    pub(super) fn rest(&self) -> &'a [u8] {
        &self.all[self.at..]
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.at == self.all.len()
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.all.len());
        let end = end.ok_or_else(|| corrupt("the file ends too early"))?;
        let taken = &self.all[self.at..end];
        self.at = end;
        Ok(taken)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    pub(super) fn u8(&mut self) -> Result<u8, Error> {
        Ok(self.array::<1>()?[0])
    }

    pub(super) fn u32(&mut self) -> Result<u32, Error> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    pub(super) fn i32(&mut self) -> Result<i32, Error> {
        Ok(i32::from_le_bytes(self.array()?))
    }

    pub(super) fn i64(&mut self) -> Result<i64, Error> {
        Ok(i64::from_le_bytes(self.array()?))
    }

    pub(super) fn f64(&mut self) -> Result<f64, Error> {
        Ok(f64::from_le_bytes(self.array()?))
    }

    /// A text after its length.
    pub(super) fn text(&mut self) -> Result<String, Error> {
        let length = self.u32()? as usize;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }
}

/// Takes this many bytes of the budget.
pub(super) fn hold(budget: &Budget, bytes: usize) -> Result<(), Error> {
    budget.hold(bytes).map_err(|_| too_large(budget.limit() as usize))
}
