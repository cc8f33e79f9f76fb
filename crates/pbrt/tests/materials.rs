// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials: which are the renderer's own, which are shaders; named ones and mixes.

use gnurt_scene::{Material, ShaderFile, Surface};

use crate::common::world;

fn made(text: &str) -> (Material, Option<ShaderFile>) {
    let loaded = world(&format!("{text}\nShape \"sphere\""));
    let id = loaded.scene.meshes()[0].material;
    let shader = loaded.scene.shader_files().find(|(of, _)| *of == id).map(|(_, file)| file.clone());
    (loaded.scene.material(id).clone(), shader)
}

#[test]
fn plain_materials_need_no_shader() {
    let (diffuse, shader) = made("Material \"diffuse\" \"rgb reflectance\" [ .1 .2 .3 ]");
    assert_eq!((diffuse.surface.base_color().factor, shader), ([0.1, 0.2, 0.3], None));
    let (gold, _) = made(
        "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" \"float roughness\" 0.0004",
    );
    let Surface::Metal { roughness, .. } = gold.surface else { panic!("{gold:?}") };
    // Alpha is the root, and the square of ours.
    assert!((roughness - 0.1414).abs() < 1e-3, "{roughness}");
    let (glass, _) = made("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"");
    let Surface::Dielectric { ior, interior, .. } = glass.surface else { panic!("{glass:?}") };
    assert!((ior - 1.5168).abs() < 1e-4 && (20.0 / interior.dispersion - 64.17).abs() < 0.1);
}

#[test]
fn others_are_shaders() {
    for (text, part) in [
        ("Material \"coateddiffuse\"", "layer"),
        ("Material \"coatedconductor\"", "conductor_bsdf"),
        ("Material \"diffusetransmission\"", "translucent"),
        ("Material \"dielectric\" \"float uroughness\" .1 \"float vroughness\" .3", "dielectric_bsdf"),
        (
            "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"b\" ]\n\
          MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\nMakeNamedMaterial \"b\" \"string type\" \"conductor\"\n\
          NamedMaterial \"m\"",
            "conductor_bsdf",
        ),
    ] {
        let (_, shader) = made(text);
        let shader = shader.unwrap_or_else(|| panic!("{text}"));
        assert!(shader.text.as_ref().is_some_and(|code| code.contains(part)), "{text}: {shader:?}");
    }
}

#[test]
fn mixes_of_mixes_end() {
    let mut text = String::from("MakeNamedMaterial \"m0\" \"string type\" \"diffuse\"\n");
    for i in 1..60 {
        let below = i - 1;
        text += &format!(
            "MakeNamedMaterial \"m{i}\" \"string type\" \"mix\" \"string materials\" [ \"m{below}\" \"m{below}\" ]\n"
        );
    }
    text += "MakeNamedMaterial \"loop\" \"string type\" \"mix\" \"string materials\" [ \"loop\" \"loop\" ]\n";
    for name in ["m59", "loop"] {
        let (_, shader) = made(&format!("{text}NamedMaterial \"{name}\""));
        let length = shader.and_then(|shader| shader.text).map_or(0, |text| text.len());
        assert!((1000..100_000).contains(&length), "{length}");
    }
}

#[test]
fn interfaces_are_not_seen() {
    let loaded = world("Shape \"disk\"\nMaterial \"interface\"\nShape \"sphere\"");
    assert_eq!(loaded.scene.meshes().len(), 1);
}
