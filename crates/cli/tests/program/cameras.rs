// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras: defaults, and parts that options replace.

use super::harness::{Folder, Run};
use super::samples;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", samples::OBJ);
    folder.write("scene.mtl", samples::MTL);
    folder
}

fn render(folder: &Folder, options: &str) -> Run {
    folder.gnurt(&format!("render a.obj -r 16x12 --spp 1 --integrator eyelight {options}")).success()
}

#[test]
fn a_scene_without_camera_or_light_says_so() {
    let folder = folder();
    let run = render(&folder, "-o p.png");
    let notes = run.lines("note: ");
    assert!(notes[0].contains("no camera") && notes[1].contains("no light"), "{}", run.stderr);
    assert_eq!(render(&folder, "-q -o q.png").stderr, "", "silence under -q");
    assert_eq!(folder.read("p.png"), folder.read("q.png"), "the same picture");
}

#[test]
fn parts_are_replaced_one_by_one() {
    let folder = folder();
    let all = "--eye 0,1,5 --target 0,1,0 --up 0,1,0 --fov 40";
    render(&folder, &format!("{all} -o all.pfm"));
    for change in ["--eye 1,1,5", "--target 0,0.5,0", "--up 1,1,0", "--fov 60"] {
        render(&folder, &format!("{all} {change} -o changed.pfm"));
        assert_ne!(folder.read("all.pfm"), folder.read("changed.pfm"), "{change} changes the picture");
    }
    render(&folder, "--eye 0,1,9 -o alone.png");
    render(&folder, "--fov 10 -o alone.png");
}

#[test]
fn another_up_is_chosen_where_it_is_parallel_to_the_view() {
    let folder = folder();
    let run = render(&folder, "--eye 0,1,5 --target 0,1,0 --up 0,0,-2 -o p.png");
    assert_eq!(run.lines("warning: ").len(), 1, "{}", run.stderr);
    assert!(run.stderr.contains("parallel"), "{}", run.stderr);
}

#[test]
fn an_eye_in_the_target_is_refused_after_loading_too() {
    let folder = folder();
    folder.write("b.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let run = folder.gnurt("render b.obj --eye 0,0,0 -o p.png");
    assert_eq!(
        run.status,
        Some(2),
        "the default camera looks at the middle, where the eye is: {}",
        run.stderr
    );
    assert!(!folder.at("p.png").exists(), "no picture");
}

#[test]
fn crops_keep_the_frame() {
    let folder = folder();
    let view = "--eye 0,1,5 --target 0,1,0";
    render(&folder, &format!("{view} -o all.pfm"));
    render(&folder, &format!("{view} --crop -3,4,8,99 -o part.pfm"));
    let (all, part) = (folder.read("all.pfm"), folder.read("part.pfm"));
    assert_eq!(all.len(), part.len(), "the picture keeps its size");
    let pixels =
        |bytes: &[u8]| bytes[bytes.len() - 16 * 12 * 12..].chunks(12).map(<[u8]>::to_vec).collect::<Vec<_>>();
    let (all, part) = (pixels(&all), pixels(&part));
    for (i, (whole, cut)) in all.iter().zip(&part).enumerate() {
        // Rows of a PFM run from the lowest one.
        let (x, y) = (i % 16, 11 - i / 16);
        let expected = if x < 8 && y >= 4 { whole.clone() } else { vec![0; 12] };
        assert_eq!(*cut, expected, "pixel {x},{y}");
    }
}

#[test]
fn projections_and_lenses_are_options() {
    let folder = folder();
    let view = "--eye 0,1,5 --target 0,1,0";
    render(&folder, &format!("{view} -o plain.pfm"));
    for change in [
        "--projection orthographic",
        "--projection orthographic --view-height 9",
        "--projection fisheye --fov 220",
        "--projection panorama",
        "--shift 0.25,0",
        "--aperture 2 --focus 2.5 --spp 4",
    ] {
        render(&folder, &format!("{view} {change} -o changed.pfm"));
        assert_ne!(folder.read("plain.pfm"), folder.read("changed.pfm"), "{change} changes the picture");
    }
    for (wrong, expected_text) in [
        ("--view-height 3", "--projection orthographic"),
        ("--focus 3", "--aperture"),
        ("--fov 200", "180"),
        ("--projection cube", "panorama"),
        ("--projection perspektive", "did you mean"),
        ("--aperture -1", "0 or above"),
        ("--shift 1", "two numbers"),
        ("--shift 0,2000", "1000"),
        ("--shift 0,1 --projection panorama", "no shift"),
    ] {
        let run = folder.gnurt(&format!("render a.obj {view} {wrong} -o p.png"));
        assert_eq!(run.status, Some(2), "{wrong}: {}", run.stderr);
        assert!(run.stderr.contains(expected_text), "{wrong}: {}", run.stderr);
    }
}
