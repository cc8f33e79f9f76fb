// SPDX-License-Identifier: GPL-3.0-or-later
//! Gives the shared library the name that programs load Embree by: libembree4.so.4.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libembree4.so.4");
    }
}
