// SPDX-License-Identifier: GPL-3.0-or-later
//! Built trees in files: what `ObjectTree::save` writes and `ObjectTree::load` accepts.
//!
//! ```text
//! "GNURTACC" | version | 0                                                        two data, one, one
//! starts of geometries, which are quads | bad primitives | statistics             lists, 6 and 7 numbers
//! number of trees; for each of them:
//!     mask | kind | statistics | bounds                                           9 numbers, 6 floats
//!     kind 0, 3: nodes, blocks of triangles, or of spheres                        lists
//!     kind 4: compact nodes, blocks in pools, corners of pools                    lists
//!     kind 5: compact nodes, blocks of spheres                                    lists
//!     kind 1: nodes, no items, starts of leaves, blocks of triangles              lists
//!     kind 2: nodes, items, projected triangles                                   lists
//! checksum                                                                        a number
//! ```
//!
//! All is made of words of 32 bits, lowest byte first on every machine. A number is two words, lower one first; a list
//! is the number of its records, then the records, word for word as in memory.
//! Cost: that of copying, and one look at each record.
//! Invariant: nothing is allocated for records that have not arrived, and a tree is handed out only if no walk through
//! it can leave its arrays, its stack, or go on for longer than its size explains. Whether boxes hold what is below
//! them is not looked at: against accidents there is the checksum, and a file made with bad intent gives wrong hits.
//! Tests: `tests/saved.rs`, and the fuzz target `accel_tree`.

pub mod blocks;
mod data;
mod error;
mod read;
mod write;

pub use data::{StoredRecord, get_bytes, get_floats, put_bytes, put_floats};
pub use error::LoadError;
pub use read::{Reader, is_sound};
pub use write::Writer;
