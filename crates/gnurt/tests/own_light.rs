// SPDX-License-Identifier: GPL-3.0-or-later
//! Every benchmark scene that has a light of its own keeps it alone. Its materials are read from its own MTL
//! file and shown by a triangle each: the decision depends on the emission of materials. Skipped, loudly,
//! where ../shared/scenes are absent.

use std::path::Path;

use gnurt::defaults::{OwnLight, Purpose, complete_lights, framing, own_light};
use gnurt::render::ShaderTable;

/// The scenes, and whether a material of theirs emits.
const SCENES: [(&str, bool); 12] = [
    ("breakfast-room", false),
    ("classroom", true),
    ("conference", true),
    ("cornell-box", true),
    ("graz", true),
    ("modern-hall", true),
    ("office", true),
    ("soda", true),
    ("sponza", false),
    ("veach-ajar", true),
    ("veach-bidir", true),
    ("white-room", true),
];

#[test]
fn scenes_keep_their_own_light_alone() {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes");
    if !shared.is_dir() {
        eprintln!("SKIPPED: the benchmark scenes (../shared/scenes) are not here");
        return;
    }
    let shaders = ShaderTable::default();
    for (name, is_lit) in SCENES {
        let folder = tempfile::tempdir().expect("a folder");
        let materials =
            std::fs::read_to_string(shared.join(format!("{name}/{name}.mtl"))).expect("its materials");
        // Its textures are not here; none of them emits.
        let plain: Vec<&str> = materials.lines().filter(|line| !line.trim().starts_with("map_")).collect();
        assert!(!materials.contains("map_Ke"), "{name} has an emissive texture; give the test its file");
        std::fs::write(folder.path().join("m.mtl"), plain.join("\n")).expect("written");
        let mut text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
        for material in materials.lines().filter_map(|line| line.trim().strip_prefix("newmtl ")) {
            text += &format!("usemtl {material}\nf 1 2 3\n");
        }
        let file = folder.path().join("a.obj");
        std::fs::write(&file, text).expect("written");
        let scene = gnurt::load_scene(&file).expect("a scene").scene;
        let expected = if is_lit { OwnLight::Lights } else { OwnLight::Nothing };
        assert_eq!(own_light(&scene, &shaders), expected, "{name}");
        let camera = framing(gnurt::defaults::bounds_of(&scene), 1.0);
        for purpose in [Purpose::Screen, Purpose::Numbers] {
            let mut lit = scene.clone();
            let note = complete_lights(&mut lit, &shaders, &camera, [0.0, 1.0, 0.0], purpose);
            assert_eq!(note.is_none(), is_lit, "{name}: {note:?}");
            assert_eq!(lit.lights().is_empty(), is_lit, "{name}: {:?}", lit.lights());
        }
    }
}
