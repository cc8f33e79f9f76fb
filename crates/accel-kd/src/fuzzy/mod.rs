// SPDX-License-Identifier: GPL-3.0-or-later
//! Fuzzy kd-trees: structures over a mesh in motion that no pose makes worse.
//! Source: [GFSS06] (trees, boxes), [GFW*06] (parts by their motion); [SIP06], section 6, names them beside rebuilds and refits.
//!
//! Poses that are given in advance divide the mesh into parts that move nearly rigidly (`parts.rs`). Seen from its part, a triangle
//! hardly moves: a box at rest encloses it in all poses (`tree.rs`). Each part has a kd-tree over these boxes (`boxes.rs`), which
//! is built once. A new pose takes the motion of each part (`rigid.rs`) and a small tree over the parts. A ray is carried to
//! the rest of a part for its tree, and meets triangles where they are.
//!
//! Differs: parts move rigidly, where those of [GFW*06] move by affine maps; so rays keep their length. Poses need not be among those
//! that were given: boxes that a triangle leaves grow, and the tree of its part is built again.

mod boxes;
mod parts;
mod rigid;
mod tree;

pub use tree::{FuzzyError, FuzzyTree};
