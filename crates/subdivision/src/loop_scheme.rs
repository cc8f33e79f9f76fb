// SPDX-License-Identifier: GPL-3.0-or-later
//! One step of Loop's scheme, for triangles.
//! New vertices are numbered: those of old vertices, of edges. Source: [Loo87]. Tests: `tests/subdivision.rs`.

use std::f32::consts::TAU;

use super::sharpness::{Rule, Sharpness};
use super::stencils::Stencils;
use super::topology::{Faces, Topology};

/// The weight of each neighbour of a smooth vertex with `n` of them.
pub(super) fn neighbour_weight(n: f32) -> f32 {
    let c = 0.375 + (TAU / n).cos() / 4.0;
    (0.625 - c * c) / n
}

/// The weights of new vertices.
pub(super) fn stencils(topology: &Topology, sharpness: &Sharpness, faces: &Faces) -> Stencils {
    let mut stencils = Stencils::default();
    for vertex in 0..faces.vertices() {
        let ([now, next], share) = sharpness.rules(topology, vertex);
        add_vertex(&mut stencils, topology, vertex, now, share);
        if share < 1.0 {
            add_vertex(&mut stencils, topology, vertex, next, 1.0 - share);
        }
        stencils.end();
    }
    for (edge, ends) in topology.edges.iter().enumerate() {
        let sharp = sharpness.of_edge(edge).min(1.0);
        if topology.face_counts[edge] != 2 {
            stencils.add_mean(ends, 1.0);
        } else {
            // Three eighths of each end, one eighth of each corner across.
            stencils.add_mean(ends, sharp + (1.0 - sharp) * 0.75);
            for face in topology.edge_faces[edge].into_iter().filter(|_| sharp < 1.0) {
                let corners = &faces.corners()[faces.range(face as usize)];
                let across = corners.iter().find(|corner| !ends.contains(corner));
                stencils.add(*across.unwrap_or(&ends[0]), (1.0 - sharp) / 8.0);
            }
        }
        stencils.end();
    }
    stencils
}

fn add_vertex(stencils: &mut Stencils, topology: &Topology, vertex: usize, rule: Rule, share: f32) {
    let own = vertex as u32;
    match rule {
        Rule::Corner => stencils.add(own, share),
        Rule::Crease(ends) => {
            stencils.add(own, 0.75 * share);
            stencils.add_mean(&ends, 0.25 * share);
        }
        Rule::Smooth => {
            let edges = topology.edges_of(vertex);
            let n = edges.len() as f32;
            let each = neighbour_weight(n);
            stencils.add(own, share * (1.0 - n * each));
            edges.iter().for_each(|&edge| stencils.add(topology.across(edge, vertex), share * each));
        }
    }
}

/// Four triangles of each, and the triangle of each.
pub(super) fn cut(topology: &Topology, faces: &Faces) -> (Faces, Vec<u32>) {
    let vertices = faces.vertices() as u32;
    let mut corners = Vec::with_capacity(4 * faces.corners().len());
    let mut parents = Vec::with_capacity(4 * faces.len());
    for face in 0..faces.len() {
        let range = faces.range(face);
        let [a, b, c] = [0, 1, 2].map(|k| faces.corners()[range.start + k]);
        let [ab, bc, ca] = [0, 1, 2].map(|k| vertices + topology.corner_edges[range.start + k]);
        corners.extend([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]);
        parents.extend([face as u32; 4]);
    }
    (Faces::regular(3, corners, faces.vertices() + topology.edges.len()), parents)
}
