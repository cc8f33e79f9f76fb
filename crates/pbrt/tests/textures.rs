// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures as shaders: each kind's text, pictures by their names, depth.

use gnurt_scene::ShaderFile;

use crate::common::{read_with_files, world};

fn shader(texture: &str) -> ShaderFile {
    let loaded = world(&format!(
        "{texture}\nMaterial \"coateddiffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\""
    ));
    let (_, file) = loaded.scene.shader_files().next().expect("a shader");
    file.clone()
}

#[test]
fn each_kind_has_its_text() {
    for (class, part) in [
        ("\"bilerp\" \"rgb v00\" [ 1 0 0 ]", "mix (mix ("),
        ("\"checkerboard\" \"string mapping\" \"spherical\"", "pbrt_board"),
        ("\"checkerboard\" \"integer dimension\" 3", "pbrt_board"),
        ("\"dots\" \"string mapping\" \"planar\"", "pbrt_dot"),
        ("\"fbm\" \"integer octaves\" 4", "pbrt_fbm"),
        ("\"wrinkled\" \"integer octaves\" 3", "pbrt_turbulence"),
        ("\"windy\"", "0.1 *"),
        ("\"marble\" \"float scale\" 3", "pbrt_marble"),
        ("\"mix\" \"rgb tex1\" [ 1 0 0 ] \"float amount\" .25", "0.25"),
        ("\"directionmix\" \"vector dir\" [ 0 0 1 ]", "dot (normalize (N)"),
    ] {
        let file = shader(&format!("Texture \"t\" \"spectrum\" {class}"));
        let text = file.text.expect("a text");
        let body = text.split("surface pbrt").nth(1).unwrap_or_default().to_owned();
        assert!(body.contains(part), "{class}: {body}");
        assert!(text.is_ascii());
    }
}

#[test]
fn pictures_have_names() {
    let pixel = include_bytes!("pixel.pfm");
    let text = "WorldBegin\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"pixel.pfm\" \"bool invert\" true\n\
        Material \"diffuse\" \"texture reflectance\" \"t\"\nShape \"disk\"\n";
    let (loaded, _folder) = read_with_files(text, &[("pixel.pfm", pixel)]);
    let loaded = loaded.expect("a scene");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let (_, file) = loaded.scene.shader_files().next().expect("a shader");
    assert_eq!(file.pictures.len(), 1);
    assert!(file.text.as_ref().is_some_and(|text| text.contains(&file.pictures[0].0)));
    let (loaded, _folder) = read_with_files(text, &[]);
    let warnings: Vec<String> = loaded.expect("a scene").warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.len() == 1 && warnings[0].contains("t.pbrt:2: texture cannot be read"), "{warnings:?}");
}

#[test]
fn deep_textures_are_refused() {
    let mut text = String::from("WorldBegin\nTexture \"t0\" \"float\" \"constant\"\n");
    for i in 1..40 {
        text += &format!("Texture \"t{i}\" \"float\" \"scale\" \"texture tex\" \"t{}\"\n", i - 1);
    }
    let (loaded, _folder) = read_with_files(&text, &[]);
    let error = loaded.expect_err("too deep").to_string();
    assert!(error.contains("more than 32 deep"), "{error}");
}
