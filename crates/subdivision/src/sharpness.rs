// SPDX-License-Identifier: GPL-3.0-or-later
//! Sharpness of edges and vertices, the rule of a vertex by it, and its rest after a step.
//! Source: [DKT98]; a rule that ends within a step is blended with the one that follows. Tests: `tests/subdivision.rs`.

use super::surface::Boundary;
use super::topology::Topology;

/// A sharpness from which it never ends.
pub(super) const FOREVER: f32 = 10.0;

/// The rule of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rule {
    /// As all faces around it say.
    Smooth,
    /// On a line between the other ends of two sharp edges.
    Crease([u32; 2]),
    /// Where it is.
    Corner,
}

/// Sharpness of a surface's edges and vertices.
#[derive(Debug)]
pub(super) struct Sharpness {
    edges: Vec<f32>,
    vertices: Vec<f32>,
    /// Vertices whose faces make no fan.
    is_torn: Vec<bool>,
}

fn child(sharpness: f32) -> f32 {
    if sharpness >= FOREVER { sharpness } else { (sharpness - 1.0).max(0.0) }
}

impl Sharpness {
    pub(super) fn new(
        topology: &Topology,
        boundary: Boundary,
        creases: &[([u32; 2], f32)],
        corners: &[(u32, f32)],
    ) -> Self {
        let mut edges: Vec<f32> =
            topology.face_counts.iter().map(|&faces| if faces == 2 { 0.0 } else { FOREVER }).collect();
        for &([a, b], sharpness) in creases {
            if let Some(edge) = topology.edge_between(a, b) {
                edges[edge] = edges[edge].max(sharpness);
            }
        }
        let mut vertices = vec![0.0; topology.vertices()];
        for &(vertex, sharpness) in corners {
            if let Some(of_vertex) = vertices.get_mut(vertex as usize) {
                *of_vertex = f32::max(*of_vertex, sharpness);
            }
        }
        if boundary == Boundary::EdgeAndCorner {
            for (vertex, sharpness) in vertices.iter_mut().enumerate() {
                if topology.faces_of(vertex).len() == 1 {
                    *sharpness = FOREVER;
                }
            }
        }
        let is_torn = (0..topology.vertices()).map(|vertex| !topology.is_fan(vertex)).collect();
        Self { edges, vertices, is_torn }
    }

    pub(super) fn of_edge(&self, edge: usize) -> f32 {
        self.edges[edge]
    }

    pub(super) fn of_vertex(&self, vertex: usize) -> f32 {
        self.vertices[vertex]
    }

    /// Whether the faces of a vertex make no fan.
    pub(super) fn is_torn(&self, vertex: usize) -> bool {
        self.is_torn[vertex]
    }

    /// The rules that apply to a vertex in this step and in the next, and the share of the first.
    pub(super) fn rules(&self, topology: &Topology, vertex: usize) -> ([Rule; 2], f32) {
        let now = self.rule(topology, vertex, |sharpness| sharpness);
        let next = self.rule(topology, vertex, child);
        if now == next {
            return ([now, next], 1.0);
        }
        let edges = topology.edges_of(vertex).iter().map(|&edge| self.edges[edge as usize]);
        let ends = edges.chain([self.vertices[vertex]]).filter(|&s| s > 0.0 && child(s) == 0.0);
        let (sum, count) = ends.fold((0.0, 0), |(sum, count), s| (sum + s, count + 1));
        ([now, next], if count == 0 { 1.0 } else { (sum / count as f32).min(1.0) })
    }

    /// The rule of a vertex by the rest of the sharpness; `left` returns that rest.
    pub(super) fn rule(&self, topology: &Topology, vertex: usize, left: impl Fn(f32) -> f32) -> Rule {
        if self.is_torn[vertex] || left(self.vertices[vertex]) > 0.0 {
            return Rule::Corner;
        }
        let mut sharp =
            topology.edges_of(vertex).iter().filter(|&&edge| left(self.edges[edge as usize]) > 0.0);
        match (sharp.next(), sharp.next(), sharp.next()) {
            (_, _, Some(_)) => Rule::Corner,
            (Some(&a), Some(&b), None) => {
                Rule::Crease([topology.across(a, vertex), topology.across(b, vertex)])
            }
            _ => Rule::Smooth,
        }
    }

    /// Sharp edges after a step: each has two halves, whose middle vertex is numbered behind the old vertices.
    pub(super) fn child_creases(&self, topology: &Topology) -> Vec<([u32; 2], f32)> {
        let vertices = topology.vertices() as u32;
        let halves = |(edge, &sharpness): (usize, &f32)| {
            let ([a, b], middle) = (topology.edges[edge], vertices + edge as u32);
            [([a, middle], child(sharpness)), ([middle, b], child(sharpness))]
        };
        let sharp = self.edges.iter().enumerate().filter(|&(_, &sharpness)| child(sharpness) > 0.0);
        sharp.flat_map(halves).collect()
    }

    /// Sharp vertices after a step.
    pub(super) fn child_corners(&self) -> Vec<(u32, f32)> {
        let left = self.vertices.iter().zip(0..).map(|(&sharpness, vertex)| (vertex, child(sharpness)));
        left.filter(|&(_, sharpness)| sharpness > 0.0).collect()
    }
}
