// SPDX-License-Identifier: GPL-3.0-or-later
//! `--ocio`: views of built-in configurations in files, by one way and by another. With the feature `ocio` only.

use gnurt::image::read;

use super::harness::Folder;

const RENDER: &str = "render builtin:cornell -r 48x36 --spp 2 --exposure 0.5 --denoise=none";
const CG: &str = "--ocio ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1";

#[test]
fn the_same_picture_by_all_commands() {
    let folder = Folder::new();
    folder.gnurt(&format!("{RENDER} {CG} -o direct.png")).success();
    folder.gnurt(&format!("{RENDER} {CG} --band-rows 32 -o bands.png")).success();
    folder.gnurt("render builtin:cornell -r 48x36 --spp 2 --bits 32 -o light.exr").success();
    folder.gnurt(&format!("convert light.exr --exposure 0.5 {CG} converted.png")).success();
    let [direct, bands, converted] =
        ["direct.png", "bands.png", "converted.png"].map(|name| read(&folder.at(name)).expect("a picture"));
    assert!(direct.color == bands.color && direct.color == converted.color, "one look");
    // A view without a curve is the clamped picture.
    folder.gnurt(&format!("{RENDER} {CG} --ocio-view Un-tone-mapped -o plain.png")).success();
    folder.gnurt(&format!("{RENDER} --tone clamp -o clamped.png")).success();
    let [plain, clamped] =
        ["plain.png", "clamped.png"].map(|name| read(&folder.at(name)).expect("a picture"));
    let apart = plain
        .color
        .iter()
        .flatten()
        .zip(clamped.color.iter().flatten())
        .filter(|(a, b)| (*a - *b).abs() > 0.01);
    assert_eq!(apart.count(), 0, "but for the last bit");
    assert!(direct.color != plain.color, "another view");
}

#[test]
fn mistakes_are_named() {
    let folder = Folder::new();
    for (more, status, part) in [
        ("--ocio no.ocio -o a.png", 1, "no.ocio"),
        (&format!("{CG} --ocio-view nice -o a.png"), 2, "Un-tone-mapped"),
        (&format!("{CG} -o a.exr"), 2, "keeps the light"),
        (&format!("{CG} --tone agx -o a.png"), 2, "--tone"),
        ("--ocio-view nice -o a.png", 2, "--ocio"),
    ] {
        folder.gnurt(&format!("{RENDER} {more}")).fails(status, part);
    }
}
