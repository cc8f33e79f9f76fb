// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts that are not due are the very same after a commit.

use std::sync::Arc;

use gnurt_image::{TexelData, Texels};
use gnurt_scene::material::Color;
use gnurt_scene::texture::{Filter, Texture, Wrap};
use gnurt_scene::{
    Affine, InstanceId, Light, LightId, Material, MaterialId, Mesh, MeshId, Scene, Surface, TextureId,
};
use gnurt_shading::lights::EnvironmentLight;

use super::*;

fn triangle(material: MaterialId, z: f32, size: f32) -> Mesh {
    let positions = vec![[-size, -size, z], [size, -size, z], [0.0, size, z]];
    Mesh { positions, indices: vec![[0, 1, 2]], material, ..Mesh::default() }
}

/// An object and a light between two others, a sky with a picture and a point light.
fn scene() -> Scene {
    let mut scene = Scene::new();
    let grey = scene.add_material(Material::matte("grey", [0.5; 3]));
    let white = scene.add_material(Material::matte("white", [0.8; 3]));
    let shining = Material { emission: [1.0; 3], ..Material::matte("lamp", [0.0; 3]) };
    let shining = scene.add_material(shining);
    let things = [(grey, 0.0, 1.0), (shining, 9.0, 1.0), (white, -20.0, 5.0), (white, 20.0, 5.0)];
    for (material, z, size) in things {
        let mesh = scene.add_mesh(triangle(material, z, size));
        let object = scene.add_object_of("", vec![mesh]);
        scene.instantiate(object, Affine::IDENTITY);
    }
    let data = TexelData::Float((0..32).map(|i| [i as f32, 1.0, 0.5, 1.0]).collect());
    let texels = Arc::new(Texels { width: 8, height: 4, data });
    let (wrap, filter) = ([Wrap::Repeat; 2], Filter::Linear);
    let texture = scene.add_texture(Texture { name: String::new(), texels, wrap, filter });
    let world_from_light = Affine::IDENTITY;
    scene.add_light(Light::Environment { radiance: [1.0; 3], texture: Some(texture), world_from_light });
    scene.add_light(Light::Point { position: [0.5, 0.5, 5.0], intensity: [1.0; 3], radius: 0.0 });
    scene
}

/// Which parts two worlds share.
#[derive(Debug, PartialEq)]
struct Shared {
    objects: bool,
    top_tree: bool,
    grey: bool,
    emitter_choice: bool,
    triangles: bool,
    light_tree: bool,
    lights: bool,
    environment: bool,
    distribution: bool,
}

const ALL: Shared = Shared {
    objects: true,
    top_tree: true,
    grey: true,
    emitter_choice: true,
    triangles: true,
    light_tree: true,
    lights: true,
    environment: true,
    distribution: true,
};

fn shared(a: &World, b: &World) -> Shared {
    let object = |world: &World, id: usize| world.objects[id].object.clone().expect("it is shown");
    let shader = |id| Arc::ptr_eq(&a.materials.get(id).shader, &b.materials.get(id).shader);
    let sky = |world: &World| world.lights.own_environment().expect("a sky").clone();
    let distribution = match (sky(a), sky(b)) {
        (EnvironmentLight::Picture(a), EnvironmentLight::Picture(b)) => a.shares_distribution(&b),
        _ => false,
    };
    Shared {
        objects: (0..2).all(|id| Arc::ptr_eq(&object(a, id).tree, &object(b, id).tree)),
        top_tree: Arc::ptr_eq(&a.tree, &b.tree),
        grey: shader(0),
        emitter_choice: shader(2),
        triangles: Arc::ptr_eq(&a.lights.emitters, &b.lights.emitters),
        light_tree: a.light_set().shares_tree(b.light_set()),
        lights: Arc::ptr_eq(&a.lights, &b.lights),
        environment: sky(a).is(&sky(b)),
        distribution,
    }
}

#[test]
fn an_edit_touches_its_part() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
    let (mut scene, mut world) = (scene(), World::new());
    let mut check = |scene: &Scene, requested: Shared, what: &str| {
        let before = world.clone();
        // Made at first use, so that it can be shared.
        let _ = before.light_set();
        let done = world.commit(scene, &ShaderTable::default(), &CommitOptions::default(), &pool);
        done.expect("the scene is sound");
        if what != "all" {
            assert_eq!(shared(&before, &world), requested, "{what}");
        }
    };
    check(&scene, ALL, "all");
    check(&scene, ALL, "nothing");
    scene.edit_material(MaterialId(0)).surface = Surface::Matte { base_color: Color::constant([0.1; 3]) };
    check(&scene, Shared { grey: false, ..ALL }, "a shader's parameter");
    scene.edit_material(MaterialId(2)).surface = Surface::Matte { base_color: Color::constant([0.1; 3]) };
    check(&scene, Shared { emitter_choice: false, ..ALL }, "how the lamp's surface reflects");
    scene.edit_instance(InstanceId(0)).world_from_object.columns[0][0] = 0.5;
    check(&scene, Shared { top_tree: false, ..ALL }, "a matrix, within the box of all");
    scene.edit_instance(InstanceId(0)).world_from_object.columns[3][2] = -50.0;
    let moved = || Shared { top_tree: false, lights: false, ..ALL };
    check(&scene, moved(), "a matrix: what is far away lights a larger ball");
    scene.edit_instance(InstanceId(1)).world_from_object.columns[3][2] = -1.0;
    let lamp_moved = || Shared { top_tree: false, triangles: false, light_tree: false, lights: false, ..ALL };
    check(&scene, lamp_moved(), "the lamp's matrix");
    scene.edit_mesh(MeshId(1)).positions[0][0] = 0.1;
    check(&scene, Shared { objects: false, ..lamp_moved() }, "the lamp's mesh");
    scene.edit_mesh(MeshId(0)).positions[0][0] = 0.1;
    check(&scene, Shared { objects: false, top_tree: false, ..ALL }, "a mesh");
    scene.edit_material(MaterialId(2)).emission = [2.0; 3];
    let brighter =
        Shared { emitter_choice: false, triangles: false, light_tree: false, lights: false, ..ALL };
    check(&scene, brighter, "what the lamp gives off");
    if let Light::Point { position, .. } = scene.edit_light(LightId(1)) {
        position[0] = 0.1;
    }
    check(&scene, Shared { light_tree: false, lights: false, ..ALL }, "a point light");
    if let Light::Environment { radiance, .. } = scene.edit_light(LightId(0)) {
        *radiance = [2.0; 3];
    }
    check(&scene, Shared { lights: false, environment: false, ..ALL }, "a brighter sky");
    let texture = scene.edit_texture(TextureId(0));
    texture.texels = Arc::new((*texture.texels).clone());
    let other_sky = Shared { lights: false, environment: false, distribution: false, ..ALL };
    check(&scene, other_sky, "another picture of the sky");
}
