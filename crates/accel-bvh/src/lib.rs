// SPDX-License-Identifier: GPL-3.0-or-later
//! Wide bounding volume hierarchies: eight children per node, leaves of blocks of eight primitives.
//! Triangles, grids, spheres, discs, curves, user geometry, and boxes that the caller supplies.
//! Source: [WBB08]. The builder is in `build`, nodes in `node` and `compact`, the code compiled for each
//! level in [`Kernels`].
//!
//! `gnurt-accel` is the API for programs; this crate is one of its structures.
#![forbid(unsafe_code)]
#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "keys of docs/papers.bib stand in brackets, too; tidy checks them"
)]

mod blocked;
mod blocks;
mod boxes;
mod build;
mod compact;
mod corners;
mod curves;
mod discs;
mod doubles;
mod gather;
mod grids;
mod in_turns;
mod incoherent;
mod index;
mod interleaved;
mod interpolated;
mod kernels;
mod leaves;
mod measure;
mod motion;
mod moving_user;
mod node;
mod node_ray;
mod planes;
mod point;
mod pools;
mod pose;
mod primitives;
mod refit;
mod region;
mod screen;
mod single_rays;
mod spheres;
mod tiles;
mod tree;
mod treelet;
mod triangles;
mod user;
mod walk;

pub use blocked::Inputs;
pub use blocks::{BlockIndex, BlockSort};
pub use boxes::{BoxEdit, BoxIndex, EnterMembers, Member, MetBlock};
pub use doubles::{DoubleBoxes, DoubleIndex, DoubleLine, LastMet, LineTile};
pub use index::BvhIndex;
pub use kernels::Kernels;
pub use motion::MotionIndex;
pub use moving_user::MovingUserIndex;
pub use refit::Refitted;
pub use screen::Screen;
pub use treelet::BoxesAt;
