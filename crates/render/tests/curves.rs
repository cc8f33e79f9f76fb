// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves and spheres of meshes: their normals, and light that leaves them, in closed form.

use std::f64::consts::PI;

use crate::common::*;
use gnurt_render::Integrator;
use gnurt_scene::{CurveBasis, CurveForm, Curves, Light, Mesh, Primitives, Scene};

/// A straight strand of radius 1 along x, or a row of spheres.
fn strand(scene: &mut Scene, basis: CurveBasis, form: Option<CurveForm>) -> Mesh {
    let material = matte(scene, [0.8; 3]);
    let positions: Vec<[f32; 3]> = (0..7).map(|i| [3.0 * i as f32 - 9.0, 0.0, 0.0]).collect();
    let primitives = match form {
        Some(form) => {
            let curves = Curves::of_strands(basis, form, [positions.len()]);
            Primitives::Curves(Box::new(Curves { radii: vec![1.0; positions.len()], ..curves }))
        }
        None => Primitives::Spheres(vec![1.0; positions.len()]),
    };
    let normals = vec![[0.0, 0.0, 1.0]; positions.len()];
    Mesh { positions, normals, primitives, material, ..Mesh::default() }
}

fn all(edit: impl Fn(&mut Scene, Mesh)) -> Vec<(String, Scene, bool)> {
    let bases = [CurveBasis::Linear, CurveBasis::Bezier, CurveBasis::BSpline, CurveBasis::CatmullRom];
    let forms = [CurveForm::Round, CurveForm::Flat, CurveForm::Oriented];
    let mut scenes = Vec::new();
    let mut add = |basis, form| {
        let mut scene = Scene::new();
        let mesh = strand(&mut scene, basis, form);
        mesh.check().expect("in order");
        edit(&mut scene, mesh);
        scenes.push((format!("{basis:?} {form:?}"), scene, form == Some(CurveForm::Oriented)));
    };
    for basis in bases {
        forms.into_iter().for_each(|form| add(basis, Some(form)));
    }
    add(CurveBasis::Linear, None);
    scenes
}

#[test]
fn normals_are_those_of_tubes() {
    for (name, scene, is_flat) in all(|scene, mesh| {
        put_mesh(scene, mesh);
        scene.add_light(Light::Directional {
            direction: [0.0, 0.0, -1.0],
            irradiance: [PI as f32; 3],
            angle: 0.0,
        });
    }) {
        for y in [0.0, 0.6, -0.8] {
            let found = radiance_at(&scene, [0.0, y, 5.0], [0.0, y, 0.0], 1)[0];
            let cos = if is_flat { 1.0 } else { f64::from(1.0 - y * y).sqrt() };
            assert_close(found, 0.8 * cos, 2e-2, &format!("{name} at {y}"));
        }
    }
}

#[test]
fn light_leaves_without_meeting_its_own_strand() {
    for (name, scene, _) in all(|scene, mesh| {
        put_mesh(scene, mesh);
        scene.add_light(environment([1.0; 3]));
    }) {
        for y in [0.0, 0.5, -0.9] {
            let found = radiance_at(&scene, [0.2, y, 5.0], [0.2, y, 0.0], 256)[0];
            assert_close(found, 0.8, 2e-2, &format!("{name} at {y}: convex, so all light arrives"));
        }
    }
}

#[test]
fn integrators_agree() {
    let mut scene = Scene::new();
    let mut mesh = strand(&mut scene, CurveBasis::BSpline, Some(CurveForm::Round));
    mesh.positions.iter_mut().for_each(|p| p[1] = 1.5 * (0.7 * p[0]).sin());
    mesh.colors = (0..7).map(|i| [1.0, 0.1 * i as f32, 0.5, 1.0]).collect();
    put_mesh(&mut scene, mesh);
    let ground = matte(&mut scene, [0.5; 3]);
    put_mesh(&mut scene, quad([-9.0, -9.0, -2.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0], ground));
    let lamp = emitter(&mut scene, [4.0; 3]);
    put_mesh(&mut scene, quad([-3.0, -3.0, 8.0], [0.0, 6.0, 0.0], [6.0, 0.0, 0.0], lamp));
    let view = camera([0.0, -9.0, 6.0], [0.0, 0.0, 0.0], 50.0);
    let by = |integrator, spp| {
        let options = gnurt_render::RenderOptions { integrator, vpls: 128, ..options(32, 24, spp) };
        mean(&frame(&scene, &view, &options).picture)
    };
    let (path, bir) = (by(Integrator::Path, 128), by(Integrator::BidirectionalInstantRadiosity, 32));
    for k in 0..3 {
        assert_close(bir[k], path[k], 1e-2, "bidirectional instant radiosity beside path tracing");
    }
}
