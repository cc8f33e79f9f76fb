// SPDX-License-Identifier: GPL-3.0-or-later
//! Tells the compiler that fuzzers set `cfg(fuzzing)`.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(fuzzing)");
    println!("cargo:rerun-if-changed=build.rs");
}
