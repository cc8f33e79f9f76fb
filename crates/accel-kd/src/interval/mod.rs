// SPDX-License-Identifier: GPL-3.0-or-later
//! Bounding interval hierarchies and B-KD trees: triangles are shared out as in a BVH, so that each lies in one leaf and a tree can be
//! refitted; nodes have planes along one axis, as in a kd-tree, so that they are small and cheap to pass.
//! Source: [WK06] (two planes a node), [WMS06] (four); what is done about empty space is original (`clips.rs`).
//!
//! The way of a build: `share.rs` shares triangles out and gives a binary tree of boxes; `clips.rs` puts it into nodes of one
//! [`Layout`](node::Layout), with clips where a child fills little of what a ray knows of it. `walk.rs` is how rays pass, alone or as a tile.

mod clips;
mod index;
mod node;
mod positions;
mod refit;
mod share;
mod walk;

pub(crate) use index::IntervalIndex;
