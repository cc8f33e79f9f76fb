// SPDX-License-Identifier: GPL-3.0-or-later
//! Where vertices of a refined surface end after infinitely many steps.
//! Source: [HKD93] for Catmull-Clark, [Loo87] for triangles. Tests: `tests/subdivision.rs`.

use super::loop_scheme::neighbour_weight;
use super::sharpness::{Rule, Sharpness};
use super::stencils::Stencils;
use super::surface::Scheme;
use super::topology::{Faces, Topology};

/// The weights of the limit of each vertex.
pub(super) fn stencils(
    scheme: Scheme,
    topology: &Topology,
    sharpness: &Sharpness,
    faces: &Faces,
) -> Stencils {
    let mut stencils = Stencils::default();
    for vertex in 0..faces.vertices() {
        let own = vertex as u32;
        match sharpness.rule(topology, vertex, |sharpness| sharpness) {
            Rule::Corner => stencils.add(own, 1.0),
            Rule::Crease(ends) => {
                stencils.add(own, 2.0 / 3.0);
                stencils.add_mean(&ends, 1.0 / 3.0);
            }
            Rule::Smooth if scheme == Scheme::Loop => {
                let edges = topology.edges_of(vertex);
                let n = edges.len() as f32;
                let each = 1.0 / (n + 3.0 / (8.0 * neighbour_weight(n)));
                stencils.add(own, 1.0 - n * each);
                edges.iter().for_each(|&edge| stencils.add(topology.across(edge, vertex), each));
            }
            Rule::Smooth => {
                let edges = topology.edges_of(vertex);
                let n = edges.len() as f32;
                let each = 1.0 / (n * (n + 5.0));
                stencils.add(own, n * n * each);
                edges.iter().for_each(|&edge| stencils.add(topology.across(edge, vertex), 4.0 * each));
                for &face in topology.faces_of(vertex) {
                    let corners = &faces.corners()[faces.range(face as usize)];
                    let at = corners.iter().position(|&corner| corner == own).unwrap_or(0);
                    stencils.add(corners[(at + 2) % corners.len()], each);
                }
            }
        }
        stencils.end();
    }
    stencils
}
