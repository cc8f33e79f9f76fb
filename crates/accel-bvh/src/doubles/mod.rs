// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangles in double precision, and boxes of instances of them, under the same wide BVH.
//! Boxes are floats around a centre, scaled to a size near 1 and rounded outwards: so the nodes, the builder and the walk are those of
//! floats, wherever the mesh lies. Leaves hold corners as given, and are tested in lanes of doubles with a bound of
//! the error; lanes that this leaves open are candidates, which the caller decides.
//! Space: object. Invariant: a triangle that a line touches is among the candidates.
//! Tests: `tests/doubles.rs` of `gnurt-accel`.

mod block;
mod grid;
mod index;
mod line;
mod rays;
mod tiles;

pub use index::{DoubleBoxes, DoubleIndex};
pub use line::DoubleLine;
pub use rays::Last as LastMet;
pub use tiles::LineTile;
