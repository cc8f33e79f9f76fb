// SPDX-License-Identifier: GPL-3.0-or-later
//! What integrators that scatter light themselves share: the vertices of paths, weights of samples.
//! Source: see each file.

mod mis;
mod vertex;

pub(crate) use mis::power_heuristic;
pub(crate) use vertex::Vertex;
