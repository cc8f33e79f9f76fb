// SPDX-License-Identifier: GPL-3.0-or-later
//! The meaning of glTF's extensions of materials and meshes, as the reader gives them to the scene.
//! Pictures: `crates/gnurt/tests/gltf_twins.rs`.

use crate::common::FORMATS;
use gnurt_scene::io::{Error, LoadOptions, Loaded, Oddity, VariantChoice};
use gnurt_scene::material::{Principled, TextureRef};
use gnurt_scene::texture::TexcoordSet;
use gnurt_scene::{Material, Surface};

/// A PNG of one pixel.
const PIXEL: &str =
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==";

/// Buffer: 0 = a triangle of floats, 36 bytes; accessor 1 = two numbers for each vertex.
fn load_with(body: &str, options: &LoadOptions) -> Result<Loaded, Error> {
    let data = r#""buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}]"#;
    let images =
        format!(r#""images":[{{"uri":"data:;base64,{PIXEL}"}}],"textures":[{{"source":0}},{{"source":0}}]"#);
    let json = format!(r#"{{"asset":{{"version":"2.0"}},{data},{images},{body}}}"#);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("t.gltf");
    std::fs::write(&path, json).expect("a file");
    FORMATS.load(path, options)
}

fn load(body: &str) -> Loaded {
    load_with(body, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn principled(material: &Material) -> &Principled {
    match &material.surface {
        Surface::Principled(principled) => principled,
        other => panic!("{other:?}"),
    }
}

#[test]
fn layers_have_textures() {
    let loaded = load(
        r#""materials":[{"extensions":{
"KHR_materials_specular":{"specularTexture":{"index":0},"specularColorTexture":{"index":1}},
"KHR_materials_clearcoat":{"clearcoatFactor":1,"clearcoatTexture":{"index":0},"clearcoatRoughnessFactor":0.5,"clearcoatRoughnessTexture":{"index":0},"clearcoatNormalTexture":{"index":0,"scale":0.5}},
"KHR_materials_sheen":{"sheenColorFactor":[1,1,1],"sheenColorTexture":{"index":0},"sheenRoughnessFactor":1,"sheenRoughnessTexture":{"index":0}},
"KHR_materials_transmission":{"transmissionFactor":1,"transmissionTexture":{"index":0}},
"KHR_materials_iridescence":{"iridescenceFactor":1,"iridescenceTexture":{"index":0},"iridescenceThicknessMinimum":50,"iridescenceThicknessTexture":{"index":0}},
"KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":1,"diffuseTransmissionTexture":{"index":0},"diffuseTransmissionColorTexture":{"index":0}}}},
{"extensions":{"KHR_materials_clearcoat":{"clearcoatTexture":{"index":0}},"KHR_materials_sheen":{"sheenColorTexture":{"index":0}}}}]"#,
    );
    let layered = principled(&loaded.scene.materials()[0]);
    let maps = &layered.layer_textures;
    assert_eq!((maps.colors().count(), maps.data().count()), (3, 9), "all of them: {maps:?}");
    assert_eq!((maps.clearcoat_normal_scale, layered.iridescence.least_thickness), (0.5, 50.0), "numbers");
    assert_eq!(loaded.warnings.count(Oddity::NotShown), 0, "{:?}", loaded.warnings);
    let none = &loaded.scene.materials()[1];
    assert!(matches!(none.surface, Surface::MetallicRoughness { .. }), "times nothing: {:?}", none.surface);
}

#[test]
fn two_sets_of_texture_coordinates_are_read() {
    let loaded = load(
        r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":3},"metallicRoughnessTexture":{"index":0,"texCoord":1,"extensions":{"KHR_texture_transform":{"texCoord":2}}}},"normalTexture":{"index":0,"texCoord":7}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_2":1},"material":0}]}],"nodes":[{"mesh":0}]"#,
    );
    let Surface::MetallicRoughness { base_color, metallic_roughness_texture, normal_texture, .. } =
        &loaded.scene.materials()[0].surface
    else {
        panic!("a metal")
    };
    let set = |texture: Option<TextureRef>| texture.map(|texture| texture.set);
    assert_eq!(set(base_color.texture), Some(TexcoordSet::First), "the base colour is first");
    assert_eq!(set(*metallic_roughness_texture), Some(TexcoordSet::Second), "the transform's set counts");
    assert!(normal_texture.is_none() && loaded.warnings.count(Oddity::NotShown) == 1, "no third set");
    let mesh = &loaded.scene.meshes()[0];
    assert!(mesh.texcoords.is_empty(), "the mesh has no set 3");
    assert_eq!(mesh.second_texcoords(), [0.0, 1.0, 0.0, 0.0, 0.0, 1.0], "v upwards");
}

const VARIANTS: &str = r#""extensionsUsed":["KHR_materials_variants"],
"extensions":{"KHR_materials_variants":{"variants":[{"name":"day"},{"name":"night"}]}},
"materials":[{"name":"plain"},{"name":"white"},{"name":"black"}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0,"extensions":{"KHR_materials_variants":{"mappings":[{"material":1,"variants":[0]},{"material":2,"variants":[1]}]}}}]}],"nodes":[{"mesh":0}]"#;

#[test]
fn variants_choose_materials() {
    let chosen = |prim: &str, names: &[&str]| {
        let choice =
            |name: &&str| VariantChoice { prim: prim.into(), set: "s".into(), variant: (*name).into() };
        let options = LoadOptions { variants: names.iter().map(choice).collect(), ..LoadOptions::default() };
        let loaded = load_with(VARIANTS, &options).map_err(|error| error.to_string())?;
        let scene = loaded.scene;
        Ok::<_, String>(scene.material(scene.meshes()[0].material).name.clone())
    };
    assert_eq!(chosen("", &[]).as_deref(), Ok("plain"), "without a choice");
    assert_eq!(chosen("", &["night"]).as_deref(), Ok("black"), "by name");
    assert_eq!(chosen("", &["night", "day"]).as_deref(), Ok("white"), "the last one counts");
    let unknown = chosen("", &["noon"]).expect_err("no such variant");
    assert!(unknown.contains("unknown variant `noon`; valid are `day`, `night`"), "{unknown}");
    let of_usd = chosen("/World", &["day"]).expect_err("another form");
    assert!(of_usd.contains("glTF has variants by name"), "{of_usd}");
}

#[test]
fn specular_and_gloss_become_plastic() {
    let loaded = load(
        r#""materials":[{"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0.5,0.25,1,1],"specularFactor":[0.04,0.5,1],"glossinessFactor":0.75}}},
{"extensions":{"KHR_materials_pbrSpecularGlossiness":{"glossinessFactor":0.5,"specularGlossinessTexture":{"index":0}}}}]"#,
    );
    let plain = principled(&loaded.scene.materials()[0]);
    assert_eq!(
        (plain.metallic, plain.roughness, plain.base_color.factor),
        (0.0, 0.25, [0.5, 0.25, 1.0]),
        "body"
    );
    assert_eq!(plain.specular_color, [1.0, 12.5, 25.0], "times the reflectance of plastic");
    let mapped = principled(&loaded.scene.materials()[1]);
    assert_eq!(mapped.roughness, 1.0, "all of it in the texture");
    let rough = mapped.metallic_roughness_texture.expect("a texture of roughness").texture;
    let [_, green, ..] = loaded.scene.texture(rough).texels.texel(0, 0);
    assert!((green - 0.75).abs() < 0.01, "1 - 0.5 times the alpha of a half: {green}");
    assert!(mapped.layer_textures.specular_color.is_some(), "its colours");
}

#[test]
fn splats_are_named() {
    let loaded = load(
        r#""extensionsUsed":["KHR_gaussian_splatting"],"meshes":[{"primitives":[{"mode":0,"attributes":{"POSITION":0},"extensions":{"KHR_gaussian_splatting":{"kernel":"ellipse"}}}]}],"nodes":[{"mesh":0}]"#,
    );
    let text = format!("{:?}", loaded.warnings);
    assert!(text.contains("Gaussian splats (KHR_gaussian_splatting)"), "{text}");
}

#[test]
fn extras_put_lights_into_groups() {
    use gnurt_scene::labels::Shining;
    use gnurt_scene::{InstanceId, LightId, MaterialId};

    let loaded = load(
        r#""extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"},{"type":"point","extras":{"light_group":"fill"}}]}},
"materials":[{"extras":{"light_group":"screen/1"}},{"extras":{"light_group":7}},{"extras":"text"}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
"nodes":[{"mesh":0,"extras":{"light_group":"lamp"}},
{"name":"Key","extensions":{"KHR_lights_punctual":{"light":0}},"extras":{"light_group":"key"}},
{"extensions":{"KHR_lights_punctual":{"light":1}}}]"#,
    );
    let labels = loaded.scene.labels();
    let group = |shining| labels.light_groups.get(&shining).map(String::as_str);
    assert_eq!(group(Shining::Light(LightId(0))), Some("key"), "of the node");
    assert_eq!(group(Shining::Light(LightId(1))), Some("fill"), "of the light");
    assert_eq!(group(Shining::Instance(InstanceId(0))), Some("lamp"), "of an instance");
    assert_eq!(group(Shining::Material(MaterialId(0))), Some("screen_1"), "of a material, as a layer's name");
    assert_eq!(labels.light_groups.len(), 4, "other extras are others'");
    assert_eq!(labels.lights.get(&LightId(0)).map(String::as_str), Some("Key"), "names");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("t.glb");
    FORMATS.save(&loaded.scene, &path).expect("it is saved");
    let again = FORMATS.load(&path, &LoadOptions::default()).expect("its own file");
    assert_eq!(again.scene.labels().light_groups, labels.light_groups, "written and read");
}

#[test]
fn extras_put_instances_into_trace_sets() {
    use gnurt_scene::InstanceId;
    use gnurt_scene::overrides::Override;

    let loaded = load(
        r#""materials":[{}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
"nodes":[{"mesh":0,"name":"a","extras":{"traceset":"props, walls"}},{"mesh":0,"name":"b","extras":{"traceset":"walls"}},
{"mesh":0,"name":"c","extras":{"traceset":7}},{"mesh":0,"name":"d","extras":{"traceset":"ok,-not"}}]"#,
    );
    let mut scene = loaded.scene;
    let sets = |scene: &gnurt_scene::Scene| {
        [0, 1, 2, 3].map(|id| scene.labels().trace_sets_of(InstanceId(id)).join("+"))
    };
    assert_eq!(sets(&scene), ["props+walls", "walls", "", ""], "all of a faulty list is left out");
    let text = format!("{:?}", loaded.warnings);
    assert!(text.contains("c: extras.traceset: 7 is not a text"), "{text}");
    assert!(text.contains("d: extras.traceset: invalid name of a trace set '-not'"), "{text}");
    let set = |text: &str| Override::parse(text).expect("a change");
    set("instances.c.traceset=props").apply(&mut scene).expect("a name");
    assert_eq!(sets(&scene), ["props+walls", "walls", "props", ""], "by an option");
    let why = set("instances.c.traceset=a/b").apply(&mut scene).expect_err("no name");
    assert!(why.starts_with("instances.c.traceset: invalid name of a trace set 'a/b'"), "{why}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("t.glb");
    FORMATS.save(&scene, &path).expect("it is saved");
    let again = FORMATS.load(&path, &LoadOptions::default()).expect("its own file");
    assert_eq!(again.scene.labels().trace_sets, scene.labels().trace_sets, "written and read");
}
