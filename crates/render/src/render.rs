// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures from worlds: tiles over a pool, in passes that double.
//! Source: original. Invariant: the picture depends on world, camera, options and the samples taken, bit for bit; neither
//! on threads nor on passes. Proof: crates/render/tests/determinism.rs.

use std::time::Instant;

use gnurt_shading::CameraShader;

use crate::accumulation::Accumulation;
use crate::error::RenderError;
use crate::frame::Frame;
use crate::options::RenderOptions;
use crate::progress::Progress;
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
    let start = Instant::now();
    // A limit beyond the end of time is none.
    let deadline = options.time_limit.and_then(|limit| start.checked_add(limit));
    let mut accumulation = Accumulation::new(options.clone())?;
    for [first, last] in passes(options.spp) {
        if !accumulation.pass_until(deadline, world, camera, last - first, pool, progress) {
            break;
        }
    }
    Ok(accumulation.into_frame(start))
}

/// Samples of each pass: 1, 1, 2, 4, 8, 16, 16, ...: the first picture comes soon, later passes keep threads busy.
fn passes(spp: u32) -> impl Iterator<Item = [u32; 2]> {
    const MOST: u32 = 16;
    let next = move |&[_, last]: &[u32; 2]| (last < spp).then(|| [last, (last + last.min(MOST)).min(spp)]);
    std::iter::successors(Some([0, 1.min(spp)]), next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_take_each_sample_once() {
        for spp in [1, 2, 3, 7, 16, 100] {
            let passes: Vec<_> = passes(spp).collect();
            assert_eq!(passes[0], [0, 1], "the first picture comes soon");
            assert_eq!(passes[passes.len() - 1][1], spp, "all of them");
            assert!(passes.windows(2).all(|w| w[0][1] == w[1][0]), "one after the other: {passes:?}");
        }
    }
}
