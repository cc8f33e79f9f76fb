// SPDX-License-Identifier: GPL-3.0-or-later
//! `--out-of-core DIR`: scenes that do not fit into memory. Source: original.

use std::process::Command;

use super::harness::{Folder, Run, finish};

/// A binary PLY file of a wavy square of so many squares on a side.
fn waves(side: u32) -> Vec<u8> {
    let (corners, faces) = ((side + 1) * (side + 1), 2 * side * side);
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {corners}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for (i, j) in (0..=side).flat_map(|j| (0..=side).map(move |i| (i, j))) {
        let (x, y) = (i as f32 / side as f32, j as f32 / side as f32);
        let corner = [x, y, 0.05 * (40.0 * x).sin() * (40.0 * y).cos()];
        file.extend(corner.iter().flat_map(|number| number.to_le_bytes()));
    }
    for (i, j) in (0..side).flat_map(|j| (0..side).map(move |i| (i, j))) {
        let corner = j * (side + 1) + i;
        for face in
            [[corner, corner + 1, corner + side + 1], [corner + 1, corner + side + 2, corner + side + 1]]
        {
            file.push(3);
            file.extend(face.iter().flat_map(|number| number.to_le_bytes()));
        }
    }
    file
}

/// Runs the program with so many MiB of memory of its own: heap, stacks, tables.
fn limited(folder: &Folder, mebibytes: u32, line: &str) -> Run {
    let program = folder.command::<&str>(&[]);
    let mut shell = Command::new("sh");
    let script = format!("ulimit -d {} && exec \"$0\" \"$@\"", mebibytes << 10);
    shell.current_dir(folder.path()).args(["-c", &script]).arg(program.get_program());
    shell.args(line.split_whitespace());
    finish(shell)
}

#[test]
fn a_scene_of_several_times_the_memory_renders() {
    let folder = Folder::new();
    folder.write("waves.ply", waves(700));
    let line = "render waves.ply -q -t 1 -r 48x48 --spp 1 --integrator eyelight -o";
    folder.gnurt(&format!("{line} free.png")).success();
    let within = limited(&folder, 40, &format!("{line} none.png"));
    assert_ne!(within.status, Some(0), "it does not fit: {}", within.stderr);
    limited(&folder, 40, &format!("{line} file.png --out-of-core .")).success();
    assert_eq!(folder.read("free.png"), folder.read("file.png"), "the same picture");
    let left = folder.contents().len();
    assert_eq!(left, 3, "the file goes with the program");
}

#[test]
fn folders_that_cannot_be_are_told() {
    let folder = Folder::new();
    let line = "render builtin:cornell -r 8x8 --spp 1 -o p.png --out-of-core nowhere";
    folder
        .gnurt(line)
        .fails(2, "--out-of-core nowhere: no such file or directory; give a folder on a local disk");
}
