// SPDX-License-Identifier: GPL-3.0-or-later
//! Vertices of paths in media, as structures of arrays: written by `media` in flight, scattered later.
//! Space: world. Tests: crates/render/tests/media.rs.

use glam::Vec3;
use gnurt_shading::phase::Phase;
use gnurt_shading::{SampleKey, Vec3s};

/// Vertices in media, at most one of each path: then pictures are the same however many are taken at a time.
#[derive(Default)]
pub(crate) struct MediumVertices {
    /// Numbers of the paths, and their keys.
    pub(super) numbers: Vec<u32>,
    pub(super) keys: Vec<SampleKey>,
    pub(super) p: Vec3s,
    /// Where light paths from the eye were heading.
    pub(super) along: Vec3s,
    /// Numbers of the phase functions: two mean cosines, share of the second.
    pub(super) phase: [Vec<f32>; 3],
    /// Factors of light that they scatter.
    pub(super) throughput: Vec3s,
    /// Factor of light samples: its rest is that of samples elsewhere on the same ray.
    pub(super) share: Vec<f32>,
}

/// One of them, on a path.
pub(super) struct MediumVertex {
    pub(super) p: Vec3,
    pub(super) along: Vec3,
    pub(super) phase: Phase<f32>,
    pub(super) throughput: Vec3,
    pub(super) share: f32,
}

impl MediumVertices {
    /// Adds a vertex of the path of a number and a key.
    pub(super) fn push(&mut self, (number, key): (u32, SampleKey), vertex: &MediumVertex) {
        self.numbers.push(number);
        self.keys.push(key);
        self.p.push(vertex.p);
        self.along.push(vertex.along);
        let Phase { anisotropy: [first, second], second_share } = vertex.phase;
        for (row, value) in self.phase.iter_mut().zip([first, second, second_share]) {
            row.push(value);
        }
        self.throughput.push(vertex.throughput);
        self.share.push(vertex.share);
    }

    pub(super) fn clear(&mut self) {
        self.numbers.clear();
        self.keys.clear();
        self.p.resize(0);
        self.along.resize(0);
        self.phase.iter_mut().for_each(Vec::clear);
        self.throughput.resize(0);
        self.share.clear();
    }
}
