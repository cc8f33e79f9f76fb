// SPDX-License-Identifier: GPL-3.0-or-later
//! Media from files of volumes.

use std::io::Read;

use gnurt_image::Volume;
use gnurt_scene::io::Error;
use gnurt_scene::volume_cells::{Heat, density_grid};

use crate::common::read_with_files;

/// Grids of NanoVDB as `gnurt-image` tests them.
fn grids() -> Vec<u8> {
    let packed: &[u8] = include_bytes!("../../image/tests/data/nano/grids.nvdb.gz");
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(packed).read_to_end(&mut bytes).expect("a packed file");
    bytes
}

fn scene_of(medium: &str) -> Result<gnurt_scene::Scene, Error> {
    let text = format!(
        "WorldBegin\nTranslate 7 0 0\nMakeNamedMedium \"smoke\" \"string type\" \"nanovdb\" {medium}\n\
         MediumInterface \"smoke\" \"\"\nMaterial \"interface\"\nShape \"sphere\""
    );
    let (loaded, _folder) = read_with_files(&text, &[("a.nvdb", &grids()), ("b.nvdb", b"none")]);
    loaded.map(|loaded| loaded.scene)
}

#[test]
fn smoke_has_the_densities_of_a_file() {
    let scene = scene_of("\"string filename\" \"a.nvdb\" \"rgb sigma_a\" [ 1 2 3 ] \"float scale\" 2")
        .expect("smoke");
    let medium = &scene.media()[0];
    assert_eq!((medium.absorption, medium.scattering), ([2.0, 4.0, 6.0], [2.0; 3]));
    assert_eq!(medium.emission, [0.0; 3], "the file has no temperatures");
    let volume = Volume::decode(&grids(), 1 << 28).expect("a volume");
    let grid = volume.grid("density").expect("a grid");
    let cells = medium.grid.as_ref().expect("cells");
    let [first, last] = grid.active().expect("voxels");
    assert_eq!(cells.size, std::array::from_fn(|k| (last[k] - first[k] + 3) as u32), "with a rim");
    let size = cells.size.map(|n| n as usize);
    let value = grid.voxel([3, 3, 3])[0];
    let at: [usize; 3] = std::array::from_fn(|k| (3 - first[k] + 1) as usize);
    assert!(value > 0.0 && cells.density[(at[2] * size[1] + at[1]) * size[0] + at[0]] == value);
    // The middle of that cell is where the voxel is, moved by the statement before the medium.
    let middle: [f64; 3] = std::array::from_fn(|k| (at[k] as f64 + 0.5) / size[k] as f64);
    let found = cells.world_from_unit.point(middle);
    let voxel = grid.index_from_world().inverse().transform_point3(glam::dvec3(3.0, 3.0, 3.0));
    let expected = scene_place([voxel.x + 7.0, voxel.y, voxel.z]);
    assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-5), "{found:?}, not {expected:?}");
}

/// pbrt's space in the scene's, whose x is mirrored.
fn scene_place([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-x, y, z]
}

#[test]
fn numbers_of_a_second_grid_shine() {
    let volume = Volume::decode(&grids(), 1 << 28).expect("a volume");
    let (density, other) = (volume.grid("density").expect("a grid"), volume.grid("ball").expect("another"));
    let emission = |number: f32| [number, 2.0 * number, number * number];
    let heat = Heat { grid: other, emission: &emission };
    let made = density_grid(density, None, Some(&heat), None).expect("cells");
    assert_eq!(made.emission.len(), made.density.len());
    let [first, _] = density.active().expect("voxels");
    let world_from_index = density.index_from_world().inverse();
    let size = made.size.map(|n| n as usize);
    let mut shining = 0;
    for (i, cell) in made.emission.iter().enumerate() {
        let at = [i % size[0], i / size[0] % size[1], i / size[0] / size[1]];
        let index: [i32; 3] = std::array::from_fn(|k| first[k] - 1 + at[k] as i32);
        let place = world_from_index.transform_point3(index.map(f64::from).into());
        let there = other.index_from_world().transform_point3(place).to_array().map(|x| x.round() as i32);
        let expected = emission(other.voxel(there)[0].max(0.0));
        // By a table of 4096 steps.
        assert!(
            (0..3).all(|k| (cell[k] - expected[k]).abs() <= 1e-3 * (1.0 + expected[k])),
            "{cell:?}, {expected:?}"
        );
        shining += usize::from(expected[0] > 0.0);
    }
    assert!(shining > 10, "the grids overlap: {shining}");
}

#[test]
fn wrong_files_are_named() {
    for (medium, part) in [
        ("", "has no \"string filename\""),
        ("\"string filename\" \"b.nvdb\"", "does not begin as files of OpenVDB or NanoVDB do"),
        ("\"string filename\" \"c.nvdb\"", "c.nvdb"),
    ] {
        let why = scene_of(medium).expect_err("no volume").to_string();
        assert!(why.contains(part), "{medium}: {why}");
    }
}
