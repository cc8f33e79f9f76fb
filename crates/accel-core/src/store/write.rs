// SPDX-License-Identifier: GPL-3.0-or-later
//! Words on their way out. Tests: `tests/saved.rs`.

use std::io::{self, Write};

use super::words::{Checksum, MAGIC, PIECE, VERSION, Words};
use crate::aabb::Aabb;

/// Writes to `to`, piece by piece, and sums up what was written.
pub struct Writer<'a, W> {
    to: &'a mut W,
    sum: Checksum,
    bytes: Vec<u8>,
}

impl<'a, W: Write> Writer<'a, W> {
    /// Starts a file.
    pub fn new(to: &'a mut W) -> io::Result<Self> {
        let mut writer = Self { to, sum: Checksum::default(), bytes: Vec::with_capacity(4 * PIECE) };
        writer.words(&[MAGIC[0], MAGIC[1], VERSION, 0])?;
        Ok(writer)
    }

    fn words(&mut self, words: &[u32]) -> io::Result<()> {
        self.sum.add(words);
        self.bytes.clear();
        self.bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        self.to.write_all(&self.bytes)
    }

    pub fn number(&mut self, number: u64) -> io::Result<()> {
        self.words(&[number as u32, (number >> 32) as u32])
    }

    pub fn bounds(&mut self, bounds: &Aabb) -> io::Result<()> {
        let [a, b, c] = bounds.min.map(f32::to_bits);
        let [d, e, f] = bounds.max.map(f32::to_bits);
        self.words(&[a, b, c, d, e, f])
    }

    pub fn list<T: Words>(&mut self, records: &[T]) -> io::Result<()> {
        self.number(records.len() as u64)?;
        let at_once = PIECE / T::WORDS;
        let mut words = vec![0; at_once.min(records.len()) * T::WORDS];
        for some in records.chunks(at_once) {
            for (record, words) in some.iter().zip(words.chunks_exact_mut(T::WORDS)) {
                record.put(words);
            }
            self.words(&words[..some.len() * T::WORDS])?;
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
