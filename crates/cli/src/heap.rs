// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the program's arrays are: in memory, or in a file as `--out-of-core` says.

use gnurt::memory::FileHeap;

#[global_allocator]
pub(crate) static HEAP: FileHeap = FileHeap::new();
