// SPDX-License-Identifier: GPL-3.0-or-later
//! An open shutter: at each time it shows the scene at that time, bit for bit, with every integrator; a
//! picture is the mean over its times; later commits, open or not, equal fresh worlds.

use std::sync::Arc;

use gnurt_accel::{KeyInterval, MotionPath};
use gnurt_image::Picture;
use gnurt_render::{
    CommitOptions, Integrator, MovingCamera, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
};
use gnurt_scene::animation::Exposure;
use gnurt_scene::{
    Affine, Camera, InstanceId, Light, LightId, Member, Mesh, MeshId, Object, ObjectId, Scene,
};
use gnurt_shading::CameraShader;

use crate::common::*;

const KEYS: usize = 4;

/// A room in which a sheet waves, a lamp sinks, a box turns, and a light passes by.
struct Setup {
    scene: Scene,
    exposure: Exposure,
    cameras: Vec<Camera>,
}

fn camera_at(x: f32) -> Camera {
    Camera {
        name: String::new(),
        eye: [x, 1.0, 6.0],
        target: [0.3 * x, 1.0, 0.0],
        up: [0.0, 1.0, 0.0],
        fov_y: 40.0,
        ..Camera::default()
    }
}

/// The way of the box: a turn and a half in all, by thirds.
fn turned(share: f64) -> Affine {
    let rotated = Affine::rotation([0.0, 1.0, 0.2], share * 3.0 * std::f64::consts::PI);
    Affine::translation([1.1, 0.6 + 0.2 * share, 0.0]) * rotated * Affine::scale([0.5, 0.9, 0.5])
}

fn scratch(lights_move: bool) -> Setup {
    let mut scene = floor(0.6, 4.0);
    let (red, shine) = (matte(&mut scene, [0.8, 0.3, 0.2]), emitter(&mut scene, [25.0, 22.0, 20.0]));
    let wave = |share: f32, material| {
        let mut sheet = quad([-2.2, 0.2, -0.5], [1.6, 0.0, 0.0], [0.0, 1.8, 0.3], material);
        sheet.normals = vec![[0.1, 0.2, 1.0]; 4];
        for (i, p) in sheet.positions.iter_mut().enumerate() {
            p[2] += share * [1.2, -0.8, 0.5, 2.0][i % 4];
            p[1] += 0.3 * share * share;
        }
        for normal in &mut sheet.normals {
            normal[0] -= share;
        }
        sheet
    };
    let share = |key: usize| key as f32 / (KEYS - 1) as f32;
    // Invisible corners fix the scene's bounds, on which the bounds on light depend.
    for corner in [[-9.0_f32, -1.0, -9.0], [9.0, 7.0, 9.0]] {
        put_mesh(&mut scene, quad(corner, [-0.1, 0.0, 0.0], [0.0, -0.1, 0.0], red));
    }
    let sheet = scene.add_mesh(wave(0.0, red));
    let object = scene.add_object_of("sheet", vec![sheet]);
    scene.instantiate(object, Affine::translation([0.1, 0.0, 0.0]));
    let ball = scene.add_mesh(sphere([0.0; 3], 1.0, 6, red));
    let object = scene.add_object_of("box", vec![ball]);
    let turning = scene.instantiate(object, turned(0.0));
    let area_light = scene.add_mesh(quad([-0.5, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], shine));
    let object = scene.add_object_of("lamp", vec![area_light]);
    let sunk = |share: f64| {
        Affine::translation([0.8 * share, 5.0 - 0.7 * share, 0.5])
            * Affine::rotation([1.0, 0.0, 0.0], std::f64::consts::PI)
    };
    let sinking = scene.instantiate(object, sunk(0.0));
    let point = |share: f32| Light::Point {
        position: [3.0 * share - 1.0, 2.0, 2.0],
        intensity: [2.0, 2.0 + share, 3.0],
        radius: 0.0,
    };
    let light = scene.add_light(point(0.0));
    let keys =
        |at: &dyn Fn(f64) -> Affine| -> Vec<Affine> { (0..KEYS).map(|k| at(f64::from(share(k)))).collect() };
    let mut exposure = Exposure {
        meshes: vec![(sheet, (0..KEYS).map(|k| Arc::new(wave(share(k), red))).collect())],
        instances: vec![(turning, keys(&turned))],
        ..Exposure::default()
    };
    if lights_move {
        exposure.instances.push((sinking, keys(&sunk)));
        exposure.lights.push((light, (0..KEYS).map(|k| point(share(k))).collect()));
    }
    Setup { scene, exposure, cameras: (0..KEYS).map(|k| camera_at(share(k))).collect() }
}

impl Setup {
    /// The same with nested objects: boxes in a row, of which the first spins, in a static object; and a
    /// small light that swings in a static one.
    fn with_members(mut self) -> Self {
        let scene = &mut self.scene;
        let [boxes, area_light] = ["box", "lamp"].map(|name| {
            let is_it = |object: &Object| object.name == name;
            ObjectId(scene.objects().iter().position(is_it).expect("the room has it") as u32)
        });
        let spun = |share: f64| {
            let rotated = Affine::rotation([0.3, 1.0, 0.0], share * 5.0);
            Affine::translation([share - 0.5, 0.3 * share, 0.0]) * rotated * Affine::scale([0.4, 0.2, 0.3])
        };
        let aside = Affine::translation([0.9, 0.0, 0.2]) * Affine::scale([0.2; 3]);
        let row = vec![Member::new(boxes, spun(0.0)), Member::new(boxes, aside)];
        let row = scene.add_object_of_members("row", row);
        let tilted = Member::new(row, Affine::rotation([0.0, 0.0, 1.0], 0.3));
        let rows = scene.add_object_of_members("rows", vec![tilted]);
        scene.instantiate(rows, Affine::translation([-0.8, 1.9, 0.4]));
        let swung =
            |share: f64| Affine::translation([0.6 * share, 0.2 * share, 0.0]) * Affine::scale([0.5; 3]);
        let swing = scene.add_object_of_members("swing", vec![Member::new(area_light, swung(0.0))]);
        let above = Affine::translation([-1.4, 5.2, 0.8]) * Affine::rotation([1.0, 0.0, 0.0], 2.6);
        scene.instantiate(swing, above);
        let keys = |at: &dyn Fn(f64) -> Affine| -> Vec<Affine> {
            (0..KEYS).map(|k| at(k as f64 / (KEYS - 1) as f64)).collect()
        };
        self.exposure.members = vec![((row, 0), keys(&spun)), ((swing, 0), keys(&swung))];
        self
    }

    fn world(&self) -> World {
        let mut world = World::new();
        self.commit(&mut world, &self.scene, &self.exposure);
        world
    }

    fn commit(&self, world: &mut World, scene: &Scene, exposure: &Exposure) {
        let how = CommitOptions::default();
        world
            .commit_exposed(scene, exposure, &ShaderTable::default(), &how, &pool(1))
            .expect("a sound scene");
    }

    /// The scene by hand as it is at a moment.
    fn frozen(&self, time: f32) -> Scene {
        let mut scene = self.scene.clone();
        let interval = KeyInterval::of(time, KEYS);
        let mix = |a: &[[f32; 3]], b: &[[f32; 3]]| -> Vec<[f32; 3]> {
            a.iter().zip(b).map(|(a, b)| interval.mix3(*a, *b)).collect()
        };
        for (id, keys) in &self.exposure.meshes {
            let (a, b): (&Mesh, &Mesh) = (&keys[interval.key], &keys[interval.next]);
            let mesh = scene.edit_mesh(MeshId(id.0));
            (mesh.positions, mesh.normals) = (mix(&a.positions, &b.positions), mix(&a.normals, &b.normals));
        }
        let at = |transforms: &[Affine]| {
            let columns: Vec<_> = transforms.iter().map(|placement| placement.columns).collect();
            // Straight ways need two places, and are found by so many.
            let straight =
                transforms.iter().all(|placement| placement.columns[..3] == transforms[0].columns[..3]);
            let some = if straight { vec![columns[0], columns[KEYS - 1]] } else { columns };
            Affine { columns: MotionPath::new(&some).expect("places").at(time) }
        };
        for (id, transforms) in &self.exposure.instances {
            scene.edit_instance(InstanceId(id.0)).world_from_object = at(transforms);
        }
        for ((id, member), transforms) in &self.exposure.members {
            scene.edit_object(*id).members[*member as usize].object_from_member = at(transforms);
        }
        for (id, keys) in &self.exposure.lights {
            let (a, b) = (&keys[interval.key], &keys[interval.next]);
            let (
                Light::Point { position: a, intensity: i, radius: 0.0 },
                Light::Point { position: b, intensity: j, radius: 0.0 },
            ) = (a, b)
            else {
                panic!("a point light");
            };
            *scene.edit_light(LightId(id.0)) = Light::Point {
                position: interval.mix3(*a, *b),
                intensity: interval.mix3(*i, *j),
                radius: 0.0,
            };
        }
        scene
    }

    fn picture(&self, world: &World, camera: &dyn CameraShader, options: &RenderOptions) -> Picture {
        render(world, camera, options, &pool(1), &Silent).expect("sound options").picture
    }

    fn of_integrator(integrator: Integrator, spp: u32) -> RenderOptions {
        RenderOptions { integrator, vpls: 64, max_depth: 4, ..options(24, 18, spp) }
    }
}

#[test]
fn each_moment_is_the_scene_at_that_moment() {
    let scratch = scratch(true).with_members();
    let world = scratch.world();
    let moving = MovingCamera::new(&scratch.cameras).expect("views");
    let all = [
        (Integrator::Eyelight, 1),
        (Integrator::Normals, 1),
        (Integrator::Whitted, 1),
        (Integrator::Path, 2),
        (Integrator::InstantRadiosity, 1),
        (Integrator::BidirectionalInstantRadiosity, 1),
    ];
    for time in [0.0, 0.4, 1.0] {
        let frozen = world_of(&scratch.frozen(time), false);
        let at = world.at(time, &pool(1));
        for (integrator, spp) in all {
            let options = RenderOptions {
                aovs: integrator == Integrator::Path,
                ..Setup::of_integrator(integrator, spp)
            };
            let camera = moving.at(time);
            let (found, expected) =
                (scratch.picture(&at, &camera, &options), scratch.picture(&frozen, &camera, &options));
            let differ = found.color.iter().zip(&expected.color).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "{integrator} at {time}: pixels of {}", found.color.len());
            assert!(mean(&found)[0] > 0.01, "{integrator} at {time} shows something");
        }
    }
}

/// Root of the mean square of differences.
fn difference(a: &Picture, b: &[[f64; 3]]) -> f64 {
    let square =
        |(a, b): (&[f32; 4], &[f64; 3])| (0..3).map(|k| (f64::from(a[k]) - b[k]).powi(2)).sum::<f64>();
    (a.color.iter().zip(b).map(square).sum::<f64>() / (3 * b.len()) as f64).sqrt()
}

#[test]
fn pictures_are_the_mean_of_their_moments() {
    for (lights_move, integrator) in [
        (false, Integrator::Whitted),
        (false, Integrator::Path),
        (true, Integrator::Path),
        (true, Integrator::InstantRadiosity),
    ] {
        let scratch = scratch(lights_move);
        let world = scratch.world();
        let moving = MovingCamera::new(&scratch.cameras).expect("views");
        let options = Setup::of_integrator(integrator, 64);
        let blurred = scratch.picture(&world, &moving, &options);
        let mut sum = vec![[0.0; 3]; blurred.color.len()];
        for i in 0..64 {
            let time = (i as f32 + 0.5) / 64.0;
            let options = RenderOptions { seed: 100 + i, ..Setup::of_integrator(integrator, 2) };
            let one = scratch.picture(&world.at(time, &pool(1)), &moving.at(time), &options);
            for (sum, color) in sum.iter_mut().zip(&one.color) {
                (0..3).for_each(|k| sum[k] += f64::from(color[k]) / 64.0);
            }
        }
        let still = scratch.picture(&world.at(0.0, &pool(1)), &moving.at(0.0), &options);
        let (blur, no_blur) = (difference(&blurred, &sum), difference(&still, &sum));
        let level = mean(&blurred)[0];
        assert!(
            blur < 0.1 * level && 4.0 * blur < no_blur,
            "{integrator}, {lights_move}: {blur}, {no_blur} of {level}"
        );
    }
}

#[test]
fn commits_after_an_open_shutter_are_those_of_fresh_worlds() {
    let scratch = scratch(true).with_members();
    let camera = SceneCamera::new(&scratch.cameras[0]).expect("a view");
    let options = Setup::of_integrator(Integrator::Path, 1);
    let same = |found: &World, expected: &World, what: &str| {
        let [found, expected] =
            [found, expected].map(|world| scratch.picture(world, &camera, &options).color);
        assert_eq!(found, expected, "{what}");
    };
    let mut world = scratch.world();
    same(&world, &scratch.world(), "open");
    let still = Exposure::default();
    scratch.commit(&mut world, &scratch.scene, &still);
    same(&world, &world_of(&scratch.scene, false), "closed again");
    let mut scene = scratch.scene.clone();
    let mut world = World::new();
    scratch.commit(&mut world, &scene, &still);
    scratch.commit(&mut world, &scene, &scratch.exposure);
    same(&world, &scratch.world(), "opened later");
    scene.edit_instance(InstanceId(3)).world_from_object = Affine::translation([0.5, 0.5, 0.5]);
    scene.edit_mesh(MeshId(3)).positions[0][1] += 0.5;
    scratch.commit(&mut world, &scene, &still);
    same(&world, &world_of(&scene, false), "edited, and closed");
    let beyond = Exposure {
        instances: vec![(InstanceId(99), vec![Affine::IDENTITY; 2])],
        meshes: vec![(MeshId(99), vec![Arc::default(); 2])],
        lights: vec![(LightId(99), Vec::new())],
        members: vec![((ObjectId(99), 0), vec![Affine::IDENTITY; 2]), ((ObjectId(0), 7), Vec::new())],
        ..Exposure::default()
    };
    scratch.commit(&mut world, &scene, &beyond);
    same(&world, &world_of(&scene, false), "what is not there does not move");
}
