// SPDX-License-Identifier: GPL-3.0-or-later
//! Words read from a file.
//! Invariant: memory grows with the bytes read so far, never with a count in a file.
//! Tests: `tests/saved.rs`.

use std::io::Read;

use gnurt_simd::prefer_huge_pages;

use super::data::{Checksum, MAGIC, PIECE, StoredRecord, VERSION, get_floats};
use super::error::LoadError;
use crate::aabb::Aabb;
use crate::geometry::FARTHEST_PLANE;

/// Reads from `from`, piece by piece, and updates the checksum.
pub struct Reader<'a, R> {
    from: &'a mut R,
    sum: Checksum,
    bytes: Vec<u8>,
    data: Vec<u32>,
}

impl<'a, R: Read> Reader<'a, R> {
    /// Starts a file.
    pub fn new(from: &'a mut R) -> Result<Self, LoadError> {
        let mut reader = Self { from, sum: Checksum::default(), bytes: Vec::new(), data: Vec::new() };
        if reader.data(2)? != MAGIC {
            return Err(LoadError::NotATree);
        }
        let &[version, _] = reader.data(2)? else { return Err(LoadError::Truncated) };
        if version != VERSION {
            return Err(LoadError::Version(version));
        }
        Ok(reader)
    }

    /// The next words, not many.
    fn data(&mut self, count: usize) -> Result<&[u32], LoadError> {
        self.bytes.resize(4 * count, 0);
        self.from.read_exact(&mut self.bytes)?;
        self.data.clear();
        self.data.extend(self.bytes.as_chunks::<4>().0.iter().map(|&bytes| u32::from_le_bytes(bytes)));
        self.sum.add(&self.data);
        Ok(&self.data)
    }

    pub fn number(&mut self) -> Result<u64, LoadError> {
        let data = self.data(2)?;
        Ok(u64::from(data[0]) | u64::from(data[1]) << 32)
    }

    /// A box that is empty, or has finite ordered sides.
    pub fn bounds(&mut self) -> Result<Aabb, LoadError> {
        let mut sides = [0.0; 6];
        get_floats(&mut sides, self.data(6)?);
        let [a, b, c, d, e, f] = sides;
        let bounds = Aabb { min: [a, b, c], max: [d, e, f] };
        if bounds == Aabb::EMPTY || is_sound(&bounds) {
            return Ok(bounds);
        }
        Err(LoadError::Damaged("its bounds are invalid"))
    }

    /// A list of at most this many records.
    pub fn list<T: StoredRecord>(&mut self, most: usize) -> Result<Vec<T>, LoadError> {
        let count = self.number()?;
        if count > most as u64 {
            return Err(LoadError::Damaged("a list is too long"));
        }
        let count = count as usize;
        let at_once = PIECE / T::LENGTH;
        let mut records = Vec::new();
        while records.len() < count {
            let now = at_once.min(count - records.len());
            let data = self.data(now * T::LENGTH)?;
            if records.capacity() < records.len() + now {
                // Twice the existing number, except for the last time.
                let additional = (2 * records.len()).max(now).min(count) - records.len();
                records.reserve_exact(additional);
                prefer_huge_pages(&records);
            }
            records.extend(data.chunks_exact(T::LENGTH).map(T::get));
        }
        Ok(records)
    }

    /// Compares the checksum.
    pub fn end(mut self) -> Result<(), LoadError> {
        let sum = self.sum.value();
        if self.number()? == sum { Ok(()) } else { Err(LoadError::Checksum) }
    }
}

/// Whether a box is not empty and its planes are within the range of a build.
pub fn is_sound(bounds: &Aabb) -> bool {
    (0..3).all(|k| {
        -FARTHEST_PLANE <= bounds.min[k] && bounds.min[k] <= bounds.max[k] && bounds.max[k] <= FARTHEST_PLANE
    })
}
