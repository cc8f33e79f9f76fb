// SPDX-License-Identifier: GPL-3.0-or-later
//! The path tracer against closed forms: furnaces, lights over a floor, a lamp in a hollow sphere, holes. //! the integrating sphere is a textbook's.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::*;
use glam::Vec3;
use gnurt_image::Picture;
use gnurt_render::{
    CommitOptions, Integrator, ReconstructionFilter, RenderOptions, SceneCamera, ShaderTable, Silent, World,
    render,
};
use gnurt_scene::material::{Alpha, Opacity, OpacityChannel};
use gnurt_scene::{Camera, Lens, Light, Material, MaterialId, Mesh, Projection, Scene, Surface};
use gnurt_shading::lights::PointLight;
use gnurt_shading::{RadianceShader, SurfaceBatch, SurfaceShader, Tracer, Vec3s};

const ALBEDO: f32 = 0.6;

fn path(width: u32, height: u32, spp: u32, max_depth: u32) -> RenderOptions {
    RenderOptions { integrator: Integrator::Path, max_depth, ..options(width, height, spp) }
}

fn measured(scene: &Scene, eye: [f32; 3], target: [f32; 3], spp: u32, max_depth: u32) -> [f64; 3] {
    mean(&frame(scene, &camera(eye, target, 0.01), &path(8, 8, spp, max_depth)).picture)
}

/// A closed cube from -1 to 1 whose sides look inward.
fn cube(scene: &mut Scene, material: MaterialId) {
    let (a, b) = (-1.0_f32, 2.0_f32);
    let sides: [[[f32; 3]; 3]; 6] = [
        [[a, a, a], [b, 0.0, 0.0], [0.0, b, 0.0]],
        [[a, a, 1.0], [0.0, b, 0.0], [b, 0.0, 0.0]],
        [[a, a, a], [0.0, b, 0.0], [0.0, 0.0, b]],
        [[1.0, a, a], [0.0, 0.0, b], [0.0, b, 0.0]],
        [[a, a, a], [0.0, 0.0, b], [b, 0.0, 0.0]],
        [[a, 1.0, a], [b, 0.0, 0.0], [0.0, 0.0, b]],
    ];
    for [corner, s, t] in sides {
        put_mesh(scene, quad(corner, s, t, material));
    }
}

#[test]
fn a_shining_box_is_a_geometric_series() {
    let (radiance, rho) = (2.0, 0.7_f64);
    let mut scene = Scene::new();
    let material = scene
        .add_material(Material { emission: [radiance as f32; 3], ..Material::matte("", [rho as f32; 3]) });
    cube(&mut scene, material);
    for (edges, spp, tolerance) in [(1, 1, 1e-5), (2, 64, 5e-3), (5, 64, 5e-3), (64, 64, 1e-2)] {
        let found = measured(&scene, [0.1, 0.2, 0.3], [1.0, 0.4, -0.2], spp, edges)[0];
        let expected = radiance * (1.0 - rho.powi(edges as i32)) / (1.0 - rho);
        assert_close(found, expected, tolerance, &format!("{edges} edges"));
    }
}

#[test]
fn white_things_vanish_under_a_white_sky() {
    let frame = white_under_white(&path(24, 24, 64, 1000));
    assert_close(mean(&frame.picture)[0], 1.0, 3e-3, "all light is scattered on");
}

#[test]
fn lights_without_extent_and_rectangles() {
    let (eye, target) = ([0.5, -2.0, 3.0], [0.5, 0.25, 0.0]);
    let albedo = f64::from(ALBEDO);
    let lit = |light: Light| {
        let mut scene = floor(ALBEDO, 10.0);
        scene.add_light(light);
        measured(&scene, eye, target, 1, 8)[0]
    };
    let d2 = 0.25 + 0.5625 + 4.0_f64;
    let point = Light::Point { position: [1.0, 1.0, 2.0], intensity: [7.0; 3], radius: 0.0 };
    assert_close(lit(point), albedo / PI * 7.0 / d2 * (2.0 / d2.sqrt()), 1e-3, "I cos / d²");
    let sun = Light::Directional { direction: [3.0, 0.0, -4.0], irradiance: [2.0; 3], angle: 0.0 };
    assert_close(lit(sun), albedo / PI * 2.0 * 0.8, 1e-4, "E cos");

    // From far above the floor to grazing: light samples find the first, scattered rays the last.
    for height in [3.0_f64, 1.0, 0.05] {
        let mut scene = floor(ALBEDO, 10.0);
        let light = emitter(&mut scene, [5.0, 1.0, 2.0]);
        let h = height as f32;
        put_mesh(&mut scene, quad([0.0, 0.0, h], [0.0, 2.0, 0.0], [1.0, 0.0, 0.0], light));
        let found = measured(&scene, [-0.1 * h, -0.1 * h, 0.5 * h], [0.0; 3], 512, 2);
        let (a, b) = (1.0 / height, 2.0 / height);
        let (x, y) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        let form = (a / x * (b / x).atan() + b / y * (a / y).atan()) / (2.0 * PI);
        assert_close(found[0], albedo * 5.0 * form, 1e-2, &format!("a corner below, at height {height}"));
        assert_close(found[2] / found[1], 2.0, 1e-4, "colours keep their ratio");
    }
}

/// A panel, a sky and a sun are three groups, of which the first vertex samples one light each: their closed forms add up.
#[test]
fn groups_of_lights_add_up() {
    let mut scene = floor(ALBEDO, 10.0);
    let light = emitter(&mut scene, [5.0, 1.0, 2.0]);
    put_mesh(&mut scene, quad([-1.0, -1.0, 1.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], light));
    scene.add_light(environment([1.0; 3]));
    // Thirty degrees above the horizon, beside the panel.
    scene.add_light(Light::Directional {
        direction: [-3.0_f32.sqrt(), 0.0, -1.0],
        irradiance: [2.0; 3],
        angle: 0.0,
    });
    let found = measured(&scene, [-0.01, -0.01, 0.5], [0.0; 3], 1024, 2);
    let corner = 0.5_f64.sqrt();
    let form = 4.0 * 2.0 * corner * corner.atan() / (2.0 * PI);
    for (found, panel) in found.into_iter().zip([5.0, 1.0, 2.0]) {
        let expected = f64::from(ALBEDO) * (form * panel + (1.0 - form) + 2.0 * 0.5 / PI);
        assert_close(found, expected, 5e-3, "a panel, the sky beside it and the sun");
    }
}

/// Sends the same radiance to all sides, and does not say how it scatters.
struct Tells(f32);

impl RadianceShader for Tells {
    fn shade(&self, _: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        (0..hits.len()).for_each(|i| out.set(i, Vec3::splat(self.0)));
    }
}

impl SurfaceShader for Tells {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }
}

/// Light samples find the described emission, too; only scattered rays find the shader's own radiance.
#[test]
fn a_shader_may_shine_beside_what_it_tells() {
    let lit = |surface: Surface, radiance: f32| {
        let mut scene = floor(ALBEDO, 10.0);
        let area_light =
            scene.add_material(Material { emission: [radiance; 3], ..Material::of("", surface) });
        put_mesh(&mut scene, quad([0.0, 0.0, 0.5], [0.0, 2.0, 0.0], [1.0, 0.0, 0.0], area_light));
        let table = ShaderTable { surfaces: vec![Arc::new(Tells(3.0))], ..ShaderTable::default() };
        let mut world = World::new();
        world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("the scene is sound");
        let view = camera([-0.05, -0.05, 0.25], [0.0; 3], 0.01);
        mean(&render(&world, &view, &path(8, 8, 512, 2), &pool(1), &Silent).expect("sound options").picture)
            [0]
    };
    let whole = lit(Material::matte("", [0.0; 3]).surface, 5.0);
    assert_close(lit(Surface::Shader(0), 2.0), whole, 1e-2, "2 that shine and 3 that are told are 5");
}

/// A lamp in a hollow white sphere: scattered light is the same everywhere, `Le f rho / (1 - rho (1 - f))` with the lamp's
/// share `f` of the surface.
#[test]
fn a_lamp_in_a_hollow_sphere() {
    let rho = 0.8_f64;
    let mut scene = Scene::new();
    let (wall, area_light) = (matte(&mut scene, [rho as f32; 3]), emitter(&mut scene, [10.0; 3]));
    let whole = sphere([0.0; 3], 1.0, 48, wall);
    // Wound to look inward; face normals; the lamp is the cap around +z.
    let part = |lit: bool, material| {
        let is_lit = |t: &&[u32; 3]| t.iter().all(|&i| whole.positions[i as usize][2] > 0.97) == lit;
        let indices = whole.indices.iter().filter(is_lit).map(|[a, b, c]| [*a, *c, *b]).collect();
        Mesh { indices, normals: Vec::new(), material, ..whole.clone() }
    };
    let (area_light, wall) = (part(true, area_light), part(false, wall));
    let area = |mesh: &Mesh| -> f64 {
        let at = |i: u32| glam::DVec3::from(mesh.positions[i as usize].map(f64::from));
        mesh.indices.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a)).length() / 2.0).sum()
    };
    let share = area(&area_light) / (area(&area_light) + area(&wall));
    put_mesh(&mut scene, area_light);
    put_mesh(&mut scene, wall);
    let expected = 10.0 * share * rho / (1.0 - rho * (1.0 - share));
    for target in [[1.0, 0.3, -0.4], [0.2, 0.1, -1.0]] {
        let found = measured(&scene, [0.0, 0.1, -0.1], target, 256, 200)[0];
        assert_close(found, expected, 1e-2, "light is even");
    }
}

#[test]
fn holes_let_light_through() {
    let opacity = Opacity { factor: 0.25, texture: None, channel: OpacityChannel::Alpha };
    let veil = |scene: &mut Scene, emission: f32, height: f32| {
        let material = scene.add_material(Material {
            alpha: Alpha::Blend { opacity },
            emission: [emission; 3],
            ..Material::matte("veil", [0.0; 3])
        });
        put_mesh(scene, quad([-9.0, -9.0, height], [0.0, 18.0, 0.0], [18.0, 0.0, 0.0], material));
    };
    // A light behind a veil, by light samples.
    let mut scene = floor(ALBEDO, 10.0);
    veil(&mut scene, 0.0, 1.0);
    scene.add_light(Light::Point { position: [0.0, 0.0, 2.0], intensity: [4.0; 3], radius: 0.0 });
    let found = measured(&scene, [0.5, 0.0, 0.9], [0.0; 3], 16, 2)[0];
    assert_close(found, f64::from(ALBEDO) / PI * 0.75, 1e-3, "three quarters of it");
    // A lamp behind three: shadow rays end before it though they leave each veil a little ahead of that.
    let lit = |veils: i32| {
        let mut scene = floor(ALBEDO, 10.0);
        (0..veils).for_each(|k| veil(&mut scene, 0.0, 1.0 + 0.25 * k as f32));
        let area_light = emitter(&mut scene, [5.0; 3]);
        put_mesh(&mut scene, quad([-0.1, -0.1, 2.0], [0.0, 0.2, 0.0], [0.2, 0.0, 0.0], area_light));
        measured(&scene, [0.5, 0.0, 0.9], [0.0; 3], 64, 2)[0]
    };
    assert_close(lit(3), lit(0) * 0.75_f64.powi(3), 0.02, "three times three quarters");
    // The sky behind it, by both kinds of sample; two veils in a row.
    let mut scene = floor(ALBEDO, 10.0);
    veil(&mut scene, 0.0, 1.0);
    scene.add_light(environment([1.0; 3]));
    let found = measured(&scene, [0.1, 0.0, 0.05], [0.0; 3], 1024, 2)[0];
    assert_close(found, f64::from(ALBEDO) * 0.75, 0.02, "three quarters of the sky");
    // A veil that shines itself.
    let mut scene = floor(ALBEDO, 1000.0);
    veil(&mut scene, 2.0, 1.0);
    let found = measured(&scene, [0.01, 0.0, 0.05], [0.0; 3], 1024, 2)[0];
    let (a, x) = (9.0_f64, (1.0 + 81.0_f64).sqrt());
    let form = 4.0 * (2.0 * a / x * (a / x).atan()) / (2.0 * PI);
    assert_close(found, f64::from(ALBEDO) * 0.25 * 2.0 * form, 0.02, "a quarter of its radiance");
}

#[test]
fn lights_of_plugins_count_as_those_of_the_scene() {
    let mut scene = floor(ALBEDO, 10.0);
    let light = Arc::new(PointLight::new([0.0, 0.0, 2.0].into(), [4.0; 3].into()));
    let table = ShaderTable { lights: vec![light], ..ShaderTable::default() };
    let by_table = {
        let mut world = World::new();
        world.commit(&scene, &table, &CommitOptions::default(), &pool(1)).expect("sound");
        let view = camera([0.5, 0.0, 1.0], [0.0; 3], 0.01);
        mean(&render(&world, &view, &path(4, 4, 1, 3), &pool(1), &Silent).expect("sound").picture)
    };
    scene.add_light(Light::Point { position: [0.0, 0.0, 2.0], intensity: [4.0; 3], radius: 0.0 });
    assert_close(by_table[0], measured(&scene, [0.5, 0.0, 1.0], [0.0; 3], 1, 3)[0], 1e-5, "the same light");
}

/// A room of many things: mirrors, glass, holes, lamps, sky.
fn scratch() -> (Scene, SceneCamera) {
    let mut scene = floor(ALBEDO, 4.0);
    let red = matte(&mut scene, [0.7, 0.2, 0.1]);
    put_mesh(&mut scene, sphere([0.0, 0.0, 0.7], 0.7, 12, red));
    let area_light = emitter(&mut scene, [8.0, 7.0, 6.0]);
    put_mesh(&mut scene, quad([-1.0, -1.0, 4.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], area_light));
    let opacity = Opacity { factor: 0.5, texture: None, channel: OpacityChannel::Alpha };
    let veil = scene
        .add_material(Material { alpha: Alpha::Blend { opacity }, ..Material::matte("", [0.1, 0.5, 0.1]) });
    put_mesh(&mut scene, quad([-2.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0], veil));
    scene.add_light(environment([0.2, 0.3, 0.5]));
    scene.add_light(Light::Point { position: [-3.0, -3.0, 2.0], intensity: [4.0; 3], radius: 0.0 });
    (scene, camera([0.5, -6.0, 2.5], [0.0, 0.0, 0.6], 40.0))
}

#[test]
fn threads_and_neighbours_do_not_matter() {
    let (scene, view) = scratch();
    let world = world_of(&scene, false);
    let picture = |options: &RenderOptions, threads| -> Picture {
        render(&world, &view, options, &pool(threads), &Silent).expect("sound options").picture
    };
    let options = path(45, 33, 5, 8);
    let one = picture(&options, 1);
    let bits = |p: &Picture| p.color.iter().map(|c| c.map(f32::to_bits)).collect::<Vec<_>>();
    assert!(bits(&one) == bits(&picture(&options, 7)), "7 threads give other bits");
    let crop = [20, 9, 31, 24];
    let cropped = picture(&RenderOptions { crop: Some(crop), ..options }, 2);
    for (x, y) in (crop[0]..crop[2]).flat_map(|x| (crop[1]..crop[3]).map(move |y| (x, y))) {
        assert_eq!(one.pixel(x, y), cropped.pixel(x, y), "pixel {x},{y} of a crop");
    }
}

/// Each contribution is limited, instead of a sample's sum.
#[test]
fn clamping_leaves_many_small_contributions() {
    let mut scene = Scene::new();
    let material = scene.add_material(Material { emission: [1.0; 3], ..Material::matte("", [0.5; 3]) });
    cube(&mut scene, material);
    let world = world_of(&scene, false);
    let view = camera([0.1, 0.2, 0.3], [1.0, 0.4, -0.2], 30.0);
    let with = |clamp| {
        let options = RenderOptions { clamp, ..path(8, 8, 16, 4) };
        render(&world, &view, &options, &pool(1), &Silent).expect("sound options").picture
    };
    // Contributions of edge k are at most 0.5^(k - 1), as none is ended by chance; those of edges 3 and 4 add up to 0.375.
    let all = with(None);
    assert_eq!(all.color, with(Some(0.26)).color, "none of them is larger than a quarter");
    assert!(mean(&with(Some(0.04)))[0] < mean(&all)[0] - 0.1, "most are larger than that");
}

#[test]
fn clamping_only_takes_light_away() {
    let (scene, view) = scratch();
    let world = world_of(&scene, false);
    let with = |clamp| {
        let options = RenderOptions { clamp, ..path(32, 24, 8, 8) };
        render(&world, &view, &options, &pool(1), &Silent).expect("sound options").picture
    };
    let (all, less, direct) = (with(None), with(Some(0.05)), with(Some(0.0)));
    let sums = [&all, &less, &direct].map(|picture| mean(picture)[0]);
    assert!(sums[0] > sums[1] && sums[1] > sums[2], "less and less: {sums:?}");
    let options = path(32, 24, 8, 2);
    let expected = render(&world, &view, &options, &pool(1), &Silent).expect("sound options").picture;
    assert_close(sums[2], mean(&expected)[0], 1e-5, "direct light is never clamped");
}

/// A small lamp out of focus is a disc as wide as the circle of confusion, and its light is spread over it.
/// Oracle: the thin lens's closed form on the plane in focus: aperture |distance - focus| / distance, for parallel rays over focus.
#[test]
fn lamps_out_of_focus_are_discs() {
    const SIDE: u32 = 61;
    let (half, distance, focus, aperture, measured) = (0.03_f32, 8.0_f32, 5.0_f32, 0.4_f32, 0.5_f32);
    let mut scene = Scene::new();
    let shine = emitter(&mut scene, [1000.0; 3]);
    let edge = 2.0 * half;
    put_mesh(&mut scene, quad([-half, -half, -distance], [edge, 0.0, 0.0], [0.0, edge, 0.0], shine));
    let world = world_of(&scene, false);
    let fov_y = 2.0 * (measured / 2.0 / focus).atan().to_degrees();
    let lens = Lens { aperture, focus: Some(focus) };
    for (projection, scale) in
        [(Projection::Perspective, focus / distance), (Projection::Orthographic { height: measured }, 1.0)]
    {
        let camera = Camera { fov_y, projection, lens, ..Camera::default() };
        let camera = SceneCamera::new(&camera).expect("a view");
        for integrator in [Integrator::Path, Integrator::Whitted] {
            let filter = ReconstructionFilter::Box;
            let options = RenderOptions { integrator, filter, ..options(SIDE, SIDE, 64) };
            let frame = render(&world, &camera, &options, &pool(1), &Silent).expect("sound options");
            let lit: Vec<f64> = frame.picture.color.iter().map(|c| f64::from(c[0])).collect();
            let sum: f64 = lit.iter().sum();
            let across = |i: usize| f64::from(i as u32 % SIDE) - f64::from(SIDE / 2);
            let second_moment = lit.iter().enumerate().map(|(i, x)| x * across(i).powi(2)).sum::<f64>() / sum;
            let pixel = f64::from(measured) / f64::from(SIDE);
            let [radius, half] =
                [aperture / 2.0 * (distance - focus) / focus, half].map(|x| f64::from(x * scale));
            // Of a disc, the lamp and a pixel; variances add up where shapes are smeared over each other.
            let expected = radius * radius / 4.0 + half * half / 3.0 + pixel * pixel / 12.0;
            assert_close(
                second_moment * pixel * pixel,
                expected,
                0.03,
                &format!("{projection} {integrator}: its size"),
            );
            let all = 1000.0 * (2.0 * half / pixel).powi(2);
            assert_close(sum, all, 0.03, &format!("{projection} {integrator}: its light"));
        }
    }
}

/// Places where a fisheye sees nothing stay empty, whatever is around.
#[test]
fn nothing_is_seen_beyond_straight_back() {
    let mut scene = Scene::new();
    scene.add_light(environment([1.0; 3]));
    let camera = Camera { projection: Projection::Fisheye, fov_y: 360.0, ..Camera::default() };
    let camera = SceneCamera::new(&camera).expect("a view");
    for integrator in [Integrator::Path, Integrator::Whitted, Integrator::InstantRadiosity] {
        let options = RenderOptions { integrator, ..options(32, 32, 4) };
        let picture = render(&world_of(&scene, false), &camera, &options, &pool(1), &Silent);
        let color = picture.expect("sound options").picture.color;
        assert_eq!(color[0][..3], [0.0; 3], "{integrator}: a corner");
        assert_eq!(color[16 * 32 + 16][..3], [1.0; 3], "{integrator}: the middle");
    }
}
