// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays that may hit sets of objects only, and light of categories, compared with scenes that have nothing else.

use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_render::{CommitOptions, RenderOptions, ShaderTable, Silent, World, render};
use gnurt_scene::labels::Shining;
use gnurt_scene::{Affine, InstanceId, Light, LightId, MaterialId, Scene, Surface};
use gnurt_shading::{
    AttributeRequest, LightBatch, RadianceShader, RayRequest, SurfaceBatch, SurfaceShader, Tracer, Vec3s,
};

use crate::common::*;

/// What a surface does with its rays and lights: shown as a colour.
type Show = dyn Fn(&mut dyn Tracer, &SurfaceBatch, usize) -> Vec3 + Send + Sync;

/// Shows that, and requests names.
struct Probe(Vec<AttributeRequest>, Box<Show>);

impl RadianceShader for Probe {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        for i in 0..hits.len() {
            let single = hits.gather(&[i as u32]);
            out.set(i, (self.1)(tracer, &single, 0));
        }
    }
}

impl SurfaceShader for Probe {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.0
    }
}

/// The mean colour of the floor's shader below the scene's middle.
fn shown(
    scene: &Scene,
    spp: u32,
    show: impl Fn(&mut dyn Tracer, &SurfaceBatch, usize) -> Vec3 + Send + Sync + 'static,
) -> Vec3 {
    let ids = AttributeRequest {
        name: AttributeRequest::IDS.to_owned(),
        components: 4,
        default: vec![f32::NAN; 4],
    };
    let shader = Probe(vec![ids], Box::new(show));
    let table = ShaderTable { surfaces: vec![Arc::new(shader)], ..ShaderTable::default() };
    let mut world = World::new();
    world.commit(scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
    let camera = camera([3.0, 0.0, 0.5], [0.0, 0.0, 0.0], 0.001);
    let options: RenderOptions = options(1, 1, spp);
    let frame = render(&world, &camera, &options, &pool(1), &Silent).expect("sound options");
    let [r, g, b, _] = frame.picture.color[0];
    Vec3::new(r, g, b)
}

fn probed_floor() -> Scene {
    let mut scene = floor(0.5, 4.0);
    scene.edit_material(MaterialId(0)).surface = Surface::Shader(0);
    scene
}

/// Squares at heights 1, 2, ..., which emit as much, with these names.
fn stack(names: &[&str]) -> Scene {
    let mut scene = probed_floor();
    for (i, name) in names.iter().enumerate() {
        let height = (i + 1) as f32;
        let material = emitter(&mut scene, [height; 3]);
        let square = quad([-1.0, -1.0, 0.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], material);
        let mesh = scene.add_mesh(square);
        let object = scene.add_object_of("square", vec![mesh]);
        let instance = scene.instantiate(object, Affine::translation([0.0, 0.0, f64::from(height)]));
        scene.edit_instance(instance).name = (*name).into();
    }
    scene
}

#[test]
fn rays_pass_what_is_not_in_their_set() {
    let mut scene = stack(&["a", "/hall/b", "c", "b"]);
    for id in [2, 3] {
        scene.labels_mut().add_to_trace_sets(InstanceId(id), "pair, other").expect("sound names");
    }
    for (set, distance) in [
        ("", 1.0),
        ("a", 1.0),
        ("b", 2.0),
        ("/hall/b", 2.0),
        ("c", 3.0),
        ("pair", 2.0),
        ("other", 2.0),
        ("-a", 2.0),
        ("-square", 0.0),
        ("-b", 1.0),
        ("square", 1.0),
        ("nothing", 0.0),
        ("-nothing", 1.0),
    ] {
        let found = shown(&scene, 1, move |tracer, hits, i| {
            let mut request = RayRequest { set: Some(set.into()), ..RayRequest::default() };
            request.push(Ray::new(hits.p.get(i).into(), [0.0, 0.0, 1.0]).within(1e-3, 100.0), i, hits.key[i]);
            let mut distances = Vec::new();
            tracer.distances(&request, &mut distances);
            let mut met = Vec::new();
            tracer.meet(&request, &mut met);
            let mut radiance = Vec3s::default();
            tracer.trace(0, &request, &mut radiance);
            // 0 where it hits nothing.
            let distance = if distances[0].is_finite() { distances[0] } else { 0.0 };
            Vec3::new(distance, met[0].map_or(0.0, |met| met.p.z), radiance.get(0).x)
        });
        // Each square emits its height.
        assert!((found - Vec3::splat(distance)).length() < 1e-4, "'{set}': {found}, not {distance}");
    }
}

#[test]
fn rays_end_behind_very_many_others() {
    for (others, distance) in [(4095, 3.0), (4097, 0.0)] {
        let mut scene = probed_floor();
        let material = matte(&mut scene, [0.5; 3]);
        let square = scene.add_mesh(quad([-1.0, -1.0, 0.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], material));
        let object = scene.add_object_of("", vec![square]);
        let mut at = |height: f64, name: &str| {
            let id = scene.instantiate(object, Affine::translation([0.0, 0.0, height]));
            scene.edit_instance(id).name = name.into();
        };
        (0..others).for_each(|i| at(1.0 + f64::from(i) / 4096.0, "other"));
        at(3.0, "last");
        let found = shown(&scene, 1, |tracer, hits, i| {
            let mut request = RayRequest { set: Some("last".into()), ..RayRequest::default() };
            request.push(Ray::new(hits.p.get(i).into(), [0.0, 0.0, 1.0]).within(1e-3, 100.0), i, hits.key[i]);
            let mut distances = Vec::new();
            tracer.distances(&request, &mut distances);
            Vec3::splat(if distances[0].is_finite() { distances[0] } else { 0.0 })
        });
        assert!((found.x - distance).abs() < 1e-4, "behind {others}: {found}");
    }
}

/// The irradiance of a category by one sample of each light, without shadows.
fn irradiance(
    category: &'static str,
) -> impl Fn(&mut dyn Tracer, &SurfaceBatch, usize) -> Vec3 + Send + Sync {
    move |tracer, hits, i| {
        let mut sum = Vec3::ZERO;
        let mut light = LightBatch::default();
        for number in 0..tracer.light_count() {
            tracer.illuminate_in(category, number, hits, &mut light);
            sum += light.radiance.get(i) * light.dir.get(i).dot(hits.facing_ns(i)).max(0.0);
        }
        sum
    }
}

#[test]
fn light_is_of_categories() {
    let mut scene = probed_floor();
    let point = |x: f32| Light::Point { position: [x, 0.0, 2.0], intensity: [4.0, 1.0, 1.0], radius: 0.0 };
    let up = [0.0, 0.0, -1.0];
    let lights = [
        (Light::Directional { direction: up, irradiance: [1.0, 2.0, 3.0], angle: 0.0 }, "sun", "key"),
        (point(0.0), "bulb", "fill"),
        (point(1.0), "/hall/bulb", ""),
        (environment([0.5; 3]), "sky", "key"),
    ];
    for (light, name, group) in lights {
        let id = scene.add_light(light);
        scene.labels_mut().lights.insert(id, name.into());
        scene.labels_mut().set_light_group(Shining::Light(id), group);
    }
    // Two panels, of which one's material has a group.
    for (i, group) in ["fill", ""].into_iter().enumerate() {
        let material = emitter(&mut scene, [1.0 + i as f32; 3]);
        scene.edit_material(material).name = ["left", "right"][i].into();
        scene.labels_mut().set_light_group(Shining::Material(material), group);
        let x = [-1.5, 0.5][i];
        put_mesh(&mut scene, quad([x, -0.5, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], material));
    }
    // The irradiance of a point light, and of a panel by quadrature.
    let bulb = |x: f64| 2.0 / (4.0 + x * x).powf(1.5);
    let panel = |x: f64| {
        let cells = 400;
        let at = |i: usize, from: f64| from + (i as f64 + 0.5) / f64::from(cells);
        let mut sum = 0.0;
        for (i, j) in (0..cells as usize).flat_map(|i| (0..cells as usize).map(move |j| (i, j))) {
            let (x, y) = (at(i, x), at(j, -0.5));
            sum += (x * x + y * y + 1.0).powi(-2);
        }
        sum / f64::from(cells * cells)
    };
    let (left, right) = (panel(-1.5), 2.0 * panel(0.5));
    let (sun, sky) = (1.0, 0.5 * std::f64::consts::PI);
    let bulbs = [4.0 * bulb(0.0), 4.0 * bulb(1.0)];
    let all = sun + sky + bulbs[0] + bulbs[1] + left + right;
    let cases: [(&'static str, f64); 11] = [
        ("", all),
        ("key", sun + sky),
        ("-key", all - sun - sky),
        ("fill", bulbs[0] + left),
        ("sun", sun),
        ("sky", sky),
        ("bulb", bulbs[0] + bulbs[1]),
        ("/hall/bulb", bulbs[1]),
        ("right", right),
        ("-left", all - left),
        ("nothing", 0.0),
    ];
    for (category, expected) in cases {
        let found = f64::from(shown(&scene, 4096, irradiance(category)).x);
        assert!((found - expected).abs() < 0.02 * expected.max(0.1), "'{category}': {found}, not {expected}");
    }
    assert_eq!(scene.lights().len(), 4, "{:?}", LightId(0));
}
