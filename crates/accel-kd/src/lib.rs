// SPDX-License-Identifier: GPL-3.0-or-later
//! Trees whose nodes have planes along one axis: the kd-tree over an object's triangles, its layout,
//! construction, traversal by one ray and by a tile; interval hierarchies, which can be refitted
//! (`interval`); and grids, which are quick to build (`grid`).
//! Source: [SIP06], sections 4.1, 5.1, 5.2 and 6. The code compiled for each level is in [`Kernels`].
//!
//! `gnurt-accel` is the API for programs; this crate is one of its structures.
#![forbid(unsafe_code)]
#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "keys of docs/papers.bib stand in brackets, too; tidy checks them"
)]

mod any;
mod build;
mod builder;
mod divide;
mod event;
mod fuzzy;
mod grid;
mod index;
mod interval;
mod kernels;
mod leaves;
mod mailbox;
mod measure;
#[cfg(test)]
mod naive;
mod node;
mod packet;
mod packet_rays;
mod point;
mod projected;
mod region;
mod sah;
mod sampled;
mod single;
mod slab;
mod tiles;

pub use any::ResearchIndex;
pub use fuzzy::{FuzzyError, FuzzyTree};
pub use kernels::Kernels;
