// SPDX-License-Identifier: GPL-3.0-or-later
//! Each program of tests/c is built by the C compiler against the library and run; it checks itself and ends with
//! status 0.

mod common;

use common::{Workshop, source};

macro_rules! programs {
    ($($name:ident)*) => {$(
        #[test]
        fn $name() {
            let workshop = Workshop::new();
            let program = source(concat!("tests/c/", stringify!($name), ".c"));
            let binary = workshop.build("cc", "c99", &program);
            workshop.run(&binary, &[]);
        }
    )*};
}

programs! {
    attributes
    closed_forms
    debug
    debug_threads
    errors
    fragment_model
    fragments
    frames
    many_vertices
    materials
    memory
    mipmaps
    pixels
    primitives
    scene
    threads
}

/// A value above a limit is reported with the limits of the renderer's library.
#[test]
fn limits() {
    let workshop = Workshop::new();
    let binary = workshop.build("cc", "c99", &source("tests/c/limits.c"));
    let output = std::process::Command::new(&binary).output().expect("it runs");
    let reported = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{}\n{}{reported}",
        output.status,
        String::from_utf8_lossy(&output.stdout)
    );
    let expected = "the picture takes 128.0 GiB of memory and ";
    assert!(
        reported.contains(expected) && reported.contains("use a smaller one than 65536x32768"),
        "{reported}"
    );
}

/// Figure 1 of the paper draws: a picture of n triangles, the colours of its parameters in it.
#[test]
fn figure1() {
    let workshop = Workshop::new();
    let binary = workshop.build("cc", "c99", &source("tests/c/figure1.c"));
    let ppm = workshop.path("figure1.ppm");
    for tri_nb in ["0", "1", "2", "7", "100"] {
        workshop.run(&binary, &[tri_nb, &ppm.to_string_lossy()]);
        let picture = std::fs::read(&ppm).expect("the program writes its picture");
        let pixels = picture.len().checked_sub(160 * 120 * 3).map(|head| &picture[head..]);
        let lit =
            pixels.expect("all pixels").chunks_exact(3).filter(|rgb| rgb.iter().any(|&c| c > 0)).count();
        assert_eq!(lit > 0, tri_nb != "0", "{tri_nb} triangles show {lit} pixels");
    }
}

/// OPENRT_DEBUG prints each error with the call and its arguments; without it nothing is printed.
#[test]
fn errors_are_printed_on_request() {
    let workshop = Workshop::new();
    let binary = workshop.build("cc", "c99", &source("tests/c/debug.c"));
    let printed = |value: &str| {
        let output =
            std::process::Command::new(&binary).env("OPENRT_DEBUG", value).output().expect("it runs");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let text = printed("1");
    let expected = "libOpenRT: rtBegin(0x17): RT_INVALID_ENUM: a constant is invalid for this call";
    assert!(text.lines().any(|line| line == expected), "the first error, among\n{text}");
    assert!(text.lines().count() > 8, "each of them:\n{text}");
    assert_eq!(printed("0"), "", "silent");
    assert_eq!(printed(""), "", "silent");
}

/// Rendering goes on while the program edits. The times are printed; on a machine with other work they say little, so
/// that only the program itself, run alone, checks them.
#[test]
fn overlap() {
    let workshop = Workshop::new();
    let binary = workshop.build("cc", "c99", &source("tests/c/overlap.c"));
    let printed = workshop.run(&binary, &["--rt-threads=1", "1"]);
    assert!(printed.contains("of the longer one"), "times: {printed}");
}

/// C++ sees both forms of rtNewObject as overloads.
#[test]
fn overload() {
    let workshop = Workshop::new();
    for standard in ["c++11", "c++14", "c++17", "c++20"] {
        let binary = workshop.build("c++", standard, &source("tests/c/overload.cpp"));
        workshop.run(&binary, &[]);
    }
}

/// The headers compile in every dialect of C, with the one-argument form of rtNewObject from C99 on.
#[test]
fn dialects() {
    let workshop = Workshop::new();
    for (standard, program) in
        [("c89", "dialect_c89.c"), ("c99", "dialect.c"), ("c11", "dialect.c"), ("c17", "dialect.c")]
    {
        let binary = workshop.build("cc", standard, &source("tests/c").join(program));
        workshop.run(&binary, &[]);
    }
}

/// The programs of examples/c build and write pictures.
#[test]
fn examples() {
    let workshop = Workshop::new();
    for example in ["figure1", "turntable"] {
        let binary =
            workshop.build("cc", "c99", &source("../../examples/c").join(example).with_extension("c"));
        let output = workshop.path(&format!("{example}.out"));
        workshop.run(&binary, &[&output.to_string_lossy(), "1"]);
    }
}

/// Shaders in the shading language, as classes.
#[test]
fn script() {
    let workshop = Workshop::new();
    let binary = workshop.build("cc", "c99", &source("tests/c/script.c"));
    let write = |name: &str, text: &str| {
        let path = workshop.path(name);
        std::fs::write(&path, text).expect("a file");
        path.to_string_lossy().into_owned()
    };
    let emission = write(
        "glow.osl",
        "surface glow (color tint = 1, int steps = 1, string word = \"a\", float heat = 0 [[ int interpolated = 1, string rate = \"vertex\" ]]) {
            Ci = (tint * steps + (word == \"b\") + heat) * emission (); }",
    );
    let light = write(
        "lamp.osl",
        "light lamp (color power = 1) { vector way = point (0, 0, 2) - Ps; lightdist = length (way); L = normalize (way); Cl = power; }",
    );
    let lit =
        write("lit.osl", "surface lit () { color c = 0; illuminance (P) c += Cl; Ci = c * radiance (); }");
    let bad = write("bad.osl", "surface bad ()\n{\n    Ci = diffus (N);\n}\n");
    let twice = write(
        "twice.osl",
        "pixel twice (float gain = 1, output color Cpixel = 0) { Cpixel = gain * (color) trace (P, I); }",
    );
    workshop.run(&binary, &[&emission, &light, &lit, &bad, &twice]);
}
