// SPDX-License-Identifier: GPL-3.0-or-later
//! Refit of a wide BVH to primitives that have moved: the same nodes and leaves, with other boxes.
//! Source: [WBS06] section 4. Cost: O(n), each block and each node once, by all threads.
//! Invariant: hits are those of a new tree, for any boxes. Tests: `tests/refit.rs` of `gnurt-accel`.

mod nodes;
mod state;
mod triangles;

pub(crate) use nodes::Sum;
pub(crate) use state::Moving;
pub use triangles::Refitted;
