// SPDX-License-Identifier: GPL-3.0-or-later
//! Built trees in files, written by `ObjectTree::save` and read by `ObjectTree::load`.
//!
//! ```text
//! "GNURTACC" | version | 0                                                        two data, one, one
//! starts of geometries, which are quads | bad primitives | statistics             lists, 6 and 7 numbers
//! number of trees; for each of them:
//!     mask | kind | statistics | bounds                                           9 numbers, 6 floats
//!     kind 0, 3: nodes, blocks of triangles, or of spheres                        lists
//!     kind 4: compact nodes, blocks in pools, corners of pools                    lists
//!     kind 5: compact nodes, blocks of spheres                                    lists
//!     kind 6, 7: nodes, or compact nodes; blocks of discs                         lists
//!     kind 8, 9: nodes, or compact nodes; blocks of curves;                       lists
//!         geometries; first number, flags, and 6 arrays of each                   number, 2 numbers, lists
//!     kind 10, 11: nodes, or compact nodes; blocks of grids;                      lists
//!         geometries; first number and vertices of each                           number, a number, a list
//!     kind 1: nodes, no items, starts of leaves, blocks of triangles              lists
//!     kind 2: nodes, items, projected triangles                                   lists
//! checksum                                                                        a number
//! ```
//!
//! Everything consists of words of 32 bits, lowest byte first on every machine. A number is two words, lower
//! one first; a list is the number of its records, then the records, word for word as in memory. Cost: that
//! of copying, and one check of each record.
//! Invariant: nothing is allocated for records that have not arrived, and a tree is returned only if no
//! traversal can leave its arrays or its stack, or run longer than its size explains. Boxes are not compared
//! with their contents: the checksum finds accidental damage, and a file made with bad intent gives wrong
//! hits.
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
