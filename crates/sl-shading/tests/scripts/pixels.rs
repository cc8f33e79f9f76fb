// SPDX-License-Identifier: GPL-3.0-or-later
//! Pixel shaders, and their information about rays.

use glam::Vec3;
use gnurt_accel::{Ray, RayBatch};
use gnurt_shading::{
    CameraSamples, LightBatch, PixelSamples, RayRequest, SampleKey, SurfaceBatch, SurfaceHit, Tracer, Vec3s,
};

use super::floor::script;

/// Rays up meet something 3 away, other rays nothing; light is the direction.
struct Above;

impl Tracer for Above {
    fn light_count(&self) -> usize {
        0
    }

    fn illuminate(&mut self, _: usize, _: &SurfaceBatch, _: &mut LightBatch) {}

    fn occluded(&mut self, _: &RayRequest, _: &mut Vec3s) {}

    fn trace(&mut self, _: u32, request: &RayRequest, radiance: &mut Vec3s) {
        radiance.reset(1, Vec3::from(request.rays.get(0).dir));
    }

    fn distances(&mut self, request: &RayRequest, out: &mut Vec<f32>) {
        out.clear();
        out.push(if request.rays.get(0).dir[1] > 0.9 { 3.0 } else { f32::INFINITY });
    }

    fn meet(&mut self, request: &RayRequest, out: &mut Vec<Option<SurfaceHit>>) {
        let ray = request.rays.get(0);
        let (ng, albedo) = (Vec3::NEG_Y, Vec3::new(0.1, 0.2, 0.3));
        let p = Vec3::from(ray.org) + 3.0 * Vec3::from(ray.dir);
        out.clear();
        out.push(Some(SurfaceHit {
            t: 3.0,
            p,
            ng,
            ns: ng,
            uv: [0.25, 0.5],
            albedo,
            back: false,
            ids: [4, 5, 6, 7],
        }));
    }

    fn random(&self, _: SampleKey, _: u32, _: u32) -> [f32; 2] {
        [0.5; 2]
    }
}

/// The colours of 40 pixels, half of which look up and the others ahead, by a shader with this body.
fn shown(body: &str) -> Vec<Vec3> {
    let count = 40;
    let text = format!("pixel p (output color Cpixel = 0) {{ {body} }}");
    let shader = script(&text).pixel().expect("a pixel shader");
    let direction = |i: usize| if i.is_multiple_of(2) { [0.0, 1.0, 0.0] } else { [0.0, 0.0, -1.0] };
    let fill = |x: f32| {
        let mut rays = RayBatch::default();
        (0..count).for_each(|i| rays.push(Ray::new([i as f32 + x, 0.0, 0.0], direction(i))));
        rays
    };
    let (rays, right, below) = (fill(0.0), fill(0.5), fill(-0.25));
    let positions: Vec<[f32; 2]> = (0..count).map(|i| [(i as f32 + 0.5) / 40.0, 0.75]).collect();
    let samples = PixelSamples {
        rays: &rays,
        neighbours: [&right, &below],
        camera: CameraSamples::sharp(&positions),
        size: [40, 8],
        projection: None,
        keys: &vec![SampleKey::default(); count],
        radiance: &Vec3s::splat(count, Vec3::new(5.0, 6.0, 7.0)),
        distances: &(0..count)
            .map(|i| if i.is_multiple_of(2) { 2.0 } else { f32::INFINITY })
            .collect::<Vec<f32>>(),
    };
    let mut out = Vec3s::splat(count, Vec3::ZERO);
    shader.show(&mut Above, &samples, &mut out);
    (0..count).map(|i| out.get(i)).collect()
}

#[test]
fn their_own_ray_is_known_and_others_are_sent() {
    for (i, found) in shown("Cpixel = (color) trace (P, I) + 10 * (color) trace (P, vector (2, 0, 0));")
        .into_iter()
        .enumerate()
    {
        assert_eq!(found, Vec3::new(15.0, 6.0, 7.0), "sample {i}: its radiance, and that of a ray aside");
    }
    let far = "float d = -1; if (trace (P, I)) getmessage (\"trace\", \"hitdist\", d);
        float e = -1; if (trace (P, -I)) e = 0; if (trace (P, vector (0, 1, 0), \"mindist\", 1.0)) getmessage (\"trace\", \"hitdist\", e);
        Cpixel = color (d, e, 0);";
    for (i, found) in shown(far).into_iter().enumerate() {
        let own = if i.is_multiple_of(2) { 2.0 } else { -1.0 };
        assert_eq!(found, Vec3::new(own, 3.0, 0.0), "sample {i}: each keeps its own ray in mind");
    }
}

#[test]
fn they_learn_what_rays_meet() {
    let body = "color a = 0; normal n = 0; point p = 0; float s = 0; int ids[4]; int unknown = 9;
        if (trace (P, vector (0, 1, 0), \"mindist\", 0.5)) {
            getmessage (\"trace\", \"albedo\", a); getmessage (\"trace\", \"N\", n); getmessage (\"trace\", \"P\", p);
            getmessage (\"trace\", \"u\", s); getmessage (\"trace\", \"instance\", ids[0]);
            getmessage (\"trace\", \"material\", ids[2]); getmessage (\"trace\", \"no such\", unknown);
        }
        Cpixel = a + color (n) + color (p[1], s, ids[0] + 10 * ids[2] + unknown);";
    let expected = Vec3::new(0.1 + 3.0, 0.2 - 1.0 + 0.25, 0.3 + 64.0 + 9.0);
    shown(body)
        .into_iter()
        .for_each(|found| assert!((found - expected).length() < 1e-4, "{found}, not {expected}"));
}

#[test]
fn globals_are_those_of_the_picture() {
    let found = shown(
        "vector way = Dx (P) + Dy (P); Cpixel = color (way[0], raster[0] - 40 * u, raster[1] + v + Dx (u));",
    );
    for (i, found) in found.into_iter().enumerate() {
        let expected = Vec3::new(0.25, 0.0, 2.0 + 0.75 + 1.0 / 40.0);
        assert!((found - expected).length() < 1e-4, "sample {i}: {found}, not {expected}");
    }
}

#[test]
fn what_shows_nothing_is_refused() {
    for (text, messages) in [
        ("pixel p () { }", "output color Cpixel"),
        ("pixel p (color Cpixel = 0) { }", "output color Cpixel"),
        ("camera c () { I = 1; }", "of type camera"),
    ] {
        let why = script(text).pixel().err().expect("it is wrong");
        assert!(why.contains(messages), "{why}");
    }
}
