// SPDX-License-Identifier: GPL-3.0-or-later
//! Declares the `cfg(fuzzing)` of fuzzers to the compiler.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(fuzzing)");
    println!("cargo:rerun-if-changed=build.rs");
}
