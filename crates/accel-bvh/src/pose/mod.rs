// SPDX-License-Identifier: GPL-3.0-or-later
//! One object in many poses: trees that share everything that a pose leaves unchanged. The boxes of a pose
//! are those of a refit [WBS06], a byte to a plane [YKL17]. Shared are the nodes' children, the leaf blocks
//! with the vertices of their triangles, and the triangles' vertices as the caller passed them
//! ([`Structure`](structure::Structure)). A pose owns a cache line for each node, its boxes, and 12 bytes for
//! each vertex: about 8 bytes a triangle of a closed mesh, where a separate tree takes 50.
//! Invariant: hits are those of a tree that is built over the pose, bit for bit. Tests: `tests/poses.rs` of `gnurt-accel`.

mod find;
mod fit;
mod leaves;
mod structure;

pub(crate) use leaves::PosedLeaves;
pub(crate) use structure::Structure;
