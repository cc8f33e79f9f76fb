// SPDX-License-Identifier: GPL-3.0-or-later
//! A face with all faces around its corners, which decide on its limit; and the same of its parts after a step.
//! Invariant: the face is number 0, and the faces around its vertices are complete, so that the rules there are those of the
//! whole surface. Others are not read. Tests: `tests/cage.rs`.

use super::patch::Spline;
use super::sharpness::{FOREVER, Rule, Sharpness};
use super::surface::Boundary;
use super::topology::{Faces, Topology};
use super::{catmull_clark, limit, surface::Scheme};

/// Faces around one, with numbers and sharpness of their own.
pub(super) struct Ring {
    faces: Faces,
    creases: Vec<([u32; 2], f32)>,
    sharp: Vec<(u32, f32)>,
    /// The corners of the face, if it is a quadrangle: at (0, 0), (1, 0), (1, 1), (0, 1).
    pub(super) center: [u32; 4],
    /// Numbers per vertex.
    pub(super) width: usize,
    pub(super) values: Vec<f64>,
}

/// A list of faces that are copied, and new numbers of their vertices.
#[derive(Default)]
struct Copied {
    starts: Vec<u32>,
    corners: Vec<u32>,
    vertices: Vec<u32>,
}

impl Copied {
    fn number(&mut self, vertex: u32) -> u32 {
        let known = self.vertices.iter().position(|&known| known == vertex);
        known.unwrap_or_else(|| {
            self.vertices.push(vertex);
            self.vertices.len() - 1
        }) as u32
    }

    fn add(&mut self, corners: &[u32]) {
        self.starts.push(self.corners.len() as u32);
        for &corner in corners {
            let number = self.number(corner);
            self.corners.push(number);
        }
    }

    fn faces(mut self) -> (Faces, Vec<u32>) {
        self.starts.push(self.corners.len() as u32);
        let faces = Faces::of_parts(self.starts, self.corners, self.vertices.len());
        (faces, self.vertices)
    }
}

impl Ring {
    /// Of a face of the whole; `fill` writes the values of a vertex.
    pub(super) fn new(
        faces: &Faces,
        topology: &Topology,
        sharpness: &Sharpness,
        face: usize,
        width: usize,
        fill: &mut dyn FnMut(u32, &mut [f64]),
    ) -> Self {
        let center = &faces.corners()[faces.range(face)];
        let mut around = vec![face as u32];
        for &vertex in center {
            for &other in topology.faces_of(vertex as usize) {
                if !around.contains(&other) {
                    around.push(other);
                }
            }
        }
        let (mut copied, mut creases) = (Copied::default(), Vec::new());
        for &other in &around {
            let range = faces.range(other as usize);
            copied.add(&faces.corners()[range.clone()]);
            for &edge in &topology.corner_edges[range] {
                let weight = sharpness.of_edge(edge as usize);
                if weight > 0.0 {
                    creases.push((topology.edges[edge as usize].map(|end| copied.number(end)), weight));
                }
            }
        }
        let center = [0, 1, 2, 3].map(|i| copied.number(center[i % center.len()]));
        let (faces, vertices) = copied.faces();
        let sharp = vertices.iter().zip(0..).filter_map(|(&vertex, number)| {
            let weight = sharpness.of_vertex(vertex as usize);
            (weight > 0.0).then_some((number, weight))
        });
        let sharp = sharp.collect();
        let mut values = vec![0.0; vertices.len() * width];
        for (vertex, values) in vertices.iter().zip(values.chunks_exact_mut(width.max(1))) {
            fill(*vertex, values);
        }
        Self { faces, creases, sharp, center, width, values }
    }

    fn corners(&self, face: u32) -> &[u32] {
        &self.faces.corners()[self.faces.range(face as usize)]
    }

    /// The control points of the face; `None` where its limit is no spline.
    pub(super) fn control_points(&self, topology: &Topology, sharpness: &Sharpness) -> Option<Vec<f64>> {
        let spline = Spline::of(&self.faces, topology, sharpness, 0, self.center)?;
        let own = |vertex: u32, values: &mut [f64]| {
            values.copy_from_slice(&self.values[vertex as usize * self.width..][..self.width]);
        };
        Some(spline.points(self.width, own))
    }

    /// Whether the masks of limits hold: they are those of quadrangles, no sharpness is to end, and no crease ends at a corner.
    pub(super) fn is_settled(&self, topology: &Topology, sharpness: &Sharpness) -> bool {
        let is_sharp = |&edge: &u32| sharpness.of_edge(edge as usize) > 0.0;
        let is_end = |&vertex: &u32| {
            let vertex = vertex as usize;
            sharpness.rule(topology, vertex, |sharpness| sharpness) == Rule::Smooth
                && topology.edges_of(vertex).iter().any(is_sharp)
        };
        self.faces.iter().all(|face| face.len() == 4)
            && self.creases.iter().all(|&(_, sharpness)| sharpness >= FOREVER)
            && self.sharp.iter().all(|&(_, sharpness)| sharpness >= FOREVER)
            && !self.center.iter().any(is_end)
    }

    pub(super) fn topology(&self) -> (Topology, Sharpness) {
        let topology = Topology::new(&self.faces);
        let sharpness = Sharpness::new(&topology, Boundary::EdgeOnly, &self.creases, &self.sharp);
        (topology, sharpness)
    }

    /// The limits of the four corners.
    pub(super) fn limits(&self, topology: &Topology, sharpness: &Sharpness) -> Vec<f64> {
        let stencils = limit::stencils(Scheme::CatmullClark, topology, sharpness, &self.faces);
        let all = stencils.apply_doubles(&self.values, self.width);
        let of = |&vertex: &u32| &all[vertex as usize * self.width..(vertex as usize + 1) * self.width];
        self.center.iter().flat_map(of).copied().collect()
    }

    /// After a step.
    pub(super) fn refined(&self, topology: &Topology, sharpness: &Sharpness) -> Self {
        let values =
            catmull_clark::stencils(topology, sharpness, &self.faces).apply_doubles(&self.values, self.width);
        let (faces, _) = catmull_clark::cut(topology, &self.faces);
        let (creases, sharp) = (sharpness.child_creases(topology), sharpness.child_corners());
        Self { faces, creases, sharp, center: self.center, width: self.width, values }
    }

    /// Of the part at a corner of the face, in a ring after a step. Its parameters begin at its own corner, or are
    /// turned by so many corners.
    pub(super) fn part(&self, part: usize, turned: usize) -> Self {
        let own = self.corners(part as u32);
        let mut copied = Copied::default();
        copied.add(own);
        for (_, face) in self.faces.iter().enumerate().filter(|&(other, _)| other != part) {
            if face.iter().any(|corner| own.contains(corner)) {
                copied.add(face);
            }
        }
        let center = [0, 1, 2, 3].map(|i| ((i + 4 - turned) % 4) as u32);
        let (faces, vertices) = copied.faces();
        let number = |vertex: u32| vertices.iter().position(|&known| known == vertex).map(|i| i as u32);
        let ends = |&([a, b], weight): &([u32; 2], f32)| Some(([number(a)?, number(b)?], weight));
        let creases = self.creases.iter().filter_map(ends).collect();
        let sharp = self.sharp.iter().filter_map(|&(vertex, weight)| Some((number(vertex)?, weight)));
        let sharp = sharp.collect();
        let of = |&vertex: &u32| &self.values[vertex as usize * self.width..][..self.width];
        let values = vertices.iter().flat_map(of).copied().collect();
        Self { faces, creases, sharp, center, width: self.width, values }
    }
}
