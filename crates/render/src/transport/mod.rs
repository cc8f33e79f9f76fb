// SPDX-License-Identifier: GPL-3.0-or-later
//! What integrators that scatter light themselves share: the vertices of paths.
//! Source: see each file.

mod vertex;

pub(crate) use vertex::Vertex;
