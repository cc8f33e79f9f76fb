// SPDX-License-Identifier: GPL-3.0-or-later
//! State made of 64-bit words: one function visits all of them, for writing and for reading.
//! Tests: crates/render/tests/checkpoint.rs.

/// Something made of words that can be read and written.
pub(crate) trait SavedState {
    /// Calls `with` for each word, always in the same order; sizes do not change.
    fn state(&mut self, with: &mut dyn FnMut(&mut u64));
}

/// A number as a word.
pub(crate) fn put_f64(x: &mut f64, with: &mut dyn FnMut(&mut u64)) {
    let mut value = x.to_bits();
    with(&mut value);
    *x = f64::from_bits(value);
}

/// A number as a word.
pub(crate) fn put_f32(x: &mut f32, with: &mut dyn FnMut(&mut u64)) {
    let mut value = u64::from(x.to_bits());
    with(&mut value);
    *x = f32::from_bits(value as u32);
}

/// A number as a word.
pub(crate) fn put_u32(x: &mut u32, with: &mut dyn FnMut(&mut u64)) {
    let mut value = u64::from(*x);
    with(&mut value);
    *x = value as u32;
}
