// SPDX-License-Identifier: GPL-3.0-or-later
//! `--out-of-core DIR`: scenes that do not fit into memory.

use std::process::Command;

use super::harness::{Folder, Run, finish};
use super::shaders::compile_source;

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

/// `prepare` is tried in a copy of the process; a block that lay in the file would be changed by that trial, too.
#[test]
fn trials_of_plugins_change_nothing() {
    let folder = Folder::new();
    let source = r#"
#include <openrt/rts.h>
struct block { float color[3]; int count, rest[5120]; };
static const RTSparam params[] = { { "color", RT_FLOAT, 3, RT_PER_SHADER, offsetof(struct block, color) } };
static int prepare(const RTShost *host, void *snapshot) {
    struct block *block = snapshot;
    (void)host;
    return ++block->count == 1 ? 0 : block->count;
}
static void shade(const RTShost *host, RTSctx *ctx, const RTShits *hits, RTSvecm out) {
    (void)host, (void)ctx;
    for (uint32_t i = 0; i < hits->n; i++) out.x[i] = out.y[i] = out.z[i] = 1;
}
static const RTSclass counts = { .struct_size = sizeof(RTSclass), .kind = RT_SURFACE_SHADER, .name = "counts",
    .shader_size = sizeof(struct block), .param_count = 1, .params = params, .prepare = prepare, .shade = shade };
const RTSmodule *rts_module(uint32_t host_abi) {
    static const RTSclass *const classes[] = { &counts };
    static const RTSmodule module = { sizeof(RTSmodule), RTS_ABI, 1, classes };
    (void)host_abi;
    return &module;
}
"#;
    compile_source(&folder, "counts", source);
    let line = "render builtin:cornell -r 8x8 --spp 1 -o p.png --shader *=counts@counts.so";
    folder.gnurt(line).success();
    folder.gnurt(&format!("{line} --out-of-core .")).success();
}

#[test]
fn folders_that_cannot_be_are_told() {
    let folder = Folder::new();
    let line = "render builtin:cornell -r 8x8 --spp 1 -o p.png --out-of-core nowhere";
    folder
        .gnurt(line)
        .fails(2, "--out-of-core nowhere: no such file or directory; give a folder on a local disk");
}
