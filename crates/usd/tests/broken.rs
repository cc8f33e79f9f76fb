// SPDX-License-Identifier: GPL-3.0-or-later
//! Broken files: an error that names the file, or a warning that names the prim; never a panic, never much memory.

use gnurt_scene::io::LoadOptions;

use crate::support::{FORMATS, Folder, load, warnings};

fn fault(name: &str, bytes: &[u8]) -> Option<String> {
    let folder = Folder::with(&[]);
    std::fs::write(folder.path(name), bytes).expect("a file");
    let error = folder.load(name, &LoadOptions::default()).err()?.to_string();
    assert!(error.contains(name) && !error.contains('\n'), "one line that names the file: {error}");
    Some(error)
}

#[test]
fn texts_that_are_none() {
    let deep = format!("#usda 1.0\n{}", "def \"A\" {".repeat(5000));
    let cases: [(&str, &[u8]); 9] = [
        ("empty.usda", b""),
        ("binary.usda", b"\0\0\0\0\0"),
        ("latin.usda", b"#usda 1.0\ndef \"\xe4\" {}\n"),
        ("open.usda", b"#usda 1.0\ndef Mesh \"A\" {\n"),
        ("quote.usda", b"#usda 1.0\ndef Mesh \"A {\n"),
        ("number.usda", b"#usda 1.0\ndef Mesh \"A\" { float x = abc }\n"),
        ("word.usda", b"#usda 1.0\nnonsense\n"),
        ("deep.usda", deep.as_bytes()),
        ("rate.usda", b"#usda 1.0\n(\n    framesPerSecond = 0\n)\n"),
    ];
    for (name, bytes) in cases {
        assert!(fault(name, bytes).is_some(), "{name} was read");
    }
}

#[test]
fn meshes_that_contradict_themselves() {
    let mesh = |name: &str, values: &str| {
        format!(
            "def Mesh \"{name}\" {{ uniform token subdivisionScheme = \"none\"\n point3f[] points = [(0,0,0), (1,0,0), (0,1,0)]\n {values} }}\n"
        )
    };
    let loaded = load(
        &[
            mesh("Good", "int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]"),
            mesh("Few", "int[] faceVertexCounts = [2]\n int[] faceVertexIndices = [0, 1]"),
            mesh("Negative", "int[] faceVertexCounts = [-3]\n int[] faceVertexIndices = [0, 1, 2]"),
            mesh("Long", "int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2, 0]"),
            mesh("Far", "int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 9]"),
            mesh(
                "Huge",
                "int[] faceVertexCounts = [2147483647, 2147483647]\n int[] faceVertexIndices = [0, 1, 2]",
            ),
        ]
        .concat(),
    );
    assert_eq!(loaded.scene.instances().len(), 1, "the good one is shown");
    let reported = warnings(&loaded);
    for name in ["/Few", "/Negative", "/Long", "/Far: face 0 names point 9", "/Huge"] {
        assert!(reported.contains(name), "{name}: {reported}");
    }
}

/// Bytes of a binary layer with most kinds of values.
fn binary() -> Vec<u8> {
    let scene = gnurt_scene::builtin::load("cornell").expect("a built-in scene");
    let folder = Folder::with(&[]);
    FORMATS.save(&scene, folder.path("a.usdc")).expect("a binary layer");
    std::fs::read(folder.path("a.usdc")).expect("the file")
}

/// Files of the library's writer, and of OpenUSD with long arrays.
#[test]
fn binaries_that_are_cut_or_changed() {
    let with_arrays = include_bytes!("data/shared-arrays.usdc").to_vec();
    for good in [binary(), with_arrays] {
        assert_eq!(fault("good.usdc", &good), None, "it is good as it is");
        for cut in [8, 16, 24, 80, good.len() / 2, good.len() - 1] {
            assert!(fault("cut.usdc", &good[..cut]).is_some(), "{cut} of {} bytes", good.len());
        }
        // A deterministic walk over bytes: whatever becomes of the file, it ends, and takes no more memory than it may.
        let mut state = 12345_u64;
        for _ in 0..300 {
            let mut bad = good.clone();
            for _ in 0..3 {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                let at = (state >> 33) as usize % bad.len();
                bad[at] = (state >> 20) as u8;
            }
            fault("bad.usdc", &bad);
        }
    }
}

#[test]
fn references_that_never_end() {
    let text = "#usda 1.0\ndef \"A\" ( prepend references = </A/B> ) { def \"B\" ( prepend references = </A> ) {} }\n";
    let folder = Folder::with(&[("a.usda", text)]);
    // An error or a warning: it ends.
    let _ = folder.load("a.usda", &LoadOptions::default());
}

#[test]
fn references_that_double() {
    // Each name shows the next one twice: more than 2^15 prims, twice the limit.
    let mut doubling = String::from("#usda 1.0\n");
    for level in 0..14 {
        let next = level + 1;
        doubling += &format!(
            "def \"L{level}\" {{ def \"a\" ( prepend references = </L{next}> ) {{}}\n def \"b\" ( prepend references = </L{next}> ) {{}} }}\n"
        );
    }
    doubling += "def Cube \"L14\" {}\n";
    let folder = Folder::with(&[("b.usda", &doubling)]);
    let error = folder.load("b.usda", &LoadOptions::default()).expect_err("too many").to_string();
    assert!(error.contains("prims are composed"), "{error}");
}
