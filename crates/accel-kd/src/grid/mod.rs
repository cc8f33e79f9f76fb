// SPDX-License-Identifier: GPL-3.0-or-later
//! Grids: space in cells of one size, each with a list of its triangles. For what is built anew each frame.
//! Source: [WIK*06].
//!
//! `cells.rs` says how many cells there are and which one a point is in; `build.rs` puts triangles into cells by a counting sort;
//! `walk.rs` is how a ray passes, `slices.rs` how a tile does.

mod build;
mod cells;
mod index;
mod positions;
mod slices;
mod walk;

pub(crate) use index::GridIndex;
