// SPDX-License-Identifier: GPL-3.0-or-later
//! Defaults of pictures: noise, curve, exposure, studio.

use gnurt::image::{ChannelData, Picture, read};

use super::harness::Folder;
use super::samples;

const BOX: &str = "render builtin:cornell -r 40x30 --spp 4 --max-depth 4";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", samples::OBJ);
    folder.write("scene.mtl", samples::MTL);
    folder
}

fn picture(folder: &Folder, name: &str) -> Picture {
    read(&folder.at(name)).expect("a picture")
}

#[test]
fn what_is_chosen_is_said_and_can_be_given() {
    let folder = Folder::new();
    let run = folder.gnurt(&format!("{BOX} -o chosen.png")).success();
    let notes = run.lines("note: ");
    let exposure = notes.iter().find_map(|note| note.split("--exposure ").nth(1)).expect("the exposure");
    let exposure = exposure.split(' ').next().expect("a number");
    assert!(notes.iter().any(|note| note.contains("--denoise=none")), "{}", run.stderr);
    let given = format!(
        "{BOX} -o given.png --exposure {exposure} --tone filmic --denoise=built-in --integrator path"
    );
    folder.gnurt(&given).success();
    assert_eq!(folder.read("chosen.png"), folder.read("given.png"), "what was chosen, written out");
    let before =
        folder.gnurt(&format!("{BOX} -o p.png --integrator whitted --tone clamp --exposure 0")).success();
    assert_eq!(before.stderr, "", "nothing is left to choose");
    assert_eq!(folder.gnurt(&format!("{BOX} -q -o q.png")).success().stderr, "", "quiet means quiet");
}

#[test]
fn colours_that_are_no_light_are_not_exposed() {
    let folder = folder();
    let line = "render a.obj -r 24x18 --spp 1 --integrator normals --eye 0,1,5 --target 0,1,0";
    let plain = folder.gnurt(&format!("{line} -o plain.png")).success();
    assert!(!plain.stderr.contains("exposure"), "nothing was chosen: {}", plain.stderr);
    folder.gnurt(&format!("{line} -o zero.png --exposure 0")).success();
    assert_eq!(folder.read("plain.png"), folder.read("zero.png"), "normals as they are");
}

#[test]
fn twice_the_light_makes_the_same_picture() {
    let folder = folder();
    let line = "render a.obj -r 24x18 --spp 4 --eye 0,1,5 --target 0,1,0";
    for (name, radiance) in [("dim", "0.001,0.001,0.001"), ("bright", "900,900,900")] {
        folder.gnurt(&format!("{line} --environment {radiance} -o {name}.png")).success();
    }
    let [dim, bright] = ["dim.png", "bright.png"].map(|name| picture(&folder, name));
    let comparison = gnurt::image::compare(&dim, &bright).expect("of one size");
    assert!(comparison.max_difference < 0.02, "{comparison}");
    assert!(dim.color.iter().any(|pixel| pixel[0] > 0.1), "and it can be seen");
}

#[test]
fn numbers_in_files_are_light() {
    let folder = Folder::new();
    for format in ["pfm", "hdr", "exr"] {
        let plain = folder.gnurt(&format!("{BOX} -o plain.{format}")).success();
        assert_eq!(plain.stderr, "", "nothing is done to it: {}", plain.stderr);
        folder.gnurt(&format!("{BOX} -o other.{format} --exposure 3 --tone reinhard")).success();
        folder.gnurt(&format!("diff plain.{format} other.{format}")).success();
    }
    folder.gnurt(&format!("{BOX} -o noisy.png --denoise=none --exposure 1 --tone filmic")).success();
    folder.gnurt("convert plain.exr later.png --exposure 1 --tone filmic").success();
    let [direct, later] = ["noisy.png", "later.png"].map(|name| picture(&folder, name));
    let comparison = gnurt::image::compare(&direct, &later).expect("of one size");
    assert!(comparison.max_difference < 0.02, "a file of floats keeps all: {comparison}");
}

#[test]
fn things_without_light_stand_in_a_studio() {
    let folder = folder();
    let run = folder.gnurt("render a.obj -r 48x32 --spp 16 -o a.exr").success();
    assert!(run.stderr.contains("studio"), "{}", run.stderr);
    let picture = picture(&folder, "a.exr");
    let background = picture.layer("background").expect("what lies behind");
    let values = |name: &str| match &background.channel(name).expect("a channel").data {
        ChannelData::F32(values) => values,
        ChannelData::U32(_) => panic!("floats"),
    };
    // The corner is floor or sky: empty, so that the whole background shows.
    assert_eq!(picture.color[0][3], 0.0, "{:?}", picture.color[0]);
    assert!((values("A")[0] - 1.0).abs() < 1e-3 && values("R")[0] > 0.1, "the backdrop");
    let opacities = || picture.color.iter().map(|pixel| pixel[3]);
    assert!(
        opacities().any(|a| a == 1.0) && opacities().any(|a| a > 0.1 && a < 0.9),
        "a thing and its shadow"
    );
    for (i, a) in opacities().enumerate() {
        assert!((a + values("A")[i] - 1.0).abs() < 2e-3, "pixel {i}: {a} and {}", values("A")[i]);
    }
    // Rays of eyelight look at shapes: there is no floor among them.
    let run = folder.gnurt("render a.obj -r 48x32 --spp 1 --integrator eyelight -o b.exr").success();
    assert!(!run.stderr.contains("studio"), "{}", run.stderr);
    folder.gnurt("render a.obj -r 48x32 --spp 1 --up 0,0,1 --eye 3,-3,3 -o z.png").success();
}

#[test]
fn lamps_of_a_scene_are_its_only_light() {
    let folder = folder();
    // A dim lamp, and surfaces far larger than it.
    folder.write("lamp.mtl", "newmtl red\nKd 0.8 0.2 0.1\nnewmtl lamp\nKe 0.02 0.02 0.01\n");
    let lamp = "usemtl lamp\nv -0.01 1 1\nv 0.01 1 1\nv 0 1.01 1\nf -3 -2 -1\n";
    folder.write("lamp.obj", samples::OBJ.replace("scene.mtl", "lamp.mtl") + lamp);
    for name in ["lamp.exr", "lamp.png"] {
        let run = folder.gnurt(&format!("render lamp.obj -r 24x18 --spp 4 -o {name}")).success();
        assert!(!run.stderr.contains("no light"), "{name}: {}", run.stderr);
    }
    assert_eq!(picture(&folder, "lamp.exr").color[0], [0.0; 4], "no backdrop and no floor");
}

#[test]
fn displays_are_lit_on_screens_and_left_alone_in_floats() {
    let folder = folder();
    folder.gnurt("render builtin:cornell -r 4x4 --spp 1 -o display.png").success();
    folder.write("display.mtl", "newmtl red\nKd 0.8 0.2 0.1\nKe 1 1 1\nmap_Ke display.png\n");
    folder.write("display.obj", samples::OBJ.replace("scene.mtl", "display.mtl"));
    let line = "render display.obj -r 24x18 --spp 4";
    let run = folder.gnurt(&format!("{line} -o a.png")).success();
    assert!(run.stderr.contains("no light but displays") && run.stderr.contains("studio"), "{}", run.stderr);
    for format in ["exr", "hdr", "pfm"] {
        let run = folder.gnurt(&format!("{line} -o a.{format}")).success();
        assert!(run.stderr.contains("a file of floats gets no other"), "{format}: {}", run.stderr);
        assert_eq!(picture(&folder, &format!("a.{format}")).color[0][..3], [0.0; 3], "{format}: no backdrop");
    }
    // Brighter than white it is a lamp.
    folder.write("display.mtl", "newmtl red\nKd 0.8 0.2 0.1\nKe 9 9 9\nmap_Ke display.png\n");
    for name in ["b.png", "b.exr"] {
        let run = folder.gnurt(&format!("{line} -o {name}")).success();
        assert!(!run.stderr.contains("no light"), "{name}: {}", run.stderr);
    }
}

#[test]
fn shaders_neither_lose_nor_become_the_studio() {
    let folder = folder();
    folder.write("red.osl", "surface red () { Ci = color (1, 0, 0) * diffuse (N); }");
    let line = "render a.obj -r 24x18 --spp 4 --denoise=none";
    for name in ["plain", "shaded"] {
        let shader = if name == "shaded" { "--shader *=red.osl" } else { "" };
        folder.gnurt(&format!("{line} {shader} -o {name}.exr")).success();
    }
    let [plain, shaded] = ["plain.exr", "shaded.exr"].map(|name| picture(&folder, name));
    assert_eq!(
        plain.color[0], shaded.color[0],
        "the floor catches shadow, whatever the scene's surfaces are"
    );
    let text = "vector way = point (0, 3, 3) - Ps; lightdist = length (way); L = normalize (way); Cl = color (9, 9, 9);";
    folder.write("lamp.osl", format!("light lamp () {{ {text} }}"));
    let run = folder.gnurt(&format!("{line} --shader lamp.osl -o lit.exr")).success();
    assert!(!run.stderr.contains("no light"), "{}", run.stderr);
}

#[test]
fn an_exr_is_over_nothing() {
    let folder = folder();
    let line = "render a.obj -r 24x18 --spp 4 --eye 0,1,5 --target 0,1,0 --environment 0.25,0.5,2";
    folder.gnurt(&format!("{line} -o a.exr")).success();
    folder.gnurt(&format!("{line} -o a.pfm")).success();
    let [exr, pfm] = ["a.exr", "a.pfm"].map(|name| picture(&folder, name));
    let comparison = gnurt::image::compare(&exr, &pfm).expect("of one size");
    assert!(comparison.max_difference < 0.01, "both tell what is seen: {comparison}");
    let bytes = folder.read("a.exr");
    let holds = |part: &str| bytes.windows(part.len()).any(|window| window == part.as_bytes());
    assert!(holds("background.R") && holds("background.A"), "what lies behind is a layer");
    folder.gnurt("convert a.exr a.png").success();
    let png = picture(&folder, "a.png");
    assert!(png.color.iter().all(|pixel| pixel[3] == 1.0), "on a screen it is opaque");
    assert!((png.color[0][1] - 0.5).abs() < 0.01, "and the background is seen: {:?}", png.color[0]);
}
