// SPDX-License-Identifier: GPL-3.0-or-later
//! What integrators that scatter light themselves share: the vertices of paths.
//! Source: see each file.

mod vertex;

#[expect(unused_imports, reason = "the integrators that scatter light themselves come next")]
pub(crate) use vertex::Vertex;
