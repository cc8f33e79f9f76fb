// SPDX-License-Identifier: GPL-3.0-or-later
//! The wide bounding volume hierarchy: eight children per node, leaves of blocks of eight primitives.
//! Source: [WBB08]. The builder is in `build`, the nodes in `node`.

mod build;
mod node;

pub(crate) use build::{DEEPEST, Primitives, Tree, build};
pub(crate) use node::{Child, Node8, WIDTH};
