// SPDX-License-Identifier: GPL-3.0-or-later
//! Allowed places of `unsafe`: behind the SIMD crate's safe functions, in the C APIs, in the benchmark's
//! calls of Embree and the denoiser's of OIDN. Also in plugins and their host, in memory and calls of machine
//! code, and in the heap with arrays in a file.

use super::files::SourceFile;

/// No `unsafe` outside of crates/simd and ffi*.rs of bindings, the benchmark, the denoiser, the library, the shading language's machine code, plugins
/// and the example of one.
pub(super) fn check(file: &SourceFile) -> Vec<(usize, String)> {
    if may_hold(&file.path) {
        return vec![];
    }
    let found = file.identifiers().filter(|(_, token)| *token == "unsafe");
    found
        .map(|(line, _)| {
            (
                line,
                "unsafe code outside of crates/simd and ffi*.rs of bindings, bench, denoise, gnurt, jit and plugins"
                    .into(),
            )
        })
        .collect()
}

fn may_hold(path: &str) -> bool {
    let parts: Vec<&str> = path.split('/').collect();
    match parts[..] {
        ["crates", "simd", ..] => true,
        ["bindings", _, "src", file]
        | ["crates", "bench" | "denoise" | "gnurt" | "jit" | "plugins", "src", file]
        | ["examples", "plugins", "rust", "src", file] => file.starts_with("ffi"),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unsafe_code_is_found_outside_its_rooms() {
        let count = |path: &str, text: &str| check(&SourceFile::new(path, text)).len();
        let text = "fn a() { unsafe { b() } }\n";
        assert_eq!(count("crates/accel/src/a.rs", text), 1, "accel has none");
        assert_eq!(count("crates/accel/src/ffi.rs", text), 1, "whatever its files are called");
        assert_eq!(count("crates/bench/src/rays.rs", text), 1, "nor has the benchmark itself");
        assert_eq!(count("bindings/openrt/src/frame.rs", text), 1, "nor has a noun of the binding");
        let rooms = [
            "crates/simd/src/a.rs",
            "bindings/openrt/src/ffi_frame.rs",
            "crates/bench/src/ffi_embree.rs",
            "crates/denoise/src/ffi_oidn.rs",
            "crates/jit/src/ffi_call.rs",
            "crates/plugins/src/ffi_host.rs",
        ];
        for path in rooms {
            assert_eq!(count(path, text), 0, "{path} may hold it");
        }
        assert_eq!(
            count("crates/accel/src/a.rs", "#![forbid(unsafe_code)] // unsafe\n"),
            0,
            "talk is not code"
        );
    }
}
