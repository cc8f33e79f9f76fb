// SPDX-License-Identifier: GPL-3.0-or-later
//! Volumes against OpenVDB 12's values of its own files, small files written here, and broken ones.
//! `data/grids.txt` has, for each grid, its name and active voxels, then voxels and their values.

mod common;

use std::io::Write;

use common::unpacked;
use gnurt_image::Volume;

const ENOUGH: usize = 1 << 26;

fn grids() -> Vec<u8> {
    unpacked(include_bytes!("data/grids.vdb.gz"))
}

/// The fault of a file.
fn fault(bytes: &[u8], limit: usize) -> String {
    Volume::decode(bytes, limit).unwrap_err().to_string()
}

#[test]
fn voxels_are_those_of_openvdb() {
    let volume = Volume::decode(&grids(), ENOUGH).unwrap();
    let names: Vec<_> = volume.grids().iter().map(gnurt_image::Grid::name).collect();
    assert_eq!(names, ["ball", "Cd", "count", "density", "density", "far"]);
    let mut grids = volume.grids().iter();
    let mut grid = None;
    let mut compared = 0;
    for line in include_str!("data/grids.txt").lines() {
        let parts: Vec<_> = line.split(' ').collect();
        let whole = |token: &str| token.parse::<i32>().unwrap();
        if parts[0] == "grid" {
            let next = grids.next().unwrap();
            assert_eq!(next.name(), parts[1]);
            let active = std::array::from_fn(|k| std::array::from_fn(|i| whole(parts[2 + 3 * k + i])));
            assert_eq!(next.active(), Some(active), "{}", parts[1]);
            grid = Some(next);
            continue;
        }
        let (grid, at) = (grid.unwrap(), std::array::from_fn(|i| whole(parts[i])));
        let found = grid.voxel(at);
        let expected: Vec<f32> =
            parts[3..].iter().map(|token| token.parse::<f64>().unwrap() as f32).collect();
        assert_eq!(found[..grid.channels()], expected, "{} {at:?}", grid.name());
        compared += 1;
    }
    assert!(compared > 450, "{compared}");
}

/// Rows against single voxels: through leaves, tiles and the background, across the edges of nodes and the last number.
#[test]
fn rows_have_the_values_of_voxels() {
    let volume = Volume::decode(&grids(), ENOUGH).unwrap();
    let (mut runs, mut leaves, mut voxels) = (0, 0, 0);
    for grid in volume.grids() {
        let [first, last] = grid.active().unwrap();
        let corners = [first, last].into_iter().chain([[-4100, 0, 0], [i32::MAX - 9, 3, -5]]);
        for at in corners.flat_map(|[x, y, z]| [[x - 3, y, z], [x - 21, y - 1, z + 1], [x - 130, y, z - 2]]) {
            for count in [0, 1, 7, 300, 8200] {
                let mut found = Vec::new();
                grid.row(at, count, |value, run| {
                    assert!(run > 0, "{} {at:?}", grid.name());
                    (runs, leaves) = (runs + 1, leaves + usize::from(run == 1));
                    found.extend(std::iter::repeat_n(value, run));
                });
                let one = |i: usize| grid.voxel([at[0].wrapping_add(i as i32), at[1], at[2]]);
                assert!(found.into_iter().eq((0..count).map(one)), "{} {at:?} {count}", grid.name());
                voxels += count;
            }
        }
    }
    assert!(leaves > 300 && 20 * runs < voxels, "{leaves} single voxels, {runs} runs, {voxels} voxels");
}

#[test]
fn maps_take_the_world_to_voxels() {
    let volume = Volume::decode(&grids(), ENOUGH).unwrap();
    let near = |name: &str, world: [f64; 3], index: [f64; 3]| {
        let found = volume.grid(name).unwrap().index_from_world().transform_point3(world.into());
        assert!(found.distance(index.into()) < 1e-9, "{name} {found}");
    };
    // Rows of the map that the file was written with, times (2, -3, 4), and its way.
    near(
        "ball",
        [2.0 * 0.5 + 3.0 * 0.1 + 3.0, 2.0 * 0.1 - 3.0 * 0.25 + 0.2 - 4.0, 8.0 + 5.0],
        [2.0, -3.0, 4.0],
    );
    near("Cd", [0.5, -0.75, 1.0], [2.0, -3.0, 4.0]);
    near("count", [2.0, -3.0, 4.0], [2.0, -3.0, 4.0]);
    let window = volume.grid("ball").unwrap().window();
    assert_eq!(window, Some([[-8, -8, -8], [7, 7, 7]]));
}

/// A file with one leaf, whose active values are 1, 2, 3, in a background of -1; `list` packs the values.
fn small(packing: u32, all: bool, list: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut file = Vec::new();
    let text = |file: &mut Vec<u8>, text: &str| {
        file.extend((text.len() as u32).to_le_bytes());
        file.extend(text.as_bytes());
    };
    file.extend(0x5644_4220_i64.to_le_bytes());
    [224_u32, 8, 0].iter().for_each(|n| file.extend(n.to_le_bytes()));
    file.push(1);
    file.extend([b'-'; 36]);
    file.extend([0; 4]);
    file.extend(1_u32.to_le_bytes());
    text(&mut file, "density");
    text(&mut file, "Tree_float_5_4_3");
    text(&mut file, "");
    let start = file.len() as i64 + 24;
    let offsets = file.len();
    file.extend([start, start, start].iter().flat_map(|n| n.to_le_bytes()));
    file.extend(packing.to_le_bytes());
    file.extend([0; 4]);
    text(&mut file, "TranslationMap");
    [1.0_f64, 0.0, 0.0].iter().for_each(|n| file.extend(n.to_le_bytes()));
    file.extend(1_u32.to_le_bytes());
    file.extend((-1.0_f32).to_le_bytes());
    file.extend([0_u32, 1].iter().flat_map(|n| n.to_le_bytes()));
    file.extend([0; 12]);
    for cells in [32_usize.pow(3), 16_usize.pow(3)] {
        // The first slot has a child; no value is active; inactive values are the background.
        let mut mask = vec![0; cells / 8];
        mask[0] = 1;
        file.extend(&mask);
        mask[0] = 0;
        file.extend(&mask);
        let values: Vec<u8> = (0..cells).flat_map(|_| (-1.0_f32).to_le_bytes()).collect();
        file.push(if all { 6 } else { 0 });
        file.extend(list(if all { &values } else { &[] }));
    }
    let mut mask = [0; 64];
    mask[0] = 0b111;
    file.extend(mask);
    file.extend(mask);
    let mut values: Vec<u8> = [1.0_f32, 2.0, 3.0].iter().flat_map(|n| n.to_le_bytes()).collect();
    if all {
        values.extend((3..512).flat_map(|_| (-1.0_f32).to_le_bytes()));
    }
    file.push(if all { 6 } else { 0 });
    file.extend(list(&values));
    let end = (file.len() as i64).to_le_bytes();
    file[offsets + 16..offsets + 24].copy_from_slice(&end);
    file
}

fn zlib(values: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    packer.write_all(values).unwrap();
    let packed = packer.finish().unwrap();
    [&(packed.len() as i64).to_le_bytes()[..], &packed].concat()
}

/// Data that did not shrink.
fn as_it_is(values: &[u8]) -> Vec<u8> {
    [&(-(values.len() as i64)).to_le_bytes()[..], values].concat()
}

#[test]
fn every_packing_gives_the_same() {
    let plain = |values: &[u8]| values.to_vec();
    let files = [
        small(0, true, plain),
        small(2, false, plain),
        small(1, true, zlib),
        small(3, false, zlib),
        small(3, false, as_it_is),
        small(6, false, as_it_is),
        small(6, true, as_it_is),
    ];
    for (i, file) in files.iter().enumerate() {
        let volume = Volume::decode(file, ENOUGH).unwrap_or_else(|error| panic!("{i}: {error}"));
        let grid = volume.grid("density").unwrap();
        let found = [0, 1, 2, 3].map(|z| grid.voxel([0, 0, z])[0]);
        assert_eq!(found, [1.0, 2.0, 3.0, -1.0], "{i}");
        assert_eq!(grid.voxel([-5, 900, 7])[0], -1.0);
        assert_eq!(grid.active(), Some([[0, 0, 0], [0, 0, 2]]));
    }
}

#[test]
fn bad_files_are_told() {
    let file = small(0, true, <[u8]>::to_vec);
    assert!(fault(b"P6 1 1 255", ENOUGH).contains("does not begin"));
    assert!(fault(&file[..200], ENOUGH).contains("ends too early"));
    assert!(fault(&file, 20_000).contains("more than the 0 MiB allowed"));
    let mut old = file.clone();
    old[8] = 215;
    assert!(fault(&old, ENOUGH).contains("version 215 of OpenVDB; 222 to 224 are read"));
    let why = fault(&unpacked(include_bytes!("data/mask.vdb.gz")), ENOUGH);
    assert!(why.contains("no grid of numbers (the first is a Tree_bool_5_4_3)"), "{why}");
    let broken = small(1, true, |_| as_it_is(&[1, 2, 3]));
    assert!(fault(&broken, ENOUGH).contains("3 bytes of values in place of"));
    let mut lines = file.clone();
    let kind = lines.windows(14).position(|token| token == b"TranslationMap").unwrap();
    lines[kind + 3..kind + 5].copy_from_slice(b"\n\x1b");
    let why = fault(&lines, ENOUGH);
    assert!(why.contains("unsupported map") && !why.contains(char::is_control), "{why:?}");
    let error = Volume::read(std::path::Path::new("no/such.vdb"), ENOUGH).unwrap_err().to_string();
    assert!(error.contains("no/such.vdb"), "{error}");
}

/// Where the descriptor of the only grid of `small` has the places of its parts.
const PLACES: usize = 8 + 12 + 1 + 36 + 4 + 4 + (4 + 7) + (4 + 16) + 4;

#[test]
fn only_regular_files_are_read() {
    let folder = std::env::temp_dir().to_string_lossy().into_owned();
    let why = |path: &str| Volume::read(std::path::Path::new(path), ENOUGH).unwrap_err().to_string();
    assert!(why(&folder).contains("is a folder; a file of OpenVDB or NanoVDB is needed"), "{}", why(&folder));
    if cfg!(unix) {
        // It has no end, and its first bytes are none of OpenVDB's.
        assert!(why("/dev/zero").contains("is a device or pipe"), "{}", why("/dev/zero"));
    }
    let path = std::env::temp_dir().join(format!("gnurt-volume-{}.vdb", std::process::id()));
    std::fs::write(&path, small(3, false, zlib)).unwrap();
    let (all, few) = (Volume::read(&path, ENOUGH), Volume::read(&path, 999));
    std::fs::remove_file(&path).unwrap();
    assert!(all.is_ok(), "a file is read");
    assert!(
        few.unwrap_err().to_string().contains("MiB allowed"),
        "a file that is larger than what may be taken"
    );
}

/// A grid that ends where it is described would be read for ever.
#[test]
fn grids_lie_one_behind_the_other() {
    let good = small(3, false, zlib);
    let number =
        |file: &mut Vec<u8>, at: usize, value: i64| file[at..at + 8].copy_from_slice(&value.to_le_bytes());
    let mut back = good.clone();
    back[61..65].copy_from_slice(&u32::MAX.to_le_bytes());
    number(&mut back, PLACES + 16, 65);
    let begin = std::time::Instant::now();
    assert!(fault(&back, ENOUGH).contains("a part from byte"), "{}", fault(&back, ENOUGH));
    assert!(begin.elapsed().as_secs() < 5, "at once");
    let mut short = good.clone();
    let start = i64::from_le_bytes(good[PLACES..PLACES + 8].try_into().unwrap());
    number(&mut short, PLACES + 16, start + 100);
    assert!(
        fault(&short, ENOUGH).contains("ends too early"),
        "a grid is read up to its end: {}",
        fault(&short, ENOUGH)
    );
}

/// Bytes of packed files changed once, and ends cut: errors or grids, nothing else.
#[test]
fn changed_files_never_panic() {
    let changed = |file: &[u8], at: usize| {
        let mut changed = file.to_vec();
        changed[at] ^= 1 << (at % 8) | 0x80;
        drop(Volume::decode(&changed, 1 << 24));
    };
    let file = small(3, false, zlib);
    (0..file.len()).step_by(29).chain(0..300).for_each(|at| changed(&file, at));
    let file = grids();
    (0..800).step_by(67).chain((8000..file.len()).step_by(17_011)).for_each(|at| changed(&file, at));
    for end in (0..file.len()).step_by(40_009) {
        assert!(Volume::decode(&file[..end], ENOUGH).is_err());
    }
}

/// Files changed in several places, cut, grown and spliced by a fixed sequence of numbers: half a second of them, or
/// `GNURT_MUTATE=SECONDS`. An error is one line, and grids can be asked everywhere.
#[test]
fn files_changed_at_many_places() {
    let seconds = std::env::var("GNURT_MUTATE").ok().and_then(|text| text.parse().ok()).unwrap_or(0.5);
    let seeds = [
        small(0, true, <[u8]>::to_vec),
        small(3, false, zlib),
        small(6, false, as_it_is),
        small(3, false, as_it_is),
    ];
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as usize % below.max(1)
    };
    let begin = std::time::Instant::now();
    while begin.elapsed().as_secs_f64() < seconds {
        let mut file = seeds[next(seeds.len())].clone();
        for _ in 0..1 + next(6) {
            // Most of a file is masks: the words of its structure come first and last.
            let at = if next(2) == 0 { next(file.len().min(260)) } else { next(file.len()) };
            match next(6) {
                0 => file.truncate(at.max(1)),
                1 => drop(file.splice(at..at, vec![next(256) as u8; next(40)])),
                2 => {
                    let end = (at + 1 + next(8)).min(file.len());
                    file[at..end].fill([0, 0xff, 0x7f, 1][next(4)]);
                }
                3 => drop(file.drain(at..(at + next(64)).min(file.len()))),
                _ => file[at] ^= 1 << next(8),
            }
            if file.is_empty() {
                file.push(0);
            }
        }
        match Volume::decode(&file, 1 << 24) {
            Ok(volume) => {
                for grid in volume.grids() {
                    let corners = grid.window().unwrap_or([[i32::MIN; 3], [i32::MAX; 3]]);
                    for at in [corners[0], corners[1], [0; 3], [-1, 4095, 4096]] {
                        std::hint::black_box(grid.voxel(at));
                    }
                }
            }
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "one line: {error}"),
        }
    }
}
