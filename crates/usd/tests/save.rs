// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes written as layers and read back. The judge reads what is written with OpenUSD.

use gnurt_scene::io::LoadOptions;
use gnurt_scene::{Affine, Camera, CurveBasis, CurveForm, Curves, Light, Material, Mesh, Primitives, Scene};
use openusd::usdc::CrateFile;

use crate::support::{FORMATS, Folder, warnings};

fn scene() -> Scene {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::matte("a red one", [0.8, 0.1, 0.1]));
    let mesh = scene.add_mesh(Mesh {
        name: "tri/angle".into(),
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        texcoords: vec![[0.0, 0.5]; 3],
        indices: vec![[0, 1, 2]],
        material,
        ..Mesh::default()
    });
    let object = scene.add_object_of("thing", vec![mesh]);
    scene.instantiate(object, Affine::translation([1.0, 2.0, 3.0]) * Affine::rotation([1.0, 0.0, 0.0], 0.5));
    scene.instantiate(object, Affine::translation([0.0, 0.0, -5.0]));
    scene.add_camera(Camera {
        eye: [0.0, 1.0, 5.0],
        target: [0.0, 1.0, 0.0],
        fov_y: 33.0,
        shift: [0.25, -0.5],
        ..Camera::default()
    });
    scene.add_light(Light::Point { position: [1.0, 2.0, 3.0], intensity: [4.0, 5.0, 6.0], radius: 0.0 });
    scene.add_light(Light::Directional {
        direction: [0.0, -1.0, 0.0],
        irradiance: [2.0, 1.0, 0.5],
        angle: 0.1,
    });
    scene.add_light(Light::Environment {
        radiance: [0.25; 3],
        texture: None,
        world_from_light: Affine::IDENTITY,
    });
    scene
}

/// A scene after it was written and read, both without a warning.
fn saved_and_read(before: &Scene, name: &str) -> Scene {
    let folder = Folder::with(&[]);
    let reported = FORMATS.save(before, folder.path(name)).unwrap_or_else(|error| panic!("{error}"));
    assert!(reported.is_empty(), "{name}: {reported:?}");
    let loaded = folder.load(name, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(warnings(&loaded), "", "{name}");
    loaded.scene
}

#[test]
fn both_forms_come_back() {
    let before = scene();
    for name in ["a.usda", "a.usdc", "b.usd"] {
        let after = &saved_and_read(&before, name);
        assert_eq!((after.meshes().len(), after.instances().len()), (1, 2), "{name}: one mesh, shown twice");
        let [old, new] = [&before.meshes()[0], &after.meshes()[0]];
        assert_eq!(
            (&old.positions, &old.normals, &old.texcoords),
            (&new.positions, &new.normals, &new.texcoords)
        );
        for (a, b) in before.instances().iter().zip(after.instances()) {
            let far = a
                .world_from_object
                .columns
                .as_flattened()
                .iter()
                .zip(b.world_from_object.columns.as_flattened());
            assert!(far.clone().all(|(a, b)| (a - b).abs() < 1e-9), "{name}: {a:?} {b:?}");
        }
        let (a, b) = (&before.cameras()[0], &after.cameras()[0]);
        assert!((a.fov_y - b.fov_y).abs() < 1e-3 && a.eye == b.eye, "{name}: {b:?}");
        assert!(a.shift.iter().zip(b.shift).all(|(a, b)| (a - b).abs() < 1e-5), "{name}: {:?}", b.shift);
        let [
            Light::Point { intensity, .. },
            Light::Directional { direction, irradiance, angle },
            Light::Environment { radiance, .. },
        ] = after.lights()
        else {
            panic!("{name}: {:?}", after.lights())
        };
        assert!((intensity[0] - 4.0).abs() < 1e-4 && (irradiance[0] - 2.0).abs() < 1e-5, "{name}");
        assert!((angle - 0.1).abs() < 1e-5, "{name}: {angle}");
        assert!(direction[1] < -0.999 && *radiance == [0.25; 3], "{name}: {direction:?} {radiance:?}");
        assert_eq!(after.material(new.material).name, "a_red_one", "{name}");
    }
}

/// Triangles beside one another.
fn strip(triangles: u32) -> Scene {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::matte("grey", [0.5; 3]));
    let mesh = scene.add_mesh(Mesh {
        positions: (0..triangles + 2).map(|k| [k as f32, (k % 2) as f32, 0.0]).collect(),
        indices: (0..triangles).map(|k| [k, k + 1, k + 2]).collect(),
        material,
        ..Mesh::default()
    });
    let object = scene.add_object_of("strip", vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
    scene
}

#[test]
fn openusd_reads_the_types_of_binary_layers() {
    const TOKENS: u64 = 0x800b;
    const NAMES: u64 = 41;
    const INT: u64 = 3;
    for triangles in [1, 2, 5, 6, 15, 16, 40] {
        let before = strip(triangles);
        let folder = Folder::with(&[]);
        FORMATS.save(&before, folder.path("a.usdc")).unwrap_or_else(|error| panic!("{error}"));
        let bytes = std::fs::read(folder.path("a.usdc")).expect("the layer");
        let layer = CrateFile::open(std::io::Cursor::new(&bytes)).expect("a binary layer");
        layer.validate().expect("a valid layer");
        let (mut lists, mut arrays) = (0, 0);
        for field in &layer.fields {
            let (name, value) = (&*layer.tokens[field.token_index], field.value_rep);
            let kind = value.0 >> 48;
            match name {
                "primChildren" | "properties" => {
                    lists += 1;
                    assert_eq!(kind, NAMES, "{name}");
                }
                "default" if kind & 0xff == INT && value.is_array() => {
                    arrays += 1;
                    let count = bytes[value.payload() as usize];
                    assert_eq!(value.is_compressed(), count >= 16, "{count} integers");
                }
                // Values of attributes stay arrays.
                "default" => assert_ne!(kind, NAMES),
                _ => assert_ne!(kind, TOKENS, "{name}"),
            }
        }
        assert!(lists >= 4 && arrays == 2, "{lists} lists, {arrays} arrays");
        let after = folder.load("a.usdc", &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(warnings(&after), "");
        assert_eq!(after.scene.meshes()[0].indices, before.meshes()[0].indices);
    }
}

#[test]
fn packages_are_not_written() {
    let folder = Folder::with(&[]);
    let error = FORMATS.save(&scene(), folder.path("a.usdz")).expect_err("no package").to_string();
    assert!(error.contains(".usdc"), "{error}");
}

/// Two strands of each basis, and spheres, one object each.
fn strands() -> Scene {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::matte("hair", [0.2, 0.1, 0.05]));
    let vertex = |k: usize| [k as f32, (k * k % 7) as f32, (k % 3) as f32 * 0.25];
    let cases = [
        (CurveBasis::Linear, CurveForm::Round, [3, 2]),
        (CurveBasis::Bezier, CurveForm::Oriented, [7, 4]),
        (CurveBasis::BSpline, CurveForm::Round, [6, 4]),
        (CurveBasis::CatmullRom, CurveForm::Round, [5, 4]),
    ];
    for (basis, form, lengths) in cases {
        let count = lengths.iter().sum();
        let mut curves = Curves::of_strands(basis, form, lengths);
        curves.radii = (0..count).map(|k| 0.01 + 0.125 * k as f32).collect();
        let is_ribbon = form == CurveForm::Oriented;
        let mesh = scene.add_mesh(Mesh {
            name: format!("{basis:?}"),
            positions: (0..count).map(vertex).collect(),
            normals: if is_ribbon { (0..count).map(|_| [0.0, 0.0, 1.0]).collect() } else { Vec::new() },
            primitives: Primitives::Curves(Box::new(curves)),
            material,
            ..Mesh::default()
        });
        let object = scene.add_object_of("strands", vec![mesh]);
        scene.instantiate(object, Affine::translation([0.0, 1.0, 0.0]));
    }
    let grey = scene.add_material(Material::matte("", [1.0; 3]));
    let mesh = scene.add_mesh(Mesh {
        positions: (0..5).map(vertex).collect(),
        colors: (0..5).map(|k| [k as f32 / 4.0, 0.5, 0.0, 1.0]).collect(),
        primitives: Primitives::Spheres(vec![0.5, 0.25, 1.0, 2.0, 0.125]),
        material: grey,
        ..Mesh::default()
    });
    let object = scene.add_object_of("dots", vec![mesh]);
    for k in 0..2 {
        scene.instantiate(object, Affine::translation([0.0, f64::from(k), 9.0]));
    }
    scene
}

#[test]
fn curves_and_spheres_come_back() {
    let before = strands();
    for name in ["a.usda", "a.usdc"] {
        let after = &saved_and_read(&before, name);
        assert_eq!(after.instances().len(), 6, "{name}: the dots are shown twice");
        for (old, new) in before.instances().iter().zip(after.instances()) {
            let mesh = |scene: &Scene, object: gnurt_scene::ObjectId| {
                scene.mesh(*scene.object(object).meshes.first().expect("a mesh")).clone()
            };
            let (old, new) = (mesh(&before, old.object), mesh(after, new.object));
            assert_eq!(old.primitives, new.primitives, "{name}: radii, basis, form, segments");
            assert_eq!((&old.positions, &old.normals), (&new.positions, &new.normals), "{name}");
        }
    }
}

/// Segments without spans are strands of their own; ribbons that face rays have no counterpart.
#[test]
fn segments_alone_are_curves_of_their_own() {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::matte("", [0.5; 3]));
    let mut curves = Curves::of_strands(CurveBasis::Linear, CurveForm::Flat, [4]);
    (curves.radii, curves.spans) = (vec![0.1; 4], Vec::new());
    let positions = (0..4).map(|k| [k as f32, 0.0, 0.0]).collect();
    let primitives = Primitives::Curves(Box::new(curves));
    let mesh = scene.add_mesh(Mesh { positions, primitives, material, ..Mesh::default() });
    let object = scene.add_object_of("grass", vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
    let folder = Folder::with(&[]);
    let reported = FORMATS.save(&scene, folder.path("a.usda")).unwrap_or_else(|error| panic!("{error}"));
    let reported: Vec<String> = reported.iter().map(ToString::to_string).collect();
    assert!(reported.len() == 1 && reported[0].contains("tubes"), "{reported:?}");
    let text = std::fs::read_to_string(folder.path("a.usda")).expect("the layer");
    assert!(text.contains("int[] curveVertexCounts = [2, 2, 2]"), "{text}");
}
