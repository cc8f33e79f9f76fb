// SPDX-License-Identifier: GPL-3.0-or-later
//! C and C++ programs on libgnurt; each checks itself and ends with status 0. Also the exported symbols of the library.

mod workshop;

use std::collections::BTreeSet;

use workshop::{Workshop, declared, exported, library};

const LIBRARY: &str = "libgnurt_rays.so";

fn workshop() -> Workshop {
    Workshop::new(&[("libgnurt.so", LIBRARY), ("libgnurt.so.0", LIBRARY)], &["-lgnurt"])
}

#[test]
fn calls_of_our_own() {
    let workshop = workshop();
    workshop.run(&workshop.build("cc", "c11", "rays/tests/c/rays.c"), &[]);
}

#[test]
fn arrays_threads_and_processes() {
    let workshop = workshop();
    workshop.run(&workshop.build("cc", "c11", "rays/tests/c/edits.c"), &[]);
}

#[test]
fn double_precision() {
    let workshop = workshop();
    workshop.run(&workshop.build("cc", "c11", "rays/tests/c/doubles.c"), &[]);
}

/// Examples run, and print their expected output.
#[test]
fn examples() {
    let workshop = workshop();
    let picture = workshop.run(&workshop.build("cc", "c11", "../examples/rays/shade.c"), &[]);
    let lit = picture.chars().filter(|letter| "-+*%#@".contains(*letter)).count();
    let dark = picture.chars().filter(|&letter| letter == '.').count();
    assert!(
        lit > 100 && dark > 20,
        "a torus, {lit} letters in the light and {dark} in the shadow:\n{picture}"
    );
    let walls = workshop.run(&workshop.build("c++", "c++17", "../examples/rays/hollow.cpp"), &[]);
    // Up the ball within begins 1 from its middle, and the outer one ends at 2: 1.75 - 1; down 2.25 - 1.
    assert!(walls.contains("  0 degrees: 0.750\n") && walls.contains("180 degrees: 1.250\n"), "{walls}");
}

#[test]
fn exports_are_the_headers() {
    let exported = exported(&library(LIBRARY), "libgnurt.so.0");
    let declared = declared("rays/include/gnurt/rays.h", "gnurt_");
    let all: BTreeSet<String> = exported.into_iter().collect();
    assert_eq!(declared, all, "what gnurt/rays.h declares is what there is, and no call of Embree");
}
