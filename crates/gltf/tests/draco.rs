// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF compressed by Draco against the same values without compression, which Google's decoder wrote:
//! `data/draco.py`. Every value is equal, bit for bit, in the same order.

use crate::common::{glb, load_named};
use gnurt_scene::Scene;
use gnurt_scene::io::Loaded;

const SEQUENTIAL: [&[u8]; 2] =
    [include_bytes!("data/draco-sequential.glb"), include_bytes!("data/draco-sequential-plain.glb")];
const STANDARD: [&[u8]; 2] =
    [include_bytes!("data/draco-standard.glb"), include_bytes!("data/draco-standard-plain.glb")];
const VALENCE: [&[u8]; 2] =
    [include_bytes!("data/draco-valence.glb"), include_bytes!("data/draco-valence-plain.glb")];
const FALLBACK: &[u8] = include_bytes!("data/draco-fallback.glb");

/// All warnings.
fn messages(loaded: &Loaded) -> String {
    loaded.warnings.iter().map(ToString::to_string).collect()
}

fn scene(bytes: &[u8]) -> Scene {
    let loaded = load_named("t.glb", bytes).expect("a scene");
    assert_eq!(messages(&loaded), "");
    loaded.scene
}

/// The triangles of the first mesh.
fn triangles(scene: &Scene) -> usize {
    scene.meshes()[0].indices.len()
}

/// `from` with a part of its JSON replaced by one of the same length.
fn edited(from: &[u8], old: &str, new: &str) -> Vec<u8> {
    let at = from.windows(old.len()).position(|part| part == old.as_bytes()).expect("the part");
    let length = u32::from_le_bytes([from[12], from[13], from[14], from[15]]) as usize;
    let json = String::from_utf8(from[20..20 + length].to_vec()).expect("text");
    match at < 20 + length {
        true => glb(json.replacen(old, new, 1).as_bytes(), &from[28 + length..]),
        false => [&from[..at], new.as_bytes(), &from[at + old.len()..]].concat(),
    }
}

#[test]
fn streams_hold_what_the_uncompressed_twin_holds() {
    for (name, [packed, plain], count) in
        [("sequential", SEQUENTIAL, 51), ("standard", STANDARD, 88), ("valence", VALENCE, 1054)]
    {
        let (packed, plain) = (scene(packed), scene(plain));
        assert_eq!(triangles(&packed), count, "{name}");
        let (a, b) = (&packed.meshes()[0], &plain.meshes()[0]);
        assert_eq!(a.indices, b.indices, "{name}");
        assert_eq!(a.positions, b.positions, "{name}");
        assert_eq!(a.normals, b.normals, "{name}");
        assert_eq!(a.texcoords, b.texcoords, "{name}");
        assert_eq!(a.colors, b.colors, "{name}");
        assert!(!a.texcoords.is_empty(), "{name}: there is something to compare");
    }
    assert!(!scene(SEQUENTIAL[0]).meshes()[0].colors.is_empty(), "colours");
    assert!(!scene(VALENCE[0]).meshes()[0].normals.is_empty(), "normals");
}

#[test]
fn joints_weights_and_morphs_move_compressed_vertices() {
    let still = edited(STANDARD[0], r#""translation":[1,2,3]"#, r#""translation":[0,0,0]"#);
    let (moved, still) = (scene(STANDARD[0]), scene(&still));
    assert_ne!(moved.meshes()[0].positions, still.meshes()[0].positions, "joints count");
    let flat = edited(STANDARD[0], r#""weights":[0.5]"#, r#""weights":[0.0]"#);
    assert_ne!(moved.meshes()[0].positions, scene(&flat).meshes()[0].positions, "morph weights count");
}

#[test]
fn a_stream_wins_over_its_uncompressed_form() {
    assert_eq!(triangles(&scene(FALLBACK)), 40);
}

#[test]
fn the_uncompressed_form_is_read_where_the_stream_is_broken() {
    let broken = edited(FALLBACK, "DRACO", "DRACC");
    let loaded = load_named("t.glb", &broken).expect("a scene");
    assert_eq!(triangles(&loaded.scene), 1);
    let told = messages(&loaded);
    assert!(told.contains("meshes[0].primitives[0]: KHR_draco_mesh_compression: "), "{told}");
    assert!(told.contains("its uncompressed form is read"), "{told}");
}

#[test]
fn errors_name_file_mesh_and_primitive() {
    let required = r#""extensionsRequired":["KHR_draco_mesh_compression"]"#;
    let fallback_required = edited(FALLBACK, r#""extensionsRequired":[]"#, required);
    for (bytes, text) in [
        (edited(VALENCE[0], "DRACO", "DRACC"), "KHR_draco_mesh_compression: "),
        (edited(&fallback_required, "DRACO", "DRACC"), "KHR_draco_mesh_compression: "),
        (
            edited(VALENCE[0], r#""attributes":{"POSITION":0,"#, r#""attributes":{"POSITION":7,"#),
            "accessor 7",
        ),
        (edited(VALENCE[0], r#"[{"attributes""#, r#"[{"mode":6,"attributes""#), "mode 6; expected 4 or 5"),
        (edited(VALENCE[0], r#""bufferView":0"#, r#""bufferView":9"#), "bufferView 9 does not exist"),
        (
            edited(SEQUENTIAL[0], r#""POSITION":3}}}}"#, r#""POSITION":9}}}}"#),
            "POSITION: there is no attribute with the unique id 9",
        ),
    ] {
        let error = load_named("t.glb", &bytes).err().unwrap_or_else(|| panic!("{text}: it was read"));
        let line = error.to_string();
        assert!(line.contains("t.glb") && line.contains(text), "`{line}` should hold `{text}`");
        assert!(line.contains("meshes[0].primitives[0]"), "{line}");
        assert!(!line.contains(['\n', '{']), "one line of plain words: {line}");
    }
}

#[test]
fn strips_are_triangles_already() {
    let strip = edited(VALENCE[0], r#"[{"attributes""#, r#"[{"mode":5,"attributes""#);
    assert_eq!(triangles(&scene(&strip)), 1054);
}
