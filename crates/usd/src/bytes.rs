// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers at places of a file in memory, and limits of the sizes that it declares. Tests: `tests/broken.rs`.

/// A file in memory, and how much its contents may become.
pub(crate) struct Bytes<'a> {
    pub(crate) all: &'a [u8],
    /// Bytes that anything in it may be unpacked to.
    pub(crate) most: u64,
}

/// Integers that one byte of compressed data may become: 255 bytes by LZ4, each four codes of an integer.
const MOST_INTEGERS: u64 = 255 * 4;

/// A fault of a file, in words.
pub(crate) type Fault = String;

impl<'a> Bytes<'a> {
    pub(crate) fn new(all: &'a [u8]) -> Self {
        const FREE: u64 = 128 << 20;
        const GROWTH: u64 = 64;
        Self { all, most: (all.len() as u64).saturating_mul(GROWTH).max(FREE) }
    }

    /// Bytes from `at` to the end.
    pub(crate) fn left(&self, at: u64) -> u64 {
        (self.all.len() as u64).saturating_sub(at)
    }

    /// A number of `N` bytes, the lowest first.
    pub(crate) fn number<const N: usize>(&self, at: u64) -> Result<u64, Fault> {
        let begin = usize::try_from(at).ok();
        let digits =
            begin.and_then(|at| self.all.get(at..at.checked_add(N)?)).ok_or("the file ends too early")?;
        Ok(digits.iter().rev().fold(0, |sum, &digit| sum << 8 | u64::from(digit)))
    }

    /// A count of things of `size` bytes each that begin 8 bytes later.
    pub(crate) fn count(&self, at: u64, size: u64) -> Result<u64, Fault> {
        let count = self.number::<8>(at)?;
        self.capacity(at + 8, count, size).map(|()| count)
    }

    /// Whether there is room for so many things in the file.
    pub(crate) fn capacity(&self, at: u64, count: u64, size: u64) -> Result<(), Fault> {
        if count.checked_mul(size).is_none_or(|bytes| bytes > self.left(at)) {
            return Err(format!(
                "{count} values are declared at byte {at}, where the file has no room for them"
            ));
        }
        Ok(())
    }

    /// Whether so many things may be unpacked.
    pub(crate) fn allow(&self, count: u64, size: u64) -> Result<(), Fault> {
        if count.checked_mul(size).is_none_or(|bytes| bytes > self.most) {
            return Err(format!("{count} values are declared, more than a file of this length may have"));
        }
        Ok(())
    }
}

/// The place behind `count` compressed integers.
pub(crate) fn skip_integers(bytes: &Bytes<'_>, at: u64, count: u64) -> Result<u64, Fault> {
    let length = bytes.count(at, 1)?;
    if count > length.saturating_mul(MOST_INTEGERS) {
        return Err(format!("{count} integers are declared at byte {at}, more than {length} bytes can be"));
    }
    // The library takes memory for their bytes, for their codes, and for themselves.
    bytes.allow(count, 16)?;
    Ok(at + 8 + length)
}
