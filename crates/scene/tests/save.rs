// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes are read back as they were written.

use std::sync::Arc;

use crate::common::{load, save};
use gnurt_scene::builtin;
use gnurt_scene::detail::{Anisotropy, DiffuseTransmission, Interior, Iridescence};
use gnurt_scene::material::{Alpha, Color, NormalMap, Opacity, OpacityChannel, Principled, TextureRef};
use gnurt_scene::texture::{Filter, TexelData, Texels, Texture, Wrap};
use gnurt_scene::{
    Affine, Camera, ConeEdge, Lens, Light, Material, Member, Mesh, Object, Primitives, Projection, RayMask,
    Scene, Surface, TextureId,
};

fn there_and_back(scene: &Scene, name: &str) -> Scene {
    reported(scene, name).0
}

/// The scene read back, the warnings of writing, and the text of the file (of a library, if there is one).
fn reported(scene: &Scene, name: &str) -> (Scene, Vec<String>, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    let warnings = save(scene, &path).unwrap_or_else(|e| panic!("{e}"));
    let back = load(&path).unwrap_or_else(|e| panic!("{e}")).scene;
    let library = path.with_extension("mtl");
    let text = std::fs::read(if library.exists() { &library } else { &path }).expect("the file");
    (back, warnings.iter().map(ToString::to_string).collect(), String::from_utf8_lossy(&text).into_owned())
}

/// Area of all triangles in world space, an order-free fingerprint of the geometry.
fn area(scene: &Scene) -> f64 {
    let of = |instance: &gnurt_scene::Instance| {
        let meshes = scene.object(instance.object).meshes.iter();
        meshes.map(|&mesh| scene.mesh(mesh).area(&instance.world_from_object)).sum::<f64>()
    };
    scene.instances().iter().map(of).sum()
}

/// Two lamps, one below the other and half as large; a cloud of points is left out.
#[test]
fn spheres_become_triangles() {
    let mut scene = Scene::new();
    let shining =
        scene.add_material(Material { emission: [3.0, 2.0, 1.0], ..Material::matte("lamp", [0.0; 3]) });
    let spheres = |n: usize| Mesh {
        positions: (0..n).map(|i| [0.0, i as f32, 0.0]).collect(),
        colors: (0..n).map(|i| [1.0 / (1.0 + i as f32), 0.0, 0.0, 1.0]).collect(),
        primitives: Primitives::Spheres((0..n).map(|i| 0.4 / (1.0 + i as f32)).collect()),
        material: shining,
        ..Mesh::default()
    };
    let mesh = scene.add_mesh(spheres(2));
    let object = scene.add_object_of("lamps", vec![mesh]);
    scene.instantiate(object, Affine::scale([2.0; 3]));
    let exact = 4.0 * std::f64::consts::PI * (0.8_f64.powi(2) + 0.4_f64.powi(2));
    assert!((area(&scene) / exact - 1.0).abs() < 1e-6, "{} as spheres", area(&scene));
    for file in ["a.obj", "a.ply", "a.glb", "a.stl"] {
        let (back, warnings, _) = reported(&scene, file);
        assert!((area(&back) / exact - 1.0).abs() < 0.02, "{file}: area {} of {exact}", area(&back));
        assert!(!warnings.iter().any(|text| text.contains("sphere")), "{file}: {warnings:?}");
        if file == "a.glb" {
            assert_eq!(back.materials()[0].emission, [3.0, 2.0, 1.0]);
            assert_eq!(back.mesh(gnurt_scene::MeshId(0)).colors.last().map(|color| color[0]), Some(0.5));
        }
    }
    let many = scene.add_mesh(spheres(2000));
    let object = scene.add_object_of("cloud", vec![many]);
    scene.instantiate(object, Affine::IDENTITY);
    let (back, warnings, _) = reported(&scene, "a.glb");
    assert!((area(&back) / exact - 1.0).abs() < 0.02, "the lamps alone");
    assert!(warnings.iter().any(|text| text.contains("mesh of curves or spheres")), "{warnings:?}");
}

#[test]
fn tangents_come_back() {
    let mut scene = builtin::load("textures").expect("it is built in");
    let material = scene.meshes()[0].material;
    let texture = gnurt_scene::material::TextureRef::new(gnurt_scene::TextureId(0));
    let principled = Principled {
        normal_texture: Some(gnurt_scene::material::NormalMap { texture, scale: 1.0 }),
        ..Principled::default()
    };
    scene.edit_material(material).surface = Surface::Principled(Box::new(principled));
    let mesh = scene.edit_mesh(gnurt_scene::MeshId(0));
    let count = mesh.positions.len();
    mesh.normals = vec![[0.0, 1.0, 0.0]; count];
    mesh.tangents = vec![[2.0, 0.0, 0.0, -1.0]; count];
    let back = there_and_back(&scene, "t.glb");
    assert_eq!(back.meshes()[0].tangents, vec![[1.0, 0.0, 0.0, -1.0]; count], "unit, on their side");
}

#[test]
fn objects_in_objects_are_unfolded() {
    let mut scene = builtin::load("cornell").expect("it is built in");
    let object = scene.instances()[0].object;
    let at = |x: f64| Affine::translation([x, 0.0, 0.0]);
    let pair =
        vec![Member::new(object, at(1.0)), Member { mask: RayMask::CAMERA, ..Member::new(object, at(2.0)) }];
    let pair = scene.add_object_of_members("pair", pair);
    let own = scene.object(object).meshes.clone();
    let members = vec![Member::new(pair, at(10.0)), Member::new(pair, at(20.0))];
    let four = scene.add_object(Object { name: "four".into(), meshes: own, members, ..Object::default() });
    scene.instantiate(four, at(100.0));
    let found_positions = |scene: &Scene| {
        let shown = scene.occurrences().filter(|found| !found.object.meshes.is_empty());
        shown.map(|found| (found.world_from_object.columns[3][0], found.mask)).collect::<Vec<_>>()
    };
    let back = there_and_back(&scene, "t.glb");
    assert_eq!(found_positions(&back), found_positions(&scene), "all of them, with their masks");
    let obj = there_and_back(&scene, "t.obj");
    let triangles = |scene: &Scene| -> usize { scene.meshes().iter().map(|mesh| mesh.indices.len()).sum() };
    let unfolded: usize = scene
        .occurrences()
        .flat_map(|found| &found.object.meshes)
        .map(|&id| scene.mesh(id).indices.len())
        .sum();
    assert_eq!(triangles(&obj), unfolded, "a format without instances has them all");
}

#[test]
fn geometry_comes_back() {
    for name in ["cornell", "spheres", "materials", "textures"] {
        let scene = builtin::load(name).expect("it is built in");
        let expected = area(&scene);
        for file in ["a.obj", "a.ply", "a.gltf", "a.glb"] {
            let found = area(&there_and_back(&scene, file));
            assert!((found / expected - 1.0).abs() < 1e-5, "{name} as {file}: area {found} of {expected}");
        }
    }
}

#[test]
fn masks_come_back() {
    let mut scene = builtin::load("textures").expect("it is built in");
    scene.edit_instance(gnurt_scene::InstanceId(0)).mask = RayMask::CAMERA | RayMask::OTHER;
    let masks = |scene: &Scene| scene.instances().iter().map(|i| i.mask).collect::<Vec<RayMask>>();
    for name in ["out.gltf", "out.glb"] {
        assert_eq!(masks(&there_and_back(&scene, name)), masks(&scene), "{name}");
    }
}

#[test]
fn cameras_lights_and_instances_come_back() {
    let scene = builtin::load("textures").expect("it is built in");
    let back = there_and_back(&scene, "a.glb");
    let (before, after) = (&scene.cameras()[0], &back.cameras()[0]);
    assert_eq!(before.eye, after.eye, "the eye");
    assert!((before.fov_y - after.fov_y).abs() < 1e-4, "the angle of view");
    let (f, g) = (before.frame().expect("a view"), after.frame().expect("a view"));
    assert!((0..3).all(|k| (f.forward[k] - g.forward[k]).abs() < 1e-5), "the direction");
    assert_eq!(back.instances().len(), scene.instances().len(), "instances stay instances");
    assert_eq!(back.lights()[0], scene.lights()[0], "the point light");
}

#[test]
fn cameras_of_all_kinds_come_back() {
    let mut scene = builtin::load("spheres").expect("it is built in");
    let lens = Lens { aperture: 0.25, focus: Some(7.5) };
    let projections = [
        Projection::Perspective,
        Projection::Orthographic { height: 3.5 },
        Projection::Fisheye,
        Projection::Panorama,
    ];
    for projection in projections {
        let shift = if projection.is_flat() { [0.25, -1.5] } else { [0.0; 2] };
        scene.add_camera(Camera { projection, lens, shift, ..scene.cameras()[0].clone() });
    }
    let back = there_and_back(&scene, "a.gltf");
    for (before, after) in scene.cameras().iter().zip(back.cameras()) {
        let rest = |camera: &Camera| (camera.projection, camera.lens, camera.shift);
        assert_eq!(rest(before), rest(after), "{before:?}");
        let reads_angle = matches!(before.projection, Projection::Perspective | Projection::Fisheye);
        assert!(!reads_angle || (before.fov_y - after.fov_y).abs() < 1e-4, "{after:?}");
    }
    assert_eq!(back.cameras().len(), scene.cameras().len(), "all of them");
}

#[test]
fn textures_come_back() {
    let scene = builtin::load("textures").expect("it is built in");
    for file in ["a.obj", "a.gltf", "a.glb"] {
        let back = there_and_back(&scene, file);
        assert_eq!(back.textures()[0].texels, scene.textures()[0].texels, "{file}: every byte");
    }
    let wraps: Vec<_> =
        there_and_back(&scene, "a.glb").textures().iter().map(|t| (t.wrap, t.filter)).collect();
    let expected: Vec<_> = scene.textures().iter().map(|t| (t.wrap, t.filter)).collect();
    assert_eq!(wraps, expected, "samplers");
}

#[test]
fn a_file_that_cannot_be_written_keeps_the_others_from_being_written() {
    let scene = builtin::load("textures").expect("it is built in");
    for (blocked, name) in [("a.mtl", "a.obj"), ("a-0.png", "a.obj"), ("a.bin", "a.gltf"), ("a.obj", "a.obj")]
    {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::create_dir(folder.path().join(blocked)).expect("a folder in the way");
        let line = save(&scene, folder.path().join(name)).expect_err("a folder is in the way").to_string();
        assert!(line.contains(blocked) && line.matches("cannot be written").count() == 1, "{line}");
        let left = std::fs::read_dir(folder.path()).expect("the folder can be listed").count();
        assert_eq!(left, 1, "{name}: nothing but the folder {blocked}");
    }
}

#[test]
fn matte_stays_matte() {
    let scene = builtin::load("cornell").expect("it is built in");
    for file in ["a.obj", "a.glb"] {
        let back = there_and_back(&scene, file);
        for material in scene.materials() {
            let found = back.materials().iter().find(|m| m.name == material.name).expect("its name");
            assert_eq!(found.surface, material.surface, "{} in {file}", material.name);
        }
    }
}

#[test]
fn glass_and_mirrors_come_back() {
    let scene = builtin::load("spheres").expect("it is built in");
    let back = there_and_back(&scene, "a.obj");
    let surface = |name: &str| &back.materials().iter().find(|m| m.name == name).expect("its name").surface;
    assert!(matches!(surface("mirror"), Surface::Mirror { .. }), "a mirror");
    assert!(matches!(surface("glass"), Surface::Dielectric { ior: 1.5, .. }), "glass");
    assert!(matches!(surface("gold"), Surface::MetallicRoughness { metallic: 1.0, .. }), "metal");
}

#[test]
fn layers_come_back() {
    let mut scene = Scene::new();
    let layered = Principled {
        base_color: Color::constant([0.5, 0.25, 0.75]),
        metallic: 0.25,
        roughness: 0.5,
        specular: 0.5,
        specular_color: [1.0, 0.5, 0.25],
        clearcoat: 0.75,
        clearcoat_roughness: 0.125,
        sheen_color: [0.25, 0.5, 0.75],
        sheen_roughness: 0.375,
        transmission: 0.625,
        thin: false,
        interior: Interior {
            attenuation_color: [0.5, 0.75, 1.0],
            attenuation_distance: 0.25,
            dispersion: 0.125,
            scatter_color: [0.5, 0.25, 0.75],
            scatter_anisotropy: 0.25,
        },
        anisotropy: Anisotropy { strength: 0.5, rotation: 0.75, texture: None },
        iridescence: Iridescence { factor: 0.5, ior: 1.25, thickness: 320.0, ..Iridescence::default() },
        diffuse_transmission: DiffuseTransmission { factor: 0.25, color: [1.0, 0.5, 0.25] },
        ..Principled::default()
    };
    let interior = layered.interior;
    let surface = Surface::Principled(Box::new(layered));
    scene.add_material(gnurt_scene::Material::of("layered", surface.clone()));
    let glass =
        Surface::Dielectric { ior: 1.5, reflectance: [1.0; 3], transmittance: [0.5, 1.0, 1.0], interior };
    scene.add_material(gnurt_scene::Material::of("glass", glass.clone()));
    let back = there_and_back(&scene, "a.glb");
    assert_eq!(back.materials()[0].surface, surface, "all of it");
    assert_eq!(back.materials()[1].surface, glass, "and what is within glass");
}

/// A texture of two texels in a row.
fn texture(data: TexelData) -> Texture {
    let texels = Arc::new(Texels { width: 2, height: 1, data });
    Texture { name: "t".into(), texels, wrap: [Wrap::Repeat; 2], filter: Filter::Linear }
}

#[test]
fn measures_stay_linear() {
    let values = vec![[0.5, 0.25, 1.0, 1.0], [0.0, 0.75, 0.125, 1.0]];
    let mut scene = Scene::new();
    let map = TextureRef::new(scene.add_texture(texture(TexelData::Float(values.clone()))));
    let turned = TextureRef { uv_from_mesh: [2.0, 0.0, 0.0, 3.0, 0.25, 0.5], ..map };
    let color = TextureRef::new(scene.add_texture(texture(TexelData::Float(values.clone()))));
    let surface = Surface::MetallicRoughness {
        base_color: Color { factor: [1.0; 3], texture: Some(color) },
        metallic: 0.5,
        roughness: 0.5,
        metallic_roughness_texture: Some(map),
        ior: 1.5,
        normal_texture: Some(NormalMap { texture: turned, scale: 0.5 }),
    };
    scene.add_material(Material::of("m", surface));
    let back = there_and_back(&scene, "a.glb");
    let Surface::MetallicRoughness { base_color, metallic_roughness_texture, normal_texture, .. } =
        &back.materials()[0].surface
    else {
        panic!("{:?}", back.materials()[0].surface);
    };
    let normals = normal_texture.expect("a normal map");
    let close = |a: f32, b: f32| (a - b).abs() < 1e-4;
    let near = normals.texture.uv_from_mesh.iter().zip(turned.uv_from_mesh).all(|(&a, b)| close(a, b));
    assert!(near, "its transform: {:?}", normals.texture.uv_from_mesh);
    let used = [base_color.texture, *metallic_roughness_texture, Some(normals.texture)];
    for (what, used) in ["colour", "roughness", "normals"].into_iter().zip(used) {
        let texels = &back.texture(used.expect(what).texture).texels;
        let is_wide = matches!(texels.data, TexelData::Float(_) | TexelData::Linear16(_));
        assert!(is_wide, "{what}: 16 bits");
        let found = [texels.texel(0, 0), texels.texel(1, 0)];
        let same = found.iter().flatten().zip(values.iter().flatten()).all(|(&a, &b)| close(a, b));
        assert!(same, "{what}: {found:?} is not {values:?}");
    }
}

#[test]
fn cut_outs_survive() {
    let mut scene = Scene::new();
    let color = scene.add_texture(texture(TexelData::Srgb8(vec![[10, 20, 30, 255], [40, 50, 60, 255]])));
    let hole = scene.add_texture(texture(TexelData::Linear8(vec![[0, 9, 9, 255], [255, 9, 9, 255]])));
    let through = |texture: TextureId, channel| Alpha::Blend {
        opacity: Opacity { factor: 1.0, texture: Some(TextureRef::new(texture)), channel },
    };
    let matte = |texture: Option<TextureId>| {
        let base_color = Color { factor: [1.0; 3], texture: texture.map(TextureRef::new) };
        Material::of("m", Surface::Matte { base_color })
    };
    scene.add_material(Material { alpha: through(hole, OpacityChannel::Red), ..matte(Some(color)) });
    scene.add_material(Material { alpha: through(hole, OpacityChannel::Red), ..matte(None) });
    let back = there_and_back(&scene, "a.gltf");
    let texels = |material: usize| {
        let Alpha::Blend { opacity } = back.materials()[material].alpha else { panic!("it blends") };
        assert_eq!(opacity.channel, OpacityChannel::Alpha, "where glTF keeps it");
        assert_eq!(opacity.texture, back.materials()[material].diffuse_color().texture, "one texture");
        back.texture(opacity.texture.expect("a texture").texture).texels.data.clone()
    };
    assert_eq!(texels(0), TexelData::Srgb8(vec![[10, 20, 30, 0], [40, 50, 60, 255]]), "colour and opacity");
    assert_eq!(texels(1), TexelData::Srgb8(vec![[255, 255, 255, 0], [255; 4]]), "white and opacity");
}

fn of(surface: Surface) -> Material {
    Material::of("m", surface)
}

fn plastic(roughness: f32, ior: f32) -> Surface {
    Surface::MetallicRoughness {
        base_color: Color::constant([0.25, 0.5, 0.75]),
        metallic: 0.25,
        roughness,
        metallic_roughness_texture: None,
        ior,
        normal_texture: None,
    }
}

/// A scene of these materials, each on a triangle of its own.
fn scene_of(materials: impl IntoIterator<Item = Material>) -> Scene {
    let mut scene = Scene::new();
    let meshes: Vec<_> = materials
        .into_iter()
        .enumerate()
        .map(|(k, material)| {
            let material = scene.add_material(Material { name: format!("m{k}"), ..material });
            scene.add_mesh(gnurt_scene::Mesh {
                positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                indices: vec![[0, 1, 2]],
                material,
                ..gnurt_scene::Mesh::default()
            })
        })
        .collect();
    let object = scene.add_object_of("o", meshes);
    scene.instantiate(object, Affine::IDENTITY);
    scene
}

#[test]
fn unlit_colours_come_back() {
    let unlit = Surface::Unlit { color: Color::constant([0.5, 0.25, 0.75]) };
    let scene = scene_of([of(unlit.clone())]);
    assert_eq!(there_and_back(&scene, "a.gltf").materials()[0].surface, unlit, "glTF has a word for it");
    let (back, lines, _) = reported(&scene, "a.obj");
    assert_eq!(back.materials()[1].emission, [0.5, 0.25, 0.75], "MTL has lamps");
    assert!(lines.iter().any(|line| line.contains("unlit colour")), "{lines:?}");
}

/// OBJ: the material of this name comes back as it was.
#[test]
fn numbers_of_mtl_come_back() {
    let glass = Surface::RoughDielectric {
        ior: 1.25,
        roughness: 0.5,
        reflectance: [1.0; 3],
        transmittance: [0.5, 1.0, 1.0],
        thin: false,
        interior: Interior::default(),
    };
    let gold = Surface::MetallicRoughness {
        base_color: Color::constant([0.75, 0.5, 0.25]),
        metallic: 1.0,
        roughness: 0.5,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_texture: None,
    };
    // As a metal of MTL's own numbers is read: `Kd` is kept beside it.
    let metal = Material { diffuse: Some(Color::constant([0.0; 3])), ..of(gold.clone()) };
    let scene = scene_of([metal, of(plastic(0.25, 1.25)), of(glass)]);
    let (back, lines, _) = reported(&scene, "a.obj");
    for (before, after) in scene.materials().iter().zip(&back.materials()[1..]) {
        assert_eq!(before.surface, after.surface, "{}", before.name);
    }
    assert!(lines.is_empty(), "nothing is lost: {lines:?}");
}

/// A metal by `Ks`, `Ns` and `illum` comes back with its colour; it came back black.
#[test]
fn a_metal_of_mtl_keeps_its_colour() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mtl = "newmtl gold\nKd 0 0 0\nKs .9 .7 .3\nNs 100\nillum 3\n";
    std::fs::write(folder.path().join("t.mtl"), mtl).expect("a file");
    let path = folder.path().join("t.obj");
    std::fs::write(&path, "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gold\nf 1 2 3\n").expect("a file");
    let scene = load(&path).unwrap_or_else(|e| panic!("{e}")).scene;
    for name in ["a.obj", "a.gltf"] {
        let back = there_and_back(&scene, name);
        let found = back.materials().iter().find(|m| m.name == "gold").expect("its name");
        assert_eq!(found.surface.base_color().factor, [0.9, 0.7, 0.3], "{name}: {found:?}");
    }
}

#[test]
fn normal_maps_clamps_and_bumps_come_back_from_obj() {
    let mut scene = Scene::new();
    let clamped = Texture {
        wrap: [Wrap::ClampToEdge; 2],
        ..texture(TexelData::Linear8(vec![[127, 128, 250, 255]; 2]))
    };
    let map = TextureRef::new(scene.add_texture(clamped));
    let heights = vec![[0.25, 0.25, 0.25, 1.0], [0.5, 0.5, 0.5, 1.0]];
    let bumps = TextureRef::new(scene.add_texture(texture(TexelData::Float(heights))));
    let mut surface = plastic(0.5, 1.5);
    if let Surface::MetallicRoughness { normal_texture, .. } = &mut surface {
        *normal_texture = Some(NormalMap { texture: map, scale: 0.5 });
    }
    scene.add_material(of(surface));
    let bump = gnurt_scene::material::BumpMap { texture: bumps, height: 2.0 };
    let plain = Material { name: "b".into(), bump: Some(bump), ..of(plastic(0.5, 1.5)) };
    scene.add_material(plain);
    let back = there_and_back(&scene, "a.obj");
    let Surface::MetallicRoughness { normal_texture, .. } = &back.materials()[1].surface else {
        panic!("plastic")
    };
    let normals = normal_texture.expect("a normal map");
    assert_eq!(normals.scale, 0.5, "how strong it is");
    assert_eq!(back.texture(normals.texture.texture).wrap, [Wrap::ClampToEdge; 2], "-clamp");
    let bump = back.materials()[2].bump.expect("a bump map");
    let texel = back.texture(bump.texture.texture).texels.texel(0, 0)[0];
    assert!((texel - 0.25).abs() < 1e-4, "heights are linear: {texel}");
}

#[test]
fn vertex_colours_and_odd_names_come_back_from_obj() {
    let mut scene = scene_of([of(plastic(0.5, 1.5))]);
    let material = scene.meshes()[0].material;
    scene.edit_material(material).name = "a\\".into();
    scene.edit_mesh(gnurt_scene::MeshId(0)).colors = vec![[0.25, 0.5, 0.75, 1.0]; 3];
    let back = there_and_back(&scene, "a.obj");
    let found = back.meshes()[0].colors[0];
    assert!((0..3).all(|k| (found[k] - [0.25, 0.5, 0.75][k]).abs() < 1e-5), "{found:?}");
    assert_eq!(back.material(back.meshes()[0].material).surface, plastic(0.5, 1.5), "its material is found");
}

/// Features that a format cannot hold are reported, kind by kind.
#[test]
fn what_is_lost_is_told() {
    let metal = Surface::Metal { eta: [1.0; 3], k: [2.0; 3], roughness: 0.5 };
    let rough = Surface::RoughMatte { base_color: Color::constant([0.5; 3]), roughness: 0.5 };
    let glass = Surface::Dielectric {
        ior: 1.5,
        reflectance: [0.5; 3],
        transmittance: [1.0; 3],
        interior: Interior { dispersion: 0.5, ..Interior::default() },
    };
    let catcher = Surface::ShadowCatcher { albedo: [0.5; 3], radiance: [0.0; 3] };
    let layered = Surface::Principled(Box::new(Principled {
        metallic: 0.0,
        transmission: 0.5,
        specular: 0.5,
        ..Principled::default()
    }));
    let bright = Surface::Matte { base_color: Color::constant([2.0; 3]) };
    let surfaces = [metal, rough, glass, catcher, layered, bright, Surface::Shader(0)];
    let mut scene = scene_of(surfaces.map(of));
    let hdr = scene.add_texture(texture(TexelData::Float(vec![[4.0; 4]; 2])));
    let turned = TextureRef { uv_from_mesh: [0.0, 1.0, -1.0, 0.0, 0.0, 0.0], ..TextureRef::new(hdr) };
    let bump = Some(gnurt_scene::material::BumpMap { texture: turned, height: 1.0 });
    let opacity = Opacity { factor: 0.5, texture: None, channel: OpacityChannel::Red };
    let mask = Alpha::Mask { cutoff: 0.5, opacity };
    scene.add_material(Material { bump, alpha: mask, ..Material::matte("bumpy", [0.5; 3]) });
    let hidden = scene.instantiate(gnurt_scene::ObjectId(0), Affine::IDENTITY);
    scene.edit_instance(hidden).visible = false;
    scene.edit_mesh(gnurt_scene::MeshId(0)).attributes = vec![gnurt_scene::Attribute {
        name: "heat".into(),
        rate: gnurt_scene::Rate::Vertex,
        components: 1,
        data: vec![0.0; 3],
    }];
    let both = [
        "index and extinction of metal",
        "roughness of a matte surface",
        "tint of the reflection of glass",
        "shadow catcher",
        "shader of a material",
        "texture values outside of 0 to 1",
        "hidden instance",
        "attribute of a mesh",
    ];
    let obj = [
        "absorption and dispersion of glass",
        "transmission of a layered material",
        "specular weight",
        "rotation of a texture",
        "alpha cutoff",
    ];
    scene.add_light(Light::Directional { direction: [0.0, -1.0, 0.0], irradiance: [1.0; 3], angle: 0.1 });
    scene.add_light(Light::Spot {
        position: [0.0; 3],
        direction: [0.0, -1.0, 0.0],
        intensity: [1.0; 3],
        inner_angle: 0.3,
        outer_angle: 0.5,
        edge: ConeEdge::Smooth,
        radius: 0.1,
    });
    let gltf = [
        "bump map",
        "base colour above 1",
        "angle of a directional light",
        "radius of a light",
        "smooth edge of a spot",
    ];
    for (name, own) in [("a.obj", &obj[..]), ("a.gltf", &gltf)] {
        let (_, lines, _) = reported(&scene, name);
        for text in both.iter().chain(own) {
            assert!(lines.iter().any(|line| line.contains(text)), "{name}: {text}: {lines:?}");
        }
    }
}

#[test]
fn gltf_lists_what_it_uses() {
    let (_, _, text) = reported(&scene_of([of(plastic(0.5, 1.5))]), "a.gltf");
    assert!(!text.contains("extensionsUsed") && !text.contains("\"extensions\""), "{text}");
    let (_, _, text) =
        reported(&scene_of([of(plastic(0.5, 1.25)), Material::matte("m", [0.5; 3])]), "a.gltf");
    let document: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(
        document["extensionsUsed"],
        serde_json::json!(["KHR_materials_ior", "KHR_materials_specular"])
    );
    let views = document["bufferViews"].as_array().expect("views");
    assert!(
        views.iter().all(|view| [34962, 34963].contains(&view["target"].as_u64().unwrap_or(0))),
        "{text}"
    );
    assert!(!text.contains("\"matrix\""), "no node moves anything: {text}");
    let mut empty = scene_of([of(plastic(0.5, 1.5))]);
    let nothing = empty.add_object_of("nothing", vec![]);
    empty.instantiate(nothing, Affine::IDENTITY);
    let bare = empty.add_mesh(gnurt_scene::Mesh::default());
    let bare = empty.add_object_of("bare", vec![bare]);
    empty.instantiate(bare, Affine::IDENTITY);
    let (back, _, text) = reported(&empty, "a.gltf");
    assert!(!text.contains("\"primitives\": []"), "{text}");
    let document: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let meshes = document["meshes"].as_array().expect("meshes");
    let filled =
        |mesh: &serde_json::Value| mesh["primitives"].as_array().is_some_and(|list| !list.is_empty());
    assert!(meshes.iter().all(filled) && meshes.len() == 1, "{text}");
    assert_eq!(back.instances().len(), 1, "what has triangles");
    let bright = scene_of([of(Surface::Matte { base_color: Color::constant([2.0, 0.5, 0.25]) })]);
    let back = there_and_back(&bright, "a.gltf");
    assert_eq!(back.materials()[0].surface.base_color().factor, [1.0, 0.5, 0.25], "factors stop at 1");
}

/// Scenes of all kinds of channels, written and read again: equal at all times.
#[test]
fn animations_are_written() {
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let folder = tempfile::tempdir().expect("a temporary folder");
    for k in 0..4 {
        let name = format!("chance-{k}.gltf");
        let mut first = crate::common::load(data.join(&name)).expect("a scene").scene;
        assert!(first.animation().is_some_and(|a| !a.clips.is_empty()), "{name} moves");
        for written in ["again.gltf", "again.glb"] {
            let path = folder.path().join(written);
            let warnings = save(&first, &path).expect("written");
            let text = warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
            assert!(!text.contains("animation"), "{name}: {text}");
            let mut second = crate::common::load(&path).unwrap_or_else(|e| panic!("{name}: {e}")).scene;
            let clips = first.animation().map_or(0, |a| a.clips.len());
            assert_eq!(second.animation().map_or(0, |a| a.clips.len()), clips, "{name}: clips");
            for clip in 0..clips {
                for step in 0..5 {
                    let seconds = f64::from(step) * 0.37;
                    first.pose(clip, seconds);
                    second.pose(clip, seconds);
                    let context = format!("{name}, clip {clip} at {seconds}");
                    let (a, b) = (shown(&first), shown(&second));
                    assert_eq!(a.len(), b.len(), "{context}: triangles");
                    for x in &a {
                        let is_same = |y: &Vec<f64>| {
                            x.iter().zip(y).all(|(x, y)| (x - y).abs() < 1e-4 * (1.0 + x.abs()))
                        };
                        assert!(b.iter().any(is_same), "{context}: {x:?} is not among {b:?}");
                    }
                }
            }
        }
    }
}

/// Coordinates of all triangles in the world.
fn shown(scene: &Scene) -> Vec<Vec<f64>> {
    let mut triangles = Vec::new();
    for found in scene.occurrences() {
        for &id in &found.object.meshes {
            let mesh = scene.mesh(id);
            let at = |i: u32| found.world_from_object.point(mesh.positions[i as usize].map(f64::from));
            triangles.extend(mesh.indices.iter().map(|triangle| triangle.map(at).concat()));
        }
    }
    triangles
}
