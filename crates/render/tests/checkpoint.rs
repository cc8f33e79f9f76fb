// SPDX-License-Identifier: GPL-3.0-or-later
//! Renderings that are broken off and go on, and tiles that get as many samples as they need.

use crate::common::*;
use gnurt_image::{ChannelData, Picture};
use gnurt_render::{Accumulation, CheckpointError, Integrator, RenderOptions, SceneCamera, Silent, World};
use gnurt_render::{render, render_on};
use gnurt_scene::Scene;

/// A floor, brightly lit in one corner, with a ball.
fn still_life() -> (World, SceneCamera) {
    let mut scene: Scene = floor(0.6, 4.0);
    let red = matte(&mut scene, [0.7, 0.2, 0.1]);
    put_mesh(&mut scene, sphere([0.0, 0.0, 0.7], 0.7, 12, red));
    let area_light = emitter(&mut scene, [30.0, 28.0, 20.0]);
    put_mesh(&mut scene, quad([-2.0, -2.0, 0.7], [0.0, 0.3, 0.0], [0.3, 0.0, 0.0], area_light));
    scene.add_light(environment([0.2, 0.3, 0.5]));
    (world_of(&scene, false), camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0))
}

fn path(spp: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth: 5, ..options(45, 33, spp) }
}

fn bits(picture: &Picture) -> Vec<[u32; 4]> {
    picture.color.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

#[test]
fn bytes_keep_everything() {
    let (world, view) = still_life();
    let options = RenderOptions { aovs: true, heatmap: true, ..path(6) };
    let whole = render(&world, &view, &options, &pool(2), &Silent).expect("sound");
    let mut first = Accumulation::new(options.clone()).expect("sound");
    first.pass(&world, &view, 2, &pool(1), &Silent);
    let bytes = first.to_bytes(7);
    let resumed = Accumulation::from_bytes(options.clone(), 7, &bytes).expect("it was just written");
    assert_eq!(resumed.to_bytes(7), bytes, "there and back");
    assert_eq!(resumed.byte_count(), bytes.len() as u64, "as many as are said");
    let empty = Accumulation::new(options.clone()).expect("sound");
    assert_eq!(empty.byte_count(), bytes.len() as u64, "from the beginning");
    let mut saved = Vec::new();
    let frame = render_on(resumed, &world, &view, &pool(7), &Silent, None, &mut |a| saved = a.to_bytes(7));
    assert!(bits(&frame.picture) == bits(&whole.picture), "the same colours");
    assert!(frame.picture.layers == whole.picture.layers, "the same layers");
    assert!(frame.heatmap == whole.heatmap, "the same costs");
    assert_eq!(frame.stats.samples, whole.stats.samples, "counters go on");
    assert!(Accumulation::from_bytes(options, 7, &saved).expect("the end").is_complete(), "saved at the end");
}

#[test]
fn bad_bytes_are_refused() {
    let (world, view) = still_life();
    let mut picture = Accumulation::new(path(4)).expect("sound");
    picture.pass(&world, &view, 3, &pool(2), &Silent);
    let bytes = picture.to_bytes(7);
    let read = |options, print, bytes: &[u8]| Accumulation::from_bytes(options, print, bytes).map(drop);
    assert_eq!(read(path(4), 8, &bytes), Err(CheckpointError::OtherPicture), "another fingerprint");
    let other = RenderOptions { width: 44, ..path(4) };
    assert_eq!(read(other, 7, &bytes), Err(CheckpointError::OtherPicture), "another size");
    assert_eq!(
        read(path(2), 7, &bytes),
        Err(CheckpointError::MoreSamples { has: 3, requested: 2 }),
        "too many"
    );
    assert_eq!(read(path(4), 7, b"GNU"), Err(CheckpointError::NoCheckpoint), "short");
    let longer = [&bytes[..], &[0; 8]].concat();
    assert_eq!(read(path(4), 7, &longer), Err(CheckpointError::OtherPicture), "of a larger one");
    for length in (16..bytes.len()).step_by(97) {
        assert_eq!(read(path(4), 7, &bytes[..length]), Err(CheckpointError::Damaged), "cut at {length}");
    }
    for at in (16..bytes.len()).step_by(101) {
        let mut changed = bytes.clone();
        changed[at] ^= 16;
        assert_eq!(read(path(4), 7, &changed), Err(CheckpointError::Damaged), "changed at {at}");
    }
}

/// Words that say sizes and counts are changed, and signed: the picture is as large as was asked for, whatever they say.
#[test]
fn signed_bytes_change_no_size() {
    let (world, view) = still_life();
    let options = RenderOptions { aovs: true, heatmap: true, ..path(4) };
    let mut picture = Accumulation::new(options.clone()).expect("sound");
    picture.pass(&world, &view, 2, &pool(2), &Silent);
    let bytes = picture.to_bytes(7);
    let mut taken = 0;
    for at in (0..40).chain((40..bytes.len() / 8 - 1).step_by(1511)) {
        for value in [(1 << 32) - 1, 1 << 40, u64::MAX] {
            let mut file = bytes.clone();
            file[8 * at..8 * at + 8].copy_from_slice(&value.to_le_bytes());
            crate::signed::sign(&mut file);
            let Ok(mut other) = Accumulation::from_bytes(options.clone(), 7, &file) else { continue };
            assert_eq!(other.byte_count(), bytes.len() as u64, "word {at} is {value:#x}");
            other.pass(&world, &view, 1, &pool(1), &Silent);
            assert_eq!(other.picture().pixel_count(), 45 * 33, "word {at} is {value:#x}");
            taken += 1;
        }
    }
    assert!(taken > 50, "sums are what they are: {taken}");
}

fn layer(picture: &Picture, name: &str) -> Vec<f32> {
    let layer = picture.layers.iter().find(|layer| layer.name == name).expect("the layer is there");
    match &layer.channels[0].data {
        ChannelData::F32(values) => values.clone(),
        other => panic!("{name} is no measure: {other:?}"),
    }
}

/// The variance that one picture tells, against the spread over many.
#[test]
fn variance_is_that_of_the_mean() {
    let (world, view) = still_life();
    const N: u32 = 24;
    let pictures: Vec<Picture> = (0..N)
        .map(|seed| {
            let options = RenderOptions { aovs: true, seed: seed.into(), pixel_centres: true, ..path(16) };
            render(&world, &view, &options, &pool(2), &Silent).expect("sound").picture
        })
        .collect();
    let reported: f64 =
        pictures.iter().flat_map(|p| layer(p, "variance")).map(f64::from).sum::<f64>() / f64::from(N);
    let spread: f64 = (0..pictures[0].pixel_count())
        .map(|i| {
            let values: Vec<f64> = pictures.iter().map(|p| f64::from(p.color[i][0])).collect();
            let mean = values.iter().sum::<f64>() / f64::from(N);
            values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(N - 1)
        })
        .sum();
    // Samples are stratified: the true variance is below that of independent ones, but not by orders.
    assert!(spread < 1.1 * reported && spread > 0.05 * reported, "spread {spread}, told {reported}");
}

#[test]
fn noise_is_brought_below_its_target() {
    let (world, view) = still_life();
    let reference = render(&world, &view, &path(400), &pool(2), &Silent).expect("sound").picture;
    let with = |noise, threads| {
        let options = RenderOptions { noise: Some(noise), ..path(512) };
        render(&world, &view, &options, &pool(threads), &Silent).expect("sound")
    };
    let frame = with(0.04, 2);
    assert!(frame.stats.complete && frame.stats.spp_min >= 16, "{:?}", frame.stats);
    assert!(frame.stats.spp_max > 2 * frame.stats.spp_min, "where it is needed: {:?}", frame.stats);
    assert!(bits(&frame.picture) == bits(&with(0.04, 7).picture), "7 threads give other bits");
    // Root mean square error over the whole picture: below the target, for stratified samples.
    let sums = frame.picture.color.iter().zip(&reference.color).fold([0.0; 2], |[error, mean], (a, b)| {
        [error + f64::from(a[0] - b[0]).powi(2), mean + f64::from(b[0])]
    });
    let n = reference.pixel_count() as f64;
    let relative = (sums[0] / n).sqrt() / (sums[1] / n);
    assert!(relative < 0.05 && relative > 0.002, "relative error {relative}");
}
