// SPDX-License-Identifier: GPL-3.0-or-later
//! Changes of a scene by names.

use gnurt_scene::material::{Alpha, Material, Surface};
use gnurt_scene::overrides::Override;
use gnurt_scene::{Affine, Light, Mesh, Scene};

fn scene() -> Scene {
    let mut scene = Scene::new();
    let gold = scene.add_material(Material::matte("gold.old", [0.5; 3]));
    scene.add_material(Material::matte("grey", [0.5; 3]));
    scene.add_light(Light::Point { position: [0.0; 3], intensity: [2.0, 4.0, 1.0] });
    let mesh = Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        indices: vec![[0, 1, 2]],
        material: gold,
        ..Mesh::default()
    };
    let mesh = scene.add_mesh(mesh);
    let object = scene.add_object_of("chair", vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
    scene
}

fn changed(text: &str) -> Result<Scene, String> {
    let mut scene = scene();
    let change: Override = text.parse().map_err(|error| format!("{error}"))?;
    change.apply(&mut scene).map_err(|error| error.to_string())?;
    Ok(scene)
}

#[test]
fn parts_change_by_their_names() {
    let scene = changed("materials.gold.old.roughness=0.25").expect("a material");
    let [gold, grey] = scene.materials() else { panic!("two") };
    let Surface::Principled(principled) = &gold.surface else { panic!("{gold:?}") };
    assert_eq!(
        (principled.roughness, principled.specular, principled.metallic),
        (0.25, 0.0, 0.0),
        "still matte"
    );
    assert!(matches!(grey.surface, Surface::Matte { .. }), "{grey:?}");
    let scene = changed("materials.*.color=1,0.5,0.25").expect("all");
    assert!(scene.materials().iter().all(|m| m.surface.base_color().factor == [1.0, 0.5, 0.25]));
    let scene = changed("materials.grey.opacity=0.5").expect("blended");
    assert!(matches!(scene.materials()[1].alpha, Alpha::Blend { opacity } if opacity.factor == 0.5));
    let intensity = |text: &str| match changed(text).expect(text).lights() {
        [Light::Point { intensity, .. }] => *intensity,
        other => panic!("{other:?}"),
    };
    assert_eq!(intensity("lights.0.intensity=8"), [4.0, 8.0, 2.0], "of the same colour");
    assert_eq!(intensity("lights.*.scale=0.5"), [1.0, 2.0, 0.5]);
    assert_eq!(intensity("lights.0.color=1,0,0.5"), [4.0, 0.0, 2.0], "as strong as before");
    assert!(!changed("instances.chair.visible=false").expect("hidden").instances()[0].visible);
}

#[test]
fn mistakes_say_what_would_be_right() {
    for (text, part) in [
        ("gold=1", "materials.gold.roughness=0.3"),
        ("stones.a.b=1", "parts are materials, lights, instances"),
        ("materials.gold.roughness=red", "one number, or three"),
        ("materials.gold.roughness=1,2", "one number, or three"),
        ("materials.silver.roughness=0.3", "nothing has this name; there are gold.old, grey"),
        ("materials.grey.roughness=3", "expected a number from 0 to 1"),
        ("materials.grey.shine=1", "unknown property; valid are color"),
        ("lights.0.roughness=1", "unknown property; valid are color, intensity, scale"),
        ("instances.chair.visible=3", "expected true or false"),
    ] {
        let error = changed(text).expect_err(text);
        assert!(error.contains(part), "{text}: {error}");
    }
}
