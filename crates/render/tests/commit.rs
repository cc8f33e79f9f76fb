// SPDX-License-Identifier: GPL-3.0-or-later
//! Commits do only the necessary work, and survive bad data.

use std::sync::mpsc;
use std::time::Duration;

use crate::common::*;
use gnurt_accel::{Quality, Ray};
use gnurt_render::{
    CommitError, CommitOptions, CommitReport, Integrator, RenderOptions, ShaderTable, Silent, World, render,
};
use gnurt_scene::{Affine, InstanceId, Material, MaterialId, MeshId, Motion, ObjectId, Scene, Surface};

fn update(world: &mut World, scene: &Scene) -> CommitReport {
    let options = CommitOptions::default();
    world.commit(scene, &ShaderTable::default(), &options, &pool(2)).expect("the scene is sound")
}

fn two_balls() -> Scene {
    let mut scene = floor(0.5, 5.0);
    for x in [-1.0, 1.0] {
        put_mesh(&mut scene, sphere([x, 0.0, 1.0], 0.5, 8, MaterialId(0)));
    }
    scene
}

#[test]
fn only_what_changed_is_built() {
    let (mut scene, mut world) = (two_balls(), World::new());
    assert_eq!(update(&mut world, &scene).built_objects, 3, "all at first");
    assert_eq!(update(&mut world, &scene).built_objects, 0, "nothing changed");
    scene.edit_mesh(MeshId(1)).positions.iter_mut().for_each(|p| p[2] += 0.1);
    let report = update(&mut world, &scene);
    assert_eq!((report.built_objects, report.refitted_objects), (0, 1), "one mesh moved");
    let object = scene.edit_object(ObjectId(1));
    object.motion = Motion::Rigid;
    assert_eq!(update(&mut world, &scene).built_objects, 0, "its triangles are the same");
    scene.edit_mesh(MeshId(1)).positions.iter_mut().for_each(|p| p[2] += 0.1);
    assert_eq!(update(&mut world, &scene).built_objects, 1, "what was not to move did");
    scene.edit_instance(InstanceId(2)).world_from_object = Affine::translation([0.0, 0.0, 1.0]);
    scene.edit_material(MaterialId(0)).emission = [1.0; 3];
    assert_eq!(update(&mut world, &scene).built_objects, 0, "instances and materials need no trees");
    scene.instantiate(ObjectId(1), Affine::translation([0.0, 3.0, 0.0]));
    assert_eq!(update(&mut world, &scene).built_objects, 0, "a second instance shares the tree");
    assert_eq!(world.stats().instances, 4, "and is there");
    scene.edit_object(ObjectId(2)).meshes.push(MeshId(1));
    assert_eq!(update(&mut world, &scene).built_objects, 1, "an object got another mesh");
    let forced = CommitOptions { force_diffuse: true, ..CommitOptions::default() };
    world.commit(&scene, &ShaderTable::default(), &forced, &pool(2)).expect("sound");
    assert!(world.stats().triangles > 0, "other options are fine too");
}

#[test]
fn few_rays_get_trees_that_are_soon_built_and_see_the_same() {
    let mut scene = floor(0.5, 5.0);
    put_mesh(&mut scene, sphere([0.0, 0.0, 1.0], 0.5, 64, MaterialId(0)));
    let how = |options: &RenderOptions| CommitOptions::default().for_picture(&scene, options);
    let (few, many) = (how(&options(16, 16, 1)), how(&options(64, 64, 64)));
    assert_eq!((few.quality, many.quality), (Quality::Fast, Quality::Medium));
    let virtual_lights = RenderOptions { integrator: Integrator::InstantRadiosity, ..options(16, 16, 1) };
    assert_eq!(how(&virtual_lights).quality, Quality::Medium, "each sample asks many lights");

    let mut world = World::new();
    let mut built = |how: &CommitOptions| {
        let done = world.commit(&scene, &ShaderTable::default(), how, &pool(2)).expect("sound");
        (done.built_objects, picture_of(&world))
    };
    let (first, soon) = built(&few);
    assert_eq!((first, built(&few).0), (2, 0));
    let (again, late) = built(&many);
    assert_eq!(again, 2, "better trees are built");
    assert_eq!(built(&few).0, 0, "and kept");
    assert!(soon == late, "the picture is the same");
}

fn picture_of(world: &World) -> Vec<[f32; 4]> {
    let camera = camera([0.0, -6.0, 3.0], [0.0; 3], 40.0);
    render(world, &camera, &options(32, 32, 4), &pool(2), &Silent).expect("sound").picture.color
}

#[test]
fn clones_are_snapshots() {
    let (mut scene, mut world) = (two_balls(), World::new());
    update(&mut world, &scene);
    let ray = Ray::new([-1.0, 0.0, 5.0], [0.0, 0.0, -1.0]);
    let before = world.intersect(&ray).expect("the ball's top");
    let snapshot = world.clone();
    scene.edit_instance(InstanceId(1)).visible = false;
    update(&mut world, &scene);
    assert_eq!(snapshot.intersect(&ray), Some(before), "the snapshot keeps the ball");
    let after = world.intersect(&ray).expect("the floor");
    assert_eq!((after.inst_id, after.t), (0, 5.0), "the world lost it");
    assert!(world.occluded(&ray), "something is there");
}

#[test]
fn snapshots_share_arrays_until_they_are_edited() {
    let (mut scene, mut world) = (two_balls(), World::new());
    let holders = |scene: &Scene| std::sync::Arc::strong_count(&scene.meshes()[1]);
    update(&mut world, &scene);
    assert_eq!(holders(&scene), 2, "scene and world hold one mesh, not two");
    let ray = Ray::new([-1.0, 0.0, 5.0], [0.0, 0.0, -1.0]);
    let before = world.intersect(&ray).expect("the ball's top");
    let snapshot = world.clone();
    scene.edit_mesh(MeshId(1)).positions.iter_mut().for_each(|p| p[2] += 1.0);
    assert_eq!(holders(&scene), 1, "an edit copies what others hold");
    update(&mut world, &scene);
    assert_eq!(snapshot.intersect(&ray), Some(before), "the snapshot sees the ball where it was");
    let after = world.intersect(&ray).expect("the ball's top");
    assert!(
        (before.t - after.t - 1.0).abs() < 1e-5,
        "the world sees it where it is: {} {}",
        before.t,
        after.t
    );
}

#[test]
fn hits_name_scene_instances() {
    let (mut scene, mut world) = (two_balls(), World::new());
    scene.edit_instance(InstanceId(0)).visible = false;
    update(&mut world, &scene);
    let hit = world.intersect(&Ray::new([1.0, 0.0, 5.0], [0.0, 0.0, -1.0])).expect("the second ball");
    assert_eq!(hit.inst_id, 2, "invisible instances keep their numbers");
}

#[test]
fn bad_data_is_dropped_and_counted() {
    let (mut scene, mut world) = (two_balls(), World::new());
    let mesh = scene.edit_mesh(MeshId(0));
    mesh.positions.push([f32::NAN; 3]);
    mesh.indices.extend([[0, 1, 4], [0, 0, 1], [0, 1, 99]]);
    scene.instantiate(ObjectId(0), Affine::scale([1.0, 1.0, 0.0]));
    scene.instantiate(ObjectId(0), Affine::translation([f64::NAN, 0.0, 0.0]));
    let report = update(&mut world, &scene);
    assert_eq!(report.dropped_triangles, 3, "NaN, no area, no such vertex");
    assert_eq!(report.dropped_instances, 2, "flat, not finite");
    let picture = frame(&scene, &camera([0.0, -6.0, 3.0], [0.0; 3], 40.0), &options(16, 16, 1)).picture;
    assert!(picture.color.iter().flatten().all(|x| x.is_finite()), "the rest renders");
}

#[test]
fn nothing_at_all() {
    let (scene, mut world) = (Scene::new(), World::new());
    update(&mut world, &scene);
    assert_eq!(world.bounds(), None, "nothing to see");
    let picture = frame(&scene, &camera([0.0, -6.0, 3.0], [0.0; 3], 40.0), &options(16, 16, 1)).picture;
    assert!(picture.color.iter().all(|pixel| *pixel == [0.0; 4]), "black and transparent");
}

#[test]
fn dangling_ids_are_errors() {
    let commit = |scene: &Scene| {
        World::new().commit(scene, &ShaderTable::default(), &CommitOptions::default(), &pool(1)).err()
    };
    let mut scene = two_balls();
    scene.add_material(Material::of("plugin", Surface::Shader(3)));
    assert_eq!(
        commit(&scene),
        Some(CommitError::UnknownShader { material: 1, shader: 3, known: 0 }),
        "no such shader"
    );
    let mut scene = two_balls();
    scene.edit_mesh(MeshId(0)).material = MaterialId(7);
    let expected = CommitError::DanglingId { what: "mesh", index: 0, used: "material", id: 7 };
    assert_eq!(commit(&scene), Some(expected), "no such material");
}

/// Many objects of the same triangles in different poses share structures; hits and later edits behave as for
/// separate objects.
#[test]
fn many_poses_share() {
    let crowd = |motion: Motion| {
        let mut scene = Scene::new();
        scene.add_material(Material::matte("", [0.5; 3]));
        for i in 0..10 {
            let mut mesh = sphere([0.0; 3], 0.5, 75, MaterialId(0));
            bend(&mut mesh.positions, 0.1 * (i % 5) as f32);
            put_mesh(&mut scene, mesh);
            scene.edit_instance(InstanceId(i)).world_from_object =
                Affine::translation([f64::from(i), 0.0, 0.0]);
            scene.edit_object(ObjectId(i)).motion = motion;
        }
        scene
    };
    let (mut crowd_world, mut separate_world) = (crowd(Motion::Auto), crowd(Motion::Static));
    let (mut shared, mut separate) = (World::new(), World::new());
    update(&mut shared, &crowd_world);
    update(&mut separate, &separate_world);
    let bytes = |world: &World| world.stats().tree_bytes;
    assert!(3 * bytes(&shared) < bytes(&separate), "{} and {} bytes", bytes(&shared), bytes(&separate));
    let view = |world: &World| -> Vec<_> {
        let ray = |i: u8| Ray::new([f32::from(i) * 0.05, 0.11, 3.0], [0.01, 0.02, -1.0]);
        (0..200).map(|i| world.intersect(&ray(i))).collect()
    };
    assert_eq!(view(&shared), view(&separate), "the same hits");
    let (snapshot, before) = (shared.clone(), view(&shared));
    for scene in [&mut crowd_world, &mut separate_world] {
        for i in [2, 3] {
            bend(&mut scene.edit_mesh(MeshId(i)).positions, -0.4);
        }
    }
    let report = update(&mut shared, &crowd_world);
    assert_eq!((report.built_objects, report.refitted_objects), (0, 2), "two have moved on");
    update(&mut separate, &separate_world);
    assert_eq!(view(&shared), view(&separate), "the same hits again");
    assert_eq!(view(&snapshot), before, "a frame in flight keeps its poses");
    let bad = |scene: &mut Scene| scene.edit_mesh(MeshId(4)).positions[99] = [f32::NAN; 3];
    bad(&mut crowd_world);
    bad(&mut separate_world);
    let report = update(&mut shared, &crowd_world);
    assert_eq!((report.built_objects, report.refitted_objects), (1, 0), "it gets a tree by itself");
    assert_eq!(
        update(&mut separate, &separate_world).dropped_triangles,
        report.dropped_triangles,
        "and is counted"
    );
    assert_eq!(view(&shared), view(&separate), "with the same hits");
}

/// Many objects of two kinds, built side by side by more threads than there are processors.
#[test]
fn many_threads_commit_many_poses() {
    let (done, ended) = mpsc::channel();
    // A static object cannot be joined.
    std::thread::spawn(move || {
        let pool = pool(16);
        for round in 0..3 {
            let mut scene = Scene::new();
            scene.add_material(Material::matte("", [0.5; 3]));
            for i in 0..48 {
                let mut mesh = sphere([0.0; 3], 0.5, [50, 60][i % 2], MaterialId(0));
                bend(&mut mesh.positions, 0.02 * (i + round) as f32);
                put_mesh(&mut scene, mesh);
            }
            let mut world = World::new();
            let options = CommitOptions::default();
            let report = world.commit(&scene, &ShaderTable::default(), &options, &pool);
            done.send(report.expect("the scene is sound").built_objects).expect("somebody waits");
        }
    });
    for _ in 0..3 {
        let built = ended.recv_timeout(Duration::from_secs(120)).expect("no commit stands still for ever");
        assert_eq!(built, 48, "all of them");
    }
}

fn bend(positions: &mut [[f32; 3]], angle: f32) {
    for p in positions {
        let (sin, cos) = (angle * p[1]).sin_cos();
        *p = [cos * p[0] - sin * p[2], p[1] + 0.2 * angle * p[0], sin * p[0] + cos * p[2]];
    }
}
