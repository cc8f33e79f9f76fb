// SPDX-License-Identifier: GPL-3.0-or-later
//! The wide bounding volume hierarchy: eight children per node, leaves of blocks of eight primitives.
//! Source: [WBB08]. The builder is in `build`, the nodes in `node`.

mod apart;
mod beam;
mod blocks;
mod build;
mod chunks;
mod compact;
mod faces;
mod index;
mod leaves;
mod measure;
mod node;
mod planes;
mod point;
mod pools;
mod slab;
mod spheres;
mod sweep;
mod turns;
mod user;
mod walk;

pub(crate) use beam::{Beam, CHUNKS, Ranges, Slopes};
pub(crate) use blocks::{BlockRay, TriangleBlock};
pub(crate) use build::{Primitives, Tree, build, try_build};
pub(crate) use chunks::Chunks;
pub(crate) use compact::CompactNode;
pub(crate) use index::BvhIndex;
pub(crate) use node::{Boxes, Child, Node8, WIDTH};
pub(crate) use point::{Around, square_of};
pub(crate) use slab::NodeRay;
pub(crate) use spheres::SphereIndex;
pub(crate) use sweep::Sweep;
pub(crate) use user::UserIndex;
