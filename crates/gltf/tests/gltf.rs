// SPDX-License-Identifier: GPL-3.0-or-later
//! The meaning of glTF files here. GlTF 2.0 and its extensions.

use crate::common::load_named;
use gnurt_scene::detail::{DiffuseTransmission, Interior, Iridescence};
use gnurt_scene::io::Oddity;
use gnurt_scene::material::{Alpha, TextureRef};
use gnurt_scene::{CameraId, Lens, Light, Material, Projection, RayMask, Scene, Surface};

/// Accessors: 0 = triangle (0,0,0) (1,0,0) (0,1,0) as floats, 1 = its first vertex three times, 2 = joints 0,
/// 3 = weights 1, 4 = the triangle with vertex 2 replaced by (1,0,0) through a sparse accessor.
const DATA: &str = r#""buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteLength":12},{"buffer":0,"byteOffset":12,"byteLength":12}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"},
{"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"},
{"componentType":5126,"count":3,"type":"VEC4","sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0,"byteOffset":12}}},
{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":2}}}]"#;

fn gltf(body: &str) -> Scene {
    let json = format!(r#"{{"asset":{{"version":"2.0"}},{DATA},{body}}}"#);
    load_named("t.gltf", json.as_bytes()).unwrap_or_else(|e| panic!("{e}")).scene
}

fn material(body: &str) -> Material {
    gltf(&format!(r#""materials":[{{{body}}}]"#)).materials()[0].clone()
}

const TRIANGLE: &str = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]"#;

#[test]
fn meshes_are_instanced() {
    let scene = gltf(&format!(
        r#"{TRIANGLE},"nodes":[{{"mesh":0}},{{"children":[2],"translation":[5,0,0]}},{{"mesh":0,"scale":[2,2,2]}}]"#
    ));
    assert_eq!(scene.objects().len(), 1, "one object");
    let corners: Vec<_> =
        scene.instances().iter().map(|i| i.world_from_object.point([1.0, 0.0, 0.0])).collect();
    assert_eq!(corners, [[1.0, 0.0, 0.0], [7.0, 0.0, 0.0]], "two instances, the child below its parent");
}

#[test]
fn a_node_may_have_its_mesh_at_many_places() {
    let node = |attributes: &str, rest: &str| {
        let extension =
            format!(r#""extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{{attributes}}}}}}}"#);
        format!(
            r#"{TRIANGLE},"extensionsRequired":["EXT_mesh_gpu_instancing"],"nodes":[{{"mesh":0,"translation":[5,0,0],{extension}{rest}}}]"#
        )
    };
    // Three positions (0,0,0) (1,0,0) (0,1,0), scaled by the same numbers; other attributes are ignored.
    let scene = gltf(&node(r#""TRANSLATION":0,"_ID":1"#, r#","extras":{"mask":5}"#));
    assert_eq!((scene.instances().len(), scene.objects().len()), (1, 2), "an object made of another");
    assert_eq!(scene.instances()[0].mask, RayMask(5), "the node's mask is of all");
    let found: Vec<_> = scene.occurrences().skip(1).map(|found| found.world_from_object.columns[3]).collect();
    assert_eq!(found, [[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0]], "behind the node's own transform");
    let scaled = gltf(&node(r#""TRANSLATION":0,"SCALE":0,"ROTATION":3"#, ""));
    let second = scaled.occurrences().nth(2).expect("three places").world_from_object;
    assert_eq!(second.columns[0], [1.0, 0.0, 0.0], "turned by nothing, scaled by 1 along x");
    assert_eq!(gltf(&node("", "")).objects().len(), 1, "nothing is said of places");
    let json =
        format!(r#"{{"asset":{{"version":"2.0"}},{DATA},{}}}"#, node(r#""TRANSLATION":0,"SCALE":9"#, ""));
    let error = load_named("t.gltf", json.as_bytes()).expect_err("no such accessor").to_string();
    assert!(error.contains("nodes[0].extensions.EXT_mesh_gpu_instancing"), "{error}");
}

#[test]
fn sparse_accessors_substitute() {
    let body = r#""meshes":[{"primitives":[{"attributes":{"POSITION":4}}]}],"nodes":[{"mesh":0}]"#;
    let json = format!(r#"{{"asset":{{"version":"2.0"}},{DATA},{body}}}"#);
    let loaded = load_named("t.gltf", json.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    // Vertex 0 became vertex 1: no area is left.
    assert_eq!(loaded.warnings.count(Oddity::ZeroAreaTriangle), 1, "the substitute counts");
}

#[test]
fn materials_become_ours() {
    let plain = material(r#""pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0,1],"metallicFactor":0.5}"#);
    assert!(
        matches!(plain.surface, Surface::MetallicRoughness { metallic: 0.5, roughness: 1.0, .. }),
        "as given"
    );
    let glass = material(
        r#""pbrMetallicRoughness":{"roughnessFactor":0},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_volume":{"thicknessFactor":0.5},"KHR_materials_ior":{"ior":1.25}}"#,
    );
    assert!(matches!(glass.surface, Surface::Dielectric { ior: 1.25, .. }), "glass: {:?}", glass.surface);
    let cloth = material(
        r#""pbrMetallicRoughness":{"metallicFactor":0},"extensions":{"KHR_materials_sheen":{"sheenColorFactor":[0.5,0.25,1],"sheenRoughnessFactor":0.25},"KHR_materials_clearcoat":{"clearcoatFactor":0.5,"clearcoatRoughnessFactor":0.125},"KHR_materials_specular":{"specularFactor":0.75}}"#,
    );
    let Surface::Principled(cloth) = &cloth.surface else { panic!("layers: {:?}", cloth.surface) };
    assert_eq!((cloth.sheen_color, cloth.sheen_roughness), ([0.5, 0.25, 1.0], 0.25), "sheen");
    assert_eq!((cloth.clearcoat, cloth.clearcoat_roughness, cloth.specular), (0.5, 0.125, 0.75), "coat");
    assert!(cloth.thin && cloth.transmission == 0.0, "nothing is glass");
    for (volume, thin) in [("", true), (r#","KHR_materials_volume":{"thicknessFactor":0.5}"#, false)] {
        let frosted = material(&format!(
            r#""pbrMetallicRoughness":{{"roughnessFactor":0.5,"metallicFactor":0}},"extensions":{{"KHR_materials_transmission":{{"transmissionFactor":0.75}}{volume}}}"#
        ));
        let Surface::Principled(frosted) = &frosted.surface else { panic!("{:?}", frosted.surface) };
        assert_eq!((frosted.transmission, frosted.thin), (0.75, thin), "with {volume}");
    }
    // Glass is a pane or solid by its volume, at every roughness.
    for roughness in [0.0, 0.049, 0.051, 1.0] {
        for (volume, thin) in [("", true), (r#","KHR_materials_volume":{"thicknessFactor":0.5}"#, false)] {
            let glass = material(&format!(
                r#""pbrMetallicRoughness":{{"roughnessFactor":{roughness},"metallicFactor":0}},"extensions":{{"KHR_materials_transmission":{{"transmissionFactor":1}}{volume}}}"#
            ));
            let is_thin = match &glass.surface {
                Surface::Dielectric { .. } => false,
                Surface::Principled(principled) => principled.thin,
                other => panic!("{other:?}"),
            };
            assert_eq!(is_thin, thin, "roughness {roughness}, {volume}: {:?}", glass.surface);
        }
    }
    let emitter = material(
        r#""emissiveFactor":[1,0.5,0],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8}}"#,
    );
    assert_eq!(emitter.emission, [8.0, 4.0, 0.0], "factor times strength");
    let sign = material(
        r#""pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0,1]},"extensions":{"KHR_materials_unlit":{}}"#,
    );
    assert!(
        matches!(sign.surface, Surface::Unlit { color } if color.factor == [0.5, 0.25, 0.0]),
        "unlit is seen as it is: {:?}",
        sign.surface
    );
    assert!(!sign.emits(), "and is no lamp");
    let leaf = material(r#""alphaMode":"MASK","alphaCutoff":0.25"#);
    assert!(matches!(leaf.alpha, Alpha::Mask { cutoff: 0.25, .. }), "masked: {:?}", leaf.alpha);
}

/// Rare properties of materials.
#[test]
fn rare_extensions_become_ours() {
    let volume = r#""KHR_materials_volume":{"thicknessFactor":2,"attenuationColor":[0.5,0.25,1],"attenuationDistance":0.75},"KHR_materials_dispersion":{"dispersion":0.5}"#;
    let exact = Interior {
        attenuation_color: [0.5, 0.25, 1.0],
        attenuation_distance: 0.75,
        dispersion: 0.5,
        ..Interior::default()
    };
    for roughness in [0.0, 0.5] {
        let glass = material(&format!(
            r#""pbrMetallicRoughness":{{"roughnessFactor":{roughness},"metallicFactor":0}},"extensions":{{"KHR_materials_transmission":{{"transmissionFactor":1}},{volume}}}"#
        ));
        let interior = match &glass.surface {
            Surface::Dielectric { interior, .. } => interior,
            Surface::Principled(principled) => &principled.interior,
            other => panic!("{other:?}"),
        };
        assert_eq!(*interior, exact, "roughness {roughness}");
    }
    let all = material(
        r#""extensions":{"KHR_materials_anisotropy":{"anisotropyStrength":0.75,"anisotropyRotation":0.5},"KHR_materials_iridescence":{"iridescenceFactor":0.25,"iridescenceIor":1.5,"iridescenceThicknessMaximum":300},"KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":0.125,"diffuseTransmissionColorFactor":[1,0.5,0.25]}}"#,
    );
    let Surface::Principled(all) = &all.surface else { panic!("{:?}", all.surface) };
    assert_eq!((all.anisotropy.strength, all.anisotropy.rotation), (0.75, 0.5), "brushed");
    let Iridescence { factor, ior, thickness, .. } = all.iridescence;
    assert_eq!([factor, ior, thickness], [0.25, 1.5, 300.0], "a film");
    let DiffuseTransmission { factor, color } = all.diffuse_transmission;
    assert_eq!((factor, color), (0.125, [1.0, 0.5, 0.25]), "light goes through");
    let pane = material(&format!(
        r#""extensions":{{"KHR_materials_transmission":{{"transmissionFactor":1}},{}}}"#,
        volume.replace(r#""thicknessFactor":2"#, r#""thicknessFactor":0"#)
    ));
    let Surface::Principled(pane) = &pane.surface else { panic!("{:?}", pane.surface) };
    assert!(pane.thin && pane.interior == Interior::default(), "a pane has no inside: {pane:?}");
    let odd = material(
        r#""extensions":{"KHR_materials_iridescence":{"iridescenceFactor":7,"iridescenceIor":-1},"KHR_materials_anisotropy":{"anisotropyStrength":-1}}"#,
    );
    let Surface::Principled(odd) = &odd.surface else { panic!("{:?}", odd.surface) };
    assert_eq!(
        (odd.iridescence.factor, odd.iridescence.ior, odd.anisotropy.strength),
        (1.0, 1.3, 0.0),
        "odd numbers"
    );
}

/// A PNG of one pixel.
const PIXEL: &str =
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==";

#[test]
fn texture_transforms_agree_with_the_extension() {
    let material = material(
        r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.1,0.2],"rotation":0.3,"scale":[2,3]}}}}"#,
    );
    assert_eq!(material.diffuse_color().texture, None, "no such texture: the base colour");
    let scene = gltf(&format!(
        r#""images":[{{"uri":"data:image/png;base64,{PIXEL}"}}],"textures":[{{"source":0}}],"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,"extensions":{{"KHR_texture_transform":{{"offset":[0.1,0.2],"rotation":0.3,"scale":[2,3]}}}}}}}}}}]"#
    ));
    let Some(TextureRef { uv_from_mesh: [a, b, c, d, e, f], .. }) =
        scene.materials()[0].diffuse_color().texture
    else {
        panic!("a texture");
    };
    // The extension's own order: scale, rotate, move, with v downwards.
    let (u, v_down) = (0.4_f32, 0.7_f32);
    let (sin, cos) = 0.3_f32.sin_cos();
    let (x, y) = (2.0 * u, 3.0 * v_down);
    let expected = [cos * x + sin * y + 0.1, 1.0 - (-sin * x + cos * y + 0.2)];
    let w = 1.0 - v_down;
    let found = [a * u + c * w + e, b * u + d * w + f];
    assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-5), "{found:?} is not {expected:?}");
}

/// A triangle with normals and tangents (accessors 5 and 6), under the material of this body.
fn mapped(material: &str) -> Scene {
    // Normals (0, 0, 1) three times, then tangents (0, 1, 0, -1) three times.
    let data = "AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAgD8AAAAAAACAvwAAAAAAAIA/AAAAAAAAgL8AAAAAAACAPwAAAAAAAIC/";
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},
        "buffers":[{{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}},{{"byteLength":84,"uri":"data:;base64,{data}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":1,"byteLength":36}},{{"buffer":1,"byteOffset":36,"byteLength":48}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
        {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"}},
        {{"bufferView":2,"componentType":5126,"count":3,"type":"VEC4"}}],
        "images":[{{"uri":"data:image/png;base64,{PIXEL}"}}],"textures":[{{"source":0}}],
        "materials":[{{{material}}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TANGENT":2,"TEXCOORD_0":0}},"material":0}}]}}]}}"#
    );
    load_named("t.gltf", json.as_bytes()).unwrap_or_else(|e| panic!("{e}")).scene
}

#[test]
fn tangents_come_with_normal_maps() {
    let scene = mapped(r#""normalTexture":{"index":0}"#);
    assert_eq!(scene.meshes()[0].tangents, [[0.0, 1.0, 0.0, -1.0]; 3], "as they are in the file");
    assert!(mapped("").meshes()[0].tangents.is_empty(), "nobody would look at them");
    let transformed = r#""normalTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.25,0],"scale":[2,1]}}}"#;
    let scene = mapped(transformed);
    let Surface::MetallicRoughness { normal_texture: Some(map), .. } = &scene.materials()[0].surface else {
        panic!("a normal map: {:?}", scene.materials()[0].surface);
    };
    assert_eq!(map.texture.uv_from_mesh, [2.0, 0.0, 0.0, 1.0, 0.25, 0.0], "its transform is read");
}

#[test]
fn morph_weights_move_vertices() {
    let scene = gltf(
        r#""meshes":[{"weights":[2],"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":0}]}]}],"nodes":[{"mesh":0}]"#,
    );
    assert_eq!(scene.meshes()[0].positions[1], [3.0, 0.0, 0.0], "position + 2 target");
}

#[test]
fn skins_follow_their_joints() {
    // Weights: vertex 0 has (1,0,0,0); vertices 1 and 2 have none and stay.
    let scene = gltf(
        r#""meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3}}]}],"skins":[{"joints":[1]}],
        "nodes":[{"mesh":0,"skin":0,"translation":[9,9,9]},{"translation":[0,0,5]}]"#,
    );
    assert_eq!(scene.meshes()[0].positions[0], [0.0, 0.0, 5.0], "where its joint is");
    assert_eq!(
        scene.instances()[0].world_from_object.point([0.0; 3]),
        [0.0; 3],
        "the node's own place does not count"
    );
}

#[test]
fn weights_that_are_no_numbers_are_told() {
    // The 1 of all accessors is NaN.
    let data = DATA.replace("AACAPw", "AADAfw");
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},{data},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":4,"JOINTS_0":2,"WEIGHTS_0":3}}}}]}}],
        "skins":[{{"joints":[1]}}],"nodes":[{{"mesh":0,"skin":0}},{{"translation":[0,0,5]}}]}}"#
    );
    let loaded = load_named("t.gltf", json.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    let reported = loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(reported.contains("vertex 0 has a joint weight that is not finite"), "{reported}");
}

#[test]
fn deep_and_cyclic_trees() {
    let load =
        |body: &str| load_named("t.gltf", format!(r#"{{"asset":{{"version":"2.0"}},{body}}}"#).as_bytes());
    let twice = load(r#""nodes":[{"children":[1,1]},{}],"scenes":[{"nodes":[0,0]}],"scene":0"#);
    let twice = twice.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(twice.warnings.count(Oddity::BadNode), 2, "a child twice, and a root twice");
    for body in [
        r#""nodes":[{"children":[0]}],"scenes":[{"nodes":[0]}]"#,
        r#""nodes":[{"children":[1]},{"children":[2]},{"children":[1]}],"scenes":[{"nodes":[0]}]"#,
        r#""nodes":[{},{"children":[2]},{"children":[1]}]"#,
    ] {
        let error = load(body).expect_err("no tree").to_string();
        assert!(error.contains("its children lead back to it; expected a tree"), "{body}: {error}");
    }
}

#[test]
fn cameras_and_lights() {
    let scene = gltf(
        r#""cameras":[{"type":"perspective","perspective":{"yfov":1.5707963,"znear":0.1}},{"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"zfar":9,"znear":1}},{"type":"other"}],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"directional","intensity":2,"color":[1,0.5,0]}]}},
        "nodes":[{"camera":0,"translation":[1,2,3]},{"camera":1},{"camera":2},{"extensions":{"KHR_lights_punctual":{"light":0}}}]"#,
    );
    let [camera, parallel] = scene.cameras() else { panic!("two cameras can be used") };
    assert_eq!(parallel.projection, Projection::Orthographic { height: 2.0 }, "twice ymag");
    assert_eq!((camera.eye, camera.target), ([1.0, 2.0, 3.0], [1.0, 2.0, 2.0]), "it looks along -z");
    assert!((camera.fov_y - 90.0).abs() < 1e-3, "degrees: {}", camera.fov_y);
    let expected =
        Light::Directional { direction: [0.0, 0.0, -1.0], irradiance: [2.0, 1.0, 0.0], angle: 0.0 };
    assert_eq!(scene.lights(), [expected], "colour times intensity");
}

#[test]
fn lenses_and_wide_views_are_among_the_extras() {
    let file = |extras: &str| {
        let bytes = r#"{ "asset": { "version": "2.0" }, "nodes": [{ "camera": 0 }],
            "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 }, "extras": EXTRAS }] }"#;
        let loaded = load_named("cameras.gltf", bytes.replace("EXTRAS", extras).as_bytes());
        let loaded = loaded.unwrap_or_else(|e| panic!("{extras}: {e}"));
        let camera = &loaded.scene.cameras()[0];
        (camera.projection, camera.fov_y, camera.lens, loaded.warnings.count(Oddity::CameraExtras))
    };
    let (pinhole, plain) = (Lens::default(), 1.0_f32.to_degrees());
    let lens = Lens { aperture: 0.5, focus: Some(3.0) };
    for (extras, exact) in [
        ("{}", (Projection::Perspective, plain, pinhole, 0)),
        (r#""aperture""#, (Projection::Perspective, plain, pinhole, 0)),
        (r#"{ "aperture": 0.5, "focus": 3 }"#, (Projection::Perspective, plain, lens, 0)),
        (r#"{ "projection": "fisheye" }"#, (Projection::Fisheye, 180.0, pinhole, 0)),
        (r#"{ "projection": "fisheye", "fov": 220 }"#, (Projection::Fisheye, 220.0, pinhole, 0)),
        (r#"{ "projection": "panorama" }"#, (Projection::Panorama, plain, pinhole, 0)),
        (r#"{ "projection": "cube" }"#, (Projection::Perspective, plain, pinhole, 1)),
        (r#"{ "aperture": -1, "focus": 0 }"#, (Projection::Perspective, plain, pinhole, 2)),
    ] {
        assert_eq!(file(extras), exact, "{extras}");
    }
}

#[test]
fn cameras_name_shaders() {
    let file = |shader: &str| {
        let bytes = r#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [{ "camera": 0 }],
            "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 }, "extras": { "gnurt": SHADER } }] }"#;
        let loaded = load_named("camera.gltf", bytes.replace("SHADER", shader).as_bytes());
        let scene = loaded.unwrap_or_else(|e| panic!("{shader}: {e}")).scene;
        scene.camera_file(CameraId(0)).cloned()
    };
    let found =
        file(r#"{ "shader": "fish.osl", "parameters": { "fov": 200, "tint": [1, 2] } }"#).expect("a shader");
    assert!(found.file.ends_with("fish.osl") && found.file.parent().is_some(), "beside the scene: {found:?}");
    let pair = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    assert_eq!(found.parameters, [pair("fov", "200"), pair("tint", "1,2")], "texts");
    assert_eq!(file(r#"{ "shader": 3 }"#), None, "of another form");
}

#[test]
fn masks_are_among_the_extras() {
    let file = |extras: &str| {
        let bytes = r#"{ "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0EXTRAS }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "buffers": [{ "byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }] }"#;
        let bytes = bytes.replace("EXTRAS", extras);
        let loaded = load_named("masks.gltf", bytes.as_bytes()).unwrap_or_else(|e| panic!("{extras}: {e}"));
        (loaded.scene.instances()[0].mask, loaded.warnings.count(Oddity::BadNode))
    };
    for (extras, mask) in [
        ("", RayMask::ALL),
        (r#", "extras": { "mask": 6 }"#, RayMask::SHADOW | RayMask::OTHER),
        (r#", "extras": { "mask": 0.0, "other": [1] }"#, RayMask::NONE),
        (r#", "extras": { "mask": 4294967295 }"#, RayMask::ALL),
        (r#", "extras": "mask""#, RayMask::ALL),
        (r#", "extras": [{ "mask": 1 }]"#, RayMask::ALL),
    ] {
        assert_eq!(file(extras), (mask, 0), "{extras}");
    }
    for bad in ["-1", "4294967296", "1.5", "\"1\"", "null", "[1]"] {
        let extras = format!(r#", "extras": {{ "mask": {bad} }}"#);
        assert_eq!(file(&extras), (RayMask::ALL, 1), "{bad} is told of");
    }
}

#[test]
fn materials_name_shaders() {
    let extras = |text: &str| {
        let json =
            format!(r#"{{"asset": {{"version": "2.0"}}, "materials": [{{"name": "a", "extras": {text}}}]}}"#);
        let loaded = load_named("t.gltf", json.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
        loaded.scene.shader_files().map(|(id, file)| (id.0, file.clone())).collect::<Vec<_>>()
    };
    let found = extras(
        r#"{"gnurt": {"shader": "wood.osl", "parameters": {"scale": 2.5, "tint": [1, 0.5, 0.25], "file": "a.png", "on": true}}}"#,
    );
    let [(0, shader)] = &found[..] else { panic!("one: {found:?}") };
    assert!(shader.file.ends_with("wood.osl"), "{shader:?}");
    let mut parameters = shader.parameters.clone();
    parameters.sort();
    let exact = [("file", "a.png"), ("on", "1"), ("scale", "2.5"), ("tint", "1,0.5,0.25")];
    assert_eq!(parameters, exact.map(|(name, value)| (name.to_owned(), value.to_owned())));
    for others in ["{}", "7", r#"{"gnurt": 3}"#, r#"{"gnurt": {"shader": 1}}"#, "null"] {
        assert!(extras(others).is_empty(), "{others} is another program's");
    }
}

#[test]
fn numbers_out_of_range_are_told() {
    let lines = |body: &str| {
        let json = format!(r#"{{"asset":{{"version":"2.0"}},{DATA},"materials":[{{{body}}}]}}"#);
        let loaded = load_named("t.gltf", json.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
        let lines: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        lines.into_iter().filter(|line| !line.contains("no triangles")).collect::<Vec<_>>()
    };
    let reported = lines(
        r#""pbrMetallicRoughness":{"roughnessFactor":3,"metallicFactor":-1,"baseColorFactor":[2,-1,0,7]},"alphaMode":"SOFT",
        "extensions":{"KHR_materials_iridescence":{"iridescenceFactor":7,"iridescenceIor":-1},"KHR_materials_ior":{"ior":0}}"#,
    );
    for text in [
        "materials[0]: roughnessFactor 3; expected 0 to 1",
        "metallicFactor -1",
        "baseColorFactor -1",
        "baseColorFactor's opacity 7",
        "iridescenceFactor 7",
        "iridescenceIor -1",
        "ior 0; expected 1 or more",
        "alphaMode `SOFT`, shown as OPAQUE",
    ] {
        assert!(reported.iter().any(|line| line.contains(text)), "{text}: {reported:?}");
    }
    let right = lines(
        r#""pbrMetallicRoughness":{"roughnessFactor":1,"metallicFactor":0,"baseColorFactor":[1,0,0.5,0.5]},"emissiveFactor":[1,1,0],
        "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":500},"KHR_materials_volume":{"attenuationDistance":3e38}}"#,
    );
    assert!(right.is_empty(), "{right:?}");
}
