// SPDX-License-Identifier: GPL-3.0-or-later
//! The kd-tree over an object's triangles: layout, construction, traversal by one ray and by a packet.
//! Source: the paper's sections 4.1, 5.1 and 5.2.

mod build;
mod clip;
mod divide;
mod event;
mod index;
mod leaves;
mod measure;
#[cfg(test)]
mod naive;
mod node;
mod packet;
mod point;
mod sah;
mod sampled;
mod single;
mod slab;
mod sweep;

pub(crate) use clip::split_boxes;
pub(crate) use index::KdIndex;
use node::KdTree;
use packet::Search;
use slab::RaySlabs;
pub(crate) use slab::{FLATTEST, least, most};

/// Traversal stacks hold this many entries; the builder goes no deeper.
pub(crate) const DEEPEST: usize = 64;
