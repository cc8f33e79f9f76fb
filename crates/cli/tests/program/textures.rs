// SPDX-License-Identifier: GPL-3.0-or-later
//! `--texture-memory MIB`: textures on the disk, the same pictures.

use gnurt::image::{TexelData, Texels, encode_texels};

use super::harness::Folder;
use super::samples;

#[test]
fn pictures_are_the_same_with_little_memory() {
    let folder = Folder::new();
    let texel = |i: u32| [i as u8, (i >> 8) as u8, i.wrapping_mul(2_654_435_761).to_le_bytes()[3], 255];
    let data = TexelData::Srgb8((0..700 * 700).map(texel).collect());
    let texels = Texels { width: 700, height: 700, data };
    folder.write("t.png", encode_texels(&texels, false).expect("a picture"));
    folder.write("scene.mtl", format!("{}map_Kd t.png\nbump -bm 0.5 t.png\n", samples::MTL));
    folder.write("a.obj", samples::OBJ);
    let render = |more: &str, to: &str| {
        let line = format!(
            "render a.obj --eye 0,1,5 --target 0,1,0 --environment 1,1,1 -r 48x48 --spp 4 -o {to} {more}"
        );
        folder.gnurt(&line).success();
        folder.read(to)
    };
    // Two megabytes twice, as colours and as heights, and a smaller one: all in one megabyte.
    assert!(render("", "a.png") == render("--texture-memory 1", "b.png"), "the same, byte for byte");
    let convert = |more: &str, to: &str| {
        folder.gnurt(&format!("convert a.obj {to} {more}")).success();
        folder.read(to)
    };
    assert!(convert("", "a.glb") == convert("--texture-memory 1", "b.glb"), "and the same file");
    folder.gnurt("info a.obj --texture-memory 0").fails(2, "--texture-memory");
}
