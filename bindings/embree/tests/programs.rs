// SPDX-License-Identifier: GPL-3.0-or-later
//! C and C++ programs on the library of Embree's calls; each checks itself and ends with status 0. Also the exported symbols of
//! the library.

#[path = "../../rays/tests/workshop/mod.rs"]
mod workshop;

use std::path::Path;
use std::process::Command;

use workshop::{Workshop, declared, exported, library, shown};

const LIBRARY: &str = "libgnurt_embree.so";

fn workshop() -> Workshop {
    Workshop::new(&[("libembree4.so", LIBRARY), ("libembree4.so.4", LIBRARY)], &["-lembree4"])
}

/// The program's expectations are Embree's results.
fn run_on_embree(binary: &Path) {
    match std::env::var_os("EMBREE4_LIB") {
        Some(embree) => {
            let folder = Path::new(&embree).parent().unwrap_or(Path::new("/"));
            let output = Command::new(binary)
                .arg("queries")
                .env("LD_PRELOAD", &embree)
                .env("LD_LIBRARY_PATH", folder)
                .output();
            let output = output.expect("it runs");
            assert!(output.status.success(), "on Embree's library: {}", shown(&output));
        }
        None => eprintln!("SKIPPED: the same on Embree's library; EMBREE4_LIB names none"),
    }
}

/// Runs a program in C on our library and on Embree's.
fn run_c(name: &str) {
    let workshop = workshop();
    let binary = workshop.build("cc", "c11", &format!("embree/tests/c/{name}"));
    workshop.run(&binary, &[]);
    run_on_embree(&binary);
}

#[test]
fn calls_of_embree() {
    run_c("embree.c");
}

#[test]
fn motion() {
    run_c("motion.c");
}

#[test]
fn collisions() {
    run_c("collide.c");
}

#[test]
fn subdivision_surfaces() {
    run_c("subdivision.c");
}

#[test]
fn grids() {
    run_c("grids.c");
}

#[test]
fn cones() {
    run_c("cones.c");
}

#[test]
fn hierarchies_of_programs() {
    run_c("build.c");
}

#[test]
fn commits() {
    let workshop = workshop();
    let binary = workshop.build("cc", "c11", "embree/tests/c/joined.c");
    workshop.run(&binary, &[]);
    // A standard error that cannot be written ends no program.
    let full = std::fs::File::options().write(true).open("/dev/full").expect("a device that is full");
    let mut command = Command::new(&binary);
    let folder = workshop.folder.path();
    let status = command.arg("verbose").env("LD_LIBRARY_PATH", folder).stderr(full).status();
    let status = status.expect("it runs");
    assert!(status.success(), "a mistake without a reader: {status}");
}

#[test]
fn callbacks_get_whole_packets() {
    let workshop = workshop();
    workshop.run(&workshop.build("cc", "c11", "embree/tests/c/frames.c"), &[]);
}

#[test]
fn arrays_of_a_scene_that_is_shown() {
    let workshop = workshop();
    workshop.run(&workshop.build("cc", "c11", "embree/tests/c/stale.c"), &[]);
}

/// In a program that uses both libraries.
#[test]
fn exceptions() {
    const OURS: &str = "libgnurt_rays.so";
    let links = [
        ("libembree4.so", LIBRARY),
        ("libembree4.so.4", LIBRARY),
        ("libgnurt.so", OURS),
        ("libgnurt.so.0", OURS),
    ];
    let workshop = Workshop::new(&links, &["-lembree4", "-lgnurt"]);
    workshop.run(&workshop.build("c++", "c++17", "embree/tests/c/throws.cpp"), &[]);
}

#[test]
fn exports_are_the_headers() {
    // Written out in the header.
    let is_inline = |name: &str| {
        let all = ["rtcInitIntersectArguments", "rtcInitOccludedArguments", "rtcInitPointQueryContext"];
        all.contains(&name) || name.starts_with("rtcInitR") || name == "rtcDefaultBuildArguments"
    };
    let exported = exported(&library(LIBRARY), "libembree4.so.4");
    let embree = declared("embree/include/gnurt/embree.h", "rtc");
    let missing: Vec<_> =
        embree.iter().filter(|name| !is_inline(name) && !exported.contains(*name)).collect();
    assert!(embree.len() > 80, "the header was read: {} functions", embree.len());
    assert!(missing.is_empty(), "declared but not exported: {missing:?}");
    let extra: Vec<_> = exported.iter().filter(|name| !name.starts_with("rtc")).collect();
    assert!(extra.is_empty(), "exported beside Embree's calls: {extra:?}");
}
