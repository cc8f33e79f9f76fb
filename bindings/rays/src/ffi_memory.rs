// SPDX-License-Identifier: GPL-3.0-or-later
//! Memory of C programs: arrays with gaps that they lend, and blocks that they are lent.
//! Invariant: a [`View`] is made where the program vouches for its memory; from then on reading it is safe, and no read
//! goes past its end. Tests: `tests`, and the programs of `tests/c`.

use std::borrow::Cow;
use std::ffi::c_void;
use std::fmt;
use std::ptr::null_mut;
use std::sync::Arc;

/// A pointer of the program's that is stored for it, and never followed here.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pointer(pub(crate) *mut c_void);

// SAFETY: it is a plain number here; its use in callbacks, from any thread, is the program's responsibility.
unsafe impl Send for Pointer {}
// SAFETY: as above.
unsafe impl Sync for Pointer {}

impl Default for Pointer {
    fn default() -> Self {
        Self(null_mut())
    }
}

/// Memory of ours that the program writes, at multiples of 16 bytes, zeros at first.
pub(crate) struct Block {
    start: *mut u128,
    u32_rows: usize,
}

// SAFETY: only its owner frees it; the program orders its writes and our reads by its calls.
unsafe impl Send for Block {}
// SAFETY: as above.
unsafe impl Sync for Block {}

impl Block {
    /// At least this many bytes, and 16 more; `None` where that is more than there can be.
    pub(crate) fn new(bytes: usize) -> Option<Self> {
        let u32_rows = bytes.checked_add(31)? / 16;
        let mut memory = Vec::new();
        memory.try_reserve_exact(u32_rows).ok()?;
        memory.resize(u32_rows, 0u128);
        let start = Box::into_raw(memory.into_boxed_slice()).cast();
        Some(Self { start, u32_rows })
    }

    pub(crate) fn start(&self) -> *mut c_void {
        self.start.cast()
    }
}

impl Drop for Block {
    fn drop(&mut self) {
        let memory = std::ptr::slice_from_raw_parts_mut(self.start, self.u32_rows);
        // SAFETY: made by `Box::into_raw` from a slice of this length, and freed once.
        drop(unsafe { Box::from_raw(memory) });
    }
}

impl fmt::Debug for Block {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Block of {} bytes", 16 * self.u32_rows)
    }
}

/// Numbers of which all bits are values.
pub(crate) trait Number: Copy {}
impl Number for u8 {}
impl Number for f32 {}
impl Number for f64 {}
impl Number for u32 {}
impl Number for u64 {}

/// Rows of numbers in memory, at any distance from each other.
#[derive(Clone, Debug)]
pub(crate) struct View {
    start: *const u8,
    stride: usize,
    count: usize,
    /// The most bytes that may be read of each row.
    width: usize,
    /// Where the memory is ours. Only held.
    _keep: Option<Arc<Block>>,
}

// SAFETY: it only reads, and its maker guarantees the memory for any thread.
unsafe impl Send for View {}
// SAFETY: as above.
unsafe impl Sync for View {}

impl View {
    /// Of nothing.
    pub(crate) fn empty() -> Self {
        Self { start: std::ptr::null(), stride: 0, count: 0, width: 0, _keep: None }
    }

    /// `count` rows of `width` bytes each, the first at `start` and each `stride` bytes behind the one before.
    ///
    /// # Safety
    /// The rows are readable, and not written meanwhile, for as long as this or a copy of it is used, or are
    /// in `keep`.
    pub(crate) unsafe fn new(
        start: *const c_void,
        stride: usize,
        count: usize,
        width: usize,
        keep: Option<Arc<Block>>,
    ) -> Self {
        Self { start: start.cast(), stride, count, width, _keep: keep }
    }

    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// The same rows with more bytes of each; `None` where they are not so far apart.
    ///
    /// # Safety
    /// The last row has as many bytes, too.
    pub(crate) unsafe fn widened(&self, bytes: usize) -> Option<Self> {
        let is_wider = bytes > self.width && bytes <= self.stride;
        is_wider.then(|| Self { width: bytes, ..self.clone() })
    }

    pub(crate) fn start(&self) -> *mut c_void {
        self.start.cast_mut().cast()
    }

    /// The first numbers of row `i`; `None` behind the last, and where rows are not that wide.
    #[inline]
    pub(crate) fn get<T: Number, const N: usize>(&self, i: usize) -> Option<[T; N]> {
        if i >= self.count || size_of::<[T; N]>() > self.width {
            return None;
        }
        // SAFETY: row `i` is one of those that the maker of this vouched for, and wide enough; all bits are values.
        Some(unsafe { self.start.add(i * self.stride).cast::<[T; N]>().read_unaligned() })
    }

    /// A number of row `i`, counted from its beginning.
    pub(crate) fn number<T: Number>(&self, i: usize, k: usize) -> Option<T> {
        let bytes = size_of::<T>();
        if i >= self.count || (k + 1).checked_mul(bytes)? > self.width {
            return None;
        }
        // SAFETY: as in `get`.
        Some(unsafe { self.start.add(i * self.stride + k * bytes).cast::<T>().read_unaligned() })
    }

    /// All rows: the memory itself where they lie close together, else a copy.
    pub(crate) fn rows<T: Number, const N: usize>(&self) -> Cow<'_, [[T; N]]> {
        let close = self.stride == size_of::<[T; N]>() && self.width >= self.stride;
        if close && self.count > 0 && self.start.cast::<[T; N]>().is_aligned() {
            // SAFETY: the rows are those that the maker of this vouched for, without gaps, and in place.
            return Cow::Borrowed(unsafe { std::slice::from_raw_parts(self.start.cast(), self.count) });
        }
        Cow::Owned((0..self.count).map_while(|i| self.get(i)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_with_their_gaps() {
        let numbers: Vec<f32> = (0..12).map(|i| i as f32).collect();
        // SAFETY: three rows of four, of which three numbers are read, in a vector that lives on.
        let view = unsafe { View::new(numbers.as_ptr().cast(), 16, 3, 12, None) };
        assert_eq!(view.get::<f32, 3>(1), Some([4.0, 5.0, 6.0]), "the second row");
        assert_eq!(view.get::<f32, 3>(3), None, "behind the last");
        assert_eq!(view.get::<f32, 4>(0), None, "wider than a row");
        assert_eq!((view.number(2, 2), view.number::<f32>(2, 3)), (Some(10.0f32), None), "single numbers");
        assert!(matches!(view.rows::<f32, 3>(), Cow::Owned(rows) if rows[2] == [8.0, 9.0, 10.0]), "copied");
        // SAFETY: four rows of three.
        let close = unsafe { View::new(numbers.as_ptr().cast(), 12, 4, 12, None) };
        assert!(
            matches!(close.rows::<f32, 3>(), Cow::Borrowed(rows) if rows[3] == [9.0, 10.0, 11.0]),
            "lent"
        );
        assert!(View::empty().rows::<u32, 3>().is_empty(), "of nothing");
    }

    #[test]
    fn blocks_are_aligned_and_no_larger_than_memory() {
        let block = Block::new(5).expect("five bytes");
        assert_eq!(block.start() as usize % 16, 0, "at a multiple of 16");
        // Miri ends at a block that the machine does not have.
        let is_none = cfg!(miri) || Block::new(1 << 60).is_none();
        assert!(Block::new(usize::MAX).is_none() && is_none, "more than there is");
    }
}
