// SPDX-License-Identifier: GPL-3.0-or-later
//! The storage of the program's arrays: in memory, or in a file by `--out-of-core`.

use gnurt::memory::FileHeap;

#[global_allocator]
pub(crate) static HEAP: FileHeap = FileHeap::new();
