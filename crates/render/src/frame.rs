// SPDX-License-Identifier: GPL-3.0-or-later
//! The result of a rendering.

use gnurt_image::Picture;

use crate::stats::RenderStats;

/// A finished picture and its cost.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Linear colours with opacity, row 0 on top, and the requested layers.
    pub picture: Picture,
    /// Cost per pixel in false colours, if requested.
    pub heatmap: Option<Picture>,
    /// Counters.
    pub stats: RenderStats,
}
