// SPDX-License-Identifier: GPL-3.0-or-later
//! Grids: space in cells of one size, each with a list of its triangles. For geometry that is rebuilt each
//! frame.
//! Source: [WIK*06].
//!
//! `cells.rs` chooses the number of cells and finds the cell of a point; `build.rs` puts triangles into cells
//! by a counting sort; `walk.rs` traverses single rays, `slices.rs` tiles.

mod build;
mod cells;
mod index;
mod positions;
mod slices;
mod walk;

pub(crate) use index::GridIndex;
