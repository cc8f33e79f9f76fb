// SPDX-License-Identifier: GPL-3.0-or-later
//! Direct light and path tracing with `--force-diffuse` against another renderer's pictures of the benchmark scenes.
//! Source: the reference images beside the repository (../shared/references), whose README says how to compare: means
//! within 0.5 %, and tiles of 8 x 8 pixels within 3 standard errors + 0.5 %, less than 2 % of them off.
//! Needs python3 to unpack the scenes; skipped, loudly, where they are not.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::*;
use gnurt_image::Picture;
use gnurt_render::{Integrator, RenderOptions, SceneCamera, Silent, render};
use gnurt_scene::Camera;

struct Reference {
    scene: &'static str,
    eye: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    fov_y: f32,
    width: u32,
}

const REFERENCES: [Reference; 5] = [
    Reference {
        scene: "cornell-box",
        eye: [0.0, 1.0, 6.8],
        target: [0.0, 1.0, 0.0],
        up: [0.0, 1.0, 0.0],
        fov_y: 19.5,
        width: 192,
    },
    Reference {
        scene: "office",
        eye: [2.1, 3.2, 2.0],
        target: [-1.2, 1.9, -0.8],
        up: [0.0, 1.0, 0.0],
        fov_y: 50.0,
        width: 256,
    },
    Reference {
        scene: "conference",
        eye: [30.0, 21.0, 7.0],
        target: [26.1962, 17.9239, 5.9663],
        up: [0.0, 0.0, 1.0],
        fov_y: 36.4,
        width: 256,
    },
    Reference {
        scene: "modern-hall",
        eye: [6.9118, 1.6516, 2.5541],
        target: [2.4108, 1.6516, 0.3766],
        up: [0.0, 1.0, 0.0],
        fov_y: 43.0,
        width: 256,
    },
    Reference {
        scene: "veach-bidir",
        eye: [16.2155, 4.0517, 0.0115],
        target: [6.2155, 4.0047, -0.0385],
        up: [0.0, 1.0, 0.0],
        fov_y: 35.0,
        width: 192,
    },
];

const HEIGHT: u32 = 192;
/// Edge of a tile.
const TILE: u32 = 8;

fn shared() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared")
}

/// The scene's folder, unpacked below the build's own folder for temporary files.
fn unpack(scene: &str) -> Option<PathBuf> {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenes");
    let script = shared().join("scenes/unpack.py");
    let done = Command::new("python3").arg(script).arg(&target).arg(scene).output();
    done.is_ok_and(|output| output.status.success()).then(|| target.join(scene))
}

/// Renders one scene several times with different seeds: the spread tells the standard error. Many batches, because
/// three standard errors estimated from a few are exceeded far more often than from many.
fn render_batches(reference: &Reference, folder: &Path, like: &RenderOptions, batches: u64) -> Vec<Picture> {
    let loaded = gnurt_scene::io::load(folder.join(format!("{}.obj", reference.scene))).expect("it loads");
    let world = world_of(&loaded.scene, true);
    let Reference { eye, target, up, fov_y, width, .. } = *reference;
    let camera = Camera { name: String::new(), eye, target, up, fov_y, ..Camera::default() };
    let camera = SceneCamera::new(&camera).expect("a view");
    let threads = pool(std::thread::available_parallelism().map_or(2, usize::from));
    let one = |seed| {
        let options = RenderOptions { seed, width, height: HEIGHT, ..like.clone() };
        render(&world, &camera, &options, &threads, &Silent).expect("sound options").picture
    };
    (0..batches).map(one).collect()
}

/// Sum of a channel over the tile at a column and a row.
fn tile_sum(picture: &Picture, [column, row]: [u32; 2], channel: usize) -> f64 {
    let pixels = (0..TILE).flat_map(|y| (0..TILE).map(move |x| (column * TILE + x, row * TILE + y)));
    pixels.map(|(x, y)| f64::from(picture.pixel(x, y).expect("inside")[channel])).sum()
}

/// The result of a comparison.
#[derive(Debug, Default)]
struct Comparison {
    /// Candidate over reference, minus one, per channel.
    mean_error: [f64; 3],
    tiles_off: usize,
    tiles: usize,
    z_mean: f64,
    z_deviation: f64,
}

fn compare(batches: &[Picture], reference: &Picture, variance: &Picture) -> Comparison {
    let n = batches.len() as f64;
    let mut comparison = Comparison::default();
    let expected = mean(reference);
    let means: Vec<[f64; 3]> = batches.iter().map(mean).collect();
    let relative = |k: usize| means.iter().map(|mean| mean[k]).sum::<f64>() / n / expected[k] - 1.0;
    comparison.mean_error = [relative(0), relative(1), relative(2)];
    let (mut z_sum, mut z_squares, mut z_count) = (0.0, 0.0, 0.0);
    let pixels = f64::from(TILE * TILE);
    let grid = (0..reference.height / TILE).flat_map(|r| (0..reference.width / TILE).map(move |c| [c, r]));
    for tile in grid {
        let mut off = false;
        for k in 0..3 {
            let sums: Vec<f64> = batches.iter().map(|batch| tile_sum(batch, tile, k) / pixels).collect();
            let found = sums.iter().sum::<f64>() / n;
            let own = sums.iter().map(|s| (s - found).powi(2)).sum::<f64>() / (n * (n - 1.0));
            let expected = tile_sum(reference, tile, k) / pixels;
            let error = (own + tile_sum(variance, tile, k) / (pixels * pixels)).sqrt();
            let difference = found - expected;
            off |= difference.abs() > 3.0 * error + 0.005 * expected;
            if error > 1e-3 * expected && expected > 0.0 {
                let z = difference / error;
                (z_sum, z_squares, z_count) = (z_sum + z, z_squares + z * z, z_count + 1.0);
            }
        }
        comparison.tiles += 1;
        comparison.tiles_off += usize::from(off);
    }
    if z_count > 0.0 {
        comparison.z_mean = z_sum / z_count;
        comparison.z_deviation = (z_squares / z_count - comparison.z_mean * comparison.z_mean).sqrt();
    }
    comparison
}

/// `kind` is "direct" or "path9". Different batches must differ by more than luck: enough of them, enough samples.
fn check(scenes: &[&str], kind: &str, like: &RenderOptions, batches: u64, mean_tolerance: f64) {
    let references = shared().join("references");
    if !references.is_dir() {
        eprintln!("SKIPPED: no reference images in {}", references.display());
        return;
    }
    for reference in REFERENCES.iter().filter(|r| scenes.contains(&r.scene)) {
        let scene = reference.scene;
        let Some(folder) = unpack(scene) else {
            eprintln!("SKIPPED: {scene} could not be unpacked (python3 and ../shared/scenes are needed)");
            continue;
        };
        let read =
            |name: String| gnurt_image::read(&references.join(name)).expect("the reference can be read");
        let (expected, variance) =
            (read(format!("{scene}-{kind}.exr")), read(format!("{scene}-{kind}-var.exr")));
        let start = std::time::Instant::now();
        let comparison = compare(&render_batches(reference, &folder, like, batches), &expected, &variance);
        let spp = u64::from(like.spp) * batches;
        eprintln!("{scene}-{kind}, {spp} spp, {:.1} s: {comparison:?}", start.elapsed().as_secs_f64());
        assert!(
            comparison.mean_error.iter().all(|e| e.abs() < mean_tolerance),
            "{scene}: means are off: {comparison:?}"
        );
        assert!(
            comparison.tiles_off * 50 < comparison.tiles,
            "{scene}: 2 % of tiles or more are off: {comparison:?}"
        );
    }
}

fn path(spp: u32, max_depth: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth, ..options(1, 1, spp) }
}

const ALL: [&str; 5] = ["cornell-box", "office", "conference", "modern-hall", "veach-bidir"];

#[test]
fn direct_light_is_right() {
    check(&["cornell-box", "office", "modern-hall"], "direct", &options(1, 1, 1), 40, 0.005);
}

#[test]
fn path_tracing_is_right() {
    check(&["cornell-box"], "path9", &path(1, 9), 40, 0.005);
}

#[test]
#[ignore = "minutes; run with --ignored after changes to light transport"]
fn direct_light_is_right_everywhere() {
    check(&ALL, "direct", &options(1, 1, 8), 48, 0.005);
}

#[test]
#[ignore = "minutes; run with --ignored after changes to light transport"]
fn path_tracing_is_right_everywhere() {
    for kind in [("direct", 2), ("path9", 9)] {
        check(&ALL[..4], kind.0, &path(8, kind.1), 48, 0.005);
    }
}

#[test]
#[ignore = "ten minutes: rare bright paths want many samples"]
fn path_tracing_is_right_where_it_is_hard() {
    for kind in [("direct", 2), ("path9", 9)] {
        check(&ALL[4..], kind.0, &path(32, kind.1), 64, 0.005);
    }
}
