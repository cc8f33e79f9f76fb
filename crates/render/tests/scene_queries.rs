// SPDX-License-Identifier: GPL-3.0-or-later
//! The camera and the names of the scene, as surfaces get them.

use std::sync::{Arc, Mutex};

use gnurt_render::{
    CommitOptions, Integrator, RenderOptions, ShaderTable, Silent, World, render, trace_pixel,
};
use gnurt_scene::animation::Exposure;
use gnurt_scene::{Affine, Attribute, InstanceId, MaterialId, MeshId, Rate, Scene, Surface};
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{
    AttributeRequest, CameraProjection, CameraProperties, SceneNames, SurfaceBatch, SurfaceShader,
};

use crate::common::*;

/// The input of a surface, point by point.
type Seen = Vec<(Option<CameraProperties>, Option<Arc<SceneNames>>, [u32; 4])>;

/// Notes its input.
struct Curious {
    requests: Vec<AttributeRequest>,
    seen: Arc<Mutex<Seen>>,
}

impl SurfaceShader for Curious {
    fn evaluate(&self, hits: &SurfaceBatch, _: &mut ClosureBatch) {
        let mut seen = self.seen.lock().expect("no test has failed before");
        for i in 0..hits.len() {
            let ids = hits
                .attributes
                .first()
                .map_or([0; 4], |ids| [0, 1, 2, 3].map(|k| ids[k * hits.len() + i].to_bits()));
            seen.push((hits.camera, hits.names.clone(), ids));
        }
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.requests
    }
}

/// The input of a curious floor during a picture.
fn seen(scene: &Scene, exposure: &Exposure, request: bool, integrator: Integrator) -> Seen {
    let request = request.then(|| AttributeRequest {
        name: AttributeRequest::IDS.to_owned(),
        components: 4,
        default: vec![f32::NAN; 4],
    });
    seen_by(scene, exposure, request.into_iter().collect(), integrator)
}

fn seen_by(
    scene: &Scene,
    exposure: &Exposure,
    requests: Vec<AttributeRequest>,
    integrator: Integrator,
) -> Seen {
    let seen: Arc<Mutex<Seen>> = Arc::default();
    let shader = Curious { requests, seen: seen.clone() };
    let table = ShaderTable { surfaces: vec![Arc::new(shader)], ..ShaderTable::default() };
    let mut world = World::new();
    world
        .commit_exposed(scene, exposure, &table, &CommitOptions::default(), &pool(1))
        .expect("the scene is sound");
    let camera = camera([0.3, 0.1, 3.0], [0.3, 0.1, 0.0], 40.0);
    let options = RenderOptions { integrator, ..options(6, 3, 2) };
    render(&world, &camera, &options, &pool(1), &Silent).expect("sound options");
    trace_pixel(&world, &camera, &options, 1, 1).expect("a pixel");
    std::mem::take(&mut *seen.lock().expect("nobody else holds it"))
}

fn curious_floor() -> Scene {
    let mut scene = floor(0.5, 1.0);
    scene.edit_material(MaterialId(0)).surface = Surface::Shader(0);
    scene.edit_material(MaterialId(0)).name = "carpet".into();
    scene.edit_instance(InstanceId(0)).name = "ground".into();
    scene
}

#[test]
fn surfaces_know_the_camera() {
    let scene = curious_floor();
    let moved = vec![Affine::IDENTITY, Affine::translation([0.1, 0.0, 0.0])];
    let open = Exposure { instances: vec![(InstanceId(0), moved)], ..Exposure::default() };
    for integrator in [Integrator::Path, Integrator::Whitted, Integrator::InstantRadiosity] {
        for (exposure, closes) in [(&Exposure::default(), 0.0), (&open, 1.0)] {
            let seen = seen(&scene, exposure, false, integrator);
            assert!(seen.len() > 10, "{integrator:?}: {} points", seen.len());
            for (camera, names, _) in seen {
                let camera = camera.unwrap_or_else(|| panic!("{integrator:?}: it has a camera"));
                assert_eq!((camera.resolution, camera.shutter), ([6, 3], [0.0, closes]), "{integrator:?}");
                let fov = camera.fov().expect("a perspective");
                assert!(matches!(camera.projection, Some(CameraProjection::Perspective { .. })));
                assert!((fov - 40.0).abs() < 1e-3, "{fov}");
                assert_eq!(names, None, "nobody requests names");
            }
        }
    }
}

#[test]
fn values_of_whole_objects_are_known_where_they_are_requested() {
    let mut scene = curious_floor();
    let value = |name: &str, data: &[f32]| Attribute {
        name: name.into(),
        rate: Rate::Vertex,
        components: 1,
        data: data.to_vec(),
    };
    scene.edit_mesh(MeshId(0)).attributes =
        vec![value("heat", &[3.0; 4]), value("slope", &[1.0, 1.0, 2.0, 1.0])];
    let mut more = (*scene.meshes()[0]).clone();
    more.attributes = vec![value("heat", &[3.0; 4])];
    let same = scene.add_mesh(more.clone());
    more.attributes = vec![value("heat", &[4.0; 4])];
    let other = scene.add_mesh(more);
    scene.add_object_of("both", vec![MeshId(0), same]);
    scene.add_object_of("mixed", vec![same, other]);
    for (with_objects, expected) in [(true, vec![vec![("heat", vec![3.0])]; 2]), (false, Vec::new())] {
        let request = |name: &str, components: u32| AttributeRequest {
            name: name.to_owned(),
            components,
            default: vec![0.0; components as usize],
        };
        let mut requests = vec![request(AttributeRequest::IDS, 4)];
        requests.extend(with_objects.then(|| request(AttributeRequest::OBJECTS, 1)));
        let seen = seen_by(&scene, &Exposure::default(), requests, Integrator::Path);
        let names = seen[0].1.clone().expect("they are requested");
        let found: Vec<Vec<(&str, Vec<f32>)>> = names
            .constants
            .values()
            .map(|values| values.iter().map(|(name, value)| (&name[..], value.clone())).collect())
            .collect();
        let mut all = expected.clone();
        all.extend(with_objects.then(Vec::new));
        assert_eq!(found, all);
        assert_eq!(names.object_of, if with_objects { vec![0] } else { Vec::new() });
    }
}

#[test]
fn surfaces_that_request_them_know_names_and_numbers() {
    let mut scene = curious_floor();
    // Another instance of another object, in front.
    let mesh = scene.meshes()[0].clone();
    let mesh = scene.add_mesh((*mesh).clone());
    let object = scene.add_object_of("rug", vec![mesh]);
    scene.instantiate(object, Affine::translation([0.0, 0.0, 0.1]) * Affine::scale([0.3; 3]));
    let seen = seen(&scene, &Exposure::default(), true, Integrator::Path);
    let (mut ground, mut rug) = (0, 0);
    for (_, names, [instance, object, material, prim]) in seen {
        let names = names.expect("they are requested");
        assert_eq!(names.materials[material as usize], "carpet");
        assert!(prim < 2, "one of two triangles");
        match names.of_geometry(instance, object) {
            "ground" => ground += 1,
            "rug" => rug += 1,
            other => panic!("a part called '{other}'"),
        }
    }
    assert!(ground > 0 && rug > 0, "{ground} points of the floor, {rug} of the rug");
}
