// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures are put in place whole, under the right name, with their headers.

use super::harness::Folder;

const SMALL: &str = "render builtin:cornell -r 16x16 --spp 1";

#[test]
fn the_default_name_is_the_scenes() {
    let folder = Folder::new();
    folder.gnurt(SMALL).success();
    folder.write("deep/a.b.ply", super::samples::PLY);
    folder.gnurt("render deep/a.b.ply -r 4x4 --spp 1").success();
    assert!(folder.at("cornell.png").exists() && folder.at("a.b.png").exists(), "in the current folder");
}

#[test]
fn quiet_runs_say_nothing() {
    let folder = Folder::new();
    let run = folder.gnurt(&format!("{SMALL} -q -o p.png")).success();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""), "silence");
    let run = folder.gnurt(&format!("{SMALL} -o p.png")).success();
    assert_eq!(run.stdout, "", "nothing for programs");
    assert!(
        run.stderr.lines().all(|line| line.starts_with("note: ")),
        "no bar without a terminal: {}",
        run.stderr
    );
}

#[test]
fn names_too_long_are_refused_before_the_work() {
    let folder = Folder::new();
    let long = "x".repeat(300);
    let begin = std::time::Instant::now();
    let run = folder.gnurt(&format!("render builtin:cornell -r 4000x4000 --spp 10000 -o {long}.png"));
    run.fails(1, "file name too long");
    assert!(begin.elapsed().as_secs() < 10, "no picture was made for it: {:?}", begin.elapsed());
    assert!(folder.contents().is_empty(), "nothing is left");
    let run = folder.gnurt(&format!("info {long}.obj"));
    run.fails(1, "file name too long");
    assert!(!run.stderr.contains("os error"), "words, no numbers: {}", run.stderr);
}

#[test]
fn extensions_are_read_in_any_case() {
    let folder = Folder::new();
    for name in ["a.PNG", "b.Exr", "c.PFM", "d.hDr"] {
        folder.gnurt(&format!("{SMALL} -o {name} --heatmap heat-{name}")).success();
        folder.gnurt(&format!("diff {name} {name}")).success();
        folder.gnurt(&format!("diff heat-{name} heat-{name}")).success();
    }
    assert_eq!(folder.contents().len(), 8, "four pictures, four heat maps, nothing else");
}

#[cfg(unix)]
#[test]
fn links_are_followed() {
    let folder = Folder::new();
    folder.write("real/old.png", "old");
    std::os::unix::fs::symlink("real/old.png", folder.at("link.png")).expect("a link");
    folder.gnurt(&format!("{SMALL} -o link.png")).success();
    assert!(folder.at("link.png").is_symlink(), "the link is still one");
    assert!(folder.read("real/old.png").starts_with(b"\x89PNG"), "its target is the picture");
}

#[cfg(unix)]
#[test]
fn protected_places_are_refused() {
    let folder = Folder::new();
    std::os::unix::fs::symlink("circle.png", folder.at("circle.png")).expect("a link");
    folder.gnurt(&format!("{SMALL} -o circle.png")).fails(1, "circle");
    std::fs::create_dir(folder.at("folder.png")).expect("a folder");
    folder.gnurt(&format!("{SMALL} -o folder.png")).fails(1, "folder");
    std::os::unix::fs::symlink("/dev/null", folder.at("device.png")).expect("a link");
    folder.gnurt(&format!("{SMALL} -o device.png")).fails(1, "device");
}

#[test]
fn an_exr_tells_how_it_was_made() {
    let folder = Folder::new();
    folder.gnurt(&format!("{SMALL} --seed 77 -o p.exr")).success();
    let bytes = folder.read("p.exr");
    let holds = |text: &str| bytes.windows(text.len()).any(|window| window == text.as_bytes());
    for text in
        ["seed", "commandLine", "cameraFromWorld", "ndcFromWorld", "samplesPerPixel", "albedo.R", "N.X"]
    {
        assert!(holds(text), "the file says {text}");
    }
    assert!(!holds(&folder.path().to_string_lossy()), "but not where its maker works");
}

#[test]
fn what_a_picture_is_made_from_is_not_lost() {
    let folder = Folder::new();
    folder.gnurt(&format!("{SMALL} -o quad.png")).success();
    let obj = "mtllib quad.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    folder.write("quad.obj", obj);
    folder.write("quad.mtl", "newmtl a\nmap_Kd quad.png\n");
    folder.write("sky.pfm", super::samples::pfm());
    let before = folder.contents();
    for line in [
        "render quad.obj -r 4x4 --spp 1",
        "render quad.obj -r 4x4 --spp 1 -o ./quad.png",
        "render quad.obj -r 4x4 --spp 1 -o p.png --heatmap quad.png",
        "render quad.obj -r 4x4 --spp 1 --environment sky.pfm -o sky.pfm",
    ] {
        folder.gnurt(line).fails(2, "would be lost; give another name");
        assert_eq!(folder.contents(), before, "{line}: all is as it was");
    }
    let run = folder.gnurt("view quad.obj --headless -r 4x4 --spp 1 -o quad.png");
    assert!(run.status == Some(2) && run.stderr.contains("would be lost"), "{}", run.stderr);
    assert_eq!(folder.contents(), before, "all is as it was");
    let run = folder.gnurt("render quad.obj -r 4x4 --spp 1 -o p.png").success();
    assert!(!run.stderr.contains("wrote"), "who gave a name knows it: {}", run.stderr);
    let run = folder.gnurt(SMALL).success();
    assert!(
        run.stderr.contains("note: wrote cornell.png"),
        "a name that nobody gave is said: {}",
        run.stderr
    );
}

#[test]
fn what_a_scene_is_read_from_is_not_lost() {
    let folder = Folder::new();
    folder.write("ok.obj", super::samples::OBJ);
    for (first, other, beside) in [("a.obj", "b.obj", "a.mtl"), ("c.gltf", "d.gltf", "c.bin")] {
        folder.gnurt(&format!("convert ok.obj {first}")).success();
        std::fs::rename(folder.at(first), folder.at(other)).expect("it is renamed");
        let before = folder.contents();
        let run = folder.gnurt(&format!("convert {other} {first}"));
        assert_eq!(run.status, Some(2), "{}", run.stderr);
        assert!(
            run.stderr.contains(&format!("{beside}: the scene is read from this file")),
            "{}",
            run.stderr
        );
        assert_eq!(folder.contents(), before, "all is as it was");
    }
}

#[test]
fn a_transparent_png_has_the_opacity_of_the_exr() {
    let folder = Folder::new();
    folder.write("t.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let picture = |options: &str, file: &str| {
        let line = format!(
            "render t.obj -r 24x16 --spp 4 --environment 1,0.5,0.25 --denoise=none -o {file} {options}"
        );
        folder.gnurt(&line).success();
        gnurt::image::read(&folder.at(file)).expect("a picture")
    };
    let (png, exr) = (picture("--transparent", "t.png"), picture("", "t.exr"));
    let opacity =
        |picture: &gnurt::image::Picture| picture.color.iter().map(|pixel| pixel[3]).collect::<Vec<_>>();
    let (found, expected) = (opacity(&png), opacity(&exr));
    assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 0.003), "{found:?} {expected:?}");
    assert!(
        found.contains(&0.0) && found.contains(&1.0) && found.iter().any(|a| *a > 0.0 && *a < 1.0),
        "{found:?}"
    );
    assert!(
        png.color.iter().all(|pixel| pixel[3] > 0.0 || pixel[..3] == [0.0; 3]),
        "no sky where nothing is in front"
    );
    assert!(opacity(&picture("", "o.png")).iter().all(|a| *a == 1.0), "opaque without it");
    let line = "render t.obj --transparent -o t.hdr";
    folder.gnurt(line).fails(2, "t.hdr has no opacity");
}
