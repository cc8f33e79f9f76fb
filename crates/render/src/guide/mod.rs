// SPDX-License-Identifier: GPL-3.0-or-later
//! Path guiding: directions that are worth following, learned from a pilot rendering.
//! Source: [MGN17] (spatial tree of directional quadtrees, mixed with the lobes), [VHH*19] (the share of the guide is learned). Differs: cells are of one orientation of the surface, so
//! that light times the lobes' cosine is learned, not light alone; of media they learn light times the phase function; trees are built from stored vertices, not refined in place.
//! Space: world. Invariant: a map depends on world, camera and options only, so that parts of a picture are guided alike.
//! Tests: `tests` of each file, crates/render/tests/guide.rs.

mod build;
mod directions;
mod mixture;
mod recorder;
mod share;
mod space;
#[cfg(test)]
mod tests;

pub(crate) use build::{Weighted, build};
pub(crate) use mixture::Mixture;
pub(crate) use recorder::{Recorder, Vertex, grey};
pub(crate) use space::Guide;
