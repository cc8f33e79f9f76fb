// SPDX-License-Identifier: GPL-3.0-or-later
//! Objects in objects: hits, ids and pictures are those of the scene with all of it unfolded into instances.

use crate::common::*;
use gnurt_accel::Ray;
use gnurt_render::{
    CommitError, CommitOptions, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
};
use gnurt_scene::nesting::{DEEPEST, NestingError};
use gnurt_scene::{Affine, Camera, Instance, Material, Member, MeshId, Object, ObjectId, RayMask, Scene};

fn committed(scene: &Scene) -> World {
    let mut world = World::new();
    let options = CommitOptions::default();
    world.commit(scene, &ShaderTable::default(), &options, &pool(1)).expect("a sound scene");
    world
}

/// The same with an instance for each object that occurs, in the order in which trees number them: members first.
fn unfolded(scene: &Scene) -> Scene {
    let mut flat = Scene::new();
    scene.materials().iter().for_each(|material| _ = flat.add_material(material.clone()));
    scene.meshes().iter().for_each(|mesh| _ = flat.add_mesh(mesh.clone()));
    scene.lights().iter().for_each(|light| _ = flat.add_light(light.clone()));
    for object in scene.objects() {
        flat.add_object(Object { members: Vec::new(), ..object.clone() });
    }
    for instance in scene.instances() {
        unfold(scene, instance, &mut flat);
    }
    flat
}

fn unfold(scene: &Scene, instance: &Instance, flat: &mut Scene) {
    for member in &scene.object(instance.object).members {
        let world_from_object = instance.world_from_object * member.object_from_member;
        let mask = instance.mask & member.mask;
        unfold(scene, &Instance { object: member.object, world_from_object, mask, ..instance.clone() }, flat);
    }
    flat.add_instance(instance.clone());
}

fn turned(x: f64, angle: f64, size: f64) -> Affine {
    let rotated = Affine::rotation([0.2, 1.0, 0.4], angle);
    Affine::translation([x, 0.3 * x, 0.1]) * rotated * Affine::scale([size, -size, 0.8 * size])
}

/// Lamps, glass and grey things, three levels deep, mirrored and scaled unevenly at each.
fn clusters() -> Scene {
    let mut scene = Scene::new();
    let grey = scene.add_material(Material::matte("grey", [0.6; 3]));
    let area_light = scene.add_material(Material { emission: [4.0; 3], ..Material::matte("lamp", [0.3; 3]) });
    let ball = scene.add_mesh(sphere([0.0; 3], 0.5, 8, grey));
    let panel = scene.add_mesh(quad([0.0; 3], [0.4, 0.0, 0.0], [0.0, 0.4, 0.0], area_light));
    let floor = scene.add_mesh(quad([-4.0, -4.0, -1.2], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0], grey));
    let ball = scene.add_object_of("ball", vec![ball]);
    let panel = scene.add_object_of("panel", vec![panel]);
    let floor = scene.add_object_of("floor", vec![floor]);
    let pair = vec![Member::new(ball, turned(-0.5, 0.3, 0.9)), Member::new(panel, turned(0.6, 1.0, 1.0))];
    let pair = scene.add_object_of_members("pair", pair);
    // It has a mesh of its own, too.
    let members = vec![Member::new(pair, turned(-0.7, 0.5, 0.8)), Member::new(pair, turned(0.9, -0.9, 0.6))];
    let own = scene.object(ball).meshes.clone();
    let four = scene.add_object(Object { name: "four".into(), meshes: own, members, ..Object::default() });
    let eight = vec![Member::new(four, turned(-1.0, 0.1, 0.7)), Member::new(four, turned(1.0, 2.0, 0.7))];
    let eight = scene.add_object_of_members("eight", eight);
    scene.instantiate(floor, Affine::IDENTITY);
    scene.instantiate(eight, Affine::IDENTITY);
    scene.instantiate(ball, Affine::translation([0.0, 0.0, 1.5]));
    scene.instantiate(pair, Affine::translation([0.5, -1.5, 1.0]));
    scene.add_light(environment([0.3; 3]));
    scene
}

fn measured(world: &World, integrator: Integrator) -> Vec<[f32; 4]> {
    let camera = Camera {
        eye: [0.0, -6.0, 2.0],
        target: [0.0; 3],
        up: [0.0, 0.0, 1.0],
        fov_y: 45.0,
        ..Camera::default()
    };
    let camera = SceneCamera::new(&camera).expect("a view");
    let options = RenderOptions { integrator, max_depth: 4, ..options(32, 24, 4) };
    render(world, &camera, &options, &pool(1), &Silent).expect("sound options").picture.color
}

/// How many pixels differ by more than rounding.
fn differing(a: &[[f32; 4]], b: &[[f32; 4]]) -> usize {
    let differ =
        |(a, b): &(&[f32; 4], &[f32; 4])| (0..3).any(|k| (a[k] - b[k]).abs() > 1e-3 * (1.0 + a[k].abs()));
    a.iter().zip(b).filter(differ).count()
}

#[test]
fn pictures_are_those_of_the_unfolded_scene() {
    let nested = clusters();
    let (world, flat) = (committed(&nested), committed(&unfolded(&nested)));
    let (found, expected) = (world.stats(), flat.stats());
    assert_eq!(found.instanced_triangles, expected.instanced_triangles, "all triangles occur");
    assert_eq!((found.instances, expected.instances), (4, 2 + 2 * 3 * 2 + 3 + 3), "but few instances");
    for integrator in [
        Integrator::Path,
        Integrator::Whitted,
        Integrator::Eyelight,
        Integrator::BidirectionalInstantRadiosity,
    ] {
        let [found, expected] = [&world, &flat].map(|world| measured(world, integrator));
        let different = differing(&found, &expected);
        assert!(different < 16, "{integrator}: {different} of {} pixels differ", found.len());
        let mean = |picture: &[[f32; 4]]| picture.iter().map(|p| p[1]).sum::<f32>() / picture.len() as f32;
        let (found, expected) = (mean(&found), mean(&expected));
        assert!((found - expected).abs() < 0.01 * expected, "{integrator}: {found} instead of {expected}");
    }
}

#[test]
fn hits_name_the_object_that_was_hit() {
    let nested = clusters();
    let (flat_scene, world) = (unfolded(&nested), committed(&nested));
    let flat = committed(&flat_scene);
    let mut objects = std::collections::BTreeSet::new();
    let mut state = 1_u32;
    let mut number = |low: f32, high: f32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        low + (high - low) * (state >> 8) as f32 / (1 << 24) as f32
    };
    for _ in 0..4000 {
        let from = [number(-3.0, 3.0), number(-3.0, 3.0), 4.0];
        let to = [number(-2.0, 2.0), number(-2.5, 1.5), number(-0.5, 1.5)];
        let ray = Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]));
        let (found, expected) = (world.intersect(&ray), flat.intersect(&ray));
        let (Some(found), Some(expected)) = (found, expected) else {
            assert_eq!(found.is_some(), expected.is_some(), "{ray:?}");
            continue;
        };
        assert!((found.t - expected.t).abs() < 1e-4 * expected.t.max(1.0), "{found:?} {expected:?}");
        assert_eq!((found.leaf_id, found.prim_id), (expected.inst_id, expected.prim_id), "{ray:?}");
        assert_eq!(
            world.object_of(&found),
            flat_scene.instances()[expected.inst_id as usize].object,
            "{found:?}"
        );
        objects.insert(world.object_of(&found));
    }
    assert!(objects.len() == 4, "{objects:?} are hit");
}

#[test]
fn masks_of_members_count() {
    let mut scene = clusters();
    let world = committed(&scene);
    let down = Ray::new([0.0, 0.0, 9.0], [0.0, 0.0, -1.0]);
    let hidden = RayMask::CAMERA;
    let first = world.intersect(&down).expect("the ball above");
    assert_eq!((first.inst_id, world.object_of(&first)), (2, ObjectId(0)), "{first:?}");
    let ball = Member { mask: hidden, ..Member::new(ObjectId(0), Affine::translation([0.0, 0.0, 3.0])) };
    let veil = scene.add_object_of_members("veil", vec![ball]);
    scene.instantiate(veil, Affine::IDENTITY);
    let world = committed(&scene);
    let found = |mask: RayMask| world.intersect(&Ray { mask: mask.0, ..down }).map(|hit| hit.inst_id);
    assert_eq!([found(hidden), found(RayMask::OTHER)], [Some(4), Some(2)], "seen by some rays");
}

#[test]
fn sixteen_levels_and_no_more() {
    let mut scene = Scene::new();
    let grey = scene.add_material(Material::matte("grey", [0.6; 3]));
    scene.add_mesh(sphere([0.0; 3], 0.5, 6, grey));
    let mut object = scene.add_object_of("ball", vec![MeshId(0)]);
    for level in 1..DEEPEST {
        let step = Affine::translation([0.25, 0.0, 0.0]);
        object = scene.add_object_of_members(format!("level {level}"), vec![Member::new(object, step)]);
    }
    scene.instantiate(object, Affine::IDENTITY);
    let mut world = committed(&scene);
    let x = 0.25 * (DEEPEST - 1) as f32;
    let hit =
        world.intersect(&Ray::new([x, 0.0, 5.0], [0.0, 0.0, -1.0])).expect("the ball, fifteen steps away");
    assert!((hit.t - 4.5).abs() < 0.1, "{hit:?}");
    assert_eq!(world.object_of(&hit), ObjectId(0), "at the end of the way");

    let mut commit = |scene: &Scene| {
        world.commit(scene, &ShaderTable::default(), &CommitOptions::default(), &pool(1)).map(|_| ())
    };
    let mut deeper = scene.clone();
    let one_more = deeper.add_object_of_members("one more", vec![Member::new(object, Affine::IDENTITY)]);
    deeper.instantiate(one_more, Affine::IDENTITY);
    let error = commit(&deeper).expect_err("too deep");
    assert!(matches!(error, CommitError::Nesting(NestingError::TooDeep { .. })), "{error}");
    let mut circle = scene.clone();
    circle.edit_object(ObjectId(3)).members.push(Member::new(ObjectId(5), Affine::IDENTITY));
    let error = commit(&circle).expect_err("a circle");
    assert!(error.to_string().contains("holds itself"), "{error}");
    commit(&scene).expect("the world is as it was");
    let flat = Member::new(ObjectId(0), Affine::scale([1.0, 0.0, 1.0]));
    scene.edit_object(ObjectId(1)).members.push(flat);
    let mut world = World::new();
    let report = world.commit(&scene, &ShaderTable::default(), &CommitOptions::default(), &pool(1));
    assert_eq!(
        report.expect("fine but for one").dropped_instances,
        1,
        "what is flat is left out and counted"
    );
}
