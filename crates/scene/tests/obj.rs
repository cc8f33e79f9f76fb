// SPDX-License-Identifier: GPL-3.0-or-later
//! The meaning of OBJ and MTL files here. The table in `io::obj::material`.

use crate::common::load_named;
use gnurt_scene::material::{Alpha, Material};
use gnurt_scene::{Scene, Surface};

const V: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";

fn obj(text: &str) -> Scene {
    load_named("t.obj", text.as_bytes()).unwrap_or_else(|e| panic!("{e}")).scene
}

/// The material that a library of one material becomes.
fn material(mtl: &str) -> Material {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("t.mtl"), format!("newmtl the one\n{mtl}\n")).expect("a file");
    let path = folder.path().join("t.obj");
    std::fs::write(&path, format!("mtllib t.mtl\n{V}usemtl the one\nf 1 2 3\n")).expect("a file");
    let loaded = gnurt_scene::io::load(path).unwrap_or_else(|e| panic!("{e}"));
    assert!(loaded.warnings.is_empty(), "{mtl}: {:?}", loaded.warnings);
    loaded.scene.material(loaded.scene.meshes()[0].material).clone()
}

#[test]
fn groups_become_one_mesh_per_material() {
    let scene = obj(&format!("{V}g a\nf 1 2 3\ng b\nf 2 4 3\no c\nf 1 2 4\n"));
    assert_eq!(scene.meshes().len(), 1, "groups of one material are one mesh");
    assert_eq!(scene.meshes()[0].positions.len(), 4, "shared vertices stay shared");
    assert_eq!(scene.instances().len(), 1, "one instance of one object");
}

#[test]
fn corners_that_are_alike_are_one_vertex() {
    let scene = obj(&format!("{V}vt 0 0\nvn 0 0 1\nf 1 2 3\nf 2//1 4//1 3//1\nf 1 2 4\n"));
    let mesh = &scene.meshes()[0];
    // Four corners without a normal, three with one.
    assert_eq!(mesh.positions.len(), 7, "vertices that differ in nothing are one");
    assert_eq!(mesh.normals.iter().filter(|n| **n == [0.0; 3]).count(), 4, "no normal is a zero normal");
    assert_eq!(mesh.indices.len(), 3, "all triangles");
}

#[test]
fn colors_and_texture_coordinates_are_kept() {
    let scene = obj("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvt 0.25 0.75\nf 1/1 2/1 3/1\n");
    let mesh = &scene.meshes()[0];
    assert_eq!(mesh.colors[1], [0.0, 1.0, 0.0, 1.0], "a colour");
    assert_eq!(mesh.texcoords[0], [0.25, 0.75], "v runs upwards in OBJ as here");
}

#[test]
fn materials_become_ours() {
    let is = |mtl: &str, check: fn(&Surface) -> bool| {
        let surface = material(mtl).surface;
        assert!(check(&surface), "{mtl:?} became {surface:?}");
    };
    is("Kd .1 .2 .3", |s| matches!(s, Surface::Matte { base_color } if base_color.factor == [0.1, 0.2, 0.3]));
    is("Kd .5 .5 .5\nKs 0 0 0\nNs 2000", |s| matches!(s, Surface::Matte { .. }));
    is("Kd 0 0 0\nKs .9 .9 .9\nNs 2000\nillum 3", |s| matches!(s, Surface::Mirror { .. }));
    is("Kd 0 0 0\nKs .9 .9 .9", |s| matches!(s, Surface::Mirror { .. }));
    is(
        "Kd 0 0 0\nKs .9 .9 .9\nNs 198\nillum 3",
        |s| matches!(s, Surface::MetallicRoughness { metallic: 1.0, roughness, .. } if (roughness - 0.316).abs() < 0.001),
    );
    is(
        "Kd .6 .6 .6\nKs .04 .04 .04\nNs 198",
        |s| matches!(s, Surface::MetallicRoughness { metallic: 0.0, ior, .. } if (ior - 1.5).abs() < 1e-3),
    );
    is("Kd 0 0 0\nKs .04 .04 .04\nTf 1 1 1\nd 0.1\nNi 1.4\nillum 7", |s| {
        matches!(s, Surface::Dielectric { ior: 1.4, transmittance: [1.0, 1.0, 1.0], .. })
    });
    is("Kd .5 .5 .5\nPm 1\nPr .25", |s| {
        matches!(s, Surface::MetallicRoughness { metallic: 1.0, roughness: 0.25, .. })
    });
    is(
        "Kd .5 .5 .5\nPm 1\nPr .25\naniso .5\nanisor .25",
        |s| matches!(s, Surface::Principled(p) if p.anisotropy.strength == 0.5 && (p.anisotropy.rotation - std::f32::consts::FRAC_PI_2).abs() < 1e-3),
    );
    let mirror = material("Kd 0 0 0\nKs .9 .9 .9\nillum 3");
    assert_eq!(mirror.diffuse_color().factor, [0.0; 3], "--force-diffuse shows Kd, black as it is");
    let window = material("Kd .5 .5 .5\nTr .25");
    assert!(
        matches!(window.alpha, Alpha::Blend { opacity } if opacity.factor == 0.75),
        "opacity: {:?}",
        window.alpha
    );
    let emitter = material("Kd 0 0 0\nKe 17 12 4");
    assert_eq!(emitter.emission, [17.0, 12.0, 4.0], "Ke is radiance");
}

#[test]
fn broken_lines_and_textures_are_warnings() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mtl = "newmtl m\nKd 1 x 1\nmap_Kd no such.png\nNs\nKd .2 .2 .2\n";
    std::fs::write(folder.path().join("my lib.mtl"), mtl).expect("a file");
    let path = folder.path().join("t.obj");
    std::fs::write(&path, format!("mtllib my lib.mtl\n{V}usemtl m\nf 1 2 3\n")).expect("a file");
    let loaded = gnurt_scene::io::load(path).unwrap_or_else(|e| panic!("{e}"));
    let lines: Vec<_> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert!(lines[0].contains("my lib.mtl:2: material line cannot be understood"), "{lines:?}");
    assert!(lines[1].contains("my lib.mtl:4: material line"), "and `Ns` without a number: {lines:?}");
    assert!(lines[2].contains("my lib.mtl:3: texture cannot be read, ignored"), "{lines:?}");
    let material = loaded.scene.material(loaded.scene.meshes()[0].material);
    assert_eq!(material.diffuse_color().factor, [0.2; 3], "the good line counts");
}

#[test]
fn all_files_are_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    let obj = format!("mtllib t.mtl\nmtllib gone.mtl\n{V}usemtl a\nf 1 2 3\n");
    std::fs::write(at("t.obj"), obj).expect("a file");
    std::fs::write(at("t.mtl"), "newmtl a\nmap_Kd gone.png\nmap_Ke gone.png\n").expect("a file");
    let loaded = gnurt_scene::io::load(at("t.obj")).expect("a missing picture is no error");
    let expected = ["t.obj", "gone.mtl", "gone.png", "t.mtl"].map(at);
    assert_eq!(loaded.files, expected, "the file itself first, and those that are missing");
}

#[test]
fn materials_name_shaders() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mtl = "newmtl a\nKd 1 0 0\ngnurt_shader my wood.osl scale=2 tint=1,0.5,0.2\nnewmtl b\ngnurt_shader scale=2\n";
    std::fs::write(folder.path().join("t.mtl"), mtl).expect("a file");
    let path = folder.path().join("t.obj");
    std::fs::write(&path, format!("mtllib t.mtl\n{V}usemtl a\nf 1 2 3\n")).expect("a file");
    let loaded = gnurt_scene::io::load(path).unwrap_or_else(|e| panic!("{e}"));
    let all: Vec<_> = loaded.scene.shader_files().collect();
    let [(id, shader)] = all[..] else { panic!("one is right: {all:?}") };
    assert_eq!(loaded.scene.material(id).name, "a");
    assert_eq!(shader.file, folder.path().join("my wood.osl"), "beside the library");
    let pair = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    assert_eq!(shader.parameters, [pair("scale", "2"), pair("tint", "1,0.5,0.2")]);
    let reported = loaded.warnings.count(gnurt_scene::io::Oddity::BadMaterialLine);
    assert_eq!(reported, 1, "the other is told: {:?}", loaded.warnings);
}

#[test]
fn bumps_are_heights() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let grey = gnurt_scene::texture::TexelData::Linear8(vec![[9, 9, 9, 255]; 4]);
    let texels = gnurt_scene::texture::Texels { width: 2, height: 2, data: grey };
    let png = gnurt_image::encode_texels(&texels, true).expect("a picture");
    std::fs::write(folder.path().join("h.png"), png).expect("a file");
    let obj =
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n";
    std::fs::write(folder.path().join("s.obj"), obj).expect("a file");
    let mtl = "newmtl a\nmap_Bump -bm 0.25 -s 2 2 1 h.png\nnewmtl b\ndisp h.png\nnewmtl c\nbump h.png\ndisp none.png\n";
    std::fs::write(folder.path().join("m.mtl"), mtl).expect("a file");
    let scene = gnurt_scene::io::load(folder.path().join("s.obj")).expect("a scene").scene;
    let of = |name: &str| {
        let material = scene.materials().iter().find(|m| m.name == name).expect("the material");
        material.bump.expect("a bump map")
    };
    assert_eq!((of("a").height, of("a").texture.uv_from_mesh[0]), (0.25, 2.0), "-bm and -s");
    assert_eq!((of("b").height, of("c").height), (1.0, 1.0), "disp is taken for bump, where there is none");
    assert_eq!(
        scene.texture(of("a").texture.texture).texels.texel(0, 0)[0],
        9.0 / 255.0,
        "not decoded as colours"
    );
}

/// Blender and MeshLab write them so, and as bytes into PLY.
#[test]
fn colors_of_vertices_are_srgb() {
    let scene = obj("v 0 0 0 .5 .5 .5\nv 1 0 0 .5 .5 .5\nv 0 1 0 .5 .5 .5\nf 1 2 3\n");
    let [r, g, b, a] = scene.meshes()[0].colors[0];
    assert!((r - 0.2140).abs() < 1e-3 && g == r && b == r && a == 1.0, "{r} {g} {b} {a}");
}

#[test]
fn the_index_and_the_roughness_of_glass_and_plastic_count() {
    let is = |mtl: &str, check: fn(&Surface) -> bool| {
        let surface = material(mtl).surface;
        assert!(check(&surface), "{mtl:?} became {surface:?}");
    };
    is("Kd .5 .5 .5\nPm 0\nPr .1\nNi 1.33", |s| matches!(s, Surface::MetallicRoughness { ior: 1.33, .. }));
    is("Kd .5 .5 .5\nPr .1\nPc .5\nNi 1.33", |s| matches!(s, Surface::Principled(p) if p.ior == 1.33));
    // Many write 1 where they know nothing.
    is("Kd .5 .5 .5\nPr .1\nNi 1", |s| matches!(s, Surface::MetallicRoughness { ior: 1.5, .. }));
    is("Kd 1 1 1\nTf 1 1 1\nPr .25\nNi 1.33\nillum 7", |s| {
        matches!(s, Surface::RoughDielectric { ior: 1.33, roughness: 0.25, thin: false, .. })
    });
    is("Kd 1 1 1\nTf 1 1 1\nPr 0\nNi 1.33\nillum 7", |s| matches!(s, Surface::Dielectric { ior: 1.33, .. }));
}

/// A picture of 8 x 8 texels beside a file, and the scene and warnings of a triangle with that library.
fn with_picture(texel: [u8; 4], mtl: &str) -> (Scene, Vec<String>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let data = gnurt_scene::texture::TexelData::Linear8(vec![texel; 64]);
    let texels = gnurt_scene::texture::Texels { width: 8, height: 8, data };
    let png = gnurt_image::encode_texels(&texels, true).expect("a picture");
    std::fs::write(folder.path().join("n.png"), png).expect("a file");
    std::fs::write(folder.path().join("m.mtl"), format!("newmtl a\n{mtl}\n")).expect("a file");
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    std::fs::write(folder.path().join("s.obj"), obj).expect("a file");
    let loaded = gnurt_scene::io::load(folder.path().join("s.obj")).unwrap_or_else(|e| panic!("{e}"));
    (loaded.scene, loaded.warnings.iter().map(ToString::to_string).collect())
}

/// Blender writes normal maps as `map_Bump`.
#[test]
fn bumps_may_be_normals() {
    let blue = [127, 128, 250, 255];
    let scale = |scene: &Scene| match &scene.materials()[1].surface {
        Surface::MetallicRoughness { normal_texture, .. } => normal_texture.map(|map| map.scale),
        Surface::Principled(p) => p.normal_texture.map(|map| map.scale),
        _ => None,
    };
    let (scene, lines) = with_picture(blue, "Kd .5 .5 .5\nPr .5\nmap_Bump -bm 0.5 n.png");
    assert_eq!((scale(&scene), scene.materials()[1].bump), (Some(0.5), None), "{lines:?}");
    assert!(
        lines.len() == 1 && lines[0].contains("m.mtl:4: bump map holds normals"),
        "it is told: {lines:?}"
    );
    let (matte, _) = with_picture(blue, "Kd .5 .5 .5\nmap_Bump n.png");
    assert_eq!(scale(&matte), Some(1.0), "matte: {:?}", matte.materials()[1]);
    let (grey, lines) = with_picture([128, 128, 128, 255], "Kd .5 .5 .5\nPr .5\nmap_Bump -bm 0.5 n.png");
    assert!(scale(&grey).is_none() && grey.materials()[1].bump.is_some(), "heights stay heights");
    assert!(lines.is_empty(), "{lines:?}");
    let (message, lines) = with_picture([128, 128, 128, 255], "Kd .5 .5 .5\nPr .5\nnorm n.png");
    assert_eq!(scale(&message), Some(1.0), "`norm` says so itself");
    assert!(lines.is_empty(), "{lines:?}");
    let (glass, lines) = with_picture(blue, "Ni 1.5\nillum 7\nnorm n.png");
    assert!(matches!(glass.materials()[1].surface, Surface::Dielectric { .. }), "glass stays glass");
    assert!(lines[0].contains("normal map of glass"), "and says so: {lines:?}");
}

#[test]
fn what_is_not_read_is_told() {
    let lines = |obj: &str, mtl: &str| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("t.mtl"), mtl).expect("a file");
        let path = folder.path().join("t.obj");
        std::fs::write(&path, format!("mtllib t.mtl\n{V}{obj}f 1 2 3\n")).expect("a file");
        let loaded = gnurt_scene::io::load(path).unwrap_or_else(|e| panic!("{e}"));
        loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let reported =
        lines("surf 0 1 0 1 1 2 3 4\nend\n", "newmtl m\nmap_Ka a.png\nmap_Ks s.png\nmap_Ns r.png\n");
    for (text, line) in [("`map_Ks`", "t.mtl:3"), ("`map_Ns`", "t.mtl:4"), ("free-form surface", "t.obj:6")] {
        assert!(
            reported.iter().any(|l| l.contains(text) && l.contains(line)),
            "{text} at {line}: {reported:?}"
        );
    }
    assert_eq!(reported.len(), 3, "nothing about ambient light: {reported:?}");
    let reported = lines("", "newmtl m\nKd -1 0 0\nPr 3\nNi 0\nd 1.5\n");
    for text in ["`Kd -1`", "`Pr 3` of `m`; expected 0 to 1", "`Ni 0`", "`d 1.5`"] {
        assert!(
            reported.iter().any(|l| l.contains(text) && l.contains("out of range")),
            "{text}: {reported:?}"
        );
    }
}

#[test]
fn maps_of_roughness_and_metal_are_packed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let grey = |name: &str, level: u8| {
        let data = gnurt_scene::texture::TexelData::Linear8(vec![[level, level, level, 255]]);
        let texels = gnurt_scene::texture::Texels { width: 1, height: 1, data };
        let png = gnurt_image::encode_texels(&texels, true).expect("a picture");
        std::fs::write(folder.path().join(name), png).expect("a file");
    };
    grey("rough.png", 188);
    grey("metal.png", 137);
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    std::fs::write(folder.path().join("m.obj"), obj).expect("a file");
    let mtl = "newmtl a\nKd 1 1 1\nmap_Pr rough.png\nmap_Pm metal.png\nPc 0.5\nmap_Pcr rough.png\nmap_Ps metal.png\n";
    std::fs::write(folder.path().join("m.mtl"), mtl).expect("a file");
    let loaded = gnurt_scene::io::load(folder.path().join("m.obj")).expect("a scene");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let gnurt_scene::Surface::Principled(p) = &loaded.scene.materials()[1].surface else { panic!("layers") };
    assert_eq!(
        (p.metallic, p.roughness, p.clearcoat, p.clearcoat_roughness),
        (1.0, 1.0, 0.5, 1.0),
        "factors"
    );
    let packed = loaded.scene.texture(p.metallic_roughness_texture.expect("a texture").texture);
    let texel = packed.texels.texel(0, 0);
    let close = |a: f32, b: f32| (a - b).abs() < 0.01;
    assert!(close(texel[1], 188.0 / 255.0) && close(texel[2], 137.0 / 255.0), "green and blue: {texel:?}");
    let maps = p.layer_textures;
    assert!(
        maps.sheen_color.is_some() && maps.clearcoat_roughness.is_some() && maps.clearcoat.is_none(),
        "{maps:?}"
    );
}
