// SPDX-License-Identifier: GPL-3.0-or-later
//! C and C++ programs with librtut, built and run; its exported symbols.

#[path = "../../openrt/tests/common/mod.rs"]
mod common;

use std::process::Command;

use OpenRT as _;
use common::{Workshop, built, source};

const LIBRARIES: &[&str] = &["rtut", "OpenRT"];

#[test]
fn shapes() {
    let workshop = Workshop::with(LIBRARIES);
    let binary = workshop.build("cc", "c99", &source("tests/c/shapes.c"));
    workshop.run(&binary, &[]);
}

/// The larger programs of examples/c build, run at a small size without errors, and their pictures show something.
#[test]
fn examples() {
    let workshop = Workshop::with(LIBRARIES);
    let build = |name: &str| workshop.build("cc", "c99", &source(&format!("../../examples/c/{name}.c")));
    let varied = |name: &str| {
        let picture = std::fs::read(workshop.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let pixels = &picture[picture.len() - 3 * 48 * 32..];
        let colors: std::collections::BTreeSet<&[u8]> = pixels.chunks_exact(3).collect();
        assert!(colors.len() > 100, "{name} shows {} colours", colors.len());
    };
    for program in ["islands", "arena"] {
        let frame = workshop.path(program).display().to_string() + "-";
        workshop.run(&build(program), &[&frame, "2", "48", "32"]);
        varied(&format!("{program}-000.ppm"));
        varied(&format!("{program}-001.ppm"));
    }
    let scene = workshop.path("scene.obj");
    let obj = "mtllib scene.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0.5\nv 0 0 1\ng a\nusemtl red\nf 1 2 3 4\n\
               g b\nusemtl blue\nf 1//1 2//1 5//1\nf -4/1 3 5\nf 9 9 9\nvn 0 0 1\ng empty\n";
    std::fs::write(&scene, obj).expect("a scene");
    std::fs::write(workshop.path("scene.mtl"), "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\nd 0.5\n")
        .expect("materials");
    let picture = workshop.path("objview.ppm").display().to_string();
    let message =
        workshop.run(&build("objview"), &[&scene.display().to_string(), &picture, "--size", "48", "32"]);
    assert_eq!(message, "2 nodes, 4 triangles, 3 materials, seen from a corner\n", "what it read");
    varied("objview.ppm");
}

#[test]
fn dialects() {
    let workshop = Workshop::with(LIBRARIES);
    for (compiler, standards) in
        [("cc", &["c89", "c99", "c11", "c17"][..]), ("c++", &["c++11", "c++14", "c++17", "c++20"][..])]
    {
        let program = if compiler == "cc" { "tests/c/dialect.c" } else { "tests/c/dialect.cpp" };
        for standard in standards {
            let binary = workshop.build(compiler, standard, &source(program));
            workshop.run(&binary, &[]);
        }
    }
}

#[test]
fn exports_are_the_header() {
    let header = std::fs::read_to_string(source("include/openrt/rtut.h")).expect("the header");
    let name = |rest: &str| rest.split('(').next().expect("a name before the parenthesis").to_owned();
    let mut declared: Vec<String> = header.split("RTAPIENTRY ").skip(1).map(name).collect();
    let symbols = Command::new("nm").args(["-D", "--defined-only"]).arg(built("librtut.so")).output();
    let symbols = String::from_utf8(symbols.expect("nm of binutils must be there").stdout).expect("names");
    let token = |line: &str| line.split_whitespace().nth(2).map(str::to_owned);
    let mut exported: Vec<String> = symbols.lines().filter_map(token).collect();
    declared.sort();
    exported.sort();
    assert_eq!(declared, exported, "exactly the functions of the header");
    let dynamic = Command::new("readelf").arg("-d").arg(built("librtut.so")).output().expect("readelf");
    assert!(String::from_utf8_lossy(&dynamic.stdout).contains("librtut.so.0"), "the soname");
}
