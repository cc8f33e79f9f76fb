// SPDX-License-Identifier: GPL-3.0-or-later
//! Pixel shaders: one that shows the radiance of its ray changes no bit; its own rays are camera rays.

use std::sync::Arc;

use gnurt_image::Picture;
use gnurt_render::{
    Accumulation, CommitOptions, Integrator, RenderOptions, SceneCamera, ShaderTable, Silent, World, render,
    trace_pixel,
};
use gnurt_shading::{PixelSamples, PixelShader, RayRequest, SurfaceHit, Tracer, Vec3s};

use crate::common::*;

/// Shows a function of the answers to rays like the camera's own.
struct Shows(fn(&mut dyn Tracer, &PixelSamples, &RayRequest, &mut Vec3s));

impl PixelShader for Shows {
    fn show(&self, tracer: &mut dyn Tracer, samples: &PixelSamples, out: &mut Vec3s) {
        let request = RayRequest {
            rays: samples.rays.clone(),
            parent: (0..samples.rays.len() as u32).collect(),
            key: samples.keys.iter().map(|key| key.fork(7)).collect(),
            ..RayRequest::default()
        };
        (self.0)(tracer, samples, &request, out);
    }
}

fn scratch(shader: Option<Shows>) -> (World, SceneCamera) {
    let scene = gnurt_scene::builtin::load("cornell").expect("it is built in");
    let table = ShaderTable { pixel: shader.map(|shader| Arc::new(shader) as _), ..ShaderTable::default() };
    let mut world = World::new();
    world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("a sound scene");
    (world, SceneCamera::new(&scene.cameras()[0]).expect("a view"))
}

fn by(integrator: Integrator, spp: u32) -> RenderOptions {
    RenderOptions { integrator, max_depth: 4, vpls: 64, ..options(40, 40, spp) }
}

fn picture((world, camera): &(World, SceneCamera), options: &RenderOptions, threads: usize) -> Picture {
    render(world, camera, options, &pool(threads), &Silent).expect("sound options").picture
}

#[test]
fn the_radiance_along_its_ray_is_what_there_is_without() {
    let same = Shows(|_, samples, _, out| out.clone_from(samples.radiance));
    let (plain, shown) = (scratch(None), scratch(Some(same)));
    for integrator in Integrator::ALL {
        for interleave in [1, 3] {
            let options = RenderOptions { interleave, ..by(integrator, 2) };
            let [a, b] = [picture(&plain, &options, 2), picture(&shown, &options, 1)];
            assert!(a.color == b.color, "{integrator}, interleaved {interleave}: the same bits");
        }
    }
}

#[test]
fn its_rays_are_samples_of_the_integrator() {
    let again = Shows(|tracer, _, request, out| tracer.trace(0, request, out));
    let (plain, shown) = (scratch(None), scratch(Some(again)));
    let all = [Integrator::Eyelight, Integrator::Whitted, Integrator::Path, Integrator::InstantRadiosity];
    for integrator in all {
        let options = by(integrator, if integrator == Integrator::Path { 64 } else { 4 });
        let [a, b] = [&plain, &shown].map(|view| mean(&picture(view, &options, 2)));
        (0..3).for_each(|k| assert_close(b[k], a[k], 0.03, &format!("{integrator}")));
    }
}

#[test]
fn what_rays_meet_is_what_layers_hold() {
    let met = Shows(|tracer, samples, request, out| {
        let (mut met, mut far) = (Vec::<Option<SurfaceHit>>::new(), Vec::new());
        tracer.meet(request, &mut met);
        tracer.distances(request, &mut far);
        for (i, met) in met.iter().enumerate() {
            let Some(met) = met else { continue };
            assert_eq!((met.t, met.t), (samples.distances[i], far[i]), "the same ray");
            out.set(i, met.ns * 0.5 + met.albedo);
        }
    });
    let options = RenderOptions { aovs: true, ..by(Integrator::Eyelight, 3) };
    let picture = picture(&scratch(Some(met)), &options, 2);
    let layer = |name: &str, channel: usize| match &picture.layers.iter().find(|l| l.name == name) {
        Some(layer) => match &layer.channels[channel].data {
            gnurt_image::ChannelData::F32(list) => list.clone(),
            other => panic!("{other:?}"),
        },
        None => panic!("no layer {name}"),
    };
    for k in 0..3 {
        let (normal, albedo) = (layer("N", k), layer("albedo", k));
        for (i, pixel) in picture.color.iter().enumerate() {
            let expected = 0.5 * normal[i] + albedo[i];
            assert!((pixel[k] - expected).abs() < 1e-5, "pixel {i}: {} is not {expected}", pixel[k]);
        }
    }
}

#[test]
fn neighbours_are_a_pixel_away_and_traces_show_it() {
    let steps = Shows(|_, samples, _, out| {
        for i in 0..out.len() {
            let at = |rays: &gnurt_accel::RayBatch| glam::Vec3::from(rays.get(i).dir);
            let here = at(samples.rays);
            let [right, below] = samples.neighbours.map(|rays| at(rays) - here);
            assert!(right.length() > 1e-4 && right.dot(below).abs() < 0.2 * right.length_squared());
            out.set(i, right.cross(below).normalize());
        }
    });
    let (world, camera) = scratch(Some(steps));
    let trace = trace_pixel(&world, &camera, &by(Integrator::Path, 1), 20, 20).expect("it is inside");
    let mut measured = Accumulation::new(by(Integrator::Eyelight, 1)).expect("sound options");
    assert!(measured.pass(&world, &camera, 1, &pool(1), &Silent), "nobody stops it");
    let pixel = measured.picture().color[20 * 40 + 20];
    let forward = glam::Vec3::from(camera.forward());
    for found in [glam::Vec3::from(trace.radiance), glam::Vec3::from_slice(&pixel[..3])] {
        assert!(found.dot(forward) > 0.99, "right and down span the picture: {found} along {forward}");
    }
}
