// SPDX-License-Identifier: GPL-3.0-or-later
//! `--environment`: skies, colours and pictures around a scene.

use super::harness::Folder;
use super::samples;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", samples::OBJ);
    folder.write("scene.mtl", samples::MTL);
    folder
}

const RENDER: &str = "render a.obj -q -r 16x12 --spp 1 --eye 0,1,5 --target 0,1,0";

#[test]
fn what_surrounds_is_seen() {
    let folder = folder();
    let color = |options: &str| {
        folder.gnurt(&format!("{RENDER} {options} -o p.pfm")).success();
        gnurt::image::read(&folder.at("p.pfm")).expect("a picture").color[0]
    };
    let corner = color("--environment 0.25,0.5,2");
    assert_eq!(corner[..3], [0.25, 0.5, 2.0], "the radiance that was given");
    let day = color("--environment builtin:day");
    assert!(day[2] > day[0] && day[2] > 0.3, "a blue sky: {day:?}");
    assert_ne!(color("--environment builtin/sunset.osl"), day, "a sky of the library");
    // A picture of nothing but that, all around.
    folder.gnurt(&format!("{RENDER} --target 0,1,9 --environment 0.25,0.5,2 -o sky.hdr")).success();
    let again = color("--environment sky.hdr");
    assert!((0..3).all(|k| (again[k] - corner[k]).abs() < 0.01), "{again:?} for {corner:?}");
    assert_ne!(color("--environment builtin:day --environment-turn 180"), day, "turned");
    assert_ne!(color("--environment builtin:day --up 0,0,1"), day, "up is up in the sky, too");
}

#[test]
fn lights_of_nobody_are_needed_there() {
    let folder = folder();
    let run =
        folder.gnurt("render a.obj -r 16x12 --spp 1 --eye 0,1,5 --target 0,1,0 --environment 1,1,1 -o p.png");
    let run = run.success();
    assert!(!run.stderr.contains("no light"), "the scene has light: {}", run.stderr);
}

#[test]
fn wrong_surroundings_are_refused() {
    let folder = folder();
    folder.write("broken.hdr", "no picture");
    let fails = |options: &str, status: i32, message: &str| {
        folder.gnurt(&format!("{RENDER} {options} -o p.png")).fails(status, message);
        assert!(!folder.at("p.png").exists(), "no picture is left behind");
    };
    fails("--environment builtin:dya", 2, "did you mean 'day'");
    fails("--environment 1,1,-1", 2, "not negative");
    fails("--environment nowhere.hdr", 1, "nowhere.hdr");
    fails("--environment broken.hdr", 1, "broken.hdr");
    fails("--environment 1,1,1 --environment-turn much", 2, "--environment-turn");
    fails("--environment-turn 5", 2, "--environment");
}
