// SPDX-License-Identifier: GPL-3.0-or-later
//! Velocity of surface points and the length of the open shutter, compared with closed forms.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use gnurt_render::{CommitOptions, ShaderTable, Silent, World, render};
use gnurt_scene::animation::Exposure;
use gnurt_scene::{Affine, InstanceId, MaterialId, Member, MeshId, Scene, Surface};
use gnurt_shading::{AttributeRequest, RadianceShader, SurfaceBatch, SurfaceShader, Tracer, Vec3s};

use crate::common::*;

/// Shows velocity + 16, and the length of the open shutter in place of it where that is 0.
struct ShowVelocity([AttributeRequest; 2]);

/// Colours are not negative.
const OFFSET: f32 = 16.0;

impl RadianceShader for ShowVelocity {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let [velocity, shutter] = [0, 1].map(|a| &hits.attributes[a]);
        for i in 0..hits.len() {
            let v = Vec3::from([0, 1, 2].map(|k| velocity[k * hits.len() + i]));
            out.set(i, (v + Vec3::splat(OFFSET)) * shutter[i]);
        }
    }
}

impl SurfaceShader for ShowVelocity {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.0
    }
}

fn table() -> ShaderTable {
    let request = |name: &str, components: u32| AttributeRequest {
        name: name.to_owned(),
        components,
        default: vec![f32::NAN; components as usize],
    };
    let requests = [request(AttributeRequest::VELOCITY, 3), request(AttributeRequest::SHUTTER, 1)];
    ShaderTable { surfaces: vec![Arc::new(ShowVelocity(requests))], ..ShaderTable::default() }
}

/// A floor at z = 0 whose shader shows velocities.
fn shown_floor() -> Scene {
    let mut scene = floor(0.5, 4.0);
    scene.edit_material(MaterialId(0)).surface = Surface::Shader(0);
    scene
}

fn opened(scene: &Scene, exposure: &Exposure) -> World {
    let mut world = World::new();
    world
        .commit_exposed(scene, exposure, &table(), &CommitOptions::default(), &pool(1))
        .expect("the scene is sound");
    world
}

/// The value above (x, y).
fn seen(world: &World, [x, y]: [f32; 2]) -> Vec3 {
    let camera = camera([x, y, 3.0], [x, y, 0.0], 0.001);
    let frame = render(world, &camera, &options(1, 1, 1), &pool(1), &Silent).expect("sound options");
    let [r, g, b, _] = frame.picture.color[0];
    Vec3::new(r, g, b)
}

/// Compares velocities at several points and times with `expected(p, time)`.
fn compare(what: &str, world: &World, expected: impl Fn(DVec3, f64) -> DVec3) {
    for time in [0.125_f32, 0.4, 0.75] {
        for at in [[0.1, 0.05], [-0.7, 0.9], [1.1, -0.3]] {
            let found = seen(&world.at(time, &pool(1)), at) - Vec3::splat(OFFSET);
            let expected = expected(DVec3::new(at[0].into(), at[1].into(), 0.0), time.into());
            let off = (found.as_dvec3() - expected).length();
            assert!(
                off < 2e-4 * (1.0 + expected.length()),
                "{what}, {at:?} at {time}: {found}, not {expected}"
            );
        }
    }
}

fn keys(count: usize, at: impl Fn(f64) -> Affine) -> Vec<Affine> {
    (0..count).map(|k| at(k as f64 / (count - 1) as f64)).collect()
}

const Z: [f64; 3] = [0.0, 0.0, 1.0];

#[test]
fn a_closed_shutter_has_no_length() {
    let scene = shown_floor();
    let world = opened(&scene, &Exposure::default());
    assert_eq!(seen(&world, [0.1, 0.05]), Vec3::ZERO, "nothing moves: no length, no velocity");
}

#[test]
fn instances_in_straight_lines_have_one_velocity() {
    let scene = shown_floor();
    let moved = |t: f64| Affine::translation([0.4 * t, -0.2 * t, 0.01 * t]);
    let exposure = Exposure { instances: vec![(InstanceId(0), keys(2, moved))], ..Exposure::default() };
    compare("a line", &opened(&scene, &exposure), |_, _| DVec3::new(0.4, -0.2, 0.01));
}

#[test]
fn turning_instances_have_the_velocity_of_a_rotation() {
    let scene = shown_floor();
    let (centre, angle) = (DVec3::new(0.3, -0.2, 0.0), 5.0);
    let turned = |t: f64| {
        Affine::translation(centre.into())
            * Affine::rotation(Z, angle * t)
            * Affine::scale([1.0 + t, 1.0 + t, 1.0])
            * Affine::translation((-centre).into())
    };
    let exposure = Exposure { instances: vec![(InstanceId(0), keys(17, turned))], ..Exposure::default() };
    let world = opened(&scene, &exposure);
    // Turned by the angle, and stretched from 1 to 2. Origins go straight from key to key: some of a chord's error.
    let rigid = |t: f64| Affine::rotation(Z, angle * t) * Affine::scale([1.0 + t, 1.0 + t, 1.0]);
    let exposure = Exposure { instances: vec![(InstanceId(0), keys(9, rigid))], ..Exposure::default() };
    compare("a turn in place", &opened(&scene, &exposure), |p, t| {
        DVec3::from(Z).cross(p) * angle + p / (1.0 + t)
    });
    for at in [[1.1, -0.3], [-0.7, 0.9]] {
        let found = (seen(&world.at(0.4, &pool(1)), at) - Vec3::splat(OFFSET)).as_dvec3();
        let p = DVec3::new(at[0].into(), at[1].into(), 0.0) - centre;
        let expected = DVec3::from(Z).cross(p) * angle + p / 1.4;
        let off = (found - expected).length();
        assert!(off < 0.05 * expected.length(), "around another centre, {at:?}: {found}, not {expected}");
    }
}

#[test]
fn members_move_with_their_holders() {
    let mut scene = shown_floor();
    let flat = scene.instance(InstanceId(0)).object;
    let holder = scene.add_object_of_members("holder", vec![Member::new(flat, Affine::IDENTITY)]);
    scene.edit_instance(InstanceId(0)).visible = false;
    let turned = |t: f64| Affine::rotation(Z, 0.8 * t);
    let slid = |t: f64| Affine::translation([0.5 * t, 0.0, 0.0]);
    let outer = scene.instantiate(holder, turned(0.0));
    let exposure = Exposure {
        instances: vec![(outer, keys(2, turned))],
        members: vec![((holder, 0), keys(2, slid))],
        ..Exposure::default()
    };
    compare("a slide on a turntable", &opened(&scene, &exposure), |p, t| {
        let (sine, cosine) = (0.8 * t).sin_cos();
        DVec3::from(Z).cross(p) * 0.8 + DVec3::new(0.5 * cosine, 0.5 * sine, 0.0)
    });
}

#[test]
fn vertices_move_between_their_keys() {
    let mut scene = shown_floor();
    scene.edit_instance(InstanceId(0)).world_from_object = Affine::scale([2.0, 2.0, 1.0]);
    // Stretched along x by 1 + 0.2 t in the first half of the time and by 1.1 + 0.6 (t - 1/2) in the second.
    let stretch = [1.0_f32, 1.1, 1.4];
    let base = scene.meshes()[0].clone();
    let at = |by: f32| {
        let mut mesh = (*base).clone();
        mesh.positions.iter_mut().for_each(|p| p[0] *= by);
        Arc::new(mesh)
    };
    let exposure = Exposure { meshes: vec![(MeshId(0), stretch.map(at).to_vec())], ..Exposure::default() };
    compare("a stretched mesh", &opened(&scene, &exposure), |p, t| {
        let (by, rate) = if t < 0.5 { (1.0 + 0.2 * t, 0.2) } else { (1.1 + 0.6 * (t - 0.5), 0.6) };
        DVec3::new(p.x / by * rate, 0.0, 0.0)
    });
}

#[test]
fn spheres_move_with_their_instance() {
    let mut scene = shown_floor();
    scene.edit_instance(InstanceId(0)).visible = false;
    let mesh = gnurt_scene::Mesh {
        primitives: gnurt_scene::Primitives::Spheres(vec![0.5]),
        positions: vec![[0.0, 0.0, 0.0]],
        material: MaterialId(0),
        ..gnurt_scene::Mesh::default()
    };
    let mesh = scene.add_mesh(mesh);
    let object = scene.add_object_of("ball", vec![mesh]);
    let ball = scene.instantiate(object, Affine::IDENTITY);
    let turned = |t: f64| Affine::rotation(Z, 2.0 * t);
    let exposure = Exposure { instances: vec![(ball, keys(2, turned))], ..Exposure::default() };
    let world = opened(&scene, &exposure);
    let found = seen(&world.at(0.3, &pool(1)), [0.2, 0.1]) - Vec3::splat(OFFSET);
    assert!((found - Vec3::new(-0.2, 0.4, 0.0)).length() < 1e-3, "the top of a spinning sphere: {found}");
}
