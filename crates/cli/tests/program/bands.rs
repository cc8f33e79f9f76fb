// SPDX-License-Identifier: GPL-3.0-or-later
//! `render --band-rows`: the values of the picture that is rendered at once, in less memory.

use gnurt::image::{Picture, read};

use super::harness::Folder;

const SMALL: &str = "render builtin:cornell -r 70x90 --spp 4";

#[test]
fn the_values_of_the_whole_picture() {
    let folder = Folder::new();
    for (options, output) in [
        ("--bits 32 --layers all,direct,cryptomatte", "exr"),
        ("--bits 16 --tile-size 24", "exr"),
        ("--exposure 1 --denoise=none", "png"),
        ("--exposure 0 --tone agx --bits 16 --transparent --denoise=none", "png"),
        ("--integrator mir --vpls 64 --exposure 0 --denoise=none", "png"),
        ("--working-space acescg --bits 32", "exr"),
    ] {
        folder.gnurt(&format!("{SMALL} {options} -o whole.{output}")).success();
        let run = folder.gnurt(&format!("{SMALL} {options} --band-rows 20 -o bands.{output}")).success();
        let [whole, bands] =
            ["whole", "bands"].map(|n| read(&folder.at(&format!("{n}.{output}"))).expect("a picture"));
        let without = |picture: &Picture| Picture { metadata: Vec::new(), ..picture.clone() };
        assert!(without(&whole) == without(&bands), "{options}");
        for name in ["seed", "integrator", "cameraFromWorld"] {
            assert_eq!(whole.metadata(name), bands.metadata(name), "{options} {name}");
        }
        assert_eq!(run.lines("error: ").len() + run.lines("warning: ").len(), 0, "{}", run.stderr);
    }
}

#[test]
fn options_that_need_the_whole_picture() {
    let folder = Folder::new();
    for (more, message) in [
        ("--denoise -o a.png", "--denoise"),
        ("--piece 1/2 -o a.exr", "--piece"),
        ("--time 3s -o a.exr", "--time"),
        ("--heatmap h.png -o a.exr", "--heatmap"),
        ("--checkpoint c -o a.exr", "--checkpoint"),
        ("--integrator ir --interleave 3 -o a.exr", "--interleave"),
        ("-o a.jpg", ".png and .exr"),
    ] {
        let run = folder.gnurt(&format!("{SMALL} --band-rows 32 {more}"));
        run.fails(2, "--band-rows");
        run.fails(2, message);
    }
    folder.gnurt(&format!("{SMALL} --band-rows 32 -o a.png")).fails(2, "give --exposure EV");
}
