// SPDX-License-Identifier: GPL-3.0-or-later
//! The light of paths by the number of scatterings after those of the smooth surfaces that they begin with: none for lamps and sky
//! in mirrors and behind smooth glass, one for direct light; all other light is indirect.

use glam::Vec3;
use gnurt_shading::Vec3s;

/// Stands for more scatterings.
pub(crate) const MANY: u8 = 2;

/// Light of a batch by lane; empty if it is not requested.
#[derive(Default)]
pub(crate) struct SeenLight {
    /// Light over more edges is not seen, see [`super::most_edges`].
    most_edges: u32,
    pub(crate) unscattered: Vec3s,
    pub(crate) direct: Vec3s,
}

impl SeenLight {
    /// Begins a batch.
    pub(crate) fn reset(&mut self, lanes: usize, most_edges: u32) {
        self.most_edges = most_edges;
        [&mut self.unscattered, &mut self.direct].into_iter().for_each(|sums| sums.reset(lanes, Vec3::ZERO));
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.direct.is_empty()
    }

    /// Adds the light of a path of this many scatterings and edges.
    #[inline]
    pub(crate) fn add(&mut self, lane: u32, light: Vec3, (scattered, edges): (u8, u32)) {
        match scattered {
            0 if edges <= self.most_edges => self.unscattered.add(lane as usize, light),
            1 => self.direct.add(lane as usize, light),
            _ => {}
        }
    }
}
