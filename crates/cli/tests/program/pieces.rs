// SPDX-License-Identifier: GPL-3.0-or-later
//! `render --piece` and `join`: the bytes of the single run, for pieces made with any settings; mismatches
//! are rejected.

use gnurt::image::{Picture, read};

use super::harness::Folder;

const SMALL: &str = "render builtin:cornell -r 70x50 --spp 4";

/// Renders all pieces, each with other threads and another instruction set.
fn render_pieces(folder: &Folder, options: &str, count: u32) -> String {
    let machines = ["-t 1 --isa scalar", "-t 2", "-t 3 --isa auto"];
    let files: Vec<String> = (1..=count).rev().map(|i| format!("p.{i}.exr")).collect();
    for (i, file) in (1..=count).rev().zip(&files) {
        let machine = machines[i as usize % machines.len()];
        folder.gnurt(&format!("{options} {machine} --piece {i}/{count} -o {file}")).success();
    }
    files.join(" ")
}

#[test]
fn the_bytes_of_the_single_run() {
    for (options, count, output, display) in [
        (SMALL.to_owned(), 3, "png", ""),
        (format!("{SMALL} --crop 5,7,61,40 --seed 9"), 4, "png", "--denoise=none --tone clamp"),
        (format!("{SMALL} --integrator whitted"), 2, "pfm", ""),
        (format!("{SMALL} --integrator mir --vpls 64"), 2, "png", "--exposure 1"),
        (format!("{SMALL} --integrator eyelight"), 21, "hdr", ""),
        ("render builtin:cornell -r 70x50 --spp 64 --noise 0.3".into(), 2, "png", "--denoise=built-in"),
    ] {
        let folder = Folder::new();
        folder.gnurt(&format!("{options} {display} -o whole.{output}")).success();
        let files = render_pieces(&folder, &options, count);
        // Some come twice.
        let twice = files.split(' ').next().expect("a piece");
        let run = folder.gnurt(&format!("join {files} {twice} {display} -o joined.{output}")).success();
        assert!(
            folder.read(&format!("whole.{output}")) == folder.read(&format!("joined.{output}")),
            "{options}"
        );
        assert_eq!(run.lines("error: ").len(), 0, "{}", run.stderr);
    }
}

#[test]
fn layers_and_headers_are_joined() {
    let folder = Folder::new();
    folder.gnurt(&format!("{SMALL} -o whole.exr")).success();
    let files = render_pieces(&folder, SMALL, 3);
    folder.gnurt(&format!("join {files} -o joined.exr")).success();
    let [whole, joined] = ["whole.exr", "joined.exr"].map(|name| read(&folder.at(name)).expect("a picture"));
    let without = |picture: &Picture| Picture { metadata: Vec::new(), ..picture.clone() };
    assert!(without(&whole) == without(&joined), "all layers, bit for bit");
    let names = |picture: &Picture| picture.metadata.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&whole), names(&joined), "the same is said, and nothing of pieces");
    for name in ["samplesPerPixel", "cameraFromWorld", "seed", "integrator"] {
        assert_eq!(whole.metadata(name), joined.metadata(name), "{name}");
    }
}

#[test]
fn pieces_of_frames() {
    let folder = Folder::new();
    super::animation::animated(&folder);
    let clip = "render a.gltf --animation slide -r 48x32 --spp 2 --frames 3..4 --denoise-window 0";
    folder.gnurt(&format!("{clip} -o whole.####.png")).success();
    for i in [1, 2] {
        folder.gnurt(&format!("{clip} --piece {i}/2 -o p{i}.####.exr")).success();
    }
    for frame in [3, 4] {
        folder.gnurt(&format!("join p1.000{frame}.exr p2.000{frame}.exr -o joined.png")).success();
        assert!(folder.read(&format!("whole.000{frame}.png")) == folder.read("joined.png"), "frame {frame}");
    }
}

#[test]
fn what_does_not_go_with_pieces() {
    let folder = Folder::new();
    for (more, message) in [
        ("--piece 1/2 -o p.png", "the file of a piece is an .exr"),
        ("--piece 1/2", "give --output FILE.exr"),
        ("--piece 1/2 -o p.exr --time 1s", "give --spp"),
        ("--piece 1/2 -o p.exr --heatmap h.png", "no heat map"),
        ("--piece 1/2 -o p.exr --denoise", "give --denoise to `gnurt join`"),
        ("--piece 1/2 -o p.exr --integrator ir --interleave 3", "read their neighbours"),
        ("--piece 3/2 -o p.exr", "piece 3 of 2 is out of range"),
        ("--piece 0/2 -o p.exr", "like 2/8"),
        ("--piece 2 -o p.exr", "like 2/8"),
    ] {
        folder.gnurt(&format!("{SMALL} {more}")).fails(2, message);
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0, "nothing is left behind");
}

#[test]
fn what_does_not_fit_is_not_joined() {
    let folder = Folder::new();
    render_pieces(&folder, SMALL, 3);
    for (name, options) in [
        ("seed", format!("{SMALL} --seed 1 --piece 2/3")),
        ("eye", format!("{SMALL} --eye 0,0,9 --piece 2/3")),
        ("spp", format!("{} --piece 2/3", SMALL.replace("--spp 4", "--spp 3"))),
        ("four", format!("{SMALL} --piece 2/4")),
        ("whole", SMALL.to_owned()),
    ] {
        folder.gnurt(&format!("{options} -o {name}.exr")).success();
    }
    for (pieces, message) in [
        ("p.1.exr p.2.exr", "piece 3/3 is missing"),
        ("p.2.exr p.2.exr", "piece 1/3, 3/3 are missing"),
        ("p.1.exr seed.exr p.3.exr", "seed.exr is of another picture than p.1.exr"),
        ("p.1.exr p.3.exr eye.exr", "eye.exr is of another picture"),
        ("p.1.exr p.3.exr spp.exr", "spp.exr has 3 samples per pixel, p.1.exr has 4"),
        ("p.1.exr p.3.exr four.exr", "four.exr is one of 4 pieces, p.1.exr one of 3"),
        ("p.1.exr p.2.exr whole.exr", "whole.exr: not a piece"),
        ("p.1.exr p.2.exr nowhere.exr", "nowhere.exr"),
    ] {
        folder.gnurt(&format!("join {pieces} -o out.png")).fails(1, message);
    }
    // The same piece with other pixels: somebody's memory or disk is at fault.
    let other = read(&folder.at("p.2.exr")).expect("a piece");
    let mut other = Picture { opacity: gnurt::image::Opacity::Associated, ..other };
    other.color[3][1] += 1.0;
    let how = gnurt::image::WriteOptions { exr_pixels: gnurt::image::ExrPixels::Float, ..Default::default() };
    let bytes = gnurt::image::encode(&other, gnurt::image::PictureFormat::EXR, &how).expect("an EXR");
    folder.write("other.exr", bytes);
    folder
        .gnurt("join p.1.exr p.2.exr p.3.exr other.exr -o out.png")
        .fails(1, "are both piece 2/3 and differ");
    let piece = folder.read("p.2.exr");
    folder.write("cut.exr", &piece[..piece.len() / 2]);
    folder.gnurt("join p.1.exr cut.exr p.3.exr -o out.png").fails(1, "cut.exr");
    folder.gnurt("join p.1.exr p.2.exr p.3.exr -o p.1.exr").fails(2, "is one of the pieces");
    folder.gnurt("join p.1.exr p.2.exr p.3.exr -o out.gif").fails(2, "picture format");
    folder.gnurt("join p.1.exr").fails(2, "--output");
    folder.gnurt("join -o out.png").fails(2, "PIECE");
    assert!(!folder.at("out.png").exists(), "nothing was written");
}

#[test]
fn a_piece_goes_on_from_its_checkpoint() {
    let folder = Folder::new();
    let piece = format!("{SMALL} --piece 1/2 --checkpoint state");
    folder.gnurt(&format!("{piece} -o p.1.exr")).success();
    let run = folder.gnurt(&format!("{piece} -o again.exr")).success();
    assert!(run.stderr.contains("going on from state"), "{}", run.stderr);
    let color = |name: &str| read(&folder.at(name)).expect("a piece").color;
    assert!(color("p.1.exr") == color("again.exr"), "the same piece");
    assert!(!run.stderr.contains("the time is up"), "it was whole already: {}", run.stderr);
    let other = piece.replace("1/2", "2/2");
    folder.gnurt(&format!("{other} -o p.2.exr")).fails(1, "of another picture");
}
