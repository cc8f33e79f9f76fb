// SPDX-License-Identifier: GPL-3.0-or-later
//! One step of Catmull and Clark's scheme.
//! New vertices are numbered: those of old vertices, of edges, of faces. Source: [CC78], with the masks of [DKT98].
//! Tests: `tests/subdivision.rs`.

use super::sharpness::{Rule, Sharpness};
use super::stencils::Stencils;
use super::topology::{Faces, Topology};

/// The weights of new vertices.
pub(super) fn stencils(topology: &Topology, sharpness: &Sharpness, faces: &Faces) -> Stencils {
    let mut stencils = Stencils::default();
    for vertex in 0..faces.vertices() {
        let ([now, next], share) = sharpness.rules(topology, vertex);
        add_vertex(&mut stencils, topology, faces, vertex, now, share);
        if share < 1.0 {
            add_vertex(&mut stencils, topology, faces, vertex, next, 1.0 - share);
        }
        stencils.end();
    }
    for (edge, ends) in topology.edges.iter().enumerate() {
        let sharp = sharpness.of_edge(edge).min(1.0);
        if topology.face_counts[edge] != 2 {
            stencils.add_mean(ends, 1.0);
        } else {
            stencils.add_mean(ends, sharp + (1.0 - sharp) / 2.0);
            for face in topology.edge_faces[edge].into_iter().filter(|_| sharp < 1.0) {
                stencils.add_mean(corners(faces, face), (1.0 - sharp) / 4.0);
            }
        }
        stencils.end();
    }
    for face in faces.iter() {
        stencils.add_mean(face, 1.0);
        stencils.end();
    }
    stencils
}

fn corners(faces: &Faces, face: u32) -> &[u32] {
    &faces.corners()[faces.range(face as usize)]
}

fn add_vertex(
    stencils: &mut Stencils,
    topology: &Topology,
    faces: &Faces,
    vertex: usize,
    rule: Rule,
    share: f32,
) {
    let own = vertex as u32;
    match rule {
        Rule::Corner => stencils.add(own, share),
        Rule::Crease(ends) => {
            stencils.add(own, 0.75 * share);
            stencils.add_mean(&ends, 0.25 * share);
        }
        Rule::Smooth => {
            let n = topology.edges_of(vertex).len() as f32;
            let each = share / (n * n);
            stencils.add(own, share * (n - 3.0) / n);
            for &edge in topology.edges_of(vertex) {
                stencils.add(own, each);
                stencils.add(topology.across(edge, vertex), each);
            }
            for &face in topology.faces_of(vertex) {
                stencils.add_mean(corners(faces, face), each);
            }
        }
    }
}

/// A quadrangle at each corner of each face, and the face of each.
pub(super) fn cut(topology: &Topology, faces: &Faces) -> (Faces, Vec<u32>) {
    let (vertices, edges) = (faces.vertices() as u32, topology.edges.len() as u32);
    let mut corners = Vec::with_capacity(4 * faces.corners().len());
    let mut parents = Vec::with_capacity(faces.corners().len());
    for face in 0..faces.len() {
        let range = faces.range(face);
        for corner in range.clone() {
            let before = if corner == range.start { range.end - 1 } else { corner - 1 };
            corners.extend([
                faces.corners()[corner],
                vertices + topology.corner_edges[corner],
                vertices + edges + face as u32,
                vertices + topology.corner_edges[before],
            ]);
            parents.push(face as u32);
        }
    }
    let count = faces.vertices() + topology.edges.len() + faces.len();
    (Faces::regular(4, corners, count), parents)
}
