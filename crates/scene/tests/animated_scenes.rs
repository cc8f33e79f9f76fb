// SPDX-License-Identifier: GPL-3.0-or-later
//! The animated benchmark scenes (../shared/scenes) are, at moments of every clip, where another program says that they are:
//! `data/pose.py`, written from the specification alone, in double precision. Skipped, loudly, where they are absent.
//! So are files that `data/random.py` makes by chance.

use std::path::Path;

use crate::common::{load, unpacked};
use gnurt_scene::Scene;
use gnurt_scene::io::Oddity;
use serde::Deserialize;

/// A row of the other program's output.
#[derive(Deserialize)]
struct Row {
    file: String,
    clip: usize,
    name: String,
    range: [f64; 2],
    seconds: f64,
    /// Of all corners of all triangles: least, greatest and mean coordinates, and means of two waves over space.
    figures: [f64; 11],
}

fn figures(scene: &Scene) -> [f64; 11] {
    let mut corners = Vec::new();
    for instance in scene.instances() {
        for mesh in scene.object(instance.object).meshes.iter().map(|&id| scene.mesh(id)) {
            let of = mesh.indices.iter().flatten().map(|&i| mesh.positions[i as usize].map(f64::from));
            corners.extend(of.map(|p| instance.world_from_object.point(p)));
        }
    }
    let over = |f: fn(f64, f64) -> f64, k: usize| corners.iter().map(|p| p[k]).reduce(f).expect("corners");
    let mean =
        |f: &dyn Fn([f64; 3]) -> f64| corners.iter().map(|&p| f(p)).sum::<f64>() / corners.len() as f64;
    let scale = corners.as_flattened().iter().map(|x| x.abs()).fold(0.0, f64::max);
    let wave = |k: [f64; 3]| mean(&|p| ((p[0] * k[0] + p[1] * k[1] + p[2] * k[2]) / scale).cos());
    let axis = |i: usize| i % 3;
    std::array::from_fn(|i| match i {
        0..3 => over(f64::min, axis(i)),
        3..6 => over(f64::max, axis(i)),
        6..9 => mean(&|p| p[axis(i)]),
        9 => wave([5.0, 3.0, 2.0]),
        _ => wave([-1.0, 4.0, 7.0]),
    })
}

/// Poses the files in a folder as the rows say.
fn check(rows: &str, folder: &Path) {
    let rows: Vec<Row> = serde_json::from_str(rows).expect("figures");
    let mut shown: Option<(String, Scene)> = None;
    let mut most: f64 = 0.0;
    for row in &rows {
        if shown.as_ref().is_none_or(|(file, _)| *file != row.file) {
            let loaded = load(folder.join(&row.file)).unwrap_or_else(|e| panic!("{e}"));
            let others = loaded.warnings.iter().filter(|warning| warning.oddity != Oddity::RepeatedKey);
            assert_eq!(others.count(), 0, "{}: {:?}", row.file, loaded.warnings);
            shown = Some((row.file.clone(), loaded.scene));
        }
        let (_, scene) = shown.as_mut().expect("a scene");
        let clip = &scene.animation().expect("an animation").clips[row.clip];
        assert_eq!(clip.name, row.name, "{} {}", row.file, row.clip);
        let range = clip.range();
        assert!(
            (0..2).all(|k| (range[k] - row.range[k]).abs() < 1e-9),
            "{} {}: {range:?}",
            row.file,
            row.clip
        );
        scene.pose(row.clip, row.seconds);
        let found = figures(scene);
        let size = (0..3).map(|k| row.figures[k + 3] - row.figures[k]).fold(0.0, f64::max);
        for (i, (found, expected)) in found.iter().zip(row.figures).enumerate() {
            let error = (found - expected).abs() / if i < 9 { size } else { 1.0 };
            most = most.max(error);
            let position = format!("{} {} at {} s", row.file, row.name, row.seconds);
            assert!(error < 2e-6, "{position}: figure {i} is {found}, not {expected}");
        }
    }
    assert!(most > 0.0, "{} rows were looked at", rows.len());
}

#[test]
fn clips_move_as_another_program_says() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    if let Some(root) = unpacked(folder.path(), &["animated"]) {
        check(include_str!("data/animated.json"), &root.join("animated"));
    }
}

/// Of files made by chance, with all that exporters seldom write.
#[test]
fn files_made_by_chance_move_as_another_program_says() {
    check(include_str!("data/chance.json"), &Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data"));
}
