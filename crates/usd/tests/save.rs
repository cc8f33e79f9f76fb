// SPDX-License-Identifier: GPL-3.0-or-later
//! Scenes written as layers and read back. The judge reads what is written with OpenUSD.

use gnurt_scene::io::LoadOptions;
use gnurt_scene::{Affine, Camera, Light, Material, Mesh, Scene};

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
        ..Camera::default()
    });
    scene.add_light(Light::Point { position: [1.0, 2.0, 3.0], intensity: [4.0, 5.0, 6.0] });
    scene.add_light(Light::Directional { direction: [0.0, -1.0, 0.0], irradiance: [2.0, 1.0, 0.5] });
    scene.add_light(Light::Environment {
        radiance: [0.25; 3],
        texture: None,
        world_from_light: Affine::IDENTITY,
    });
    scene
}

#[test]
fn both_forms_come_back() {
    let before = scene();
    for name in ["a.usda", "a.usdc", "b.usd"] {
        let folder = Folder::with(&[]);
        let told = FORMATS.save(&before, folder.path(name)).unwrap_or_else(|error| panic!("{error}"));
        assert!(told.is_empty(), "{name}: {told:?}");
        let loaded = folder.load(name, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(warnings(&loaded), "", "{name}");
        let after = &loaded.scene;
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
        let [
            Light::Point { intensity, .. },
            Light::Directional { direction, irradiance },
            Light::Environment { radiance, .. },
        ] = after.lights()
        else {
            panic!("{name}: {:?}", after.lights())
        };
        assert!((intensity[0] - 4.0).abs() < 1e-4 && (irradiance[0] - 2.0).abs() < 1e-5, "{name}");
        assert!(direction[1] < -0.999 && *radiance == [0.25; 3], "{name}: {direction:?} {radiance:?}");
        assert_eq!(after.material(new.material).name, "a_red_one", "{name}");
    }
}

#[test]
fn packages_are_not_written() {
    let folder = Folder::with(&[]);
    let error = FORMATS.save(&scene(), folder.path("a.usdz")).expect_err("no package").to_string();
    assert!(error.contains(".usdc"), "{error}");
}
