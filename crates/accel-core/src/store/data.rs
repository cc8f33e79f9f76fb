// SPDX-License-Identifier: GPL-3.0-or-later
//! The elements of tree files: words of 32 bits, and a checksum over them.
//! Tests: `tests/saved.rs` of `gnurt-accel`.

/// The first two words of a file.
pub(super) const MAGIC: [u32; 2] = [u32::from_le_bytes(*b"GNUR"), u32::from_le_bytes(*b"TACC")];

/// The version of the format. Increase it with every change of the contents of any list of any kind.
pub(super) const VERSION: u32 = 2;

/// Words that are read and written at a time.
pub(super) const PIECE: usize = 1 << 14;

/// A record of a list.
pub trait StoredRecord: Sized {
    /// How many words one takes.
    const LENGTH: usize;
    /// Writes all of them.
    fn put(&self, data: &mut [u32]);
    /// From this many words, of any contents.
    fn get(data: &[u32]) -> Self;
}

impl StoredRecord for u32 {
    const LENGTH: usize = 1;

    #[inline(always)]
    fn put(&self, data: &mut [u32]) {
        data[0] = *self;
    }

    #[inline(always)]
    fn get(data: &[u32]) -> Self {
        data[0]
    }
}

impl StoredRecord for f32 {
    const LENGTH: usize = 1;

    #[inline(always)]
    fn put(&self, data: &mut [u32]) {
        data[0] = self.to_bits();
    }

    #[inline(always)]
    fn get(data: &[u32]) -> Self {
        Self::from_bits(data[0])
    }
}

/// Copies floats to words.
#[inline(always)]
pub fn put_floats(data: &mut [u32], floats: &[f32]) {
    for (input, float) in data.iter_mut().zip(floats) {
        *input = float.to_bits();
    }
}

/// Copies words to floats.
#[inline(always)]
pub fn get_floats(floats: &mut [f32], data: &[u32]) {
    for (float, input) in floats.iter_mut().zip(data) {
        *float = f32::from_bits(*input);
    }
}

/// Copies bytes to words, four to each.
#[inline(always)]
pub fn put_bytes(data: &mut [u32], bytes: &[u8]) {
    for (input, bytes) in data.iter_mut().zip(bytes.as_chunks().0) {
        *input = u32::from_le_bytes(*bytes);
    }
}

/// Copies words to bytes, four from each.
#[inline(always)]
pub fn get_bytes(bytes: &mut [u8], data: &[u32]) {
    for (bytes, input) in bytes.as_chunks_mut().0.iter_mut().zip(data) {
        *bytes = input.to_le_bytes();
    }
}

/// A sum that no change within one word leaves as it is: each step is a bijection of the state and of the word.
#[derive(Default)]
pub(super) struct Checksum {
    lanes: [u32; 8],
    count: usize,
}

impl Checksum {
    fn step(lane: &mut u32, input: u32) {
        *lane = (*lane ^ input).rotate_left(13).wrapping_mul(0x9e37_79b1);
    }

    pub(super) fn add(&mut self, data: &[u32]) {
        let ahead = (self.count.next_multiple_of(8) - self.count).min(data.len());
        let (first, data) = data.split_at(ahead);
        let at = self.count % 8;
        self.count += first.len() + data.len();
        self.lanes[at..].iter_mut().zip(first).for_each(|(lane, &input)| Self::step(lane, input));
        let (rows, last) = data.as_chunks::<8>();
        for row in rows {
            self.lanes.iter_mut().zip(row).for_each(|(lane, &input)| Self::step(lane, input));
        }
        self.lanes.iter_mut().zip(last).for_each(|(lane, &input)| Self::step(lane, input));
    }

    pub(super) fn value(&self) -> u64 {
        self.lanes.iter().fold(self.count as u64, |sum, &lane| {
            (sum ^ u64::from(lane)).rotate_left(27).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        })
    }
}
