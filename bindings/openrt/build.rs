// SPDX-License-Identifier: GPL-3.0-or-later
//! Gives the shared library the name that programs load it by: libOpenRT.so.0.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(gnurt_plain_lock)");
    println!("cargo::rustc-check-cfg=cfg(fuzzing)");
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libOpenRT.so.0");
    }
}
