// SPDX-License-Identifier: GPL-3.0-or-later
//! Arrays of our own in the form of the program's. Invariant: their memory goes with the last copy of the view.

use std::sync::Arc;

use crate::ffi_memory::{Block, Number, View};

/// A copy of rows; `None` where there is no memory.
pub(crate) fn stored<T: Number, const N: usize>(rows: &[[T; N]]) -> Option<View> {
    let (bytes, width) = (size_of_val(rows), size_of::<[T; N]>());
    let block = Arc::new(Block::new(bytes)?);
    // SAFETY: the block has as many bytes, and it is not shared yet; numbers have no invalid bits. The view keeps it.
    unsafe {
        rows.as_ptr().cast::<u8>().copy_to_nonoverlapping(block.start().cast(), bytes);
        Some(View::new(block.start(), width, rows.len(), width, Some(block)))
    }
}
