// SPDX-License-Identifier: GPL-3.0-or-later
//! The vertices of a pilot's paths, with the light that came to them.
//! Space: world. Invariant: vertices of a tile are in an order that depends on the tile only.
//! Tests: crates/render/tests/guide.rs.

use glam::Vec3;

/// A vertex at which a path chose where to go on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    pub(crate) p: Vec3,
    /// The unit direction that was chosen, and its density per solid angle; by lobes alone.
    pub(crate) dir: Vec3,
    pub(crate) pdf: f32,
    pub(crate) pdf_of_lobes: f32,
    /// The share of the lobes that can be guided.
    pub(crate) guidable: f32,
    /// The path's factor before.
    pub(crate) throughput: f32,
    /// The light at the eye that came from the direction.
    pub(crate) light: f32,
    /// The orientation of the surface, or that it is in a medium.
    pub(crate) class: u8,
    /// The trail that led here.
    pub(crate) before: u32,
}

/// Collects them. A trail is the number of the last vertex of a path, from 1 on; 0 = none.
#[derive(Clone, Debug, Default)]
pub(crate) struct Recorder {
    pub(crate) vertices: Vec<Vertex>,
    most: usize,
}

impl Recorder {
    /// Collects no more than `most`.
    pub(crate) fn new(most: usize) -> Self {
        Self { vertices: Vec::new(), most }
    }

    /// Adds a vertex; returns the trail that it ends: that before if there is no room.
    pub(crate) fn scatter(&mut self, vertex: Vertex) -> u32 {
        if self.vertices.len() >= self.most {
            return vertex.before;
        }
        self.vertices.push(vertex);
        self.vertices.len() as u32
    }

    /// The density by lobes alone of the unit direction `dir`, if the last vertex of a trail chose it.
    pub(crate) fn pdf_of_lobes(&self, trail: u32, dir: Vec3) -> Option<f32> {
        let last = self.vertices.get((trail as usize).wrapping_sub(1))?;
        (last.dir == dir).then_some(last.pdf_of_lobes)
    }

    /// Drops vertices that no light came to: they teach nothing. Trails end.
    pub(crate) fn drop_dark(&mut self) {
        self.vertices.retain(|vertex| vertex.light > 0.0 && vertex.light.is_finite());
    }

    /// Notes light at the eye at the end of a trail.
    pub(crate) fn found(&mut self, mut trail: u32, light: Vec3) {
        let light = grey(light);
        while let Some(vertex) = self.vertices.get_mut((trail as usize).wrapping_sub(1)) {
            vertex.light += light;
            trail = vertex.before;
        }
    }
}

/// The mean of a colour.
pub(crate) fn grey(color: Vec3) -> f32 {
    color.element_sum() * (1.0 / 3.0)
}
