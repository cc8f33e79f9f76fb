// SPDX-License-Identifier: GPL-3.0-or-later
//! The benchmark scenes (../shared/scenes) load with the counts of their README. Skipped, loudly, where they are absent.

use crate::common::unpacked;

/// File, triangles, vertices in the file, materials in its library (a PLY has one of its own).
const SCENES: &[(&str, usize, usize, usize)] = &[
    ("conference/conference.obj", 197_486, 120_683, 42),
    ("office/office.obj", 22_428, 10_870, 28),
    ("soda/soda.obj", 117_676, 69_901, 26),
    ("graz/graz.obj", 26_928, 16_949, 63),
    ("classroom/classroom.obj", 9_253, 6_786, 26),
    ("buddha-100k/buddha-100k.ply", 100_000, 49_950, 1),
    ("armadillo/armadillo.ply", 86_482, 43_243, 1),
    ("sponza/sponza.obj", 69_063, 36_160, 20),
    ("veach-ajar/veach-ajar.obj", 23_441, 12_007, 13),
    ("white-room/white-room.obj", 371_370, 188_244, 65),
    ("breakfast-room/breakfast-room.obj", 269_538, 135_752, 15),
    ("cornell-box/cornell-box.obj", 36, 36, 8),
    ("veach-bidir/veach-bidir.obj", 11_544, 6_236, 6),
    ("modern-hall/modern-hall.obj", 28_655, 14_955, 21),
    ("bunny/bunny.ply", 69_451, 35_947, 1),
    ("hand/hand.ply", 15_855, 7_929, 1),
    ("dragon/dragon.ply", 871_414, 437_645, 1),
];

#[test]
fn counts_are_those_of_the_readme() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let names: Vec<&str> = SCENES.iter().filter_map(|(file, ..)| file.split('/').next()).collect();
    let Some(root) = unpacked(folder.path(), &names) else {
        return;
    };
    for &(file, triangles, vertices, materials) in SCENES {
        let loaded = crate::common::load(root.join(file)).unwrap_or_else(|e| panic!("{e}"));
        let scene = &loaded.scene;
        let count: usize = scene.meshes().iter().map(|m| m.indices.len()).sum();
        let dropped = loaded.warnings.count(gnurt_scene::io::Oddity::ZeroAreaTriangle) as usize;
        assert_eq!(count + dropped, triangles, "{file}: triangles");
        let count: usize = scene.meshes().iter().map(|m| m.positions.len()).sum();
        // A vertex with several normals or materials is several here.
        assert!(
            count * 10 >= vertices * 9 && count <= vertices * 2,
            "{file}: {count} vertices of {vertices}"
        );
        assert_eq!(
            scene.materials().len(),
            materials + usize::from(file.ends_with(".obj")),
            "{file}: materials"
        );
        scene.check().unwrap_or_else(|e| panic!("{file}: {e}"));
    }
}

#[test]
fn animated_ones_load_in_their_rest_pose() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Some(root) = unpacked(folder.path(), &["animated"]) else {
        return;
    };
    let files = [
        ("CesiumMan.glb", 4_672),
        ("Fox.glb", 576),
        ("MorphStressTest.gltf", 2_412),
        ("Stag.gltf", 3_670),
        ("Rabbit.gltf", 8_284),
        ("Alien_Scolitex.gltf", 11_036),
    ];
    for (file, triangles) in files {
        let path = root.join("animated").join(file);
        let loaded = crate::common::load(path).unwrap_or_else(|e| panic!("{e}"));
        let count: usize = loaded.scene.meshes().iter().map(|m| m.indices.len()).sum();
        assert_eq!(count, triangles, "{file}: triangles");
    }
}
