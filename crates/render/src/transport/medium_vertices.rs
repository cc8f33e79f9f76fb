// SPDX-License-Identifier: GPL-3.0-or-later
//! Vertices of paths in media, as structures of arrays: written by `media` in flight, scattered later.
//! Space: world. Tests: crates/render/tests/media.rs.

use gnurt_shading::{SampleKey, Vec3s};

/// Vertices in media.
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
}

impl MediumVertices {
    /// Marks the lanes that they are of, among `count`.
    pub(crate) fn mark(&self, count: usize, lanes: &mut Vec<bool>) {
        lanes.clear();
        lanes.resize(count, false);
        self.numbers.iter().for_each(|&lane| lanes[lane as usize] = true);
    }

    pub(super) fn clear(&mut self) {
        self.numbers.clear();
        self.keys.clear();
        self.p.resize(0);
        self.along.resize(0);
        self.phase.iter_mut().for_each(Vec::clear);
    }
}
