// SPDX-License-Identifier: GPL-3.0-or-later
//! Volumes of NanoVDB against the same grids in OpenVDB's file, NanoVDB's own values of packed types, and broken files.
//! `data/nano` was written by NanoVDB 32.9 from the grids of `data/grids.vdb.gz`. `types.txt` has, for each grid, voxels and the
//! values that NanoVDB reads there.

mod common;

use common::unpacked;
use gnurt_image::{Grid, Volume};

const ENOUGH: usize = 1 << 28;

fn grids() -> Vec<u8> {
    unpacked(include_bytes!("data/nano/grids.nvdb.gz"))
}

fn types() -> Vec<u8> {
    unpacked(include_bytes!("data/nano/types.nvdb.gz"))
}

/// A file with one grid, which no segment describes: the grid "density" of [`zipped`].
fn raw() -> Vec<u8> {
    raw_grid(3)
}

fn raw_grid(number: usize) -> Vec<u8> {
    let file = grids();
    let (_, grid) = segments(&file).nth(number).unwrap();
    grid.to_vec()
}

fn zipped() -> Vec<u8> {
    unpacked(include_bytes!("data/nano/zip.nvdb.gz"))
}

fn open() -> Volume {
    Volume::decode(&unpacked(include_bytes!("data/grids.vdb.gz")), ENOUGH).unwrap()
}

fn number(file: &[u8], at: usize) -> usize {
    u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize
}

/// The segments of a file with one grid in each: head and grid.
fn segments(file: &[u8]) -> impl Iterator<Item = (&[u8], &[u8])> {
    let mut at = 0;
    std::iter::from_fn(move || {
        (at < file.len()).then(|| {
            let name = u32::from_le_bytes(file[at + 152..at + 156].try_into().unwrap()) as usize;
            let (head, packed) = (at, number(file, at + 24));
            let grid = at + 16 + 176 + name;
            at = grid + packed;
            (&file[head..grid], &file[grid..at])
        })
    })
}

/// The fault of a file.
fn fault(bytes: &[u8]) -> String {
    Volume::decode(bytes, ENOUGH).unwrap_err().to_string()
}

/// Whether two grids are the same, at all places about the active voxels and some far away.
fn compare(nano: &Grid, open: &Grid) {
    let name = open.name();
    assert_eq!((nano.name(), nano.channels()), (name, open.channels()));
    assert_eq!(nano.active(), open.active(), "{name}");
    let (a, b) = (nano.index_from_world(), open.index_from_world());
    assert!(a.abs_diff_eq(b, 1e-9), "{name}: {a:?} {b:?}");
    let mut compared = 0;
    let mut same = |at: [i32; 3]| {
        assert_eq!(nano.voxel(at), open.voxel(at), "{name} {at:?}");
        compared += 1;
    };
    for x in -24..24 {
        for y in -24..24 {
            (-24..24).for_each(|z| same([x, y, z]));
        }
    }
    let [first, last] = open.active().unwrap();
    let step =
        |k: usize, i: i64| (i64::from(first[k]) + (i64::from(last[k]) - i64::from(first[k])) * i / 40) as i32;
    for x in -2..43 {
        for y in -2..43 {
            (-2..43).for_each(|z| same([step(0, x), step(1, y), step(2, z)]));
        }
    }
    [[i32::MIN; 3], [i32::MAX; 3], [-4096, 0, 0], [-1, 4095, 4096]].into_iter().for_each(&mut same);
    assert!(compared > 100_000);
}

#[test]
fn grids_are_those_of_openvdb() {
    let (nano, open) = (Volume::decode(&grids(), ENOUGH).unwrap(), open());
    assert_eq!(nano.grids().len(), open.grids().len());
    nano.grids().iter().zip(open.grids()).for_each(|(nano, open)| compare(nano, open));
}

#[test]
fn every_packing_gives_the_same() {
    let open = open();
    let mut old = zipped();
    // Before version 32.6, files began as grids do.
    old[7] = b'0';
    old[9] = 0xc;
    let blosc = unpacked(include_bytes!("data/nano/blosc.nvdb.gz"));
    // Two grids without a segment.
    let twice = [raw(), raw()].concat();
    for (name, file) in
        [("zlib", zipped()), ("old", old), ("Blosc", blosc), ("raw", raw()), ("raw, twice", twice)]
    {
        let nano = Volume::decode(&file, ENOUGH).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(nano.grids().len(), if name == "raw, twice" { 2 } else { 1 });
        nano.grids().iter().for_each(|grid| compare(grid, &open.grids()[3]));
    }
}

#[test]
fn every_type_gives_what_nanovdb_reads() {
    let volume = Volume::decode(&types(), ENOUGH).unwrap();
    let (mut grid, mut compared, mut names) = (None, 0, 0);
    for line in include_str!("data/nano/types.txt").lines() {
        let parts: Vec<_> = line.split(' ').collect();
        if parts[0] == "grid" {
            names += 1;
            grid = volume.grid(parts[1]);
            continue;
        }
        let grid = grid.expect(line);
        let at = std::array::from_fn(|i| parts[i].parse::<i32>().unwrap());
        let expected: Vec<f32> = parts[3..].iter().map(|x| x.parse::<f64>().unwrap() as f32).collect();
        assert_eq!(grid.voxel(at)[..grid.channels()], expected, "{} {line}", grid.name());
        compared += 1;
    }
    assert!(names == 9 && compared > 150, "{names} {compared}");
}

#[test]
fn bad_files_are_told() {
    let file = raw();
    let changed = |at: usize, bytes: &[u8]| {
        let mut file = file.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let is_told = |file: &[u8], part: &str| assert!(fault(file).contains(part), "{part}: {}", fault(file));
    is_told(&file[..700], "the file ends too early");
    is_told(b"NanoVDB2", "the file ends too early");
    is_told(b"1BDVonaN        ", "begin with the highest byte");
    is_told(&changed(16, &[0, 0, 0xe0, 3]), "version 31.0 of NanoVDB; 32.0 and later ones of 32 are read");
    is_told(&changed(636, &[8]), "no grid of numbers (the first is a Mask)");
    is_told(&changed(636, &[99]), "no grid of numbers (the first is a grid of an unknown type)");
    is_told(&changed(384, &[0; 72]), "the map of the grid \"density\" has no inverse");
    is_told(&changed(32, &[9, 0, 0, 0]), "a grid is shorter than its head");
    is_told(&changed(672 + 24, &[0xff; 8]), "is not in its grid");
    let mut packed = zipped();
    packed[14] = 7;
    is_told(&packed, "unknown compression 7");
    // The head of the root, then its first two places, which may not be one node's.
    let root = 736;
    let places = root + 64;
    let second = number(&file, places + 8) as i64;
    is_told(&changed(places + 32 + 8, &second.to_le_bytes()), "two nodes share the bytes");
    // 2^60 bytes of a grid in some hundred.
    is_told(
        &{
            packed[14] = 1;
            packed[16..24].copy_from_slice(&(1_u64 << 60).to_le_bytes());
            packed
        },
        "MiB allowed",
    );
    assert!(Volume::decode(&raw(), 100_000).is_err_and(|error| error.to_string().contains("MiB allowed")));
}

/// Bytes changed once, and ends cut: errors or grids, nothing else.
#[test]
fn changed_files_never_panic() {
    // One voxel, and no more nodes than it needs.
    let file = raw_grid(4);
    let look = |file: &[u8]| match Volume::decode(file, 1 << 24) {
        Ok(volume) => {
            for grid in volume.grids() {
                let corners = grid.window().unwrap_or([[i32::MIN; 3], [i32::MAX; 3]]);
                for at in [corners[0], corners[1], [0; 3], [-1, 4095, 4096]] {
                    std::hint::black_box(grid.voxel(at));
                }
            }
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "one line: {error}"),
    };
    let changed = |file: &[u8], at: usize, bits: u8| {
        let mut changed = file.to_vec();
        changed[at] ^= bits;
        look(&changed);
    };
    let ats = (0..40).chain(384..460).chain((620..1200).step_by(2)).chain((1200..file.len()).step_by(40_013));
    ats.for_each(|at| changed(&file, at, 1 << (at % 8) | 0x80));
    let packed = zipped();
    (0..220)
        .step_by(7)
        .chain((220..packed.len()).step_by(packed.len() / 10))
        .for_each(|at| changed(&packed, at, 1 << (at % 8)));
    (0..packed.len()).step_by(packed.len() / 8).for_each(|end| look(&packed[..end]));
    (0..file.len()).step_by(50_001).for_each(|end| assert!(Volume::decode(&file[..end], ENOUGH).is_err()));
}
