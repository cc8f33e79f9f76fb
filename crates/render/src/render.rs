// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures from worlds: tiles over a pool, in passes that double.
//! Source: original. Invariant: the picture depends on world, camera, options and the samples taken, bit for bit; neither
//! on threads nor on passes. Proof: crates/render/tests/determinism.rs.

use std::sync::atomic::{AtomicBool, AtomicU64};
use std::time::Instant;

use glam::Vec3;
use gnurt_accel::RayBatch;
use gnurt_image::{Filter, Picture, heat_map};
use gnurt_shading::CameraShader;
use rayon::prelude::*;

use crate::aov;
use crate::error::RenderError;
use crate::film::TileFilm;
use crate::frame::Frame;
use crate::options::RenderOptions;
use crate::progress::Progress;
use crate::stats::RenderStats;
use crate::tile::Job;
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
    let region = options.region()?;
    let job = job(world, camera, options, progress, start)?;
    let mut tiles = TileFilm::cover(region, options.aovs);
    let mut stats = RenderStats::default();
    for [first, last] in passes(options.spp) {
        if job.should_stop() {
            break;
        }
        let of_tiles: Vec<RenderStats> =
            pool.install(|| tiles.par_iter_mut().map(|tile| job.render_tile(tile, first, last)).collect());
        of_tiles.iter().for_each(|tile| stats.add(tile));
    }
    stats.spp_min = tiles.iter().map(|tile| tile.samples).min().unwrap_or(0);
    stats.spp_max = tiles.iter().map(|tile| tile.samples).max().unwrap_or(0);
    stats.complete = stats.spp_min == options.spp;
    stats.threads = pool.current_num_threads();
    let picture = picture(options, &tiles);
    let heatmap = options.heatmap.then(|| heatmap(options, &tiles));
    stats.seconds = start.elapsed().as_secs_f64();
    Ok(Frame { picture, heatmap, stats })
}

/// What all tiles share.
pub(crate) fn job<'a>(
    world: &'a World,
    camera: &'a dyn CameraShader,
    options: &'a RenderOptions,
    progress: &'a dyn Progress,
    start: Instant,
) -> Result<Job<'a>, RenderError> {
    let [x0, y0, x1, y1] = options.region()?;
    Ok(Job {
        world,
        camera,
        options,
        filter: Filter::new(options.filter),
        progress,
        // A limit beyond the end of time is none.
        deadline: options.time_limit.and_then(|limit| start.checked_add(limit)),
        all_samples: u64::from(x1 - x0) * u64::from(y1 - y0) * u64::from(options.spp),
        samples_done: AtomicU64::new(0),
        stopped: AtomicBool::new(false),
        forward: forward(camera, options),
    })
}

/// Samples of each pass: 1, 1, 2, 4, 8, 16, 16, ...: the first picture comes soon, later passes keep threads busy.
fn passes(spp: u32) -> impl Iterator<Item = [u32; 2]> {
    const MOST: u32 = 16;
    let next = move |&[_, last]: &[u32; 2]| (last < spp).then(|| [last, (last + last.min(MOST)).min(spp)]);
    std::iter::successors(Some([0, 1.min(spp)]), next)
}

/// Where the middle of the picture looks.
fn forward(camera: &dyn CameraShader, options: &RenderOptions) -> Vec3 {
    let mut rays = RayBatch::default();
    camera.rays(&[[0.5, 0.5]], options.width as f32 / options.height as f32, &mut rays);
    if rays.is_empty() { Vec3::NEG_Z } else { Vec3::from(rays.get(0).dir) }
}

fn picture(options: &RenderOptions, tiles: &[TileFilm]) -> Picture {
    let mut picture = Picture::new(options.width, options.height);
    for tile in tiles {
        for (i, [x, y]) in tile.pixels().enumerate() {
            picture.color[y as usize * options.width as usize + x as usize] = tile.mean(i);
        }
    }
    if options.aovs {
        aov::add_layers(&mut picture, tiles);
    }
    picture
}

fn heatmap(options: &RenderOptions, tiles: &[TileFilm]) -> Picture {
    let mut costs = vec![0.0; options.width as usize * options.height as usize];
    for tile in tiles {
        let per_sample = 1.0 / f64::from(tile.samples.max(1));
        for ([x, y], &cost) in tile.pixels().zip(&tile.costs) {
            costs[y as usize * options.width as usize + x as usize] = (cost as f64 * per_sample) as f32;
        }
    }
    heat_map(options.width, options.height, &costs)
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
