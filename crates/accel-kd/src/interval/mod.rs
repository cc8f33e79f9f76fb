// SPDX-License-Identifier: GPL-3.0-or-later
//! Bounding interval hierarchies and B-KD trees. Triangles are divided as in a BVH, so that each lies in one
//! leaf and a tree can be refitted; nodes have planes along one axis, as in a kd-tree, so that they are small
//! and cheap to pass.
//! Source: [WK06] (two planes a node), [WMS06] (four); the treatment of empty space is original (`clips.rs`).
//!
//! Stages of a build: `share.rs` divides triangles and gives a binary tree of boxes; `clips.rs` puts it into
//! nodes of one [`Layout`](node::Layout), with clips where a child fills little of its region. `walk.rs`
//! traverses rays, singly or as a tile.

mod clips;
mod index;
mod node;
mod positions;
mod refit;
mod share;
mod walk;

pub(crate) use index::IntervalIndex;
