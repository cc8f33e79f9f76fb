// SPDX-License-Identifier: GPL-3.0-or-later
//! The built-in scenes: complete, clean, and as large as they say.

use gnurt_scene::io::{ErrorKind, FORMATS, LoadOptions};
use gnurt_scene::{Light, builtin};

#[test]
fn every_scene_is_complete() {
    for known in builtin::ALL {
        let scene = builtin::load(known.name).expect("it has this name");
        let name = known.name;
        assert!(!scene.cameras().is_empty(), "{name} has a camera");
        assert!(scene.cameras()[0].frame().is_some_and(|f| !f.up_replaced), "{name}'s camera can be used");
        let emits = scene.materials().iter().any(gnurt_scene::Material::emits);
        assert!(emits || !scene.lights().is_empty(), "{name} has a light");
        scene.check().unwrap_or_else(|e| panic!("{name}: {e}"));
        for mesh in scene.meshes() {
            for t in &mesh.indices {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize].map(f64::from));
                let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
                let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                assert!(
                    cross.iter().any(|x| x.abs() > 0.0),
                    "{name}: {} has a triangle without area",
                    mesh.name
                );
            }
        }
        for instance in scene.instances() {
            assert!(
                instance.world_from_object.inverse().is_some(),
                "{name}: {} can be placed",
                instance.name
            );
        }
        for light in scene.lights() {
            if let Light::Directional { direction, .. } = light {
                let length = direction.iter().map(|x| x * x).sum::<f32>();
                assert!((length - 1.0).abs() < 0.01, "{name}: a sun's direction is a unit vector: {length}");
            }
        }
    }
}

#[test]
fn the_showpiece_is_large() {
    let scene = builtin::load("island").expect("the showpiece");
    let stored: usize = scene.meshes().iter().map(|m| m.indices.len()).sum();
    let visible_triangles: usize = scene
        .instances()
        .iter()
        .flat_map(|i| &scene.object(i.object).meshes)
        .map(|&m| scene.mesh(m).indices.len())
        .sum();
    assert!(stored >= 100_000, "triangles in memory: {stored}");
    assert!(visible_triangles >= 1_000_000, "triangles in sight: {visible_triangles}");
    assert!(scene.instances().len() >= 3000, "instances: {}", scene.instances().len());
}

#[test]
fn names_are_checked() {
    let load_source = |name| FORMATS.load_source(name, &LoadOptions::default());
    assert!(load_source("builtin:cornell").is_ok(), "a good name");
    let error = load_source("builtin:cornel").expect_err("a bad name");
    assert_eq!(error.kind, ErrorKind::UnknownName, "the caller's mistake");
    let message = error.to_string();
    assert!(message.contains("did you mean `builtin:cornell`?"), "the nearest: {message}");
    assert!(message.contains("island, cornell, spheres, materials, textures"), "all: {message}");
}

#[test]
fn trees_move_in_the_wind() {
    let mut scene = builtin::load("wind").expect("it has this name");
    let still = builtin::load("island").expect("it has this name");
    assert_eq!(scene.instances().len(), still.instances().len(), "the same island");
    for (a, b) in scene.instances().iter().zip(still.instances()) {
        let [a, b] = [a, b].map(|instance| instance.world_from_object.columns);
        let near = a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near, "at rest trees stand as they do on the island: {a:?}, {b:?}");
    }
    let clip = &scene.animation().expect("an animation").clips[0];
    let [first, last] = clip.range();
    let trees = clip.channels.len();
    assert!(trees > 3000 && first == 0.0, "{trees} trees from {first} s on");
    scene.pose(0, first);
    let begin = scene.instances().to_vec();
    assert_eq!(scene.pose(0, 0.4 * last).instances, trees, "all of them move");
    scene.pose(0, last);
    for (a, b) in begin.iter().zip(scene.instances()) {
        let [a, b] = [a, b].map(|instance| instance.world_from_object.columns);
        let near = a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(near, "after the last key trees are where they began");
    }
}
