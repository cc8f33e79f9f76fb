// SPDX-License-Identifier: GPL-3.0-or-later
//! Words written to a file. Tests: `tests/saved.rs`.

use std::io::{self, Write};

use super::data::{Checksum, MAGIC, PIECE, StoredRecord, VERSION};
use crate::aabb::Aabb;

/// Writes to `to`, piece by piece, and updates the checksum.
pub struct Writer<'a, W> {
    to: &'a mut W,
    sum: Checksum,
    bytes: Vec<u8>,
}

impl<'a, W: Write> Writer<'a, W> {
    /// Starts a file.
    pub fn new(to: &'a mut W) -> io::Result<Self> {
        let mut writer = Self { to, sum: Checksum::default(), bytes: Vec::with_capacity(4 * PIECE) };
        writer.data(&[MAGIC[0], MAGIC[1], VERSION, 0])?;
        Ok(writer)
    }

    fn data(&mut self, data: &[u32]) -> io::Result<()> {
        self.sum.add(data);
        self.bytes.clear();
        self.bytes.extend(data.iter().flat_map(|item| item.to_le_bytes()));
        self.to.write_all(&self.bytes)
    }

    pub fn number(&mut self, number: u64) -> io::Result<()> {
        self.data(&[number as u32, (number >> 32) as u32])
    }

    pub fn bounds(&mut self, bounds: &Aabb) -> io::Result<()> {
        let [a, b, c] = bounds.min.map(f32::to_bits);
        let [d, e, f] = bounds.max.map(f32::to_bits);
        self.data(&[a, b, c, d, e, f])
    }

    pub fn list<T: StoredRecord>(&mut self, records: &[T]) -> io::Result<()> {
        self.number(records.len() as u64)?;
        let at_once = PIECE / T::LENGTH;
        let mut data = vec![0; at_once.min(records.len()) * T::LENGTH];
        for some in records.chunks(at_once) {
            for (record, data) in some.iter().zip(data.chunks_exact_mut(T::LENGTH)) {
                record.put(data);
            }
            self.data(&data[..some.len() * T::LENGTH])?;
        }
        Ok(())
    }

    /// Puts the checksum behind all.
    pub fn end(mut self) -> io::Result<()> {
        let sum = self.sum.value();
        self.number(sum)?;
        self.to.flush()
    }
}
