// SPDX-License-Identifier: GPL-3.0-or-later
//! `--fog` and `--volume`: media around and within a scene, and integrators that leave them out.

use super::harness::Folder;
use super::samples;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", samples::OBJ);
    folder.write("scene.mtl", samples::MTL);
    folder
}

const RENDER: &str =
    "render a.obj -r 16x12 --spp 4 --eye 0,1,5 --target 0,1,9 --environment 1,1,1 --denoise=none";

#[test]
fn fog_takes_light_out() {
    let folder = folder();
    let color = |options: &str| {
        folder.gnurt(&format!("{RENDER} -q {options} -o p.pfm")).success();
        gnurt::image::read(&folder.at("p.pfm")).expect("a picture").color[0]
    };
    assert_eq!(color("")[..3], [1.0; 3], "the sky");
    // Fog that only absorbs, and less of blue light.
    let dim = color("--fog 4,4,1000:albedo=0");
    assert!(dim[0] == dim[1] && dim[0] < 0.9 && dim[2] > 0.9, "{dim:?}");
}

#[test]
fn integrators_without_media_say_so() {
    let folder = folder();
    let run = folder.gnurt(&format!("{RENDER} --fog 4 --integrator whitted -o p.pfm"));
    let stderr = run.success().stderr;
    assert!(stderr.contains("leaves out media"), "{stderr}");
}

#[test]
fn wrong_media_are_named() {
    let folder = folder();
    for (options, part) in [
        ("--fog 0", "above 0"),
        ("--fog 4:colour=1", "no 'colour'"),
        ("--volume none.vdb", "none.vdb"),
        ("--volume a.obj", "a.obj"),
    ] {
        let run = folder.gnurt(&format!("{RENDER} -q {options} -o p.pfm"));
        assert!(run.status != Some(0) && run.stderr.contains(part), "{options}: {}", run.stderr);
    }
}
