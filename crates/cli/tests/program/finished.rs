// SPDX-License-Identifier: GPL-3.0-or-later
//! `view` of finished pictures without a window: layers, comparisons, wrong names and options.

use super::harness::Folder;

/// Two pictures with layers, and one of another size.
fn rendered() -> Folder {
    let folder = Folder::new();
    for (name, options) in [("a", "--seed 1"), ("b", "--seed 2"), ("wide", "-r 40x16")] {
        let line =
            format!("render builtin:cornell -r 24x16 --spp 2 {options} --layers normal,ids -o {name}.exr");
        folder.gnurt(&line).success();
    }
    folder
}

#[test]
fn layers_and_comparisons_are_written() {
    let folder = rendered();
    let view = |line: &str, output: &str| {
        folder.gnurt(&format!("view {line} --headless -o {output}")).success();
        gnurt::image::read(&folder.at(output)).expect("a picture")
    };
    let of = |name: &str| gnurt::image::read(&folder.at(name)).expect("a picture");
    let (a, b) = (of("a.exr"), of("b.exr"));
    assert!(view("a.exr", "same.exr").color == a.color, "light stays light");
    folder.gnurt("convert a.exr converted.png --exposure 1 --tone agx").success();
    let seen = view("a.exr --exposure 1 --tone agx", "seen.png");
    assert!(seen.color == of("converted.png").color, "as convert writes it");
    let normals = view("a.exr --layer N", "n.exr");
    assert!(normals.color.iter().all(|c| c[..3].iter().all(|x| (0.0..=1.0).contains(x))), "(v + 1) / 2");
    view("a.exr --layer id.material", "ids.png");
    let split = view("a.exr --compare b.exr", "split.exr");
    for (i, color) in split.color.iter().enumerate() {
        assert_eq!(*color, if i % 24 < 12 { a.color[i] } else { b.color[i] }, "left and right");
    }
    let difference = view("a.exr --compare b.exr --compare-as difference", "difference.exr");
    assert_eq!(difference.color[100][0], (a.color[100][0] - b.color[100][0]).abs());
    assert!(view("a.exr --compare a.exr --compare-as flip", "flip.png").color.iter().all(|c| c[0] == 0.0));
}

#[test]
fn wrong_names_and_options_are_told() {
    let folder = rendered();
    let error = |line: &str, parts: &[&str]| {
        let run = folder.gnurt(line);
        assert_ne!(run.status, Some(0), "{line}");
        parts
            .iter()
            .for_each(|part| assert!(run.stderr.contains(part), "{line}: '{part}' in {}", run.stderr));
    };
    error(
        "view a.exr --layer albido --headless -o x.png",
        &["a.exr", "unknown layer 'albido'", "id.material"],
    );
    error("view a.exr --headless", &["--output"]);
    error("view a.exr -o x.png", &["--headless"]);
    error("view none.exr --headless -o x.png", &["none.exr"]);
    error("view none.####.exr --headless -o x.png", &["none.####.exr", "no file"]);
    error("view a.exr --compare wide.exr --headless -o x.png", &["24x16", "40x16"]);
    error("view a.exr --compare-as both --headless -o x.png", &["both", "split"]);
    error("view a.exr --headless -o a.exr", &["a.exr"]);
    assert!(!folder.at("x.png").exists(), "nothing was written");
    let run = folder.gnurt("view a.exr --spp 4 --headless -o x.png").success();
    assert!(run.stderr.contains("--spp has no effect on finished pictures"), "{}", run.stderr);
    let run = folder.gnurt("view builtin:cornell -r 8x8 --spp 1 --layer N --headless -o y.png").success();
    assert!(run.stderr.contains("--layer has no effect on scenes"), "{}", run.stderr);
}
