// SPDX-License-Identifier: GPL-3.0-or-later
//! Steps without smoothing: old vertices stay, edges and faces get their middles. Tests: `tests/subdivision.rs`.

use super::stencils::Stencils;
use super::topology::{Faces, Topology};

/// Vertices, edges, faces.
pub(super) fn of_polygons(topology: &Topology, faces: &Faces) -> Stencils {
    let mut stencils = of_triangles(topology);
    for corners in faces.iter() {
        stencils.add_mean(corners, 1.0);
        stencils.end();
    }
    stencils
}

/// Vertices and edges.
pub(super) fn of_triangles(topology: &Topology) -> Stencils {
    let mut stencils = Stencils::default();
    for vertex in 0..topology.vertices() as u32 {
        stencils.add(vertex, 1.0);
        stencils.end();
    }
    for ends in &topology.edges {
        stencils.add_mean(ends, 1.0);
        stencils.end();
    }
    stencils
}
