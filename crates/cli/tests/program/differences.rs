// SPDX-License-Identifier: GPL-3.0-or-later
//! `diff`: equal and different pictures, and the size of differences.

use super::harness::Folder;
use super::samples;

/// A PFM of one grey pixel.
fn pixel(value: f32) -> Vec<u8> {
    [&b"Pf\n1 1\n-1.0\n"[..], &value.to_le_bytes()].concat()
}

#[test]
fn statuses() {
    let folder = Folder::new();
    for (name, value) in [("a", 0.5), ("b", 0.5625), ("nan", f32::NAN)] {
        folder.write(&format!("{name}.pfm"), pixel(value));
    }
    let status = |line: &str| {
        let run = folder.gnurt(line);
        assert_eq!(run.stderr, "", "a difference is no error: {line}");
        for name in ["MSE", "relMSE", "PSNR", "SSIM", "max difference"] {
            assert!(run.stdout.contains(name), "{line} prints {name}: {}", run.stdout);
        }
        run.status
    };
    assert_eq!(folder.gnurt("diff -q a.pfm a.pfm").success().stdout, "", "no word about equal ones under -q");
    assert_eq!(status("diff -q a.pfm b.pfm"), Some(1), "but about different ones");
    assert_eq!(status("diff a.pfm a.pfm"), Some(0), "equal");
    assert_eq!(status("diff a.pfm b.pfm"), Some(1), "different");
    assert_eq!(status("diff a.pfm b.pfm --fail 0.0625"), Some(0), "just within the tolerance");
    assert_eq!(status("diff a.pfm b.pfm --fail 0.06"), Some(1), "just beyond it");
    assert_eq!(status("diff --fail=1e9 nan.pfm nan.pfm"), Some(1), "NaN differs from everything");
}

#[test]
fn formats_may_be_mixed() {
    let folder = Folder::new();
    folder.write("a.pfm", samples::pfm());
    for format in ["exr", "hdr", "png"] {
        folder.gnurt(&format!("convert a.pfm a.{format}")).success();
    }
    // Half floats and shared exponents are near; screen bytes clip the 3.0.
    folder.gnurt("diff a.pfm a.exr --fail 0.01").success();
    folder.gnurt("diff a.hdr a.pfm --fail 0.02").success();
    folder.gnurt("diff a.png a.pfm --fail 2.01").success();
    assert_eq!(folder.gnurt("diff a.png a.pfm --fail 0.5").status, Some(1), "what was clipped differs");
}

#[test]
fn renderings_are_told_apart() {
    let folder = Folder::new();
    folder.write("a.obj", samples::OBJ);
    folder.write("scene.mtl", samples::MTL);
    for (name, seed) in [("one", 1), ("same", 1), ("other", 2)] {
        folder.gnurt(&format!("render a.obj -r 24x16 --spp 2 --seed {seed} -o {name}.exr")).success();
    }
    folder.gnurt("diff one.exr same.exr").success();
    assert_eq!(folder.gnurt("diff one.exr other.exr").status, Some(1), "another seed, another picture");
    // EXR keeps its colours over nothing, so formats are compared where nothing lies open: inside the box.
    let inside = "render builtin:cornell --eye 2.78,2.73,1 --target 2.78,2.73,5 -r 24x16 --spp 2";
    for name in ["in.exr", "in.pfm"] {
        folder.gnurt(&format!("{inside} -o {name}")).success();
    }
    folder.gnurt("diff in.exr in.pfm --fail 0.01").success();
}

#[test]
fn differences_are_drawn_and_weighed() {
    let folder = Folder::new();
    for (name, value) in [("a", 0.5), ("b", 0.75)] {
        folder.write(&format!("{name}.pfm"), pixel(value));
    }
    let run = folder.gnurt("diff a.pfm b.pfm --flip -o seen.png");
    assert_eq!(run.status, Some(1), "they differ: {}", run.stderr);
    let flip = run.stdout.lines().find_map(|line| line.strip_prefix("FLIP")).expect("a line");
    assert!(flip.trim().parse::<f64>().is_ok_and(|flip| flip > 0.05 && flip < 1.0), "{flip}");
    assert!(folder.at("seen.png").exists(), "false colours");
    folder.gnurt("diff a.pfm b.pfm -o by.pfm --fail 1").success();
    folder.write("quarter.pfm", pixel(0.25));
    folder.gnurt("diff by.pfm quarter.pfm").success();
    folder.gnurt("diff a.pfm b.pfm -o a.pfm").fails(2, "would be lost");
}

#[test]
fn formats_keep_what_they_hold() {
    let folder = Folder::new();
    folder.write("a.pfm", pixel(0.123_456));
    folder.gnurt("convert a.pfm a.png --bits 16").success();
    folder.gnurt("diff a.png a.pfm --fail 0.00002").success();
    folder.gnurt("convert a.pfm b.png").success();
    assert_eq!(folder.gnurt("diff b.png a.pfm --fail 0.00002").status, Some(1), "bytes are coarser");
    folder.gnurt("convert a.pfm a.jpg --quality 100").success();
    folder.gnurt("diff a.jpg a.pfm --fail 0.01").success();
    folder.gnurt("convert a.pfm a.webp").success();
    folder.gnurt("diff a.webp b.png").success();
    for compression in ["none", "rle", "zips", "zip", "piz", "pxr24"] {
        folder.gnurt(&format!("convert a.pfm a.exr --bits 32 --compression {compression}")).success();
        let most = if compression == "pxr24" { 1e-5 } else { 0.0 };
        folder.gnurt(&format!("diff a.exr a.pfm --fail {most}")).success();
    }
    folder.gnurt("convert a.pfm a.png --bits 9").fails(2, "expected 8, 16 or 32");
    folder
        .gnurt("convert a.pfm a.exr --compression zap")
        .fails(2, "valid are: none, rle, zips, zip, piz, pxr24");
    for tone in ["agx", "neutral"] {
        folder.gnurt(&format!("convert a.pfm {tone}.png --tone {tone}")).success();
    }
    let run = folder.gnurt("convert a.pfm a.png --quality 50").success();
    assert!(run.stderr.contains("--quality has no effect except on JPEG"), "{}", run.stderr);
}
